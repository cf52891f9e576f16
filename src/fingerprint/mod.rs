//! The rules of a texture unit, found by look-ups whose results tell them apart.
//!
//! [`fingerprint`] asks a [`TextureUnit`] some hundred thousand look-ups on textures that are made for one question
//! each, and finds the rule behind the answers among named candidates. The rules together are a [`Model`]; the last step predicts
//! random look-ups with it and counts how many come out right, so that the report proves itself or says where it does not hold.
//! Every step passes the unit's own error on.
//! Nothing here knows of a GPU: a `Model` is a `TextureUnit` too, and tests fingerprint models whose rules they know.

pub mod aniso;
pub mod check;
pub mod cube;
mod json;
pub mod levels;
pub mod model;
mod picture;
mod picture_map;
mod plot;
pub mod rho;
pub mod shapes;
pub mod steps;
pub mod taps;
pub mod texels;
mod text;
mod text_taps;
pub mod transfer;

use crate::error::InputError;
use crate::sampler::{Format, Query, Shape, Source, State, TextureUnit};
use aniso::{CLAMPS, LodRule};
use check::Group;
use cube::{Seams, Shown, Ties};
use levels::{Curve, Fit};
use model::{Corner, Line, Model, Rule, Seam};
use rho::{Projection, Rho};
use steps::Staircase;
use taps::{Footprint, Taps};
use texels::{Coordinates, Weights};
use transfer::Transfer;

pub use json::to_json;
pub use picture::draw;
pub use text::print;

/// Texels along an edge of the texture whose every texel's weight is measured.
pub const MAP: usize = 64;
/// Steps that [`fingerprint`] reports.
pub const STEPS: u64 = 7;
/// Ratios of the tap map.
pub const MAP_RATIOS: [f64; 5] = [1.0, 2.0, 4.0, 8.0, 16.0];
/// Angles of the tap map in degrees.
pub const MAP_ANGLES: [f64; 6] = [0.0, 30.0, 45.0, 60.0, 90.0, 135.0];
/// Ratios of the tap table.
const TABLE_RATIOS: [f64; 10] = [1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 12.0, 16.0];
/// Ratios whose angle is swept.
const SWEPT_RATIOS: [f64; 4] = [2.0, 4.0, 8.0, 16.0];

/// A kind of look-up with anisotropy, and the findings about it.
#[derive(Clone, Debug)]
pub struct Filter {
    /// The rules that fit best.
    pub rule: Rule,
    /// How well the level of detail fits: distances in levels.
    pub lod: Fit<LodRule>,
    /// How well each line fits, the best first: distances in colours of noise 0…1.
    pub lines: Vec<Fit<Line>>,
}

/// A footprint of the tap map: every texel's weight, and the taps if there are any.
#[derive(Clone, Debug)]
pub struct Mapped {
    /// The look-up, on a texture of [`MAP`] texels.
    pub footprint: Footprint,
    /// Texels.
    pub transfer: Transfer,
}

/// All findings about one texture unit.
#[derive(Clone, Debug)]
pub struct Fingerprint {
    /// Weights between texels, by format.
    pub weights: Vec<Weights>,
    /// Coordinates and edges.
    pub coordinates: Coordinates,
    /// Weights between levels.
    pub mips: Staircase,
    /// Level of detail over the length.
    pub curve: Curve,
    /// Which length, the best rule first.
    pub rho: Vec<Fit<Rho>>,
    /// For each clamp λ of a look-up alone and of the same one among others: equal where given derivatives are used.
    pub neighbours: Vec<(u16, [f64; 2])>,
    /// λ over the ratio for each clamp, by given derivatives and by those of a quad.
    pub ratios: Vec<aniso::Levels>,
    /// Where taps lie, for each clamp over the ratio, and for the largest over the angle.
    pub taps: Vec<Taps>,
    /// The tap map by given derivatives.
    pub map: Vec<Mapped>,
    /// The tap map by a quad's derivatives; empty where it adds nothing.
    pub quad_map: Vec<Mapped>,
    /// Faces of equal components.
    pub ties: Ties,
    /// Seams and corners.
    pub seams: Seams,
    /// Which length on cubes, the best rule first.
    pub cube_rho: Vec<Fit<(Projection, Rho)>>,
    /// Footprints on a cube by given derivatives, and by a quad's where those are ignored.
    pub cube_map: Vec<(Source, Vec<Shown>)>,
    /// Kinds of look-up with anisotropy.
    pub filters: Vec<Filter>,
    /// The claims of the findings.
    pub model: Model,
    /// How many random look-ups the model predicts.
    pub checks: Vec<Group>,
}

