//! Plots of a few curves on logarithmic axes, drawn with what the project has.

use super::font::{draw_text, fill};
use crate::picture::Picture;

/// A curve: its name, its colour in linear RGB, its points in order.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Name.
    pub name: String,
    /// Linear RGB.
    pub color: [f64; 3],
    /// (x, y); what is not above 0 is left out.
    pub points: Vec<[f64; 2]>,
}

/// Colours that can be told apart.
pub const COLORS: [[f64; 3]; 6] = [
    [0.7, 0.05, 0.05],
    [0.02, 0.15, 0.7],
    [0.05, 0.4, 0.1],
    [0.6, 0.3, 0.0],
    [0.4, 0.05, 0.5],
    [0.1, 0.1, 0.1],
];

const LEFT: usize = 70;
const BOTTOM: usize = 40;
const TOP: usize = 30;
const RIGHT: usize = 20;

/// Decades that hold all values.
fn decades(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let logs = values.filter(|x| *x > 0.0 && x.is_finite()).map(libm::log10);
    let (low, high) =
        logs.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
    if low > high {
        return [0.0, 1.0];
    }
    let (low, high) = (low.floor(), high.ceil());
    [low, if high > low { high } else { low + 1.0 }]
}

/// Draws curves over decades of x and y, with a grid line and a label a decade.
#[must_use]
pub fn log_log(
    title: &str,
    x_label: &str,
    curves: &[Curve],
    width: usize,
    height: usize,
) -> Picture {
    let mut picture = Picture::new(width, height);
    picture.rgb.fill([1.0; 3]);
    let all = || curves.iter().flat_map(|c| &c.points);
    let (xs, ys) = (decades(all().map(|p| p[0])), decades(all().map(|p| p[1])));
    let inner =
        [width.saturating_sub(LEFT + RIGHT).max(1), height.saturating_sub(TOP + BOTTOM).max(1)];
    let place = |log: f64, [low, high]: [f64; 2], pixels: usize| {
        let share = ((log - low) / (high - low)).clamp(0.0, 1.0);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            clippy::cast_precision_loss,
            reason = "a share of a picture's pixels"
        )]
        let at = (share * (pixels - 1) as f64).round() as usize;
        at
    };
    let column = |log: f64| LEFT + place(log, xs, inner[0]);
    let row = |log: f64| TOP + inner[1] - 1 - place(log, ys, inner[1]);
    let (grey, ink) = ([0.8; 3], [0.0; 3]);
    let step = |[low, high]: [f64; 2]| if high - low > 10.0 { 2.0 } else { 1.0 };
    let mut at = xs[0];
    while at <= xs[1] {
        fill(&mut picture, (column(at), TOP), (1, inner[1]), grey);
        let label = format!("1E{at:.0}");
        draw_text(
            &mut picture,
            (column(at).saturating_sub(10), TOP + inner[1] + 8),
            &label,
            1,
            ink,
        );
        at += step(xs);
    }
    let mut at = ys[0];
    while at <= ys[1] {
        fill(&mut picture, (LEFT, row(at)), (inner[0], 1), grey);
        draw_text(&mut picture, (28, row(at).saturating_sub(3)), &format!("1E{at:.0}"), 1, ink);
        at += step(ys);
    }
    draw_text(&mut picture, (LEFT, 10), title, 1, ink);
    draw_text(&mut picture, (LEFT, TOP + inner[1] + 24), x_label, 1, ink);
    for (k, curve) in curves.iter().enumerate() {
        let mut last: Option<[f64; 2]> = None;
        for [x, y] in &curve.points {
            let here = (*x > 0.0 && *y > 0.0).then(|| [libm::log10(*x), libm::log10(*y)]);
            if let (Some(a), Some(b)) = (last, here) {
                for i in 0..=64 {
                    let t = f64::from(i) / 64.0;
                    let (x, y) = (a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t);
                    fill(&mut picture, (column(x), row(y).saturating_sub(1)), (1, 2), curve.color);
                }
            }
            last = here;
        }
        let at = (LEFT + 10, TOP + 8 + 12 * k);
        fill(&mut picture, (at.0, at.1 + 2), (14, 3), curve.color);
        draw_text(&mut picture, (at.0 + 20, at.1), &curve.name, 1, ink);
    }
    picture.covered.fill(true);
    picture
}
