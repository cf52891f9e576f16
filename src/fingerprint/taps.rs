//! Probes of the anisotropic filter: where its bilinear taps lie, and which texels it reads with what weights.
//!
//! Two measurements that know nothing of each other. **Hinge**: the texture max(0, x), bilinearly interpolated, has one
//! kink, at x = 0. Swept under the hinge, each tap draws a kink where it crosses it; the second difference of the sweep is
//! a comb with a tooth for each tap, as high as the tap's weight. A tooth between two points of the sweep is shared by both, so
//! its place is finer than the sweep. The texture max(0, x)·y gives the other coordinate in the same way. **Transfer**: a texture
//! that is 1 at one texel and 0 elsewhere returns this texel's weight; four at a time, one in each channel.

use super::unit::{
    Format, Image, Query, Shape, Source, State, TextureUnit, alone, to_f32, to_index,
};
use crate::gpu::GpuError;

/// Texels along an edge of the hinge.
const HINGE: usize = 64;
/// Points of the sweep in a texel.
const FINE: usize = 16;
/// Texels that the sweep reaches to either side: half the longest line and two more.
const REACH: usize = 10;
/// A tooth below this share of the whole weight is noise.
const NOISE: f64 = 1.0 / 512.0;

/// A bilinear tap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tap {
    /// Place relative to the query's, in texels of the level that is read most.
    pub offset: [f64; 2],
    /// Its share.
    pub weight: f64,
}

/// A footprint that is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    /// Largest anisotropy.
    pub clamp: u16,
    /// Longer over shorter derivative; the shorter one is one texel.
    pub ratio: f64,
    /// Direction of the longer one in degrees, from +x to +y.
    pub degrees: f64,
}

impl Footprint {
    /// The derivatives in texels.
    #[must_use]
    pub fn derivatives(&self) -> [[f64; 2]; 2] {
        let (sin, cos) = (
            libm::sin(self.degrees.to_radians()),
            libm::cos(self.degrees.to_radians()),
        );
        // Multiples of 90 degrees are exact.
        let snap = |x: f64| if x.abs() < 1e-12 { 0.0 } else { x };
        let (sin, cos) = (snap(sin), snap(cos));
        [[self.ratio * cos, self.ratio * sin], [-sin, cos]]
    }
}

/// Taps of a footprint.
#[derive(Clone, Debug)]
pub struct Taps {
    /// What was asked for.
    pub footprint: Footprint,
    /// λ that it got.
    pub lod: f64,
    /// The taps along the line.
    pub taps: Vec<Tap>,
    /// Largest tooth that points down, as a share: large where the filter is no sum of bilinear taps.
    pub negative: f64,
}

impl Taps {
    /// Mean distance between neighbours and its largest deviation, in texels; nothing for a single tap.
    #[must_use]
    pub fn spacing(&self) -> Option<[f64; 2]> {
        let gaps: Vec<f64> = self
            .taps
            .windows(2)
            .map(|w| {
                libm::hypot(
                    w[1].offset[0] - w[0].offset[0],
                    w[1].offset[1] - w[0].offset[1],
                )
            })
            .collect();
        let mean = gaps.iter().sum::<f64>() / gaps.len() as f64;
        let off = gaps.iter().map(|g| (g - mean).abs()).fold(0.0, f64::max);
        (!gaps.is_empty()).then_some([mean, off])
    }

    /// Whether the taps explain the sweep: their weights sum to 1 within 1/64 and no tooth points down by more.
    #[must_use]
    pub fn explains(&self) -> bool {
        let sum: f64 = self.taps.iter().map(|t| t.weight).sum();
        (sum - 1.0).abs() < 1.0 / 64.0 && self.negative < 1.0 / 64.0
    }
}

/// The format with the finest results.
fn finest(unit: &dyn TextureUnit) -> Format {
    if unit.filters(Format::Float) {
        Format::Float
    } else {
        Format::Half
    }
}

/// Hinges along x and y in one level, the others empty: max(0, x), max(0, x)·y, max(0, y), max(0, y)·x.
fn hinge(format: Format, in_level: usize) -> Image {
    Image::new(Shape::Planar, format, HINGE, 7, |level, _, x, y| {
        if level != in_level {
            return [0.0; 4];
        }
        let half = (HINGE >> level) as f32 / 2.0;
        let [x, y] = [x as f32 - half, y as f32 - half];
        [x.max(0.0), x.max(0.0) * y, y.max(0.0), y.max(0.0) * x]
    })
}

/// Finds the taps of footprints by hinges.
///
/// # Errors
///
/// What the device reports.
pub fn taps(
    unit: &mut dyn TextureUnit,
    source: Source,
    footprints: &[Footprint],
) -> Result<Vec<Taps>, GpuError> {
    let format = finest(unit);
    let mut found = Vec::new();
    for footprint in footprints {
        let state = State::trilinear(footprint.clamp);
        let centre = [(HINGE as f64 + 1.0) / 2.0; 2];
        let numbered = super::levels::numbered(Shape::Planar, HINGE, 7);
        let lod = alone(unit, &numbered, state, source, &[place(footprint, centre)])?[0][0];
        let level = to_index(lod.round().into()).min(3);
        // The level's own share of the colours.
        let share = 1.0 - (f64::from(lod) - level as f64).abs();
        let texel = libm::exp2(level as f64);
        let [dx, _] = footprint.derivatives();
        let along = usize::from(dx[1].abs() > dx[0].abs());
        let count = 2 * REACH * FINE + 1;
        let queries: Vec<Query> = (0..count)
            .map(|s| {
                let shift = (s as f64 / FINE as f64 - REACH as f64) * texel;
                let mut at = [(HINGE as f64 + texel) / 2.0; 2];
                at[along] += shift;
                place(footprint, at)
            })
            .collect();
        let seen = alone(unit, &hinge(format, level), state, source, &queries)?;
        found.push(comb(*footprint, lod.into(), &seen, along, share));
    }
    Ok(found)
}

