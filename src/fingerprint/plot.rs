//! Lines, frames and labels on a picture.

use crate::base::num;
use crate::picture::Picture;
use crate::report::font::{draw_text, fill, text_width};
use crate::srgb::linear_of_bytes;

/// Colours as 8-bit sRGB.
pub(super) const PAPER: [u8; 3] = [250, 250, 247];
pub(super) const INK: [u8; 3] = [25, 25, 30];
pub(super) const FAINT: [u8; 3] = [205, 205, 200];
pub(super) const IDEAL: [u8; 3] = [150, 150, 150];
pub(super) const SERIES: [[u8; 3]; 5] =
    [[20, 90, 180], [210, 80, 20], [30, 140, 70], [150, 50, 150], [180, 140, 0]];

/// A picture to draw on.
pub(super) struct Canvas {
    pub(super) picture: Picture,
}

impl Canvas {
    pub(super) fn new(width: usize, height: usize) -> Self {
        let mut picture = Picture::new(width, height);
        picture.rgb.fill(linear_of_bytes(PAPER));
        picture.covered.fill(true);
        Self { picture }
    }

    pub(super) fn text(&mut self, at: (usize, usize), text: &str, scale: usize, color: [u8; 3]) {
        draw_text(&mut self.picture, at, text, scale, linear_of_bytes(color));
    }

    pub(super) fn rect(&mut self, at: (usize, usize), size: (usize, usize), color: [u8; 3]) {
        fill(&mut self.picture, at, size, linear_of_bytes(color));
    }

    pub(super) fn frame(&mut self, (x, y): (usize, usize), (w, h): (usize, usize), color: [u8; 3]) {
        self.rect((x, y), (w, 1), color);
        self.rect((x, y + h - 1), (w, 1), color);
        self.rect((x, y), (1, h), color);
        self.rect((x + w - 1, y), (1, h), color);
    }

    fn dot(&mut self, x: f64, y: f64, color: [u8; 3]) {
        if x >= 0.0 && y >= 0.0 {
            self.rect((num::index(x), num::index(y)), (1, 1), color);
        }
    }

    fn line(&mut self, a: [f64; 2], b: [f64; 2], color: [u8; 3]) {
        let length = (b[0] - a[0]).abs().max((b[1] - a[1]).abs()).ceil().clamp(1.0, 8192.0);
        for i in 0..=num::index(length) {
            let t = i as f64 / length;
            self.dot(a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t, color);
        }
    }
}

/// A frame with axes.
pub(super) struct Axes {
    pub(super) at: (usize, usize),
    pub(super) size: (usize, usize),
    pub(super) x: [f64; 2],
    pub(super) y: [f64; 2],
}

impl Axes {
    fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let share = |v: f64, [low, high]: [f64; 2]| ((v - low) / (high - low)).clamp(0.0, 1.0);
        let (w, h) = ((self.size.0 - 1) as f64, (self.size.1 - 1) as f64);
        [self.at.0 as f64 + share(x, self.x) * w, self.at.1 as f64 + (1.0 - share(y, self.y)) * h]
    }

    /// Frame, title, grid lines and their labels.
    pub(super) fn draw(
        &self,
        canvas: &mut Canvas,
        title: &str,
        labels: [&str; 2],
        ticks: [&[f64]; 2],
    ) {
        canvas.text((self.at.0, self.at.1 - 14), title, 1, INK);
        for tick in ticks[0] {
            let [x, _] = self.place([*tick, self.y[0]]);
            canvas.rect((num::index(x), self.at.1), (1, self.size.1), FAINT);
            let text = format!("{tick}");
            let left = (num::index(x)).saturating_sub(text_width(&text, 1) / 2);
            canvas.text((left, self.at.1 + self.size.1 + 4), &text, 1, INK);
        }
        for tick in ticks[1] {
            let [_, y] = self.place([self.x[0], *tick]);
            canvas.rect((self.at.0, num::index(y)), (self.size.0, 1), FAINT);
            let text = format!("{tick}");
            let left = self.at.0.saturating_sub(text_width(&text, 1) + 4);
            canvas.text((left, (num::index(y)).saturating_sub(3)), &text, 1, INK);
        }
        canvas.frame(self.at, self.size, INK);
        let below = self.at.1 + self.size.1 + 16;
        let left = self.at.0 + self.size.0 - text_width(labels[0], 1).min(self.size.0);
        canvas.text((left, below), labels[0], 1, INK);
        canvas.text((self.at.0, below), labels[1], 1, INK);
    }

    /// A line through points.
    pub(super) fn curve(
        &self,
        canvas: &mut Canvas,
        points: impl Iterator<Item = [f64; 2]>,
        color: [u8; 3],
    ) {
        let mut before = None;
        for point in points {
            let here = self.place(point);
            canvas.line(before.unwrap_or(here), here, color);
            before = Some(here);
        }
    }
}

/// Colour of a weight as a share of the largest one: paper, then blue to dark red.
pub(super) fn heat(share: f64) -> [u8; 3] {
    const RAMP: [[f64; 3]; 5] = [
        [222.0, 232.0, 242.0],
        [140.0, 185.0, 220.0],
        [70.0, 140.0, 150.0],
        [230.0, 150.0, 50.0],
        [150.0, 20.0, 20.0],
    ];
    let place = share.clamp(0.0, 1.0) * 4.0;
    let below = num::index(place).min(3);
    let part = place - below as f64;
    [0, 1, 2].map(|i| {
        let mixed = RAMP[below][i] + (RAMP[below + 1][i] - RAMP[below][i]) * part;
        num::u8(num::index(mixed))
    })
}
