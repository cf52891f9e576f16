//! What the format of a cone's registers costs, bounce by bounce: error of the level of detail, tiles.

use crate::base::num;
use std::collections::BTreeMap;

use rayon::prelude::*;
use rtl_model::cone::{ConeFormat, StoreRounding};
use rtl_model::unit::{Operation as _, TexBlock};

use crate::engine::Progress;
use crate::engine::cones::{Asked, FloatCones, RtlCones, walk};
use crate::engine::tex::{value, words};
use crate::engine::tex_subject::{TexEngine, TexSubject};
use crate::engine::tiles::Tiles;
use crate::error::InputError;
use crate::reference::tex::tex;
use crate::reference::{NoTap, Prepared};
use crate::scene::tex::path::Path;
use crate::unit::{ReferenceAxis, UnitSpec};

/// The formats that are compared.
pub const FORMATS: [(&str, ConeFormat, StoreRounding); 5] = [
    ("f32", ConeFormat::F32, StoreRounding::Rne),
    ("f16", ConeFormat::F16, StoreRounding::Rne),
    ("bf16 rne", ConeFormat::Bf16, StoreRounding::Rne),
    ("bf16 truncate", ConeFormat::Bf16, StoreRounding::Truncate),
    ("bf16 stochastic", ConeFormat::Bf16, StoreRounding::Stochastic),
];

/// First bounce of each group of bounces.
pub const GROUPS: [u32; 8] = [0, 1, 2, 4, 8, 16, 32, 64];

/// The group of a bounce.
fn group(bounce: u32) -> usize {
    GROUPS.iter().rposition(|first| bounce >= *first).unwrap_or(0)
}

/// One format at one group of bounces.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Index into [`FORMATS`].
    pub format: usize,
    /// First bounce of the group.
    pub bounce: u32,
    /// Texture requests.
    pub requests: usize,
    /// |LOD − LOD by doubles|: median, 95th and 99th percentile, largest. LODs are those of the chain, 0 to its last.
    pub lod_error: [f64; 4],
    /// |w/w by doubles − 1|: median, 95th percentile.
    pub width_error: [f64; 2],
    /// Mean of LOD − LOD by doubles.
    pub bias: f64,
    /// Requests that chose a level two or more away.
    pub far: usize,
    /// Touched tiles of this group alone.
    pub tiles: usize,
    /// Touched tiles if the cones were doubles.
    pub reference_tiles: usize,
}

/// Samples of one group.
#[derive(Clone, Debug, Default)]
struct Samples {
    lod: Vec<f64>,
    width: Vec<f64>,
}

fn percentile(sorted: &[f64], share: f64) -> f64 {
    if sorted.is_empty() {
        return 0.0;
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "an index below the length"
    )]
    let index = (share * (sorted.len() - 1) as f64).round() as usize;
    sorted[index.min(sorted.len() - 1)]
}

/// One format's part of a row of the picture.
struct Part {
    samples: Vec<Samples>,
    /// Tiles of each group, texture by texture: the format's, and the doubles'.
    tiles: [BTreeMap<(usize, usize), Tiles>; 2],
}

/// Runs a scene's paths with every format of the cones; all else is as `spec` says.
pub fn study(
    subject: &TexSubject,
    spec: &UnitSpec,
    progress: Progress<'_>,
) -> Result<Vec<Row>, InputError> {
    let mut rows = Vec::new();
    for (index, (_, format, rounding)) in FORMATS.into_iter().enumerate() {
        let mut spec = spec.clone();
        spec.config.policy.cone.format = format;
        spec.config.policy.cone.rounding = rounding;
        let engine = TexEngine::new(&spec, subject)?;
        let parts: Vec<Part> = (0..subject.scene.height)
            .into_par_iter()
            .map(|y| {
                let part = row(subject, &spec, &engine, y);
                progress(1);
                part
            })
            .collect();
        rows.extend(collect(index, parts));
    }
    Ok(rows)
}

