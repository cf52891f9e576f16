//! The plotter: axes with round numbers, dots, lines and texts as SVG.

use maud::{Markup, PreEscaped, html};

/// A number with as many places as a drawing needs.
pub(super) fn n(x: f64) -> String {
    let text = format!("{x:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.into() }
}

/// A whole drawing; it brings its own colours, which a page may replace.
pub(super) fn svg([width, height]: [f64; 2], label: &str, body: &Markup) -> String {
    let drawing = html! {
        svg xmlns="http://www.w3.org/2000/svg" viewBox={ "0 0 " (n(width)) " " (n(height)) } width=(n(width))
            height=(n(height)) role="img" aria-label=(label) {
            style { (PreEscaped(include_str!("figure.css"))) }
            (body)
        }
    };
    drawing.into_string()
}

/// A straight line.
pub(super) fn line(from: [f64; 2], to: [f64; 2], class: &str) -> Markup {
    html! { line class=(class) x1=(n(from[0])) y1=(n(from[1])) x2=(n(to[0])) y2=(n(to[1])) {} "\n" }
}

/// Points as `points` of a polyline or a polygon has them.
pub(super) fn points<'a>(points: impl IntoIterator<Item = &'a [f64; 2]>) -> String {
    let pair = |p: &[f64; 2]| format!("{},{}", n(p[0]), n(p[1]));
    points.into_iter().map(pair).collect::<Vec<_>>().join(" ")
}

/// A text.
pub(super) fn label(at: [f64; 2], class: &str, text: &str) -> Markup {
    html! { text class=(class) x=(n(at[0])) y=(n(at[1])) { (text) } "\n" }
}

/// A dot; one of a row can be chosen.
pub(super) fn dot(at: [f64; 2], radius: f64, class: &str, row: &str, title: &str) -> Markup {
    let row = (!row.is_empty()).then_some(row);
    html! {
        circle class=(class) data-row=[row] tabindex=[row.map(|_| "0")] cx=(n(at[0])) cy=(n(at[1])) r=(n(radius)) {
            title { (title) }
        }
        "\n"
    }
}

/// Width and height of a chart.
pub(super) const CHART: [f64; 2] = [520.0, 330.0];
const TOP: f64 = 30.0;
const BASE: f64 = CHART[1] - 52.0;

/// The axes of a chart.
pub(super) struct Axes {
    x: Scale,
    y: Scale,
    /// Numbers or names along x.
    columns: Vec<(f64, String)>,
    rows: Vec<(f64, String)>,
}

impl Axes {
    /// Axes that span these values; `names` stand along x in place of numbers.
    pub(super) fn new(
        xs: &[f64],
        log: bool,
        ys: &[f64],
        names: Option<Vec<(f64, String)>>,
    ) -> Self {
        let y = Scale::new(ys, false, BASE, TOP);
        let rows = y.ticks();
        // The name of the axis, then the longest number.
        let longest = rows.iter().map(|(_, text)| text.chars().count()).max().unwrap_or(0);
        let left = (30.0 + 6.5 * longest as f64).max(62.0);
        let mut x = Scale::new(xs, log, left, CHART[0]);
        let columns = names.unwrap_or_else(|| x.ticks());
        // Half of the last number may stand under the end of the axis.
        let last = columns.last().map_or(0, |(_, text)| text.chars().count());
        x.to -= (3.5 * last as f64).max(14.0);
        Self { x, y, columns, rows }
    }

    /// Where a point lies.
    pub(super) fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.x.at(x), self.y.at(y)]
    }

    /// Grid, numbers, names.
    pub(super) fn draw(&self, [x_name, y_name]: [&str; 2], title: &str) -> Markup {
        let (left, right) = (self.x.from, self.x.to);
        let middle = f64::midpoint(TOP, BASE);
        html! {
            @for (t, text) in &self.rows {
                @let y = self.y.at(*t);
                (line([left, y], [right, y], "g")) (label([left - 6.0, y + 4.0], "s e", text))
            }
            @for (t, text) in &self.columns {
                @let x = self.x.at(*t);
                (line([x, TOP], [x, BASE], "g")) (label([x, BASE + 16.0], "s m", text))
            }
            (line([left, BASE], [right, BASE], "a")) (line([left, TOP], [left, BASE], "a"))
            (label([f64::midpoint(left, right), BASE + 38.0], "m", x_name))
            text.m transform={ "translate(15 " (n(middle)) ") rotate(-90)" } { (y_name) }
            (label([left, 18.0], "t", title))
        }
    }
}

/// An axis of a chart: what it spans, and where.
#[derive(Clone, Debug)]
struct Scale {
    low: f64,
    high: f64,
    log: bool,
    from: f64,
    to: f64,
}

impl Scale {
    /// From values onto pixels, a twentieth wider than they are.
    fn new(values: &[f64], log: bool, from: f64, to: f64) -> Self {
        let map = |x: f64| if log { libm::log2(x) } else { x };
        let finite = || values.iter().copied().filter(|x| x.is_finite()).map(map);
        let (mut low, mut high) =
            (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max));
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        let room = if high > low { (high - low) / 20.0 } else { low.abs().max(1.0) / 20.0 };
        Self { low: low - room, high: high + room, log, from, to }
    }

    fn at(&self, x: f64) -> f64 {
        let x = if self.log { libm::log2(x) } else { x };
        let share = ((x - self.low) / (self.high - self.low)).clamp(0.0, 1.0);
        self.from + (self.to - self.from) * share
    }

    /// The distance between two round numbers of a scale that is not logarithmic.
    fn step(&self) -> f64 {
        let raw = (self.high - self.low) / 6.0;
        let power = libm::pow(10.0, libm::floor(libm::log10(raw)));
        let steps = [1.0, 2.0, 5.0, 10.0].map(|s| s * power);
        steps.into_iter().find(|s| *s >= raw).unwrap_or(steps[3])
    }

    /// Round numbers inside, each as text with as many places as neighbours need to differ.
    fn ticks(&self) -> Vec<(f64, String)> {
        if self.log {
            let (low, high) = (self.low.ceil(), self.high.floor());
            let step = ((high - low) / 6.0).ceil().max(1.0);
            let powers = (0..).map(|i| low + step * f64::from(i)).take_while(|x| *x <= high);
            return powers.map(libm::exp2).map(|x| (x, tick(x))).collect();
        }
        let step = self.step();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "clamped to 0 to 9"
        )]
        let places = (-libm::floor(libm::log10(step) + 1e-9)).clamp(0.0, 9.0) as usize;
        let first = (self.low / step).ceil();
        let round = (0..20).map(|i| (first + f64::from(i)) * step);
        round.take_while(|x| *x <= self.high).map(|x| (x, format!("{x:.places$}"))).collect()
    }
}

/// A tick's number.
pub(super) fn tick(x: f64) -> String {
    if x == 0.0 {
        "0".into()
    } else {
        crate::report::table::significant(x, 3)
            .trim_end_matches(".00")
            .trim_end_matches(".0")
            .into()
    }
}
