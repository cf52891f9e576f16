//! Kept results of the ENV operation and of HIT.

use std::hash::{Hash as _, Hasher as _};
use std::time::Instant;

use rtl_model::Unit;
use rtl_model::regs::Reg;
use rtl_model::stages::filter::Corner;
use rtl_model::unit::{BlockOf, HitUnit, Operation, Results};

use super::lines::RtlLine;
use super::{Keys, MOST_KEPT, Saved, StepHasher};
use crate::engine::dispatch::{LANES, Source};
use crate::engine::hit::{HitResult, HitRtl, words};
use crate::engine::rtl::{Filtered, Rtl, RtlEngine, words_of};
use crate::engine::{EnvJob, HitJob, Rendering};
use crate::error::InputError;
use crate::unit::UnitSpec;

/// A job's requests with a unit's results for them.
#[derive(Debug)]
pub struct Kept<O: Operation> {
    engine: Option<Rtl<O>>,
    blocks: Vec<BlockOf<O, LANES>>,
    keys: Keys,
}

impl<O: Operation> Default for Kept<O> {
    fn default() -> Self {
        Self { engine: None, blocks: Vec::new(), keys: Keys::default() }
    }
}

/// A job's fragments with a unit's results for them.
pub type KeptEnv = Kept<Unit>;
/// A job's rays with a unit's results for them.
pub type KeptHit = Kept<HitUnit>;

/// Parts of a result in order, the time of the start, and the parts that were kept.
type Again<P> = (Vec<P>, Instant, Saved);

impl<O: Operation> Kept<O> {
    /// Runs `count` requests, always the same ones, by the unit of `engine`; the first step's key is `inputs`.
    fn run<P: Default + Send>(
        &mut self,
        engine: Rtl<O>,
        inputs: u64,
        count: usize,
        words: impl FnOnce() -> Vec<O::Words>,
        each: impl Fn(&Rtl<O>, &mut P, &BlockOf<O, LANES>, &Results<LANES>) + Sync,
    ) -> Again<P> {
        let engine = self.engine.insert(engine);
        if count as u64 > MOST_KEPT {
            let words = words();
            let start = Instant::now();
            let parts = engine.parts(Source::Words(&words), &|_| {}, each);
            return (parts, start, Saved::default());
        }
        if self.blocks.is_empty() {
            self.blocks = engine.kept(&words());
        }
        let keys = Keys::of(&engine.unit, inputs);
        let first = keys.first_changed(&self.keys);
        self.keys = keys;
        let start = Instant::now();
        let parts = engine.parts(Source::Kept(&mut self.blocks, first), &|_| {}, each);
        (parts, start, Saved { kept: first, steps: O::STEPS })
    }

    /// The engine that rendered last.
    #[must_use]
    pub fn engine(&self) -> Option<&Rtl<O>> {
        self.engine.as_ref()
    }

    /// What tells the last rendering's probes apart from others', in addition to the addresses' own configuration; nothing
    /// where no registers are kept.
    #[must_use]
    pub fn probes_key(&self) -> Option<u64> {
        (!self.blocks.is_empty()).then(|| self.keys.last())
    }

    /// The probe line of every request.
    pub fn lines(&self, each: &mut dyn FnMut(RtlLine)) {
        let Some(engine) = &self.engine else { return };
        for block in &self.blocks {
            for lane in 0..block.env.len {
                each(RtlLine::new(&engine.config, &block.env, lane));
            }
        }
    }

    /// The first texel of each bilinear footprint of every request, in their order.
    pub fn touched_corners(&self, each: &mut dyn FnMut(Corner)) {
        if let Some(engine) = &self.engine {
            touched_corners(engine, &self.blocks, each);
        }
    }
}

/// The first texel of each bilinear footprint of every request in `blocks`.
pub(super) fn touched_corners<O: Operation>(
    engine: &Rtl<O>,
    blocks: &[BlockOf<O, LANES>],
    each: &mut dyn FnMut(Corner),
) {
    let Some(texture) = &engine.memory.texture else { return };
    for block in blocks {
        for lane in 0..block.env.len {
            engine.unit.touched_corners(block, lane, texture, each);
        }
    }
}

impl KeptEnv {
    /// Renders a job, always the same one, by a unit.
    pub fn render(
        &mut self,
        spec: &UnitSpec,
        job: &EnvJob,
    ) -> Result<(Rendering, Saved), InputError> {
        let engine = RtlEngine::again(self.engine.take(), spec, job.needs(), &job.map)?;
        let count = job.scene.fragments.len();
        let words = || words_of(job);
        let (parts, start, saved) = self.run(engine, 0, count, words, RtlEngine::add);
        let filtered = Filtered::whole(parts, count);
        Ok((filtered.rendering(&spec.config, job, start), saved))
    }
}

/// The key of rays in front of their first step; `rays` is their own.
pub(super) fn rays_key(spec: &UnitSpec, rays: u64) -> u64 {
    let mut hasher = StepHasher::default();
    (rays, spec.config.format(Reg::HitDistance)).hash(&mut hasher);
    hasher.finish()
}

impl KeptHit {
    /// Renders a job, always the same one, by a unit; with each ray's result.
    pub fn render(
        &mut self,
        spec: &UnitSpec,
        job: &HitJob,
    ) -> Result<(Rendering, Vec<HitResult>, Saved), InputError> {
        let map = Some(&job.map);
        let engine = HitRtl::again(self.engine.take(), spec, &job.distance, map, 0)?;
        let rays = &job.scene.rays;
        let all = || rays.iter().map(|ray| words(&ray.fragment)).collect();
        let key = rays_key(spec, 0);
        let (parts, start, saved) = self.run(engine, key, rays.len(), all, HitRtl::add);
        let results = parts.concat();
        Ok((job.rendering(start, &results), results, saved))
    }
}
