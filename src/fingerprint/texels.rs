//! Probes of the filter between texels: weights, coordinates, the edge of the texture.

use super::steps::{SWEEP, Staircase, fraction, staircase};
use crate::base::num;
use crate::error::InputError;
use crate::sampler::{Format, Image, Query, Shape, Source, State, TextureUnit};

/// Texels along an edge of the probes' texture. With coordinates near 1/2 a float resolves 2^−24·16 = 2^−20 texel.
const SIZE: usize = 16;
/// log2 of the finest step of a coordinate that the fine sweeps make, in texels.
const FINE: i32 = -20;

/// Weights of one texel format.
#[derive(Clone, Debug)]
pub struct Weights {
    /// The format.
    pub format: Format,
    /// Weight of the right texel over the fraction of the column, and of the lower one over that of the row.
    pub axes: [Staircase; 2],
    /// Where no steps were seen: different weights at 256 coordinates 2^−20 texel apart.
    pub fine: Option<usize>,
    /// Largest distance of the weight of a 2 × 2 block's texel from the product of its column's and row's weight.
    pub separable: f64,
    /// Farthest sum of the four weights from 1.
    pub sum: f64,
}

/// Coordinates and edges.
#[derive(Clone, Debug)]
pub struct Coordinates {
    /// With a nearest filter: where between two texel centres the texel changes, in texels from their border.
    pub nearest_switch: f64,
    /// With a nearest filter: the same at the border between the last texel of a row and its clamped neighbour, that is
    /// whether any texel but the last one is seen beyond the edge.
    pub clamps: bool,
    /// Weights of the outermost texel at a quarter texel from the edge and 1000 texels beyond it: both 1 where the
    /// coordinate is clamped to the edge's texel.
    pub edge: [f64; 2],
}

fn at(x: f64, y: f64) -> Query {
    let size = num::u64(SIZE) as f64;
    Query { at: [num::f32(x / size), num::f32(y / size), 0.0], ..Query::default() }
}

/// A texture with one level whose texel (x, y) gives.
fn flat(format: Format, texel: impl Fn(usize, usize) -> [f32; 4]) -> Image {
    Image::new(Shape::Planar, format, SIZE, 1, |_, _, x, y| texel(x, y))
}

fn one_if(yes: bool) -> f32 {
    if yes { 1.0 } else { 0.0 }
}

/// The weight tables of a format: an impulse column in red, an impulse row in green; the coordinate runs from the
/// centre before the impulse to its own, in [`SWEEP`] steps, on both axes at once.
pub fn weights(unit: &mut dyn TextureUnit, format: Format) -> Result<Weights, InputError> {
    let linear = State::trilinear(1);
    let cross = flat(format, |x, y| [one_if(x == 8), one_if(y == 8), 0.0, 1.0]);
    let sweep: Vec<Query> =
        (0..=SWEEP).map(|k| 7.5 + f64::from(k) / f64::from(SWEEP)).map(|c| at(c, c)).collect();
    let seen = unit.sample(&cross, linear, Source::Level, &sweep)?;
    let colors = (format == Format::Unorm8).then_some(255.0);
    let axes = [0, 1].map(|axis| {
        let weights = seen.iter().map(|c| f64::from(c[axis]));
        staircase(weights.collect(), colors)
    });

    let fine = if axes[0].steps.size() > 1.0 / f64::from(SWEEP) {
        None
    } else {
        let queries: Vec<Query> = (0..256)
            .map(|k| 7.875 + f64::from(k) * libm::exp2(f64::from(FINE)))
            .map(|c| at(c, c))
            .collect();
        let seen = unit.sample(&cross, linear, Source::Level, &queries)?;
        Some(staircase(seen.iter().map(|c| f64::from(c[0])).collect(), None).distinct)
    };

    // Each texel of a 2 x 2 block has a channel of its own: one look-up returns its four weights.
    let block = flat(format, |x, y| [0, 1, 2, 3].map(|c| one_if(c == (x % 2) + 2 * (y % 2))));
    let step = 63;
    let mut queries = Vec::new();
    for i in 0..=65u32 {
        for j in 0..=65u32 {
            let [x, y] = [i, j].map(|k| 8.5 + f64::from(k * step) / f64::from(SWEEP));
            queries.push(at(x, y));
        }
    }
    let seen = unit.sample(&block, linear, Source::Level, &queries)?;
    let (mut separable, mut sum) = (0.0f64, 0.0f64);
    for four in seen {
        let [a, b, c, d] = four.map(f64::from);
        let (right, below) = (b + d, c + d);
        separable = separable.max((d - right * below).abs());
        sum = sum.max((a + b + c + d - 1.0).abs());
    }
    Ok(Weights { format, axes, fine, separable, sum })
}

/// Where the texel changes with a nearest filter, and the texels beyond the edge.
pub fn coordinates(unit: &mut dyn TextureUnit) -> Result<Coordinates, InputError> {
    let format = Format::Half;
    let numbered = flat(format, |x, _| [x as f32, 0.0, 0.0, 1.0]);
    // From half a texel before the border between texels 7 and 8 by bisection, down to the float's resolution.
    let (mut low, mut high) = (7.5, 8.5);
    while high - low > libm::exp2(f64::from(FINE)) {
        let middle = f64::midpoint(low, high);
        let seen = unit.sample(&numbered, State::nearest(), Source::Level, &[at(middle, 8.5)])?;
        if seen[0][0] >= 8.0 {
            high = middle;
        } else {
            low = middle;
        }
    }
    let last = SIZE - 1;
    let beyond = [at(15.999, 8.5), at(16.001, 8.5), at(25.0, 8.5), at(1016.0, 8.5)];
    let seen = unit.sample(&numbered, State::nearest(), Source::Level, &beyond)?;
    let clamps = seen.iter().all(|c| (c[0] - last as f32).abs() < 0.5);
    let edge = flat(format, |x, _| [one_if(x == last), 0.0, 0.0, 1.0]);
    let linear = State::trilinear(1);
    let seen = unit.sample(&edge, linear, Source::Level, &[at(15.75, 8.5), at(1016.0, 8.5)])?;
    Ok(Coordinates {
        nearest_switch: high - 8.0,
        clamps,
        edge: [seen[0][0], seen[1][0]].map(f64::from),
    })
}

/// Fractions of a sweep, for pictures.
#[must_use]
pub fn fractions() -> Vec<f64> {
    (0..=SWEEP as usize).map(fraction).collect()
}
