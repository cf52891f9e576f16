//! The roughness pyramid: means and covariances of a bump map's offsets, level by level.
//!
//! How a level comes from the map is in [`moments`](super::moments); here is how it is looked up.

use std::sync::Arc;

use super::bump::{BumpMap, Taps};
use super::moments::{Level, Moments, build_level};
use crate::policy::{Curvature, RoughnessInterpolation};

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

impl Filtered {
    /// The look-up for a map that is seen from its back: b2 and all that goes with it change sign.
    pub(super) fn turn_b2(&mut self) {
        self.bump[1] = -self.bump[1];
        self.rough[1] = -self.rough[1];
        self.slope[0][1] = -self.slope[0][1];
        self.slope[1][1] = -self.slope[1][1];
    }
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
                build_level(&map, (width >> level).max(1), (height >> level).max(1), curvature)
            })
            .collect();
        Self { map, above, curvature, interpolation }
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
                    half(self.map.texel((x + 1) % w, y), self.map.texel((x + w - 1) % w, y)),
                    half(self.map.texel(x, (y + 1) % h), self.map.texel(x, (y + h - 1) % h)),
                ]
            }
        };
        Moments { mean: self.map.texel(x, y), covariance: [0.0; 3], trend }
    }

    /// Variance of the position inside a texel along columns and rows, in square texels of level 0.
    fn spread(&self, level: usize, x: usize, y: usize) -> [f64; 2] {
        match level.checked_sub(1) {
            None => [0.0; 2],
            Some(above) => {
                let [columns, rows] = &self.above[above].spread;
                [columns[x], rows[y]]
            }
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
        if longer > 1.0 { (libm::log2(longer) / 2.0).min(top) } else { 0.0 }
    }

    /// Trilinear look-up at (s, t), repeating.
    ///
    /// `Moments`: the taps are a mixture of distributions, so the spread of their means counts with
    /// their covariances (it is what interpolating raw moments and subtracting the mean's square gives,
    /// without the cancellation). `Factors`: d1, d2, d3 are interpolated as numbers, so it does not.
    ///
    /// [`Curvature::Surface`]: the slope is that of the least-squares plane through the whole mixture
    /// (at level 0 between two texels: their difference), and the roughness is what is left about it.
    #[must_use]
    pub fn look_up(&self, s: f64, t: f64, lod: f64) -> Filtered {
        let taps = self.taps(s, t, lod);
        let mut bump = [0.0; 2];
        for tap in &taps {
            for (sum, mean) in bump.iter_mut().zip(tap.moments.mean) {
                *sum += tap.weight * mean;
            }
        }
        let slope = match self.curvature {
            Curvature::Pyramid => [[0.0; 2]; 2],
            Curvature::Surface => plane(&taps, bump),
        };
        let rough = match self.interpolation {
            RoughnessInterpolation::Factors => {
                let mut rough = [0.0; 3];
                for tap in &taps {
                    let d = factors(tap.moments.covariance);
                    for i in 0..3 {
                        rough[i] += tap.weight * d[i];
                    }
                }
                rough
            }
            RoughnessInterpolation::Moments => factors(mixture(&taps, bump, slope)),
        };
        let (w, h) = (self.map.width() as f64, self.map.height() as f64);
        Filtered { bump, rough, slope: [slope[0].map(|g| g * w), slope[1].map(|g| g * h)] }
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
        for (four, (level, share)) in
            taps.chunks_exact_mut(4).zip([(level, 1.0 - between), (next, between)])
        {
            let [width, height] = self.size(level);
            let (x, y) = (Taps::new(s, width), Taps::new(t, height));
            let (step_x, step_y) = (w / width as f64, h / height as f64);
            let columns =
                [(x.first, 1.0 - x.weight, -x.weight), (x.second, x.weight, 1.0 - x.weight)];
            let rows = [(y.first, 1.0 - y.weight, -y.weight), (y.second, y.weight, 1.0 - y.weight)];
            for (slot, tap) in four.iter_mut().enumerate() {
                let (column, weight_x, from_x) = columns[slot % 2];
                let (row, weight_y, from_y) = rows[slot / 2];
                *tap = Tap {
                    weight: share * weight_x * weight_y,
                    offset: [from_x * step_x, from_y * step_y],
                    spread: self.spread(level, column, row),
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
    /// Variance of the position inside the texel.
    spread: [f64; 2],
    moments: Moments,
}

impl Tap {
    const NONE: Self = Self {
        weight: 0.0,
        offset: [0.0; 2],
        spread: [0.0; 2],
        moments: Moments { mean: [0.0; 2], covariance: [0.0; 3], trend: [[0.0; 2]; 2] },
    };
}

/// Least-squares slopes of b1, b2 by column (first) and row over all taps. Tap weights and texels are
/// products of a column's and a row's part, so the two directions separate.
fn plane(taps: &[Tap; 8], bump: [f64; 2]) -> [[f64; 2]; 2] {
    [0, 1].map(|axis| {
        let mut spread = 0.0;
        let (mut products, mut mean_trend) = ([0.0; 2], [0.0; 2]);
        for tap in taps {
            let offset = tap.offset[axis];
            spread += tap.weight * (tap.spread[axis] + offset * offset);
            for i in 0..2 {
                let trend = tap.moments.trend[axis][i];
                let between = (tap.moments.mean[i] - bump[i]) * offset;
                products[i] += tap.weight * (trend * tap.spread[axis] + between);
                mean_trend[i] += tap.weight * trend;
            }
        }
        // On the centre of a texel of level 0 nothing is spread: the neighbours' difference stands.
        if spread > 0.0 { products.map(|p| p / spread) } else { mean_trend }
    })
}

/// Covariance of the mixture of all taps about the plane with mean `bump` and slopes `slope`.
fn mixture(taps: &[Tap; 8], bump: [f64; 2], slope: [[f64; 2]; 2]) -> [f64; 3] {
    let mut covariance = [0.0; 3];
    for tap in taps {
        let mut add = |parts: [f64; 2], share: f64| {
            covariance[0] += share * parts[0] * parts[0];
            covariance[1] += share * parts[0] * parts[1];
            covariance[2] += share * parts[1] * parts[1];
        };
        let [x, y] = tap.offset;
        // The texel's mean off the plane, and its own trend against the plane's.
        add(
            [0, 1].map(|i| tap.moments.mean[i] - bump[i] - (slope[0][i] * x + slope[1][i] * y)),
            tap.weight,
        );
        for (axis, slope) in slope.iter().enumerate() {
            let against = [0, 1].map(|i| tap.moments.trend[axis][i] - slope[i]);
            add(against, tap.weight * tap.spread[axis]);
        }
        for (sum, own) in covariance.iter_mut().zip(tap.moments.covariance) {
            *sum += tap.weight * own;
        }
    }
    covariance
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
