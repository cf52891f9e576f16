//! Latitude-longitude images as a function of direction.
//!
//! Directions follow OpenEXR for every lat-long image: latitude +π/2 (the +y pole) is the top row,
//! longitude runs from π at the left edge to −π at the right, and
//! direction = (sin lon·cos lat, sin lat, cos lon·cos lat), so +z is in the middle of the picture.

use super::resample::{centres, mix, real, samples_per_side, split};
use crate::base::num;
use crate::cube::CubeLevel;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

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
    /// Bilinear look-up at a longitude of `turns` whole turns (any number) and a latitude in radians.
    fn lookup(&self, turns: f64, latitude: f64) -> [f64; 3] {
        let across = 0.5 - turns;
        let across = across - across.floor();
        let down = 0.5 - latitude / PI;
        let (column, row) = if self.on_poles {
            (across * real(self.width - 1), down * real(self.height - 1))
        } else {
            (across * real(self.width) - 0.5, down * real(self.height) - 0.5)
        };
        let ((x0, fx), (y0, fy)) = (split(column), split(row));
        if let (Ok(x), Ok(y)) = (usize::try_from(x0), usize::try_from(y0))
            && x + 1 < self.width
            && y + 1 < self.height
        {
            // Well inside, as nearly always: the same taps without a thought for the borders.
            let above = &self.texels[y * self.width + x..][..2];
            let below = &self.texels[(y + 1) * self.width + x..][..2];
            let line = |row: &[[f32; 3]]| mix(row[0].map(f64::from), row[1].map(f64::from), fx);
            return mix(line(above), line(below), fy);
        }
        let line = |y| mix(self.tap(x0, y), self.tap(x0 + 1, y), fx);
        mix(line(y0), line(y0 + 1), fy)
    }

    /// The map as a cube: per texel the mean of n² look-ups at the centres of its sub-squares, n as
    /// `samples_per_side` has it for the map's finest direction.
    ///
    /// Angles are computed once for one side face and for +y; the other faces are turns and mirror
    /// images of these.
    pub(super) fn to_cube(&self, size: usize) -> CubeLevel {
        // In the middle of a face a texel spans 2/size radians; the map has width/2π columns and
        // height/π rows a radian. The second bound only matters far from 2:1: it keeps the look-ups
        // below 6 a pixel of the map.
        let (w, h) = (real(self.width), real(self.height));
        let finest = w.max(2.0 * h).min(PI / 2.0 * (w * h).sqrt());
        let side = samples_per_side(finest / (PI * real(size)));
        let centres = centres(size, side);
        let turns: Vec<f64> = centres.iter().map(|u| libm::atan(*u) / TAU).collect();
        let count = real(side * side);
        let rows: Vec<Vec<[[f32; 3]; 6]>> = (0..size)
            .into_par_iter()
            .map(|y| {
                let mut sums = vec![[[0.0; 3]; 6]; size];
                for v in &centres[y * side..(y + 1) * side] {
                    for (k, (u, turn)) in centres.iter().zip(&turns).enumerate() {
                        self.add(&mut sums[k / side], *u, *v, *turn);
                    }
                }
                let mean = |sum: [f64; 3]| sum.map(|c| num::f32(c / count));
                sums.into_iter().map(|faces| faces.map(mean)).collect()
            })
            .collect();
        let texels =
            (0..6).flat_map(|face| rows.iter().flatten().map(move |faces| faces[face])).collect();
        CubeLevel { size, texels }
    }

    /// Adds the look-up at (u, v) of each face; `turn` is atan(u) in turns.
    fn add(&self, sums: &mut [[f64; 3]; 6], u: f64, v: f64, turn: f64) {
        let mut add = |face: usize, turns: f64, latitude: f64| {
            let colour = self.lookup(turns, latitude);
            for (s, c) in sums[face].iter_mut().zip(colour) {
                *s += c;
            }
        };
        // Side faces: +z holds (u, −v, 1); +x, −z, −x follow at a quarter turn each.
        let latitude = libm::atan2(-v, (1.0 + u * u).sqrt());
        for (quarters, face) in [4, 0, 5, 1].into_iter().enumerate() {
            add(face, turn + 0.25 * real(quarters), latitude);
        }
        // +y holds (u, 1, v), −y (u, −1, −v).
        let around = libm::atan2(u, v) / TAU;
        let latitude = libm::atan2(1.0, (u * u + v * v).sqrt());
        add(2, around, latitude);
        add(3, 0.5 - around, -latitude);
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
        let index = num::usize(y * w + x);
        self.texels[index].map(f64::from)
    }
}

