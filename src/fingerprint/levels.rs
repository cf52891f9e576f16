//! Probes of the level of detail: its weights, its curve, which length the derivatives have.

use super::rho::Rho;
use super::steps::{SWEEP, Staircase, fraction, grid_bits, staircase};
use crate::base::named::named;
use crate::base::num;
use crate::base::random::Random;
use crate::error::InputError;
use crate::sampler::{Format, Image, Query, Shape, Source, State, TextureUnit, alone};

/// Texels along an edge of level 0.
pub const SIZE: usize = 256;
/// Levels of the chain.
pub const LEVELS: usize = 9;
/// Points of the curve in an octave.
pub const CURVE: usize = 256;
/// Octaves that the curve's picture covers, from half a texel a pixel on.
pub const OCTAVES: usize = 6;
/// Random pairs of derivatives that tell the rules of length apart.
const PAIRS: usize = 512;

/// A texture whose texels are their level's number in red.
#[must_use]
pub fn numbered(shape: Shape, size: usize, levels: usize) -> Image {
    Image::new(shape, Format::Half, size, levels, |level, _, _, _| [level as f32, 0.0, 0.0, 1.0])
}

named! {
    /// Ways to take a logarithm of f32's exponent and mantissa.
    pub enum Log {
        /// Exact to the last bits.
        Exact = "log2 itself",
        /// Exponent and mantissa − 1 of ρ: straight lines from octave to octave.
        Mantissa = "straight lines between whole levels (exponent and mantissa of rho)",
        /// Half of that of ρ²: straight lines over half octaves.
        MantissaOfSquare = "straight lines between half levels (half of exponent and mantissa of rho squared)",
        /// Exact, but compressed to the middle half between two levels (Mesa's "brilinear").
        MiddleHalf = "log2, compressed to the middle half between two levels",
    }
}

impl Log {
    /// λ − ⌊log2 ρ⌋ for the fraction of log2 ρ.
    #[must_use]
    pub fn fraction(self, f: f64) -> f64 {
        match self {
            Self::Exact => f,
            Self::Mantissa => libm::exp2(f) - 1.0,
            Self::MantissaOfSquare => {
                let half = (2.0 * f).floor();
                (half + libm::exp2(2.0 * f - half) - 1.0) / 2.0
            }
            Self::MiddleHalf => (2.0 * f - 0.5).clamp(0.0, 1.0),
        }
    }

    /// One octave of a curve.
    #[must_use]
    pub fn octave(self) -> Vec<f64> {
        let mut octave: Vec<f64> =
            (0..SWEEP).map(|k| self.fraction(f64::from(k) / f64::from(SWEEP))).collect();
        octave.push(1.0);
        octave
    }
}

/// λ of a length's logarithm by one octave of a curve.
#[must_use]
pub fn lod_on(octave: &[f64], log2: f64) -> f64 {
    if log2.is_nan() || log2 <= 0.0 {
        return 0.0;
    }
    let points = octave.len() - 1;
    let place = (log2 - log2.floor()) * points as f64;
    let below = place.floor();
    let index = num::index(below).min(points - 1);
    let (a, b) = (octave[index], octave[index + 1]);
    log2.floor() + a + (b - a) * (place - below)
}

/// The level of detail over the logarithm of the length, as colours show it: weights between levels included.
#[derive(Clone, Debug)]
pub struct Curve {
    /// λ at log2 ρ = −1 + i/[`CURVE`].
    pub lods: Vec<f64>,
    /// One octave, from log2 ρ = 2 on: λ − 2 at its 4097 points, both ends included.
    pub octave: Vec<f64>,
    /// Smallest and largest λ − log2 ρ above log2 ρ = 0.
    pub error: [f64; 2],
    /// Largest difference between an octave and the next.
    pub repeats: f64,
    /// Fraction bits of λ, where all λ of an octave are multiples of 2^−bits.
    pub bits: Option<u32>,
    /// Different λ at 4097 points of that octave.
    pub distinct: usize,
    /// Ways to take the logarithm by their distance from the octave, the nearest first.
    pub logs: Vec<Fit<Log>>,
    /// With nearest levels: log2 ρ where level 1 gives way to level 2.
    pub nearest_switch: f64,
}

/// A query in the middle of the texture with derivatives in texels of level 0.
#[must_use]
pub fn query(dx: [f64; 2], dy: [f64; 2]) -> Query {
    let scale = |v: [f64; 2]| [num::f32(v[0] / SIZE as f64), num::f32(v[1] / SIZE as f64), 0.0];
    Query { at: [0.5, 0.5, 0.0], dx: scale(dx), dy: scale(dy), lod: 0.0 }
}

/// The levels of detail that queries get.
pub fn lods(
    unit: &mut dyn TextureUnit,
    state: State,
    source: Source,
    queries: &[Query],
) -> Result<Vec<f64>, InputError> {
    let image = numbered(Shape::Planar, SIZE, LEVELS);
    let seen = alone(unit, &image, state, source, queries)?;
    Ok(seen.iter().map(|c| f64::from(c[0])).collect())
}

