//! Probes of cube maps: faces, seams, corners, the level of detail, the anisotropic filter across them.

use super::aniso::{LodRule, rules};
use super::levels::{Fit, lod_on, numbered, random, rank};
use super::model::{Corner, Model, Seam};
use super::rho::{Projection, Rho};
use super::transfer::{Transfer, transfer};
use crate::base::num;
use crate::cube::{FACE_AXES, FACE_NAMES, direction, major_face};
use crate::error::InputError;
use crate::sampler::{Format, Image, Query, Shape, Source, State, TextureUnit, alone};

/// Texels along an edge of a face for the level of detail.
const SIZE: usize = 256;
/// Levels of that cube.
const LEVELS: usize = 9;
/// Random look-ups that tell the rules apart.
const CASES: usize = 512;
/// Texels along an edge where every texel's weight is measured.
pub const SMALL: usize = 8;
/// Levels of that cube.
pub const SMALL_LEVELS: usize = 4;

/// Faces of directions with equal components.
#[derive(Clone, Debug)]
pub struct Ties {
    /// Direction and the face that it gets.
    pub seen: Vec<([i8; 3], usize)>,
    /// How many get the face that z before y before x gives.
    pub expected: usize,
}

/// Looks at all edges and corners.
pub fn ties(unit: &mut dyn TextureUnit) -> Result<Ties, InputError> {
    let image =
        Image::new(Shape::Cube, Format::Half, 4, 1, |_, face, _, _| [face as f32, 0.0, 0.0, 1.0]);
    let mut directions = Vec::new();
    for x in [-1i8, 0, 1] {
        for y in [-1i8, 0, 1] {
            for z in [-1i8, 0, 1] {
                if x.abs() + y.abs() + z.abs() >= 2 {
                    directions.push([x, y, z]);
                }
            }
        }
    }
    let queries: Vec<Query> =
        directions.iter().map(|d| Query { at: d.map(f32::from), ..Query::default() }).collect();
    let faces = unit.sample(&image, State::nearest(), Source::Level, &queries)?;
    let seen: Vec<([i8; 3], usize)> =
        directions.into_iter().zip(faces).map(|(d, c)| (d, num::index(c[0].into()))).collect();
    let expected = seen.iter().filter(|(d, face)| major_face(d.map(f64::from)) == *face).count();
    Ok(Ties { seen, expected })
}

impl Ties {
    /// Names of a direction's face.
    #[must_use]
    pub fn name(face: usize) -> &'static str {
        FACE_NAMES.get(face).copied().unwrap_or("?")
    }
}

/// The filter across edges and at corners.
#[derive(Clone, Debug)]
pub struct Seams {
    /// The rules that come closest.
    pub rule: (Seam, Corner),
    /// Largest distance of a texel's weight from each pair of rules, the nearest first.
    pub ranked: Vec<((Seam, Corner), f64)>,
    /// Weights of the three texels around a corner when the look-up meets the corner exactly.
    pub at_corner: Vec<f64>,
    /// Look-ups that were compared.
    pub look_ups: usize,
}

/// Measures every texel's weight of look-ups near all edges and corners of a small cube.
pub fn seams(unit: &mut dyn TextureUnit, model: &Model) -> Result<Seams, InputError> {
    let mut queries = Vec::new();
    let near = |f: f64| 1.0 - f * 2.0 / SMALL as f64;
    for face in 0..6 {
        for (u, v) in [
            (near(0.4), 0.3),
            (near(0.1), -0.55),
            (-near(0.3), 0.1),
            (0.2, near(0.2)),
            (-0.4, -near(0.45)),
            (near(0.4), near(0.2)),
            (-near(0.15), near(0.35)),
            (near(0.3), -near(0.1)),
            (-near(0.2), -near(0.25)),
        ] {
            queries.push(Query { at: direction(face, u, v).map(num::f32), ..Query::default() });
        }
    }
    let state = State::trilinear(1);
    let measured = transfer(unit, (Shape::Cube, SMALL, 1), state, Source::Level, &queries)?;
    let mut ranked = Vec::new();
    for seam in [Seam::Neighbour, Seam::Clamped] {
        for corner in Corner::ALL {
            if seam == Seam::Clamped && corner != Corner::Mean {
                continue;
            }
            let mut model = Model { seam, corner, ..model.clone() };
            let predicted =
                transfer(&mut model, (Shape::Cube, SMALL, 1), state, Source::Level, &queries)?;
            let pairs = measured.iter().zip(&predicted);
            let worst = pairs.map(|(a, b)| distance(a, b)).fold(0.0, f64::max);
            ranked.push(((seam, corner), worst));
        }
    }
    ranked.sort_by(|a, b| a.1.total_cmp(&b.1));
    let corner = Query { at: [1.0; 3], ..Query::default() };
    let corner = transfer(unit, (Shape::Cube, SMALL, 1), state, Source::Level, &[corner])?;
    let weights = corner[0].levels[0].iter().filter(|w| **w > 0.0);
    Ok(Seams {
        rule: ranked[0].0,
        ranked,
        at_corner: weights.map(|w| f64::from(*w)).collect(),
        look_ups: queries.len(),
    })
}

/// Largest difference of two transfers' weights.
fn distance(a: &Transfer, b: &Transfer) -> f64 {
    let pairs = a.levels.iter().flatten().zip(b.levels.iter().flatten());
    pairs.map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max)
}

