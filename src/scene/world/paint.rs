//! How surfaces glow: tiles, panels, lamps and bands with hard edges over smooth shades.
//!
//! A place is in world units from the part's corner, so that patterns keep their size on every wall.
//! On the walls of a room the second coordinate is the height, on floor and ceiling it is z.

/// A procedural surface. Values are linear radiance between 0 and 8.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Paint {
    /// A room from inside: tiled walls with panels, a chequered floor, lamps in the ceiling.
    Room,
    /// A second room in other colours, without lamps.
    BackRoom,
    /// Horizontal bands and upright flutes; caps in one bright colour with a ring.
    Banded {
        /// Colour of the broad bands.
        colour: [f64; 3],
    },
    /// Square tiles with joints.
    Tiled {
        /// Colour of the tiles.
        colour: [f64; 3],
    },
}

impl Paint {
    /// Linear RGB of a place on a part of the given width and height.
    #[must_use]
    pub fn glow(&self, part: usize, place: [f64; 2], extent: [f64; 2]) -> [f64; 3] {
        match *self {
            Self::Room => room(part, place, extent, &WARM),
            Self::BackRoom => room(part, place, extent, &COLD),
            Self::Banded { colour } => banded(part, place, extent, colour),
            Self::Tiled { colour } => tiles(place, 0.25, 0.02, colour, [0.03; 3]),
        }
    }
}

/// The colours of a room.
struct Palette {
    /// Of the sides +X −X +Y −Y +Z −Z; that of −Y is the floor's bright squares.
    walls: [[f64; 3]; 6],
    floor_dark: [f64; 3],
    lamp: [f64; 3],
}

const WARM: Palette = Palette {
    walls: [
        [0.55, 0.12, 0.08],
        [0.10, 0.22, 0.50],
        [0.72, 0.70, 0.66],
        [0.70, 0.64, 0.52],
        [0.14, 0.38, 0.16],
        [0.60, 0.46, 0.14],
    ],
    floor_dark: [0.05, 0.06, 0.08],
    lamp: [6.0, 5.4, 4.2],
};

const COLD: Palette = Palette {
    walls: [
        [0.30, 0.10, 0.42],
        [0.05, 0.36, 0.38],
        [0.30, 0.32, 0.36],
        [0.36, 0.40, 0.44],
        [0.46, 0.20, 0.30],
        [0.90, 0.86, 0.30],
    ],
    floor_dark: [0.10, 0.02, 0.03],
    lamp: [0.5, 0.6, 0.9],
};

fn mix(a: [f64; 3], b: [f64; 3], share: f64) -> [f64; 3] {
    [0, 1, 2].map(|i| a[i] + (b[i] - a[i]) * share)
}

fn scaled(colour: [f64; 3], by: f64) -> [f64; 3] {
    colour.map(|c| c * by)
}

/// Distance from the nearest multiple of `step`.
fn from_line(x: f64, step: f64) -> f64 {
    (x - step * (x / step + 0.5).floor()).abs()
}

fn odd(x: f64) -> bool {
    x.floor().rem_euclid(2.0) >= 1.0
}

/// Tiles of one colour, every second a little darker, with joints.
fn tiles(place: [f64; 2], side: f64, joint: f64, colour: [f64; 3], dark: [f64; 3]) -> [f64; 3] {
    if place.iter().any(|c| from_line(*c, side) < joint / 2.0) {
        return dark;
    }
    let second = odd(place[0] / side) != odd(place[1] / side);
    scaled(colour, if second { 0.78 } else { 1.0 })
}

fn room(part: usize, place: [f64; 2], extent: [f64; 2], palette: &Palette) -> [f64; 3] {
    let base = palette.walls[part.min(5)];
    // From −1 to 1 over the part.
    let [a, b] = [0, 1].map(|i| 2.0 * place[i] / extent[i] - 1.0);
    match part {
        2 => ceiling(place, [a, b], base, palette.lamp),
        3 => {
            let bright = odd(2.0 * place[0]) != odd(2.0 * place[1]);
            let colour = if bright { base } else { palette.floor_dark };
            // A pool of light in the middle.
            scaled(colour, 0.35 + 0.65 / (1.0 + 1.5 * (a * a + b * b)))
        }
        _ => wall(part, place, extent, base),
    }
}

fn ceiling(place: [f64; 2], [a, b]: [f64; 2], base: [f64; 3], lamp: [f64; 3]) -> [f64; 3] {
    let cell = [0, 1].map(|i| place[i] - 2.0 * (place[i] / 2.0).floor() - 1.0);
    if cell[0].abs() < 0.55 && cell[1].abs() < 0.2 {
        return lamp;
    }
    if from_line(place[0], 1.0) < 0.015 || from_line(place[1], 1.0) < 0.015 {
        return scaled(base, 0.3);
    }
    scaled(base, 0.5 + 0.25 * libm::cos(1.5 * a) * libm::cos(1.5 * b))
}