/// Weights between levels: the level of detail is given, from 2 to 3.
pub fn mip_weights(unit: &mut dyn TextureUnit) -> Result<Staircase, InputError> {
    let queries: Vec<Query> = (0..=SWEEP)
        .map(|k| Query {
            at: [0.5, 0.5, 0.0],
            lod: 2.0 + k as f32 / SWEEP as f32,
            ..Query::default()
        })
        .collect();
    let seen = lods(unit, State::trilinear(1), Source::Level, &queries)?;
    Ok(staircase(seen.into_iter().map(|lod| lod - 2.0).collect(), None))
}

/// The curve, of footprints that have a derivative along one axis alone: all rules of length agree on those.
pub fn curve(unit: &mut dyn TextureUnit) -> Result<Curve, InputError> {
    let line = |log2: f64| query([libm::exp2(log2), 0.0], [0.0; 2]);
    let state = State::trilinear(1);
    let place = |i: usize| i as f64 / CURVE as f64 - 1.0;
    let queries: Vec<Query> = (0..=OCTAVES * CURVE).map(|i| line(place(i))).collect();
    let measured = lods(unit, state, Source::Gradient, &queries)?;
    let mut error = [f64::INFINITY, f64::NEG_INFINITY];
    for (i, lod) in measured.iter().enumerate().skip(CURVE) {
        error = [error[0].min(lod - place(i)), error[1].max(lod - place(i))];
    }
    let mut repeats = 0.0f64;
    for i in CURVE..=(OCTAVES - 1) * CURVE {
        repeats = repeats.max((measured[i + CURVE] - measured[i] - 1.0).abs());
    }
    let fine: Vec<Query> =
        (0..=SWEEP).map(|k| line(2.0 + f64::from(k) / f64::from(SWEEP))).collect();
    let fine = lods(unit, state, Source::Gradient, &fine)?;
    let octave: Vec<f64> = fine.into_iter().map(|l| l - 2.0).collect();
    let bits = grid_bits(&octave);
    let distinct = staircase(octave.clone(), None).distinct;
    let points: Vec<(f64, f64)> =
        octave.iter().enumerate().map(|(k, l)| (fraction(k), *l)).take(SWEEP as usize).collect();
    let logs = rank(&Log::ALL, &points, |log, f| log.fraction(*f));
    let nearest = State { linear_mips: false, ..state };
    let switch: Vec<Query> =
        (0..=SWEEP).map(|k| line(1.0 + f64::from(k) / f64::from(SWEEP))).collect();
    let switch = lods(unit, nearest, Source::Gradient, &switch)?;
    let first = switch.iter().position(|l| *l > 1.5).unwrap_or(switch.len());
    Ok(Curve {
        lods: measured,
        octave,
        error,
        repeats,
        bits,
        distinct,
        logs,
        nearest_switch: 1.0 + first as f64 / f64::from(SWEEP),
    })
}

/// How well a rule explains the measured levels of detail.
#[derive(Clone, Copy, Debug)]
pub struct Fit<R> {
    /// The rule.
    pub rule: R,
    /// Largest distance in levels.
    pub worst: f64,
    /// Mean distance in levels.
    pub mean: f64,
}

impl<R> Fit<R> {
    /// A rule by its distances.
    #[must_use]
    pub fn of(rule: R, distances: &[f64]) -> Self {
        Self {
            rule,
            worst: distances.iter().copied().fold(0.0, f64::max),
            mean: distances.iter().sum::<f64>() / distances.len().max(1) as f64,
        }
    }
}

/// Rules by how well they fit, the best first; among equals the plainer, earlier one.
pub fn rank<R: Copy, T>(
    rules: &[R],
    cases: &[(T, f64)],
    predict: impl Fn(R, &T) -> f64,
) -> Vec<Fit<R>> {
    let mut fits: Vec<Fit<R>> = Vec::new();
    for rule in rules {
        let distances = cases.iter().map(|(case, seen)| (predict(*rule, case) - seen).abs());
        fits.push(Fit::of(*rule, &distances.collect::<Vec<_>>()));
    }
    fits.sort_by(|a, b| a.mean.total_cmp(&b.mean));
    fits
}

/// A number −1…1 from a seed.
#[must_use]
pub fn random(seed: u64) -> f64 {
    Random::new(seed).signed()
}

/// Which length of the derivatives counts: random pairs of them against each rule.
pub fn rho(unit: &mut dyn TextureUnit, curve: &Curve) -> Result<Vec<Fit<Rho>>, InputError> {
    let cases: Vec<[[f64; 2]; 2]> = (0..PAIRS as u64)
        .map(|i| {
            let r = |j| random(16 * i + j);
            // Lengths between 2 and 32 texels.
            let scale = libm::exp2(3.0 + 2.0 * r(4));
            [[r(0) * scale, r(1) * scale], [r(2) * scale, r(3) * scale]]
        })
        .collect();
    let queries: Vec<Query> = cases.iter().map(|[dx, dy]| query(*dx, *dy)).collect();
    let seen = lods(unit, State::trilinear(1), Source::Gradient, &queries)?;
    let cases: Vec<_> = cases.into_iter().zip(seen).collect();
    Ok(rank(&Rho::ALL, &cases, |rule, [dx, dy]| {
        lod_on(&curve.octave, libm::log2(rule.length(*dx, *dy)))
    }))
}
