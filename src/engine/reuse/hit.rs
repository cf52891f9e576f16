//! Kept results of the HIT operation.

use std::hash::{Hash as _, Hasher as _};
use std::time::Instant;

use rtl_model::regs::Reg;
use rtl_model::stages::filter::Corner;
use rtl_model::unit::{HIT_STEPS, HitUnit};

use super::lines::RtlLine;
use super::{Keys, MOST_KEPT, Saved, StepHasher, texel_key};
use crate::base::num;
use crate::cube::CubeMap;
use crate::distance::Distance;
use crate::engine::dispatch::{LANES, Level};
use crate::engine::hit::{Block, HitResult, HitRtl, memory};
use crate::engine::hit_subject::HitSubject;
use crate::engine::{Rendering, encode};
use crate::error::InputError;
use crate::unit::{UnitSpec, refused};

/// Compiles a unit around the memories of the one before, where they hold the same.
pub(super) fn compile(
    before: Option<HitRtl>,
    spec: &UnitSpec,
    distance: &Distance,
    map: &CubeMap,
) -> Result<HitRtl, InputError> {
    let config = &spec.config;
    let size = num::u32(map.size());
    let unit = HitUnit::new(config, size).map_err(refused)?;
    let (mut distances, mut texture) = (None, None);
    if let Some(engine) = before {
        let stored = |c: &rtl_model::Config| c.format(Reg::HitDistance);
        if stored(&engine.config) == stored(config) {
            distances = Some(engine.memory);
        }
        if texel_key(&engine.config) == texel_key(config) {
            texture = engine.texture;
        }
    }
    Ok(HitRtl {
        unit,
        memory: match distances {
            Some(memory) => memory,
            None => memory(config, distance).map_err(refused)?,
        },
        texture: match texture {
            Some(texture) => Some(texture),
            None => Some(encode::texture(config, map).map_err(refused)?),
        },
        config: config.clone(),
        level: Level::detect(),
    })
}

/// Keys of the steps of rays whose own key is `rays`.
pub(super) fn keys(engine: &HitRtl, rays: u64) -> Keys {
    let mut hasher = StepHasher::default();
    (rays, engine.config.format(Reg::HitDistance)).hash(&mut hasher);
    Keys::new(HIT_STEPS, hasher.finish(), |n, hasher| {
        engine.unit.hash_step(n, hasher);
    })
}

/// A subject's rays with what a unit has made of them.
#[derive(Debug, Default)]
pub struct KeptHit {
    engine: Option<HitRtl>,
    blocks: Vec<Box<Block>>,
    keys: Keys,
}

impl KeptHit {
    /// Renders a subject, always the same one, by a unit; with each ray's result.
    pub fn render(
        &mut self,
        spec: &UnitSpec,
        subject: &HitSubject,
    ) -> Result<(Rendering, Vec<HitResult>, Saved), InputError> {
        let engine = compile(self.engine.take(), spec, &subject.distance, &subject.map)?;
        let rays = subject.fragments();
        if num::u64(rays.len()) > MOST_KEPT {
            let start = Instant::now();
            let results = engine.filter(&rays, &|_| {});
            let rendering = subject.rendering(start, &results);
            self.engine = Some(engine);
            return Ok((rendering, results, Saved::default()));
        }
        if self.blocks.is_empty() {
            self.blocks = rays.chunks(LANES).map(Block::kept).collect();
        }
        let keys = keys(&engine, 0);
        let first = keys.first_changed(&self.keys);
        let start = Instant::now();
        let results = engine.refilter(&mut self.blocks, first, &|_| {});
        let rendering = subject.rendering(start, &results);
        self.keys = keys;
        self.engine = Some(engine);
        let saved = Saved { kept: first, steps: HIT_STEPS };
        Ok((rendering, results, saved))
    }

    /// The engine that rendered last.
    #[must_use]
    pub fn engine(&self) -> Option<&HitRtl> {
        self.engine.as_ref()
    }

    /// What tells the last rendering's probes apart from others', beside the addresses' own configuration; nothing
    /// where no registers are kept.
    #[must_use]
    pub fn probes_key(&self) -> Option<u64> {
        (!self.blocks.is_empty()).then(|| self.keys.last())
    }

    /// The probe line of every ray.
    pub fn lines(&self, each: &mut dyn FnMut(RtlLine)) {
        let Some(engine) = &self.engine else { return };
        for block in &self.blocks {
            for (lane, _) in block.rays().iter().enumerate() {
                each(RtlLine::new(&engine.config, &block.state().env, lane));
            }
        }
    }

    /// The first texel of each bilinear footprint of every ray, in the rays' order.
    pub fn footprints(&self, each: &mut dyn FnMut(Corner)) {
        let Some(engine) = &self.engine else { return };
        let Some(texture) = &engine.texture else {
            return;
        };
        for block in &self.blocks {
            for (lane, _) in block.rays().iter().enumerate() {
                engine.unit.footprints(block.state(), lane, texture, each);
            }
        }
    }
}
