//! Kept results of the TEX operation.

use std::hash::{Hash as _, Hasher as _};

use rayon::prelude::*;
use rtl_model::stages::filter::Corner;
use rtl_model::unit::{TEX_STEPS, TexUnit, TexWords};

use super::lines::RtlLine;
use super::{Keys, MOST_KEPT, Saved, StepHasher, hit, texel_key};
use crate::distance::Distance;
use crate::engine::Rendering;
use crate::engine::dispatch::LANES;
use crate::engine::hit::Block as SkyBlock;
use crate::engine::tex::{Block, TexRtl, texture, value};
use crate::engine::tex_requests::AskedRtl;
use crate::engine::tex_subject::{TexEngine, TexSubject};
use crate::error::InputError;
use crate::fragment::HitFragment;
use crate::settings::Settings;
use crate::unit::{UnitSpec, refused};

/// The steps from which a row's blocks have to run: of each texture's unit, and of the environment's.
#[derive(Clone, Debug)]
pub(in crate::engine) struct First {
    pub(in crate::engine) looks: Vec<usize>,
    pub(in crate::engine) sky: usize,
}

/// Blocks of a row's requests.
#[derive(Debug)]
pub(in crate::engine) struct KeptBlocks {
    /// By texture.
    pub(in crate::engine) looks: Vec<Vec<Block>>,
    pub(in crate::engine) sky: Vec<Box<SkyBlock>>,
}

/// A row's requests and their blocks.
#[derive(Debug)]
pub(in crate::engine) struct KeptRow {
    pub(in crate::engine) asked: AskedRtl,
    pub(in crate::engine) blocks: KeptBlocks,
}

impl KeptRow {
    fn new(asked: AskedRtl) -> Self {
        let looks = asked.looks.iter().map(|looks| {
            let words: Vec<TexWords> = looks.iter().map(|r| r.asked).collect();
            words.chunks(LANES).map(Block::kept).collect()
        });
        let rays: Vec<HitFragment> = asked.sky.iter().map(|r| r.asked).collect();
        let blocks = KeptBlocks {
            looks: looks.collect(),
            sky: rays.chunks(LANES).map(SkyBlock::kept).collect(),
        };
        Self { asked, blocks }
    }
}

/// A subject's requests with what units have made of them.
#[derive(Debug, Default)]
pub struct KeptTex {
    engine: Option<TexEngine>,
    rows: Vec<KeptRow>,
    /// Key of the cones, and with it of the requests.
    cones: u64,
    looks: Vec<Keys>,
    sky: Keys,
}

impl KeptTex {
    /// Renders a subject, always the same one, by a unit.
    pub fn render(
        &mut self,
        spec: &UnitSpec,
        settings: &Settings,
        subject: &TexSubject,
    ) -> Result<(Rendering, Saved), InputError> {
        let engine = compile(self.engine.take(), spec, subject)?;
        if subject.requests > MOST_KEPT {
            let rendering = subject.rtl(&engine, settings, &|_| {});
            self.engine = Some(engine);
            return Ok((rendering, Saved::default()));
        }
        let mut hasher = StepHasher::default();
        let policy = &spec.config.policy;
        (policy.cone, policy.surface_footprint, policy.address).hash(&mut hasher);
        let cones = hasher.finish();
        if self.rows.is_empty() || self.cones != cones {
            self.rows = (0..subject.scene.height)
                .into_par_iter()
                .map(|y| KeptRow::new(subject.ask_rtl(&engine, settings, y)))
                .collect();
            self.cones = cones;
            (self.looks, self.sky) = (Vec::new(), Keys::default());
        }
        let looks: Vec<Keys> = engine
            .textures
            .iter()
            .map(|t| Keys::new(TEX_STEPS, cones, |n, hasher| t.unit.hash_step(n, hasher)))
            .collect();
        let sky = hit::keys(&engine.sky, cones);
        let kept = |index: usize| self.looks.get(index);
        let first = First {
            looks: looks
                .iter()
                .enumerate()
                .map(|(i, keys)| kept(i).map_or(0, |kept| keys.first_changed(kept)))
                .collect(),
            sky: sky.first_changed(&self.sky),
        };
        let rendering = subject.rtl_again(&engine, &mut self.rows, &first, &|_| {});
        (self.looks, self.sky) = (looks, sky);
        self.engine = Some(engine);
        let saved =
            Saved { kept: first.looks.iter().copied().min().unwrap_or(0), steps: TEX_STEPS };
        Ok((rendering, saved))
    }