/// A look-up with a footprint on a texture of `size` texels, at a place in texels.
#[must_use]
pub fn query_on(footprint: &Footprint, size: usize, at: [f64; 2]) -> Query {
    let scale = |v: [f64; 2]| [0, 1, 2].map(|i| v.get(i).map_or(0.0, |c| to_f32(c / size as f64)));
    let [dx, dy] = footprint.derivatives();
    Query {
        at: scale(at),
        dx: scale(dx),
        dy: scale(dy),
        lod: 0.0,
    }
}

fn place(footprint: &Footprint, at: [f64; 2]) -> Query {
    query_on(footprint, HINGE, at)
}

/// Teeth of a sweep: each run of neighbouring points with weight is one tap.
fn comb(footprint: Footprint, lod: f64, seen: &[[f32; 4]], along: usize, share: f64) -> Taps {
    let channel = |c: usize, s: usize| f64::from(seen[s][2 * along + c]);
    let tooth = |c: usize, s: usize| {
        (channel(c, s - 1) - 2.0 * channel(c, s) + channel(c, s + 1)) * FINE as f64 / share
    };
    let (mut taps, mut negative) = (Vec::new(), 0.0f64);
    let mut run = [0.0; 3];
    for s in 1..seen.len() - 1 {
        let weight = tooth(0, s);
        negative = negative.max(-weight);
        if weight > NOISE {
            let offset = REACH as f64 - s as f64 / FINE as f64;
            run = [
                run[0] + weight,
                run[1] + weight * offset,
                run[2] + tooth(1, s),
            ];
        } else if run[0] > 0.0 {
            let [weight, first, second] = run;
            let mut offset = [second / weight; 2];
            offset[along] = first / weight;
            taps.push(Tap { offset, weight });
            run = [0.0; 3];
        }
    }
    taps.reverse();
    Taps {
        footprint,
        lod,
        taps,
        negative,
    }
}

/// Every texel that a look-up reads, with its weight.
#[derive(Clone, Debug)]
pub struct Transfer {
    /// Texels along an edge of level 0.
    pub size: usize,
    /// Weights of each level, laid out like an [`Image`]'s texels.
    pub levels: Vec<Vec<f32>>,
}

impl Transfer {
    /// Sum of a level's weights.
    #[must_use]
    pub fn level(&self, level: usize) -> f64 {
        self.levels[level].iter().map(|w| f64::from(*w)).sum()
    }

    /// The level with the largest weight.
    #[must_use]
    pub fn main_level(&self) -> usize {
        (0..self.levels.len())
            .max_by(|a, b| self.level(*a).total_cmp(&self.level(*b)))
            .unwrap_or(0)
    }

    /// Texels with weight.
    #[must_use]
    pub fn texels(&self) -> usize {
        self.levels.iter().flatten().filter(|w| **w != 0.0).count()
    }

    /// Centroid of a planar level's weights, relative to a place in texels, and the lengths of boxes with the same variance along
    /// a direction and across it.
    #[must_use]
    pub fn moments(&self, level: usize, at: [f64; 2], axis: [f64; 2]) -> ([f64; 2], [f64; 2]) {
        let side = (self.size >> level).max(1);
        let points = || {
            self.levels[level].iter().enumerate().map(|(i, w)| {
                let place = [i % side, i / side].map(|c| c as f64 + 0.5);
                (f64::from(*w), [place[0] - at[0], place[1] - at[1]])
            })
        };
        let total = points().map(|(w, _)| w).sum::<f64>().max(f64::MIN_POSITIVE);
        let mean = [0, 1].map(|i| points().map(|(w, p)| w * p[i]).sum::<f64>() / total);
        let spread = [axis, [-axis[1], axis[0]]].map(|axis| {
            let off = |p: [f64; 2]| (p[0] - mean[0]) * axis[0] + (p[1] - mean[1]) * axis[1];
            let variance = points().map(|(w, p)| w * off(p) * off(p)).sum::<f64>() / total;
            libm::sqrt(12.0 * variance)
        });
        (mean, spread)
    }
}

/// Measures the transfer of look-ups on a texture of `size` with `levels` levels.
///
/// # Errors
///
/// What the device reports.
pub fn transfer(
    unit: &mut dyn TextureUnit,
    (shape, size, levels): (Shape, usize, usize),
    state: State,
    source: Source,
    queries: &[Query],
) -> Result<Vec<Transfer>, GpuError> {
    let format = finest(unit);
    let count = |level: usize| shape.faces() * (size >> level).max(1).pow(2);
    let empty = Transfer {
        size,
        levels: (0..levels).map(|l| vec![0.0; count(l)]).collect(),
    };
    let mut found = vec![empty; queries.len()];
    let mut image = Image::new(shape, format, size, levels, |_, _, _, _| [0.0; 4]);
    for level in 0..levels {
        for first in (0..count(level)).step_by(4) {
            let four = first..(first + 4).min(count(level));
            for (channel, texel) in four.clone().enumerate() {
                image.levels[level][texel][channel] = 1.0;
            }
            let seen = alone(unit, &image, state, source, queries)?;
            for (transfer, color) in found.iter_mut().zip(seen) {
                for (channel, texel) in four.clone().enumerate() {
                    transfer.levels[level][texel] = color[channel];
                }
            }
            image.levels[level][four].fill([0.0; 4]);
        }
    }
    Ok(found)
}