/// Finds the rules of a texture unit. `progress` gets the name of each step before it starts.
pub fn fingerprint(
    unit: &mut dyn TextureUnit,
    progress: &dyn Fn(&str),
) -> Result<Fingerprint, InputError> {
    progress("weights");
    let mut weights = Vec::new();
    for format in [Format::Unorm8, Format::Half, Format::Float] {
        if unit.filters(format) {
            weights.push(texels::weights(unit, format)?);
        }
    }
    let coordinates = texels::coordinates(unit)?;
    progress("levels");
    let mips = levels::mip_weights(unit)?;
    let curve = levels::curve(unit)?;
    let rho = levels::rho(unit, &curve)?;
    let cube_rho = cube::rho(unit, &curve.octave)?;
    let half = weights.iter().find(|w| w.format == Format::Half);
    let mut model = Model {
        texels: half.map_or(steps::Steps::Smooth, |w| w.axes[0].steps),
        mips: mips.steps,
        octave: curve.octave.clone(),
        rho: rho[0].rule,
        cube_rho: cube_rho[0].rule,
        rules: Vec::new(),
        seam: Seam::Neighbour,
        corner: Corner::Mean,
    };
    progress("cube");
    let ties = cube::ties(unit)?;
    let seams = cube::seams(unit, &model)?;
    (model.seam, model.corner) = seams.rule;

    progress("anisotropy");
    let clamps: &[u16] = if unit.is_anisotropic() { &CLAMPS } else { &CLAMPS[..1] };
    let largest = clamps[clamps.len() - 1];
    let (mut neighbours, mut ratios, mut filters) = (Vec::new(), Vec::new(), Vec::new());
    for clamp in clamps {
        neighbours.push((*clamp, aniso::beside_neighbours(unit, *clamp)?));
        for source in [Source::Gradient, Source::Quad] {
            let levels = aniso::levels(unit, &curve.octave, *clamp, source)?;
            if *clamp > 1 {
                let lod = levels.rules[0];
                let kind = (*clamp, source);
                filters.push(filter(unit, &model, Shape::Planar, lod, kind)?);
                let lod = cube::aniso(unit, &curve.octave, cube_rho[0].rule, kind)?[0];
                filters.push(filter(unit, &model, Shape::Cube, lod, kind)?);
            }
            ratios.push(levels);
        }
    }
    settle(&mut filters);
    model.rules = filters.iter().map(|f| f.rule).collect();
    let honoured = neighbours.iter().all(|(_, lods)| honours(*lods));

    progress("taps");
    let taps = taps::taps(unit, Source::Gradient, &table(clamps))?;
    progress("tap map");
    let map = map(unit, Source::Gradient, largest)?;
    let mut sources = vec![Source::Gradient];
    let mut quad_map = Vec::new();
    if !honoured {
        sources.push(Source::Quad);
        quad_map = self::map(unit, Source::Quad, largest)?;
    }
    let mut cube_map = Vec::new();
    for source in sources {
        cube_map.push((source, cube::footprints(unit, largest, source)?));
    }

    progress("check");
    let mut checks = Vec::new();
    for source in [Source::Gradient, Source::Quad] {
        for shape in [Shape::Planar, Shape::Cube] {
            for clamp in clamps {
                checks.push(check::check(unit, &model, shape, source, *clamp)?);
            }
        }
    }
    Ok(Fingerprint {
        weights,
        coordinates,
        mips,
        curve,
        rho,
        neighbours,
        ratios,
        taps,
        map,
        quad_map,
        ties,
        seams,
        cube_rho,
        cube_map,
        filters,
        model,
        checks,
    })
}

