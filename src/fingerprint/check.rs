//! The proof: a model built from the fingerprint's claims predicts random look-ups.

use super::cube::straddles;
use super::levels::{Fit, random};
use super::model::{Line, Model, Rule};
use crate::base::num;
use crate::cube::direction;
use crate::error::InputError;
use crate::sampler::{Format, Image, Query, Shape, Source, State, TextureUnit, alone};

/// Look-ups in a group.
const LOOK_UPS: usize = 2048;
/// Look-ups that tell the lines apart.
const CASES: usize = 384;
/// Texels along an edge of the noise.
const NOISE: usize = 64;

/// A group of random look-ups and how many of them the model predicts.
#[derive(Clone, Debug)]
pub struct Group {
    /// Kind of texture.
    pub shape: Shape,
    /// Where the derivatives come from.
    pub source: Source,
    /// Largest anisotropy.
    pub clamp: u16,
    /// Look-ups.
    pub look_ups: usize,
    /// Those whose four channels are all within 2^−16 of the prediction.
    pub exact: usize,
    /// Those within one step: the model's weights between texels and levels, all four of them, may be one step off.
    pub within: usize,
    /// That step, as a share of the range of the texels.
    pub step: f64,
    /// Largest and mean distance.
    pub fit: Fit<()>,
    /// Further look-ups whose quad lies on several faces of a cube, and how many of those are within one step. They count apart:
    /// what a driver takes for their differences is not defined by any rule above.
    pub straddling: [usize; 2],
}

/// Texels of noise 0…1 in steps of 1/1024, which half floats hold exactly.
fn noise(shape: Shape) -> Image {
    let levels = NOISE.ilog2() as usize + 1;
    let mut seed = 0xABCD_0000;
    Image::new(shape, Format::Half, NOISE, levels, |_, _, _, _| {
        [0; 4].map(|_: u8| {
            seed += 1;
            num::f32(((random(seed) + 1.0) * 512.0).floor() / 1024.0)
        })
    })
}

/// Random look-ups with footprints of 1 to 16 texels and ratios up to 16, on cubes over edges and corners too.
fn look_ups(shape: Shape, count: usize) -> Vec<Query> {
    (0..count as u64)
        .map(|i| {
            let r = |j| random(0x0010_0000 + 32 * i + j);
            let major = libm::exp2(2.0 + 2.0 * r(0));
            let minor = major * libm::exp2(-2.0 * (1.0 + r(1)));
            let turn = std::f64::consts::PI * r(2);
            let (sin, cos) = (libm::sin(turn), libm::cos(turn));
            let texel = if shape == Shape::Planar { 1.0 } else { 2.0 } / NOISE as f64;
            let x = [major * cos * texel, major * sin * texel];
            let y = [-minor * sin * texel, minor * cos * texel];
            let f32s = |d: [f64; 3]| d.map(num::f32);
            match shape {
                Shape::Planar => Query {
                    at: f32s([0.5 + 0.3 * r(3), 0.5 + 0.3 * r(4), 0.0]),
                    dx: f32s([x[0], x[1], 0.0]),
                    dy: f32s([y[0], y[1], 0.0]),
                    lod: 0.0,
                },
                Shape::Cube => {
                    let face = (i % 6) as usize;
                    let [u, v] = [r(3), r(4)];
                    let zero = direction(face, 0.0, 0.0);
                    let on = |d: [f64; 2]| {
                        let to = direction(face, d[0], d[1]);
                        [0, 1, 2].map(|c| to[c] - zero[c])
                    };
                    Query {
                        at: f32s(direction(face, u, v)),
                        dx: f32s(on(x)),
                        dy: f32s(on(y)),
                        lod: 0.0,
                    }
                }
            }
        })
        .collect()
}

/// Lines by how well they predict random look-ups in place of the rule's own line, the best first.
pub fn lines(
    unit: &mut dyn TextureUnit,
    model: &Model,
    rule: Rule,
) -> Result<Vec<Fit<Line>>, InputError> {
    let image = noise(rule.shape);
    let mut queries = look_ups(rule.shape, CASES);
    if rule.shape == Shape::Cube && rule.source == Source::Quad {
        queries.retain(|q| !straddles(q));
    }
    let state = State::trilinear(rule.clamp);
    let seen = alone(unit, &image, state, rule.source, &queries)?;
    let mut fits = Vec::new();
    for line in Line::all(rule.shape) {
        let mut trial = Model { rules: vec![Rule { line, ..rule }], ..model.clone() };
        let predicted = trial.sample(&image, state, rule.source, &queries)?;
        let distances: Vec<f64> =
            seen.iter().zip(&predicted).map(|(a, b)| distance(a, b)).collect();
        fits.push(Fit::of(line, &distances));
    }
    fits.sort_by(|a, b| a.mean.total_cmp(&b.mean));
    Ok(fits)
}

/// Largest difference of two colours' channels.
fn distance(a: &[f32; 4], b: &[f32; 4]) -> f64 {
    let channels = a.iter().zip(b).map(|(a, b)| f64::from((a - b).abs()));
    channels.fold(0.0, f64::max)
}

/// Compares the model with the unit over random look-ups, edges and corners of cubes included.
pub fn check(
    unit: &mut dyn TextureUnit,
    model: &Model,
    shape: Shape,
    source: Source,
    clamp: u16,
) -> Result<Group, InputError> {
    let image = noise(shape);
    let queries = look_ups(shape, LOOK_UPS);
    let state = State::trilinear(clamp);
    let seen = alone(unit, &image, state, source, &queries)?;
    let predicted = model.clone().sample(&image, state, source, &queries)?;
    // Column, row and level weight of each of two levels may be a step off, each moves a colour by at most one range; of 8-bit
    // and of smooth weights one step counts as 2^−8.
    let step = model.texels.size().max(libm::exp2(-8.0));
    let straddles = |q: &Query| shape == Shape::Cube && source == Source::Quad && straddles(q);
    let (mut distances, mut straddling) = (Vec::new(), [0; 2]);
    for (query, (a, b)) in queries.iter().zip(seen.iter().zip(&predicted)) {
        let distance = distance(a, b);
        if straddles(query) {
            straddling[0] += 1;
            straddling[1] += usize::from(distance <= step);
        } else {
            distances.push(distance);
        }
    }
    let below = |limit: f64| distances.iter().filter(|d| **d <= limit).count();
    Ok(Group {
        shape,
        source,
        clamp,
        look_ups: distances.len(),
        exact: below(libm::exp2(-16.0)),
        within: below(step),
        step,
        fit: Fit::of((), &distances),
        straddling,
    })
}
