//! The roughness pyramid: means and covariances of a bump map's offsets, level by level.
//!
//! Level L has max(1, ⌊size/2^L⌋) texels along each side; a texel covers an equal share of the map, for
//! a power of two exactly 2^L × 2^L texels, otherwise with parts of texels at its border. Means and
//! covariances come from ALL covered texels of level 0, about the mean (two passes: nothing cancels).

use std::sync::Arc;

use rayon::prelude::*;

use super::bump::{BumpMap, Taps};
use crate::policy::{Curvature, RoughnessInterpolation};

/// What a texel of the pyramid holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    /// Mean of b1, b2.
    pub mean: [f64; 2],
    /// Covariance a, b, c of b1, b2; under [`Curvature::Surface`] about the linear trend, not the mean.
    pub covariance: [f64; 3],
    /// Least-squares slope of b1, b2 by column (first) and row, per texel of level 0.
    pub trend: [[f64; 2]; 2],
}

/// One level of the pyramid.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// Texels along a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Row by row from the top.
    pub texels: Vec<Moments>,
}

/// A bump map with its filtered means and its roughness.
#[derive(Clone, Debug)]
pub struct Pyramid {
    map: Arc<BumpMap>,
    /// Levels from 1 on; level 0 is the map itself.
    above: Vec<Level>,
    curvature: Curvature,
    interpolation: RoughnessInterpolation,
}

/// A trilinear look-up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filtered {
    /// Mean offsets b1, b2.
    pub bump: [f64; 2],
    /// Factors d1, d2, d3 of the roughness.
    pub rough: [f64; 3],
    /// ∂b1, ∂b2 by s (first) and by t; zero unless the curvature belongs to the surface.
    pub slope: [[f64; 2]; 2],
}

impl Pyramid {
    /// Builds every level down to 1 × 1.
    #[must_use]
    pub fn new(
        map: Arc<BumpMap>,
        curvature: Curvature,
        interpolation: RoughnessInterpolation,
    ) -> Self {
        let (width, height) = (map.width(), map.height());
        let count = width.max(height).ilog2();
        let above = (1..=count)
            .map(|level| {
                build_level(
                    &map,
                    (width >> level).max(1),
                    (height >> level).max(1),
                    curvature,
                )
            })
            .collect();
        Self {
            map,
            above,
            curvature,
            interpolation,
        }
    }

    /// The bump map.
    #[must_use]
    pub fn map(&self) -> &BumpMap {
        &self.map
    }

    /// Number of levels, level 0 included.
    #[must_use]
    pub fn levels(&self) -> usize {
        self.above.len() + 1
    }

    /// Columns and rows of a level, which must be there.
    #[must_use]
    pub fn size(&self, level: usize) -> [usize; 2] {
        match level.checked_sub(1) {
            None => [self.map.width(), self.map.height()],
            Some(above) => [self.above[above].width, self.above[above].height],
        }
    }

    /// The contents of a texel. On level 0 the covariance is zero, and the trend is the central
    /// difference of the neighbours.
    #[must_use]
    pub fn texel(&self, level: usize, x: usize, y: usize) -> Moments {
        if let Some(above) = level.checked_sub(1) {
            let level = &self.above[above];
            return level.texels[y * level.width + x];
        }
        let trend = match self.curvature {
            Curvature::Pyramid => [[0.0; 2]; 2],
            Curvature::Surface => {
                let (w, h) = (self.map.width(), self.map.height());
                let half = |a: [f64; 2], b: [f64; 2]| [(a[0] - b[0]) / 2.0, (a[1] - b[1]) / 2.0];
                [
                    half(
                        self.map.texel((x + 1) % w, y),
                        self.map.texel((x + w - 1) % w, y),
                    ),
                    half(
                        self.map.texel(x, (y + 1) % h),
                        self.map.texel(x, (y + h - 1) % h),
                    ),
                ]
            }
        };
        Moments {
            mean: self.map.texel(x, y),
            covariance: [0.0; 3],
            trend,
        }
    }

    /// Level of detail of a pair of screen derivatives of (s, t), by the D3D rule: log2 of the longer
    /// one in texels of level 0, clamped to the chain.
    #[must_use]
    pub fn lod(&self, st_dx: [f64; 2], st_dy: [f64; 2]) -> f64 {
        let (w, h) = (self.map.width() as f64, self.map.height() as f64);
        let square = |d: [f64; 2]| {
            let (s, t) = (d[0] * w, d[1] * h);
            s * s + t * t
        };
        let longer = square(st_dx).max(square(st_dy));
        let top = self.above.len() as f64;
        // Also 0 for derivatives that are zero or not numbers.
        if longer > 1.0 {
            (libm::log2(longer) / 2.0).min(top)
        } else {
            0.0
        }
    }

