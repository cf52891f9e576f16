//! Latitude-longitude images as a function of direction.
//!
//! Directions follow OpenEXR for every lat-long image: latitude +π/2 (the +y pole) is the top row,
//! longitude runs from π at the left edge to −π at the right, and
//! direction = (sin lon·cos lat, sin lat, cos lon·cos lat), so +z is in the middle of the picture.

use super::resample::{mix, real, split};

/// A lat-long image and the grid that its samples lie on.
pub(super) struct LatLong {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) texels: Vec<[f32; 3]>,
    /// True: first and last row on the poles, first and last column both at ±π (the `envmap`
    /// attribute). False: half-texel centres.
    pub(super) on_poles: bool,
}

impl LatLong {
    /// Bilinear look-up in a direction that is not zero.
    pub(super) fn lookup(&self, d: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = d;
        let longitude = if x == 0.0 && z == 0.0 {
            0.0
        } else {
            libm::atan2(x, z)
        };
        let latitude = libm::atan2(y, (x * x + z * z).sqrt());
        let across = 0.5 - longitude / std::f64::consts::TAU;
        let down = 0.5 - latitude / std::f64::consts::PI;
        let (column, row) = if self.on_poles {
            (across * real(self.width - 1), down * real(self.height - 1))
        } else {
            (
                across * real(self.width) - 0.5,
                down * real(self.height) - 0.5,
            )
        };
        let ((x0, fx), (y0, fy)) = (split(column), split(row));
        let line = |y| mix(self.tap(x0, y), self.tap(x0 + 1, y), fx);
        mix(line(y0), line(y0 + 1), fy)
    }

    /// A texel, also one step outside: columns go round, and beyond a pole lies the first row again,
    /// half a turn away. With samples on the poles nothing lies outside but the weightless end.
    fn tap(&self, x: i64, y: i64) -> [f64; 3] {
        let (w, h) = (as_i64(self.width), as_i64(self.height));
        let (x, y) = if self.on_poles {
            (x.clamp(0, w - 1), y.clamp(0, h - 1))
        } else if y < 0 {
            ((x + w / 2).rem_euclid(w), (-1 - y).min(h - 1))
        } else if y >= h {
            ((x + w / 2).rem_euclid(w), (2 * h - 1 - y).max(0))
        } else {
            (x.rem_euclid(w), y)
        };
        let index = usize::try_from(y * w + x).unwrap_or(0);
        self.texels[index].map(f64::from)
    }
}

fn as_i64(n: usize) -> i64 {
    i64::try_from(n).unwrap_or(i64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// x, y, z of each sample's own direction plus 2 (so that nothing is negative).
    fn directions(width: usize, height: usize, on_poles: bool) -> LatLong {
        let mut texels = Vec::new();
        for row in 0..height {
            for column in 0..width {
                let (a, d) = if on_poles {
                    (real(column) / real(width - 1), real(row) / real(height - 1))
                } else {
                    (
                        (real(column) + 0.5) / real(width),
                        (real(row) + 0.5) / real(height),
                    )
                };
                let (lon, lat) = (PI - 2.0 * PI * a, PI / 2.0 - PI * d);
                let v = [
                    libm::sin(lon) * libm::cos(lat),
                    libm::sin(lat),
                    libm::cos(lon) * libm::cos(lat),
                ];
                texels.push(v.map(|c| crate::image::mips::narrow(c + 2.0)));
            }
        }
        LatLong {
            width,
            height,
            texels,
            on_poles,
        }
    }

    #[test]
    fn a_lookup_returns_the_direction_stored_there_on_both_grids() {
        // Bilinear interpolation of sin and cos on a grid of step h errs by at most h²/8 a axis:
        // (2π/128)²/8 = 3.0e-4 in longitude and as much in latitude; f32 storage adds 2e-7.
        let bound = 2.0 * (2.0 * PI / 127.0) * (2.0 * PI / 127.0) / 8.0 + 1e-6;
        for on_poles in [false, true] {
            let map = directions(128, 64, on_poles);
            for i in 0..2000u32 {
                let t = f64::from(i);
                let y = 1.0 - 2.0 * (t + 0.5) / 2000.0;
                let r = (1.0 - y * y).sqrt();
                let d = [r * libm::cos(t * 2.4), y, r * libm::sin(t * 2.4)];
                let got = map.lookup(d.map(|c| 3.0 * c));
                for (g, d) in got.into_iter().zip(d) {
                    assert!((g - 2.0 - d).abs() <= bound, "{on_poles} {i}: {g} {d}");
                }
            }
            for axis in 0..3 {
                for sign in [1.0, -1.0] {
                    let mut d = [0.0; 3];
                    d[axis] = sign;
                    let got = map.lookup(d)[axis] - 2.0;
                    assert!(
                        (got - sign).abs() <= bound,
                        "{on_poles} {axis} {sign}: {got}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_one_by_one_map_is_constant() {
        for on_poles in [false, true] {
            let map = LatLong {
                width: 1,
                height: 1,
                texels: vec![[3.0, 4.0, 5.0]],
                on_poles,
            };
            assert_eq!(
                map.lookup([0.0, 1.0, 0.0]).map(f64::to_bits),
                [3.0f64, 4.0, 5.0].map(f64::to_bits)
            );
        }
    }
}