/// Tiles below, a plaster with soft waves above, and three panels at eye level: rings, stripes and a
/// smooth gradient with a dark frame.
fn wall(part: usize, place: [f64; 2], extent: [f64; 2], base: [f64; 3]) -> [f64; 3] {
    let [x, y] = place;
    let light = 0.45 + 0.55 * y / extent[1];
    let low = 0.32 * extent[1];
    // Panels sit in thirds of the wall, 1.1 wide and 1 high.
    let third = extent[0] / 3.0;
    let index = (x / third).floor().clamp(0.0, 2.0);
    let from_middle = [x - (index + 0.5) * third, y - 0.56 * extent[1]];
    let [p, q] = from_middle.map(|c| c / 0.5);
    if p.abs() < 1.1 && q.abs() < 1.0 {
        if p.abs() > 1.02 || q.abs() > 0.92 {
            return [0.02, 0.02, 0.02];
        }
        return panel(part, index, p, q);
    }
    if y < low {
        return scaled(tiles(place, 0.25, 0.02, mix(base, [0.8; 3], 0.35), [0.05; 3]), light);
    }
    if y < low + 0.06 {
        return [0.85, 0.80, 0.70];
    }
    let wave = 1.0 + 0.15 * libm::sin(3.0 * x) * libm::cos(2.0 * y);
    scaled(base, light * wave)
}

fn panel(part: usize, index: f64, p: f64, q: f64) -> [f64; 3] {
    // Another order on every wall.
    let kind = (index + part as f64).rem_euclid(3.0);
    if kind < 0.5 {
        let ring = (p * p + q * q).sqrt() * 5.0;
        if odd(ring) { [0.90, 0.88, 0.80] } else { [0.75, 0.05, 0.04] }
    } else if kind < 1.5 {
        let stripe = if q > 0.0 { 6.0 * p } else { 18.0 * p };
        if odd(stripe) { [0.95, 0.95, 0.95] } else { [0.02, 0.03, 0.10] }
    } else {
        let sky = mix([1.2, 0.9, 0.5], [0.15, 0.35, 1.1], 0.5 + 0.5 * q);
        let sun = libm::exp(-12.0 * ((p - 0.4) * (p - 0.4) + (q - 0.3) * (q - 0.3)));
        [0, 1, 2].map(|i| sky[i] + [3.0, 2.4, 1.2][i] * sun)
    }
}

fn banded(part: usize, place: [f64; 2], extent: [f64; 2], colour: [f64; 3]) -> [f64; 3] {
    if part > 0 {
        let reach = [0, 1].map(|i| 2.0 * place[i] / extent[i] - 1.0);
        let square = reach[0] * reach[0] + reach[1] * reach[1];
        return if (0.3..0.6).contains(&square) { [0.05, 0.05, 0.05] } else { [1.6, 1.3, 0.3] };
    }
    let [x, y] = place;
    if from_line(y, 0.5) < 0.05 {
        return [0.9, 0.85, 0.75];
    }
    // Eight flutes, shaded smoothly.
    let flute = libm::cos(8.0 * 2.0 * std::f64::consts::PI * x / extent[0]);
    scaled(colour, (0.7 + 0.3 * flute) * (0.5 + 0.5 * y / extent[1]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_paint_is_finite_never_negative_and_has_both_soft_and_hard_parts() {
        let paints = [
            Paint::Room,
            Paint::BackRoom,
            Paint::Banded { colour: [0.5, 0.4, 0.3] },
            Paint::Tiled { colour: [0.2, 0.4, 0.3] },
        ];
        for paint in paints {
            for part in 0..6 {
                let (mut soft, mut hard) = (0, 0);
                let extent = [6.0, 4.0];
                let glow = |i: i32, j: i32| {
                    paint.glow(part, [f64::from(i) / 100.0, f64::from(j) / 100.0], extent)
                };
                for j in 1..400 {
                    for i in 1..600 {
                        let here = glow(i, j);
                        assert!(here.iter().all(|c| (0.0..=8.0).contains(c)), "{paint:?} {part}");
                        for before in [glow(i - 1, j), glow(i, j - 1)] {
                            let step = (here[0] - before[0]).abs();
                            soft += usize::from(step > 0.0 && step < 0.02);
                            hard += usize::from(step > 0.04);
                        }
                    }
                }
                assert!(hard > 100, "{paint:?} {part}: {hard} edges");
                let shaded = matches!(paint, Paint::Room | Paint::BackRoom);
                assert!(!shaded || soft > 1000, "{paint:?} {part}: {soft} soft steps");
            }
        }
    }
}