    /// Trilinear look-up at (s, t), repeating.
    ///
    /// `Moments`: the taps are a mixture of distributions, so the spread of their means counts with
    /// their covariances (it is what interpolating raw moments and subtracting the mean's square gives,
    /// without the cancellation). `Factors`: d1, d2, d3 are interpolated as numbers, so it does not.
    /// Where the trend belongs to the surface, the spread that the trend explains is left out.
    #[must_use]
    pub fn look_up(&self, s: f64, t: f64, lod: f64) -> Filtered {
        let taps = self.taps(s, t, lod);
        let mut bump = [0.0; 2];
        let mut trend = [[0.0; 2]; 2];
        for tap in &taps {
            for i in 0..2 {
                bump[i] += tap.weight * tap.moments.mean[i];
                trend[0][i] += tap.weight * tap.moments.trend[0][i];
                trend[1][i] += tap.weight * tap.moments.trend[1][i];
            }
        }
        let mut rough = [0.0; 3];
        match self.interpolation {
            RoughnessInterpolation::Factors => {
                for tap in &taps {
                    let d = factors(tap.moments.covariance);
                    for i in 0..3 {
                        rough[i] += tap.weight * d[i];
                    }
                }
            }
            RoughnessInterpolation::Moments => {
                let mut covariance = [0.0; 3];
                for Tap {
                    weight,
                    offset: [x, y],
                    moments,
                } in &taps
                {
                    let rest = [0, 1]
                        .map(|i| moments.mean[i] - bump[i] - (trend[0][i] * x + trend[1][i] * y));
                    let [a, b, c] = moments.covariance;
                    covariance[0] += weight * (a + rest[0] * rest[0]);
                    covariance[1] += weight * (b + rest[0] * rest[1]);
                    covariance[2] += weight * (c + rest[1] * rest[1]);
                }
                rough = factors(covariance);
            }
        }
        let (w, h) = (self.map.width() as f64, self.map.height() as f64);
        Filtered {
            bump,
            rough,
            slope: [trend[0].map(|g| g * w), trend[1].map(|g| g * h)],
        }
    }

    /// The eight taps of a trilinear look-up; their weights sum to 1 but for rounding.
    fn taps(&self, s: f64, t: f64, lod: f64) -> [Tap; 8] {
        let mut level = 0;
        while level + 1 < self.levels() && (level + 1) as f64 <= lod {
            level += 1;
        }
        let between = (lod - level as f64).clamp(0.0, 1.0);
        let next = (level + 1).min(self.levels() - 1);
        let (w, h) = (self.map.width() as f64, self.map.height() as f64);
        let mut taps = [Tap::NONE; 8];
        for (four, (level, share)) in taps
            .chunks_exact_mut(4)
            .zip([(level, 1.0 - between), (next, between)])
        {
            let [width, height] = self.size(level);
            let (x, y) = (Taps::new(s, width), Taps::new(t, height));
            let (step_x, step_y) = (w / width as f64, h / height as f64);
            let columns = [
                (x.first, 1.0 - x.weight, -x.weight),
                (x.second, x.weight, 1.0 - x.weight),
            ];
            let rows = [
                (y.first, 1.0 - y.weight, -y.weight),
                (y.second, y.weight, 1.0 - y.weight),
            ];
            for (slot, tap) in four.iter_mut().enumerate() {
                let (column, weight_x, from_x) = columns[slot % 2];
                let (row, weight_y, from_y) = rows[slot / 2];
                *tap = Tap {
                    weight: share * weight_x * weight_y,
                    offset: [from_x * step_x, from_y * step_y],
                    moments: self.texel(level, column, row),
                };
            }
        }
        taps
    }
}

/// One texel of a look-up.
#[derive(Clone, Copy, Debug)]
struct Tap {
    weight: f64,
    /// The texel's centre from the place looked up, in texels of level 0.
    offset: [f64; 2],
    moments: Moments,
}