/// Random look-ups: directions that keep clear of edges, derivatives that are skewed in 3-D.
fn cases() -> Vec<Query> {
    (0..CASES as u64)
        .map(|i| {
            let r = |j| random(0x9000 + 16 * i + j);
            let face = (i % 6) as usize;
            let at = direction(face, 0.9 * r(0), 0.9 * r(1));
            // 2 to 32 texels of level 0.
            let scale = libm::exp2(3.0 + 2.0 * r(8)) * 2.0 / SIZE as f64;
            let d = |j: u64| [0, 1, 2].map(|c| num::f32(r(j + c) * scale));
            Query { at: at.map(num::f32), dx: d(2), dy: d(5), lod: 0.0 }
        })
        .collect()
}

/// Whether the quad of a look-up lies on several faces: what a driver takes for its differences is then not defined by a rule of
/// one face.
#[must_use]
pub fn straddles(query: &Query) -> bool {
    let face = |d: [f32; 3]| major_face(d.map(f64::from));
    let add = |a: [f32; 3], b: [f32; 3]| [0, 1, 2].map(|i| a[i] + b[i]);
    let right = add(query.at, query.dx);
    let quad = [right, add(query.at, query.dy), add(right, query.dy)];
    quad.iter().any(|d| face(*d) != face(query.at))
}

/// λ of look-ups on a cube.
fn lods(
    unit: &mut dyn TextureUnit,
    state: State,
    source: Source,
    queries: &[Query],
) -> Result<Vec<(Query, f64)>, InputError> {
    let image = numbered(Shape::Cube, SIZE, LEVELS);
    let seen = alone(unit, &image, state, source, queries)?;
    Ok(queries.iter().copied().zip(seen.iter().map(|c| f64::from(c[0]))).collect())
}

/// Which length of 3-D derivatives counts without anisotropy.
pub fn rho(
    unit: &mut dyn TextureUnit,
    octave: &[f64],
) -> Result<Vec<Fit<(Projection, Rho)>>, InputError> {
    let cases = lods(unit, State::trilinear(1), Source::Gradient, &cases())?;
    let all: Vec<(Projection, Rho)> =
        Projection::ALL.into_iter().flat_map(|p| Rho::ALL.map(|rho| (p, rho))).collect();
    Ok(rank(&all, &cases, |(projection, rho), q| {
        let [at, dx, dy] = [q.at, q.dx, q.dy].map(|v| v.map(f64::from));
        let length = projection.length(rho, at, [dx, dy], SIZE as f64);
        lod_on(octave, libm::log2(length)).min((LEVELS - 1) as f64)
    }))
}

/// Which level of detail counts under a clamp: the same look-ups.
pub fn aniso(
    unit: &mut dyn TextureUnit,
    octave: &[f64],
    (projection, rho): (Projection, Rho),
    (clamp, source): (u16, Source),
) -> Result<Vec<Fit<LodRule>>, InputError> {
    let mut queries = cases();
    if source == Source::Quad {
        // In the face's plane: there the difference of two projected pixels is the derivative.
        for q in &mut queries {
            let (major, _) = FACE_AXES[major_face(q.at.map(f64::from))][2];
            (q.dx[major], q.dy[major]) = (0.0, 0.0);
        }
        queries.retain(|q| !straddles(q));
    }
    let cases = lods(unit, State::trilinear(clamp), source, &queries)?;
    Ok(rank(&rules(), &cases, |rule, q| {
        let [at, dx, dy] = [q.at, q.dx, q.dy].map(|v| v.map(f64::from));
        let pair = [dx, dy].map(|d| projection.on_face(at, d, SIZE as f64));
        let major = projection.length(rho, at, [dx, dy], SIZE as f64);
        rule.lod(octave, clamp, major, pair).min((LEVELS - 1) as f64)
    }))
}

/// A look-up whose footprint on the small cube is shown.
#[derive(Clone, Debug)]
pub struct Shown {
    /// In words.
    pub title: &'static str,
    /// The look-up.
    pub query: Query,
    /// Its texels.
    pub transfer: Transfer,
}

/// A footprint 6 texels long and one wide in the middle of a face, over an edge, and over a corner.
pub fn footprints(
    unit: &mut dyn TextureUnit,
    clamp: u16,
    source: Source,
) -> Result<Vec<Shown>, InputError> {
    let texel = 2.0 / SMALL as f64;
    let on = |u: f64, v: f64, x: [f64; 2], y: [f64; 2]| {
        let face = 4;
        let zero = direction(face, 0.0, 0.0);
        let moved = |d: [f64; 2]| {
            let to = direction(face, d[0] * texel, d[1] * texel);
            [0, 1, 2].map(|i| num::f32(to[i] - zero[i]))
        };
        Query { at: direction(face, u, v).map(num::f32), dx: moved(x), dy: moved(y), lod: 0.0 }
    };
    let half = libm::sqrt(0.5);
    let asked = [
        ("middle of +z", on(0.125, 0.125, [6.0, 0.0], [0.0, 1.0])),
        ("middle, 45 degrees", on(0.125, 0.125, [6.0 * half, 6.0 * half], [-half, half])),
        ("over the edge to +x", on(0.9, 0.125, [6.0, 0.0], [0.0, 1.0])),
        ("near a corner", on(0.85, 0.85, [6.0, 0.0], [0.0, 1.0])),
    ];
    let queries = asked.map(|(_, q)| q);
    let shape = (Shape::Cube, SMALL, SMALL_LEVELS);
    let found = transfer(unit, shape, State::trilinear(clamp), source, &queries)?;
    Ok(asked
        .into_iter()
        .zip(found)
        .map(|((title, query), transfer)| Shown { title, query, transfer })
        .collect())
}
