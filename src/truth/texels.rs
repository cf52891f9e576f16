//! Level 0 of a cube map with a border of one texel, so that a bilinear look-up never leaves its face.

use crate::cube::{CubeLevel, across_edge};

/// Six faces of (size + 2)² texels.
#[derive(Clone, Debug, PartialEq)]
pub struct PaddedCube {
    size: usize,
    texels: Vec<[f32; 3]>,
}

impl PaddedCube {
    /// Copies a level; the border comes from the neighbouring faces, and a corner is the mean of the
    /// three texels that meet there.
    #[must_use]
    pub fn new(level: &CubeLevel) -> Self {
        let size = level.size;
        let mut texels = Vec::with_capacity(6 * (size + 2) * (size + 2));
        let along: Vec<i64> = (-1..).take(size + 2).collect();
        for face in 0..6 {
            let at = |x: i64, y: i64| {
                across_edge(size, face, x, y).map(|(face, x, y)| level.texel(face, x, y))
            };
            for &y in &along {
                for &x in &along {
                    texels.push(at(x, y).unwrap_or_else(|| {
                        // Outside both ways: one step back in x, in y and in both.
                        let inside = |t: i64| if t < 0 { 0 } else { t - 1 };
                        let three = [(inside(x), y), (x, inside(y)), (inside(x), inside(y))];
                        let mut mean = [0.0f32; 3];
                        for (x, y) in three {
                            let texel = at(x, y).unwrap_or_default();
                            for (mean, c) in mean.iter_mut().zip(texel) {
                                *mean += c / 3.0;
                            }
                        }
                        mean
                    }));
                }
            }
        }
        Self { size, texels }
    }

    /// Bilinear texel in a direction of any length. A direction that is zero or not finite counts as +z.
    #[inline]
    #[must_use]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the place is clamped to 0..=size + 1, and not-a-number becomes 0"
    )]
    pub fn look_up(&self, d: [f64; 3]) -> [f64; 3] {
        let (face, u, v) = crate::cube::face_uv(d);
        let (face, u, v) =
            if u.is_finite() && v.is_finite() { (face, u, v) } else { (4, 0.0, 0.0) };
        let size = self.size as f64;
        // The border shifts texel centres by one: u = −1 lies half a texel into the border's side.
        let place = |u: f64| ((u + 1.0) * 0.5 * size + 0.5).clamp(0.0, size + 0.5);
        let (x, y) = (place(u), place(v));
        // Never negative, so that the conversion is the floor.
        let (x0, y0) = (x as u32, y as u32);
        let (fx, fy) = (x - f64::from(x0), y - f64::from(y0));
        let stride = self.size + 2;
        let start = (face * stride + y0 as usize) * stride + x0 as usize;
        let row = |i: usize| [self.texels[i], self.texels[i + 1]];
        let ([a, b], [c, d]) = (row(start), row(start + stride));
        // Written out: the closures of `map` are not inlined below opt-level 3.
        let channel = |i: usize| {
            let above = f64::from(a[i]) + (f64::from(b[i]) - f64::from(a[i])) * fx;
            let below = f64::from(c[i]) + (f64::from(d[i]) - f64::from(c[i])) * fx;
            above + (below - above) * fy
        };
        [channel(0), channel(1), channel(2)]
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "where bits must be equal, that is what is tested")]
mod tests {
    use super::*;
    use crate::cube::direction;

    fn cube(size: usize) -> CubeLevel {
        let texel = |i: usize| {
            let byte = |k: usize| u8::try_from(i * k % 251).map_or(0.0, f32::from) / 251.0;
            [byte(17), byte(101), byte(1)]
        };
        CubeLevel { size, texels: (0..6 * size * size).map(texel).collect() }
    }

    #[test]
    fn texel_centres_give_their_texels() {
        for size in [1, 2, 5, 8] {
            let (level, n) = (cube(size), size as f64);
            let padded = PaddedCube::new(&level);
            for face in 0..6 {
                for (y, x) in (0..size).flat_map(|y| (0..size).map(move |x| (y, x))) {
                    let at = |t: usize| (2 * t + 1) as f64 / n - 1.0;
                    let got = padded.look_up(direction(face, at(x), at(y)).map(|c| 3.0 * c));
                    // The place is off by at most 4 roundings of a number up to 2·size, texels differ
                    // by at most 1, in two directions.
                    let bound = 2.0 * 4.0 * 2.0 * n * f64::EPSILON;
                    for (got, want) in got.iter().zip(level.texel(face, x, y)) {
                        assert!((got - f64::from(want)).abs() <= bound);
                    }
                }
            }
        }
    }

    #[test]
    fn there_is_no_seam_at_edges_and_corners() {
        let step = f64::powi(2.0, -30);
        for size in [1, 2, 7, 16] {
            let padded = PaddedCube::new(&cube(size));
            // A step of 2^-30 moves by as much times size texels, which differ by at most 1, in two
            // directions and on both sides; singles in the corner's mean carry 4 roundings more.
            let bound = 4.0 * step * size as f64 + 4.0 * f64::from(f32::EPSILON);
            let mut compared = 0;
            for (i, j, k) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
                for (a, b) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                    for along in [-1.0, -0.999, -0.6, 0.0, 0.31, 0.77, 1.0] {
                        let at = |first: f64, second: f64| {
                            let mut d = [0.0; 3];
                            (d[i], d[j], d[k]) = (a * first, b * second, along * (1.0 - step));
                            padded.look_up(d)
                        };
                        let (one, other) = (at(1.0, 1.0 - step), at(1.0 - step, 1.0));
                        for c in 0..3 {
                            assert!(
                                (one[c] - other[c]).abs() <= bound,
                                "{size}: {one:?} {other:?}"
                            );
                        }
                        compared += 1;
                    }
                }
            }
            assert_eq!(compared, 84);
        }
    }

    #[test]
    fn a_corner_is_the_mean_of_its_three_texels() {
        let level = cube(4);
        let padded = PaddedCube::new(&level);
        // +x +y +z: +x at (sc, tc) = (−, −): column 0, row 0; +y at (+, +): 3, 3; +z at (+, −): 3, 0.
        let three = [level.texel(0, 0, 0), level.texel(2, 3, 3), level.texel(4, 3, 0)];
        let got = padded.look_up([1.0, 1.0, 1.0]);
        for c in 0..3 {
            let want = three.iter().map(|t| f64::from(t[c])).sum::<f64>() / 3.0;
            assert!((got[c] - want).abs() <= 4.0 * f64::from(f32::EPSILON));
        }
    }

    #[test]
    fn a_direction_that_is_no_direction_looks_at_plus_z() {
        let padded = PaddedCube::new(&cube(8));
        let middle = padded.look_up([0.0, 0.0, 1.0]);
        for d in [[0.0; 3], [f64::NAN, 1.0, 0.0], [f64::INFINITY, f64::INFINITY, 1.0]] {
            assert_eq!(padded.look_up(d), middle);
        }
    }
}
