//! Kept results of the TEX operation.

use std::hash::{Hash as _, Hasher as _};

use rayon::prelude::*;
use rtl_model::stages::filter::Corner;
use rtl_model::unit::{HitBlock, HitWords, Operation as _, TexBlock, TexUnit, TexWords};

use super::kept::{rays_key, touched_corners};
use super::lines::RtlLine;
use super::{Keys, MOST_KEPT, Saved, StepHasher};
use crate::distance::Distance;
use crate::engine::dispatch::LANES;
use crate::engine::hit::{HitRtl, words};
use crate::engine::job::tex::TexEngine;
use crate::engine::job::tex_requests::AskedRtl;
use crate::engine::tex::{TexRtl, value};
use crate::engine::{Engine as _, Rendering, TexJob};
use crate::error::InputError;
use crate::unit::UnitSpec;

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
    pub(in crate::engine) looks: Vec<Vec<TexBlock<LANES>>>,
    pub(in crate::engine) sky: Vec<HitBlock<LANES>>,
}

/// A row's requests and their blocks.
#[derive(Debug)]
pub(in crate::engine) struct KeptRow {
    pub(in crate::engine) asked: AskedRtl,
    pub(in crate::engine) blocks: KeptBlocks,
}

impl KeptRow {
    fn new(engine: &TexEngine, asked: AskedRtl) -> Self {
        let looks = engine.textures.iter().zip(&asked.looks).map(|(unit, looks)| {
            let words: Vec<TexWords> = looks.iter().map(|r| r.asked).collect();
            unit.kept(&words)
        });
        let looks = looks.collect();
        let rays: Vec<HitWords> = asked.sky.iter().map(|r| words(&r.asked)).collect();
        let blocks = KeptBlocks { looks, sky: engine.sky.kept(&rays) };
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
        subject: &TexJob,
    ) -> Result<(Rendering, Saved), InputError> {
        let engine = compile(self.engine.take(), spec, subject)?;
        if subject.requests > MOST_KEPT {
            let rendering = engine.render(subject, &|_| {})?;
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
                .map(|y| KeptRow::new(&engine, subject.ask_rtl(&engine, y)))
                .collect();
            self.cones = cones;
            (self.looks, self.sky) = (Vec::new(), Keys::default());
        }
        let looks: Vec<Keys> = engine.textures.iter().map(|t| Keys::of(&t.unit, cones)).collect();
        let sky = Keys::of(&engine.sky.unit, rays_key(spec, cones));
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
        let kept = first.looks.iter().copied().min().unwrap_or(0);
        let saved = Saved { kept, steps: TexUnit::STEPS };
        Ok((rendering, saved))
    }

    /// The engine that rendered last.
    #[must_use]
    pub fn engine(&self) -> Option<&TexEngine> {
        self.engine.as_ref()
    }

    /// What tells the last rendering's probes apart from others', in addition to the addresses' own configuration; nothing
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
    pub fn lines(&self, each: &mut dyn FnMut(RtlLine)) {
        let Some(engine) = &self.engine else { return };
        for row in &self.rows {
            let blocks = row.blocks.looks.iter().zip(&engine.textures);
            for (blocks, unit) in blocks {
                for block in blocks {
                    for lane in 0..block.env.len {
                        let width = value(unit.unit.cone.width(block.front.width(lane)));
                        let line = RtlLine::new(&unit.config, &block.env, lane);
                        each(RtlLine { width: Some(width), ..line });
                    }
                }
            }
        }
    }

    /// Texture (the environment is the one behind the last) and first texel of each bilinear footprint of every
    /// request, row by row.
    pub fn touched_corners(&self, each: &mut dyn FnMut(usize, Corner)) {
        let Some(engine) = &self.engine else { return };
        for row in &self.rows {
            for (index, (blocks, unit)) in row.blocks.looks.iter().zip(&engine.textures).enumerate()
            {
                touched_corners(unit, blocks, &mut |corner| each(index, corner));
            }
            let index = engine.textures.len();
            touched_corners(&engine.sky, &row.blocks.sky, &mut |corner| each(index, corner));
        }
    }
}

/// Compiles a scene's units around the memories of those before, where they hold the same.
fn compile(
    before: Option<TexEngine>,
    spec: &UnitSpec,
    subject: &TexJob,
) -> Result<TexEngine, InputError> {
    let (old, sky) = before.map_or((Vec::new(), None), |e| (e.textures, Some(e.sky)));
    let mut old = old.into_iter();
    let textures = subject.scene.textures.iter().map(|map| TexRtl::again(old.next(), spec, map));
    Ok(TexEngine {
        textures: textures.collect::<Result<_, _>>()?,
        sky: HitRtl::again(sky, spec, &Distance::nothing(), Some(&subject.sky), 0)?,
    })
}