impl Tap {
    const NONE: Self = Self {
        weight: 0.0,
        offset: [0.0; 2],
        moments: Moments {
            mean: [0.0; 2],
            covariance: [0.0; 3],
            trend: [[0.0; 2]; 2],
        },
    };
}

/// d1, d2, d3 with [d1 d2; 0 d3]·[d1 d2; 0 d3]ᵀ = [a b; b c], the paper's appendix.
///
/// c = 0 gives d2 = 0, d1 = √a. Where a − b²/c is negative, which only rounding can cause, d1 = 0.
#[must_use]
pub fn factors([a, b, c]: [f64; 3]) -> [f64; 3] {
    let d3 = c.max(0.0).sqrt();
    if d3 > 0.0 {
        let d2 = b / d3;
        [(a - b * b / c).max(0.0).sqrt(), d2, d3]
    } else {
        [a.max(0.0).sqrt(), 0.0, 0.0]
    }
}

/// Builds one level straight from level 0.
fn build_level(map: &BumpMap, width: usize, height: usize, curvature: Curvature) -> Level {
    let columns: Vec<Vec<Piece>> = (0..width).map(|i| pieces(i, width, map.width())).collect();
    let texels = (0..height)
        .into_par_iter()
        .flat_map_iter(|j| {
            let rows = pieces(j, height, map.height());
            columns
                .iter()
                .map(move |columns| moments(map, columns, &rows, curvature))
                .collect::<Vec<_>>()
        })
        .collect();
    Level {
        width,
        height,
        texels,
    }
}

/// A texel of level 0, or a part of one, inside a texel of a level, along one side.
#[derive(Clone, Copy, Debug)]
struct Piece {
    index: usize,
    /// Share of the level's texel; the shares sum to 1.
    share: f64,
    /// The piece's centre from the centre of the level's texel, in texels of level 0.
    offset: f64,
}

/// The pieces of texel `i` of `count` along a side of `size` texels, in integers of 1/count texel.
fn pieces(i: usize, count: usize, size: usize) -> Vec<Piece> {
    let (start, end) = (i * size, (i + 1) * size);
    (start / count..end.div_ceil(count))
        .map(|index| {
            let (from, to) = ((index * count).max(start), ((index + 1) * count).min(end));
            let twice = |a: usize, b: usize| (a + b) as f64;
            Piece {
                index,
                share: (to - from) as f64 / size as f64,
                offset: (twice(from, to) - twice(start, end)) / (2.0 * count as f64),
            }
        })
        .collect()
}

/// Mean, covariance and trend of a texel. Sums run along rows first, so that rounding grows with the
/// texel's sides, not with its area.
fn moments(map: &BumpMap, columns: &[Piece], rows: &[Piece], curvature: Curvature) -> Moments {
    let sum = |value: &dyn Fn(&Piece, &Piece) -> f64| -> f64 {
        let row = |row: &Piece| -> f64 { columns.iter().map(|c| c.share * value(c, row)).sum() };
        rows.iter().map(|r| r.share * row(r)).sum()
    };
    let b = |i: usize| move |c: &Piece, r: &Piece| map.texel(c.index, r.index)[i];
    let mean = [sum(&b(0)), sum(&b(1))];
    let trend = match curvature {
        Curvature::Pyramid => [[0.0; 2]; 2],
        Curvature::Surface => {
            // The shares are a product of one for columns and one for rows, so the two slopes separate.
            let along = |square: f64, offset: &dyn Fn(&Piece, &Piece) -> f64| {
                [0, 1].map(|i| {
                    let slope = sum(&|c, r| offset(c, r) * (b(i)(c, r) - mean[i])) / square;
                    if square > 0.0 { slope } else { 0.0 }
                })
            };
            let square = |pieces: &[Piece]| -> f64 {
                pieces.iter().map(|p| p.share * p.offset * p.offset).sum()
            };
            [
                along(square(columns), &|c, _| c.offset),
                along(square(rows), &|_, r| r.offset),
            ]
        }
    };
    let rest = |i: usize| {
        move |c: &Piece, r: &Piece| {
            b(i)(c, r) - mean[i] - (trend[0][i] * c.offset + trend[1][i] * r.offset)
        }
    };
    let (first, second) = (rest(0), rest(1));
    Moments {
        mean,
        covariance: [
            sum(&|c, r| first(c, r) * first(c, r)),
            sum(&|c, r| first(c, r) * second(c, r)),
            sum(&|c, r| second(c, r) * second(c, r)),
        ],
        trend,
    }
}
