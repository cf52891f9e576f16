//! SVG by hand: axes with round numbers, dots, lines, texts.

use std::fmt::Write as _;

use crate::report::escape::escape;

/// A drawing under construction.
#[derive(Debug)]
pub(super) struct Svg {
    size: [f64; 2],
    body: String,
}

/// A number with as many places as a drawing needs.
pub(super) fn n(x: f64) -> String {
    let text = format!("{x:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.into() }
}

impl Svg {
    pub(super) fn new(width: f64, height: f64) -> Self {
        Self { size: [width, height], body: String::new() }
    }

    pub(super) fn raw(&mut self, element: &str) {
        self.body += element;
        self.body.push('\n');
    }

    pub(super) fn line(&mut self, from: [f64; 2], to: [f64; 2], class: &str) {
        // Writing to a String cannot fail.
        let _ = writeln!(
            self.body,
            "<line class=\"{class}\" x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\"/>",
            n(from[0]),
            n(from[1]),
            n(to[0]),
            n(to[1])
        );
    }

    pub(super) fn polyline(&mut self, points: &[[f64; 2]], class: &str) {
        let points: Vec<String> =
            points.iter().map(|p| format!("{},{}", n(p[0]), n(p[1]))).collect();
        let _ =
            writeln!(self.body, "<polyline class=\"{class}\" points=\"{}\"/>", points.join(" "));
    }

    pub(super) fn text(&mut self, at: [f64; 2], class: &str, text: &str) {
        let _ = writeln!(
            self.body,
            "<text class=\"{class}\" x=\"{}\" y=\"{}\">{}</text>",
            n(at[0]),
            n(at[1]),
            escape(text)
        );
    }

    pub(super) fn dot(&mut self, at: [f64; 2], radius: f64, class: &str, row: &str, title: &str) {
        let row = if row.is_empty() {
            String::new()
        } else {
            format!(" data-row=\"{row}\" tabindex=\"0\"")
        };
        let _ = writeln!(
            self.body,
            "<circle class=\"{class}\"{row} cx=\"{}\" cy=\"{}\" r=\"{}\"><title>{}</title></circle>",
            n(at[0]),
            n(at[1]),
            n(radius),
            escape(title)
        );
    }

    pub(super) fn finish(self, label: &str) -> String {
        let [w, h] = self.size.map(n);
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" width=\"{w}\" height=\"{h}\" role=\"img\" aria-label=\"{}\">\n<style>{}</style>\n{}</svg>",
            escape(label),
            include_str!("figure.css"),
            self.body
        )
    }
}

/// An axis of a chart: what it spans, and where.
#[derive(Clone, Debug)]
pub(super) struct Scale {
    pub(super) low: f64,
    pub(super) high: f64,
    pub(super) log: bool,
    from: f64,
    to: f64,
}

impl Scale {
    /// From values onto pixels, a twentieth wider than they are.
    pub(super) fn new(values: &[f64], log: bool, from: f64, to: f64) -> Self {
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

    pub(super) fn at(&self, x: f64) -> f64 {
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

    /// Round numbers inside.
    pub(super) fn ticks(&self) -> Vec<f64> {
        if self.log {
            let (low, high) = (self.low.ceil(), self.high.floor());
            let step = ((high - low) / 6.0).ceil().max(1.0);
            return (0..)
                .map(|i| low + step * f64::from(i))
                .take_while(|x| *x <= high)
                .map(libm::exp2)
                .collect();
        }
        let step = self.step();
        let first = (self.low / step).ceil();
        (0..20).map(|i| (first + f64::from(i)) * step).take_while(|x| *x <= self.high).collect()
    }

    /// A tick's number, with as many places as neighbours need to differ.
    pub(super) fn label(&self, x: f64) -> String {
        if self.log {
            return tick(x);
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "clamped to 0 to 9"
        )]
        let places = (-libm::floor(libm::log10(self.step()) + 1e-9)).clamp(0.0, 9.0) as usize;
        format!("{x:.places$}")
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