    /// The engine that rendered last.
    #[must_use]
    pub fn engine(&self) -> Option<&TexEngine> {
        self.engine.as_ref()
    }

    /// What tells the last rendering's probes apart from others', beside the addresses' own configuration; nothing
    /// where no registers are kept.
    #[must_use]
    pub fn probes_key(&self) -> Option<u64> {
        let mut hasher = StepHasher::default();
        for keys in self.looks.iter().chain([&self.sky]) {
            keys.last().hash(&mut hasher);
        }
        (!self.looks.is_empty()).then(|| hasher.finish())
    }

    /// The probe line of every request to a texture and the width of its cone, row by row, and in a row texture by
    /// texture.
    pub fn lines(&self, each: &mut dyn FnMut(RtlLine, f64)) {
        let Some(engine) = &self.engine else { return };
        for row in &self.rows {
            let blocks = row.blocks.looks.iter().zip(&engine.textures);
            for (blocks, unit) in blocks {
                for block in blocks {
                    for (lane, request) in block.requests().iter().enumerate() {
                        let line = RtlLine::new(&unit.config, &block.state().env, lane);
                        each(line, value(unit.unit.cone.width(request.cone.width)));
                    }
                }
            }
        }
    }

    /// Texture (the environment is the one behind the last) and first texel of each bilinear footprint of every
    /// request, row by row.
    pub fn footprints(&self, each: &mut dyn FnMut(usize, Corner)) {
        let Some(engine) = &self.engine else { return };
        for row in &self.rows {
            let blocks = row.blocks.looks.iter().zip(&engine.textures).enumerate();
            for (index, (blocks, unit)) in blocks {
                let Some(texture) = &unit.texture else {
                    continue;
                };
                for block in blocks {
                    for (lane, _) in block.requests().iter().enumerate() {
                        let each = &mut |corner| each(index, corner);
                        unit.unit.footprints(block.state(), lane, texture, each);
                    }
                }
            }
            let Some(texture) = &engine.sky.texture else {
                continue;
            };
            let index = engine.textures.len();
            for block in &row.blocks.sky {
                for (lane, _) in block.rays().iter().enumerate() {
                    let each = &mut |corner| each(index, corner);
                    let unit = &engine.sky.unit;
                    unit.footprints(block.state(), lane, texture, each);
                }
            }
        }
    }
}

/// Compiles a scene's units around the memories of those before, where they hold the same.
fn compile(
    before: Option<TexEngine>,
    spec: &UnitSpec,
    subject: &TexSubject,
) -> Result<TexEngine, InputError> {
    let config = &spec.config;
    let (mut old, sky) = before.map_or((Vec::new(), None), |e| (e.textures, Some(e.sky)));
    old.retain(|unit| texel_key(&unit.config) == texel_key(config));
    let mut old = old.into_iter();
    let mut textures = Vec::new();
    for map in &subject.scene.textures {
        let unit = TexUnit::new(config, map.size_u32()).map_err(refused)?;
        let kept = old.next().and_then(|unit| unit.texture);
        let texture = match kept {
            Some(texture) => texture,
            None => texture(config, map).map_err(refused)?,
        };
        textures.push(TexRtl { unit, texture: Some(texture), config: config.clone() });
    }
    let nowhere = Distance::nothing();
    Ok(TexEngine { textures, sky: hit::compile(sky, spec, &nowhere, &subject.sky)? })
}