fn row(subject: &TexSubject, spec: &UnitSpec, engine: &TexEngine, y: usize) -> Part {
    let settings = spec.settings(ReferenceAxis::Exact);
    let prepared = Prepared::new(&settings);
    let scene = &subject.scene;
    let mut part = Part {
        samples: vec![Samples::default(); GROUPS.len()],
        tiles: [BTreeMap::new(), BTreeMap::new()],
    };
    let cfg = &engine.textures[0].unit.cone;
    let mut registers = RtlCones::new(cfg, &scene.camera);
    let mut doubles = FloatCones::new(
        &scene.camera,
        settings.policy.cone.rules,
        settings.policy.cone.set_diffuse,
    );
    let mut path = Path::default();
    for column in 0..scene.width {
        for sample in 0..scene.samples {
            let at = [column, y].map(|n| n as f64 + 0.5);
            scene.path(at, [sample, scene.samples], &mut path);
            let pixel = num::u64(y * scene.width + column);
            registers.ray(pixel * u64::from(scene.samples) + u64::from(sample));
            let mut exact = Vec::new();
            let lens = scene.camera.lens;
            walk(&mut doubles, &settings.policy.cone, lens, &path, &mut |asked, cone| {
                if let Asked::Look(_) = asked {
                    exact.push(cone.width.0);
                }
            });
            let mut next = exact.iter();
            walk(&mut registers, &settings.policy.cone, lens, &path, &mut |asked, cone| {
                let Asked::Look(look) = asked else { return };
                let Some(&exact) = next.next() else { return };
                let map = &scene.textures[look.texture];
                let width = value(cfg.width(cone.width));
                let lod =
                    |w: f64| tex(&prepared, w, &look.fragment, map.size(), None, &mut NoTap).lod;
                let samples = &mut part.samples[group(look.bounce)];
                samples.lod.push(lod(width) - lod(exact));
                let relative =
                    if exact == 0.0 { 0.0 } else { (width.abs() / exact.abs() - 1.0).abs() };
                samples.width.push(relative);
                let unit = &engine.textures[look.texture];
                let Some(texture) = &unit.memory.texture else { return };
                // The doubles' width goes through the same unit, as near as its register holds it.
                for (kind, w) in [width, exact].into_iter().enumerate() {
                    let mut flags = rtl_model::fx::Flags::default();
                    let cone = if kind == 0 {
                        cone
                    } else {
                        cfg.load([0, w.to_bits()], &mut cfg.dither(0), &mut flags)
                    };
                    let request = [words(&look.fragment, cone)];
                    let mut block = TexBlock::<1>::default();
                    unit.unit.load(&request, &mut block);
                    let blocks = std::slice::from_mut(&mut block);
                    unit.unit.steps(0, &unit.memory, blocks, &mut rtl_model::NoTap);
                    let key = (group(look.bounce), look.texture);
                    let tiles = part.tiles[kind]
                        .entry(key)
                        .or_insert_with(|| Tiles::new(map, settings.policy.address.wrap()));
                    unit.unit.touched_corners(&block, 0, texture, &mut |at| {
                        tiles.touch(at.level, at.texel);
                    });
                }
            });
        }
    }
    part
}

fn collect(format: usize, parts: Vec<Part>) -> Vec<Row> {
    let mut samples = vec![Samples::default(); GROUPS.len()];
    let mut tiles: [BTreeMap<(usize, usize), Tiles>; 2] = [BTreeMap::new(), BTreeMap::new()];
    for part in parts {
        for (all, more) in samples.iter_mut().zip(part.samples) {
            all.lod.extend(more.lod);
            all.width.extend(more.width);
        }
        for (all, more) in tiles.iter_mut().zip(part.tiles) {
            for (key, more) in more {
                match all.get_mut(&key) {
                    Some(tiles) => tiles.merge(&more),
                    None => {
                        all.insert(key, more);
                    }
                }
            }
        }
    }
    let count = |kind: usize, g: usize| {
        let of = tiles[kind].iter().filter(|((group, _), _)| *group == g);
        of.map(|(_, t)| t.total()).sum()
    };
    samples
        .into_iter()
        .enumerate()
        .filter(|(_, s)| !s.lod.is_empty())
        .map(|(g, s)| {
            let sum: f64 = s.lod.iter().sum();
            let mut lod: Vec<f64> = s.lod.iter().map(|e| e.abs()).collect();
            let mut width = s.width;
            lod.sort_by(f64::total_cmp);
            width.sort_by(f64::total_cmp);
            Row {
                format,
                bounce: GROUPS[g],
                requests: lod.len(),
                lod_error: [0.5, 0.95, 0.99, 1.0].map(|share| percentile(&lod, share)),
                width_error: [0.5, 0.95].map(|share| percentile(&width, share)),
                bias: sum / lod.len() as f64,
                far: lod.iter().filter(|e| **e >= 2.0).count(),
                tiles: count(0, g),
                reference_tiles: count(1, g),
            }
        })
        .collect()
}
