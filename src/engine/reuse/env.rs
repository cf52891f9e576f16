//! Kept results of the ENV operation.

use std::time::Instant;

use rayon::prelude::*;
use rtl_model::Unit;
use rtl_model::stages::filter::Corner;
use rtl_model::unit::{ENV_STEPS, Words};

use super::lines::RtlLine;
use super::{Keys, MOST_KEPT, Saved, texel_key};
use crate::base::num;
use crate::engine::dispatch::{GROUP, Group, LANES, Level};
use crate::engine::rtl::RtlEngine;
use crate::engine::{Engine as _, Rendering, Subject, encode};
use crate::error::InputError;
use crate::unit::{UnitSpec, refused};

/// A subject's fragments with what a unit has made of them.
#[derive(Debug, Default)]
pub struct KeptEnv {
    engine: Option<RtlEngine>,
    groups: Vec<Box<Group>>,
    keys: Keys,
}

impl KeptEnv {
    /// Renders a subject, always the same one, by a unit.
    pub fn render(
        &mut self,
        spec: &UnitSpec,
        subject: &Subject,
    ) -> Result<(Rendering, Saved), InputError> {
        let size = num::u32(subject.map.size());
        let unit = Unit::new(&spec.config, subject.needs(), size).map_err(refused)?;
        let same_texels = |e: &RtlEngine| texel_key(&e.config) == texel_key(&spec.config);
        let texture = match self.engine.take().filter(same_texels) {
            Some(engine) => engine.texture,
            None => encode::texture(&spec.config, &subject.map).map_err(refused)?,
        };
        let engine =
            RtlEngine { unit, texture, config: spec.config.clone(), level: Level::detect() };
        if num::u64(subject.scene.fragments.len()) > MOST_KEPT {
            let rendering = engine.render(subject, &|_| {});
            self.engine = Some(engine);
            return Ok((rendering, Saved::default()));
        }
        if self.groups.is_empty() {
            let fragments = subject.scene.fragments.par_chunks(GROUP * LANES);
            self.groups = fragments
                .map(|chunk| {
                    let words: Vec<Words> =
                        chunk.iter().map(|f| encode::words(&f.fragment)).collect();
                    Group::kept(&engine.unit, &words)
                })
                .collect();
        }
        let keys = Keys::new(ENV_STEPS, 0, |n, hasher| engine.unit.hash_step(n, hasher));
        let first = keys.first_changed(&self.keys);
        let start = Instant::now();
        let fragments = subject.scene.fragments.len();
        let filtered = engine.refilter(&mut self.groups, fragments, first, &|_| {});
        let rendering = engine.rendering(subject, &filtered, start.elapsed().as_secs_f64());
        self.keys = keys;
        self.engine = Some(engine);
        let saved = Saved { kept: first, steps: ENV_STEPS };
        Ok((rendering, saved))
    }

    /// The engine that rendered last.
    #[must_use]
    pub fn engine(&self) -> Option<&RtlEngine> {
        self.engine.as_ref()
    }

    /// What tells the last rendering's probes apart from others', beside the addresses' own configuration; nothing
    /// where no registers are kept.
    #[must_use]
    pub fn probes_key(&self) -> Option<u64> {
        (!self.groups.is_empty()).then(|| self.keys.last())
    }

    /// The probe line of every fragment.
    pub fn lines(&self, each: &mut dyn FnMut(RtlLine)) {
        let Some(engine) = &self.engine else { return };
        for (state, len) in self.groups.iter().flat_map(|g| g.blocks()) {
            for lane in 0..len {
                each(RtlLine::new(&engine.config, state, lane));
            }
        }
    }

    /// The first texel of each bilinear footprint of every fragment, in the fragments' order.
    pub fn footprints(&self, each: &mut dyn FnMut(Corner)) {
        let Some(engine) = &self.engine else { return };
        for (state, len) in self.groups.iter().flat_map(|g| g.blocks()) {
            for lane in 0..len {
                engine.unit.footprints(state, lane, &engine.texture, each);
            }
        }
    }
}