/// Finds the line of a kind of look-up whose level of detail is known.
fn filter(
    unit: &mut dyn TextureUnit,
    model: &Model,
    shape: Shape,
    lod: Fit<LodRule>,
    (clamp, source): (u16, Source),
) -> Result<Filter, InputError> {
    let mut rule = Rule { shape, source, clamp, lod: lod.rule, line: Line::Single };
    let lines = check::lines(unit, model, rule)?;
    rule.line = lines[0].rule;
    Ok(Filter { rule, lod, lines })
}

/// Where a small clamp cannot tell two lines apart, it has the one of the largest clamp.
fn settle(filters: &mut [Filter]) {
    let largest: Vec<Rule> = filters.iter().map(|f| f.rule).collect();
    for filter in filters {
        let of_kind = |r: &&Rule| (r.shape, r.source) == (filter.rule.shape, filter.rule.source);
        let Some(last) = largest.iter().filter(of_kind).max_by_key(|r| r.clamp) else {
            continue;
        };
        let as_good = |f: &Fit<Line>| f.rule == last.line && f.mean <= filter.lines[0].mean * 1.01;
        if let Some(at) = filter.lines.iter().position(as_good) {
            filter.lines.swap(0, at);
            filter.rule.line = last.line;
        }
    }
}

/// The footprints of the tap table: every clamp over the ratio, the largest one over the angle.
fn table(clamps: &[u16]) -> Vec<Footprint> {
    let mut table = Vec::new();
    let largest = clamps[clamps.len() - 1];
    let mut add = |shape, clamp: u16, ratio: f64, degrees: u32| {
        // Beyond eight clamps the level is so small that edges come near.
        if ratio <= 8.0 * f64::from(clamp) {
            table.push(Footprint { shape, clamp, ratio, degrees: degrees.into() });
        }
    };
    for (shape, ratios, degrees) in
        [(Shape::Planar, &TABLE_RATIOS[..], 15), (Shape::Cube, &SWEPT_RATIOS[..], 45)]
    {
        for clamp in clamps {
            for ratio in ratios {
                add(shape, *clamp, *ratio, 0);
            }
        }
        for ratio in SWEPT_RATIOS {
            for angle in (degrees..180).step_by(degrees as usize) {
                add(shape, largest, ratio, angle);
            }
        }
    }
    table
}

/// Every texel's weight over ratios and angles.
fn map(unit: &mut dyn TextureUnit, source: Source, clamp: u16) -> Result<Vec<Mapped>, InputError> {
    let mut footprints = Vec::new();
    for ratio in MAP_RATIOS {
        footprints.extend(MAP_ANGLES.map(|degrees| Footprint {
            shape: Shape::Planar,
            clamp,
            ratio,
            degrees,
        }));
    }
    let queries: Vec<Query> =
        footprints.iter().map(|f| taps::query_on(f, MAP, [(MAP as f64 + 1.0) / 2.0; 2])).collect();
    let levels = MAP.ilog2() as usize + 1;
    let shape = (Shape::Planar, MAP, levels);
    let found = transfer::transfer(unit, shape, State::trilinear(clamp), source, &queries)?;
    Ok(footprints
        .into_iter()
        .zip(found)
        .map(|(footprint, transfer)| Mapped { footprint, transfer })
        .collect())
}

/// Whether λ of a look-up alone and among others shows that its derivatives count: the same, and above 0.
#[must_use]
pub fn honours([alone, together]: [f64; 2]) -> bool {
    alone > 0.0 && (alone - together).abs() < 1e-3
}
