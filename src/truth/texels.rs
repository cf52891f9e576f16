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
    #[must_use]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the place is clamped to 0..=size + 1, and not-a-number becomes 0"
    )]
    pub fn look_up(&self, d: [f64; 3]) -> [f64; 3] {
        let (face, u, v) = crate::cube::face_uv(d);
        let (face, u, v) = if u.is_finite() && v.is_finite() {
            (face, u, v)
        } else {
            (4, 0.0, 0.0)
        };
        let size = self.size as f64;
        // The border shifts texel centres by one: u = −1 lies half a texel into the border's side.
        let place = |u: f64| ((u + 1.0) * 0.5 * size + 0.5).clamp(0.0, size + 0.5);
        let (x, y) = (place(u), place(v));
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = (x - x0, y - y0);
        let stride = self.size + 2;
        let start = (face * stride + y0 as usize) * stride + x0 as usize;
        let rows = [start, start + stride].map(|i| [self.texels[i], self.texels[i + 1]]);
        [0, 1, 2].map(|i| {
            let mix = |row: &[[f32; 3]; 2]| {
                let (a, b) = (f64::from(row[0][i]), f64::from(row[1][i]));
                a + (b - a) * fx
            };
            let (above, below) = (mix(&rows[0]), mix(&rows[1]));
            above + (below - above) * fy
        })
    }
}
