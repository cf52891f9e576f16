//! Probes of the anisotropic filter: where its bilinear taps lie, and how much each counts.
//!
//! The texture max(0, x), bilinearly interpolated, has one kink, at x = 0. Swept under this hinge, each tap draws a kink where
//! it crosses it; the second difference of the sweep is a comb with a tooth for each tap, as high as the tap's weight. A tooth
//! between two points of the sweep is shared by both, so its place is finer than the sweep. The texture max(0, x)·y gives the
//! other coordinate in the same way. On cubes the hinge lies on face +z.

use crate::base::num;
use crate::cube::direction;
use crate::error::InputError;
use crate::sampler::{Format, Image, Query, Shape, Source, State, TextureUnit, alone, finest};

/// Texels along an edge of the hinge.
const HINGE: usize = 256;
/// Levels of that texture.
const LEVELS: usize = 9;
/// The highest level whose middle is far enough from the edges for the sweep.
const TOP: usize = 3;
/// The face of a cube that has the hinge: +z.
const FACE: usize = 4;
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
    /// Kind of texture.
    pub shape: Shape,
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
        let (sin, cos) =
            (libm::sin(self.degrees.to_radians()), libm::cos(self.degrees.to_radians()));
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
            .map(|w| libm::hypot(w[1].offset[0] - w[0].offset[0], w[1].offset[1] - w[0].offset[1]))
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

/// Hinges along x and y in one level, the others empty: max(0, x), max(0, x)·y, max(0, y), max(0, y)·x.
fn hinge(shape: Shape, format: Format, in_level: usize) -> Image {
    let on = if shape == Shape::Cube { FACE } else { 0 };
    Image::new(shape, format, HINGE, LEVELS, |level, face, x, y| {
        if level != in_level || face != on {
            return [0.0; 4];
        }
        let half = (HINGE >> level) as f32 / 2.0;
        let [x, y] = [x as f32 - half, y as f32 - half];
        [x.max(0.0), x.max(0.0) * y, y.max(0.0), y.max(0.0) * x]
    })
}

/// Points of a sweep.
const POINTS: usize = 2 * REACH * FINE + 1;

/// The axis along which a footprint is swept: the one that its line is nearer to.
fn along(footprint: &Footprint) -> usize {
    let [dx, _] = footprint.derivatives();
    usize::from(dx[1].abs() > dx[0].abs())
}

/// Finds the taps of footprints by hinges, in the footprints' order.
pub fn taps(
    unit: &mut dyn TextureUnit,
    source: Source,
    footprints: &[Footprint],
) -> Result<Vec<Taps>, InputError> {
    let mut found: Vec<(usize, Taps)> = Vec::new();
    for shape in [Shape::Planar, Shape::Cube] {
        let asked: Vec<(usize, &Footprint)> =
            footprints.iter().enumerate().filter(|(_, f)| f.shape == shape).collect();
        if asked.is_empty() {
            continue;
        }
        let lods = middle_lods(unit, shape, source, &asked)?;
        for level in 0..=TOP {
            let at_level =
                |(_, lod): &(&(usize, &Footprint), f64)| num::index(lod.round()).min(TOP) == level;
            let group: Vec<(&(usize, &Footprint), f64)> =
                asked.iter().zip(lods.iter().copied()).filter(at_level).collect();
            sweep(unit, (shape, source, level), &group, &mut found)?;
        }
    }
    found.sort_by_key(|(index, _)| *index);
    Ok(found.into_iter().map(|(_, taps)| taps).collect())
}

/// λ of each footprint.
fn middle_lods(
    unit: &mut dyn TextureUnit,
    shape: Shape,
    source: Source,
    asked: &[(usize, &Footprint)],
) -> Result<Vec<f64>, InputError> {
    let numbered = super::levels::numbered(shape, HINGE, LEVELS);
    let middle = [(HINGE as f64 + 1.0) / 2.0; 2];
    let mut lods = Vec::new();
    for (_, footprint) in asked {
        let state = State::trilinear(footprint.clamp);
        let query = query_on(footprint, HINGE, middle);
        lods.push(f64::from(alone(unit, &numbered, state, source, &[query])?[0][0]));
    }
    Ok(lods)
}

/// Sweeps the footprints of a level, those of a clamp at once.
fn sweep(
    unit: &mut dyn TextureUnit,
    (shape, source, level): (Shape, Source, usize),
    group: &[(&(usize, &Footprint), f64)],
    found: &mut Vec<(usize, Taps)>,
) -> Result<(), InputError> {
    if group.is_empty() {
        return Ok(());
    }
    let image = hinge(shape, finest(unit), level);
    let texel = libm::exp2(level as f64);
    for clamp in super::aniso::CLAMPS {
        let of_clamp: Vec<_> = group.iter().filter(|((_, f), _)| f.clamp == clamp).collect();
        let mut queries = Vec::new();
        for ((_, footprint), _) in &of_clamp {
            for s in 0..POINTS {
                let mut at = [(HINGE as f64 + texel) / 2.0; 2];
                at[along(footprint)] += (s as f64 / FINE as f64 - REACH as f64) * texel;
                queries.push(query_on(footprint, HINGE, at));
            }
        }
        if queries.is_empty() {
            continue;
        }
        let seen = alone(unit, &image, State::trilinear(clamp), source, &queries)?;
        for (((index, footprint), lod), seen) in of_clamp.iter().zip(seen.chunks(POINTS)) {
            // The level's own share of the colours.
            let share = (1.0 - (lod - level as f64).abs()).max(f64::MIN_POSITIVE);
            found.push((*index, comb(**footprint, *lod, seen, along(footprint), share)));
        }
    }
    Ok(())
}

/// A look-up with a footprint on a texture of `size` texels, at a place in texels; on cubes on face +z.
#[must_use]
pub fn query_on(footprint: &Footprint, size: usize, at: [f64; 2]) -> Query {
    let share = |v: [f64; 2]| v.map(|c| c / size as f64);
    let vector = |[x, y]: [f64; 2]| [x, y, 0.0].map(num::f32);
    let [dx, dy] = footprint.derivatives().map(share);
    let at = share(at);
    if footprint.shape == Shape::Planar {
        return Query { at: vector(at), dx: vector(dx), dy: vector(dy), lod: 0.0 };
    }
    // In the face's plane s grows along +x and t along −y; the face is 2 wide.
    let on_face = |[s, t]: [f64; 2]| vector([2.0 * s, -2.0 * t]);
    Query {
        at: direction(FACE, 2.0 * at[0] - 1.0, 2.0 * at[1] - 1.0).map(num::f32),
        dx: on_face(dx),
        dy: on_face(dy),
        lod: 0.0,
    }
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
            run = [run[0] + weight, run[1] + weight * offset, run[2] + tooth(1, s)];
        } else if run[0] > 0.0 {
            let [weight, first, second] = run;
            let mut offset = [second / weight; 2];
            offset[along] = first / weight;
            taps.push(Tap { offset, weight });
            run = [0.0; 3];
        }
    }
    taps.reverse();
    Taps { footprint, lod, taps, negative }
}