fn as_i64(n: usize) -> i64 {
    num::i64(n)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// x, y, z of each sample's own direction plus 2 (so that nothing is negative).
    fn directions(width: usize, height: usize, on_poles: bool) -> LatLong {
        let mut texels = Vec::new();
        for row in 0..height {
            for column in 0..width {
                let (a, d) = if on_poles {
                    (real(column) / real(width - 1), real(row) / real(height - 1))
                } else {
                    ((real(column) + 0.5) / real(width), (real(row) + 0.5) / real(height))
                };
                let (lon, lat) = (PI - 2.0 * PI * a, PI / 2.0 - PI * d);
                let v = [
                    libm::sin(lon) * libm::cos(lat),
                    libm::sin(lat),
                    libm::cos(lon) * libm::cos(lat),
                ];
                texels.push(v.map(|c| num::f32(c + 2.0)));
            }
        }
        LatLong { width, height, texels, on_poles }
    }

    #[test]
    fn a_lookup_returns_the_direction_stored_there_on_both_grids() {
        // Bilinear interpolation of sin and cos on a grid of step h errs by at most h²/8 an axis
        // (both factors are at most 1); f32 storage of numbers up to 3 adds 1.2e-7.
        let step = 2.0 * PI / 127.0;
        let bound = 2.0 * step * step / 8.0 + 1.2e-7;
        for on_poles in [false, true] {
            let map = directions(128, 64, on_poles);
            for i in 0..2000u32 {
                let t = f64::from(i);
                let y = 1.0 - 2.0 * (t + 0.5) / 2000.0;
                let r = (1.0 - y * y).sqrt();
                let d = [r * libm::cos(t * 2.4), y, r * libm::sin(t * 2.4)];
                let turns = libm::atan2(d[0], d[2]) / TAU;
                let got = map.lookup(turns, libm::asin(d[1]));
                for (g, d) in got.into_iter().zip(d) {
                    assert!((g - 2.0 - d).abs() <= bound, "{on_poles} {i}: {g} {d}");
                }
            }
        }
    }

    #[test]
    fn every_texel_of_the_cube_holds_the_mean_direction_of_its_square() {
        // The look-ups err as above; the mean over the sub-squares is compared with the mean of the
        // exact unit directions at the same places.
        let step = 2.0 * PI / 127.0;
        let bound = 2.0 * step * step / 8.0 + 2.4e-7;
        for (on_poles, size) in [(false, 32), (true, 32), (false, 5), (true, 1)] {
            let cube = directions(128, 64, on_poles).to_cube(size);
            let side = samples_per_side(128.0 / (PI * real(size)));
            let centres = centres(size, side);
            for face in 0..6 {
                for (y, x) in (0..size * size).map(|i| (i / size, i % size)) {
                    let mut mean = [0.0; 3];
                    for v in &centres[y * side..(y + 1) * side] {
                        for u in &centres[x * side..(x + 1) * side] {
                            let d = crate::cube::direction(face, *u, *v);
                            let length = d.iter().map(|c| c * c).sum::<f64>().sqrt();
                            for (m, c) in mean.iter_mut().zip(d) {
                                *m += c / length / real(side * side);
                            }
                        }
                    }
                    for (g, m) in cube.texel(face, x, y).into_iter().zip(mean) {
                        assert!((f64::from(g) - 2.0 - m).abs() <= bound, "{face} {x} {y}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_constant_map_makes_an_exactly_constant_cube() {
        let colour = [0.1, 33_952.0, 3.0e-8];
        for (width, height, on_poles) in [(1, 1, false), (1, 1, true), (8, 4, false), (7, 3, true)]
        {
            let texels = vec![colour; width * height];
            let map = LatLong { width, height, texels, on_poles };
            let cube = map.to_cube(3);
            assert!(cube.texels.iter().all(|t| t.map(f32::to_bits) == colour.map(f32::to_bits)));
        }
    }
}
