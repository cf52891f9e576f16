//! The `rtl` engine: the integer model of an operation over blocks of requests, all cores.

use std::collections::BTreeMap;
use std::time::Instant;

use rayon::prelude::*;
use rtl_model::distance::DistanceMemory;
use rtl_model::fx::flags::{FlagCounts, Flags};
use rtl_model::regs::{Event, Reg};
use rtl_model::unit::{Block, BlockOf, EnvBlock, Memory, Needs, Operation, Results, Words};
use rtl_model::{Config, Tap, Texture, Unit};

use super::dispatch::{Blocks, Each, LANES, Level, Source};
use super::{Engine, EnvJob, Progress, Rendering, encode};
use crate::base::num;
use crate::cube::CubeMap;
use crate::error::InputError;
use crate::gpu::GpuError;
use crate::unit::{UnitSpec, refused};

/// Blocks that one task of the thread pool takes at a time.
const BLOCKS: usize = 32;

/// The integer model of an operation with its memory.
#[derive(Clone, Debug)]
pub struct Rtl<O> {
    /// The compiled unit.
    pub unit: O,
    /// Texels and distances.
    pub memory: Memory,
    /// The configuration that both were made from.
    pub config: Config,
    /// Instructions that blocks run under.
    pub level: Level,
}

impl<O: Operation> Rtl<O> {
    pub(super) fn around(spec: &UnitSpec, unit: O, memory: Memory) -> Self {
        Self { unit, memory, config: spec.config.clone(), level: Level::detect() }
    }

    /// The texels and the distances of an engine before, where a unit of `config` would hold the same of the same maps.
    pub(super) fn memory_for(
        before: Option<Self>,
        config: &Config,
    ) -> (Option<Texture>, Option<DistanceMemory>) {
        let Some(Self { memory, config: old, .. }) = before else {
            return (None, None);
        };
        let texels = |c: &Config| {
            let texel = &c.policy.texel;
            (texel.format, texel.int, texel.frac, c.policy.address.wrap())
        };
        let stored = |c: &Config| c.format(Reg::HitDistance);
        (
            memory.texture.filter(|_| texels(&old) == texels(config)),
            (stored(&old) == stored(config)).then_some(memory.distances),
        )
    }

    /// Runs blocks one after the other.
    pub fn blocks(&self, source: Source<'_, O>, each: Each<'_, O>) {
        Blocks { unit: &self.unit, memory: &self.memory, source, each }.run(self.level);
    }

    /// Runs blocks on all cores; `each` adds a block to the part of the result that its task makes. Parts in order.
    pub fn parts<P: Default + Send>(
        &self,
        source: Source<'_, O>,
        progress: Progress<'_>,
        each: impl Fn(&Self, &mut P, &BlockOf<O, LANES>, &Results<LANES>) + Sync,
    ) -> Vec<P> {
        let part = |source: Source<'_, O>| {
            let (mut part, mut count) = (P::default(), 0);
            self.blocks(source, &mut |block, out| {
                count += num::u64(block.env.len);
                each(self, &mut part, block, out);
            });
            progress(count);
            part
        };
        match source {
            Source::Words(words) => {
                words.par_chunks(LANES * BLOCKS).map(|words| part(Source::Words(words))).collect()
            }
            Source::Kept(blocks, first) => blocks
                .par_chunks_mut(BLOCKS)
                .map(|blocks| part(Source::Kept(blocks, first)))
                .collect(),
        }
    }

    /// Blocks whose results stay from unit to unit; nothing has run yet.
    #[must_use]
    pub fn kept(&self, words: &[O::Words]) -> Vec<BlockOf<O, LANES>> {
        let blocks = words.par_chunks(LANES).map(|words| {
            let mut block = Block::kept();
            self.unit.load(words, &mut block);
            block
        });
        blocks.collect()
    }

    /// Runs up to `N` requests as one block.
    pub fn lanes<const N: usize, T: Tap>(
        &self,
        words: &[O::Words],
        tap: &mut T,
    ) -> (BlockOf<O, N>, Results<N>) {
        let (mut block, mut out) = (Block::default(), Results::default());
        self.unit.load(words, &mut block);
        self.unit.run(&self.memory, &mut block, &mut out, tap);
        (block, out)
    }

    /// A colour code as a double: exact, as the register has at most 48 bits.
    #[must_use]
    pub fn color(&self, code: [i64; 3]) -> [f64; 3] {
        color(&self.config, code)
    }

    /// Names of the flags that are set.
    #[must_use]
    pub fn flag_names(&self, flags: Flags) -> Vec<String> {
        flag_names(&self.config, flags)
    }
}

fn color(config: &Config, code: [i64; 3]) -> [f64; 3] {
    let frac = num::i32(config.format(Reg::FilterColor).frac);
    code.map(|c| super::probe::to_f64(c, frac))
}

/// Names of the flags that are set.
#[must_use]
pub fn flag_names(config: &Config, flags: Flags) -> Vec<String> {
    let registers = Reg::ALL.iter().filter(|reg| flags.has(**reg));
    let events = Event::ALL.iter().filter(|event| flags.has_event(**event));
    registers
        .map(|reg| overflow_name(config, *reg))
        .chain(events.map(|event| event.name().to_string()))
        .collect()
}

/// `<stage>.<register>.saturated`, or `.wrapped` where the register wraps.
#[must_use]
pub fn overflow_name(config: &Config, reg: Reg) -> String {
    let how = match config.format(reg).overflow {
        rtl_model::fx::Overflow::Wrap => "wrapped",
        rtl_model::fx::Overflow::Saturate
        | rtl_model::fx::Overflow::SaturateSymmetric
        | rtl_model::fx::Overflow::Zero => "saturated",
    };
    format!("{reg}.{how}")
}

/// The integer model of ENV.
pub type RtlEngine = Rtl<Unit>;

impl RtlEngine {
    /// Compiles a unit with the parts that a scene needs and encodes its environment.
    pub fn new(spec: &UnitSpec, needs: Needs, map: &CubeMap) -> Result<Self, InputError> {
        Self::again(None, spec, needs, map)
    }

    /// [`RtlEngine::new`] with the texels of the engine before for the same map.
    pub(super) fn again(
        before: Option<Self>,
        spec: &UnitSpec,
        needs: Needs,
        map: &CubeMap,
    ) -> Result<Self, InputError> {
        let unit = Unit::new(&spec.config, needs, num::u32(map.size())).map_err(refused)?;
        let texture = match Self::memory_for(before, &spec.config).0 {
            Some(texture) => texture,
            None => encode::texture(&spec.config, map).map_err(refused)?,
        };
        let memory = Memory { texture: Some(texture), ..Memory::default() };
        Ok(Self::around(spec, unit, memory))
    }

    /// Filters fragments; colours as integers with the fraction bits of `filter.color`.
    #[must_use]
    pub fn filter(&self, words: &[Words], progress: Progress<'_>) -> Filtered {
        let parts = self.parts(Source::Words(words), progress, Self::add);
        Filtered::whole(parts, words.len())
    }

    /// Adds a block of fragments to a part.
    pub(super) fn add(&self, part: &mut Filtered, block: &EnvBlock<LANES>, out: &Results<LANES>) {
        let len = block.env.len;
        part.colors.extend_from_slice(&out.color[..len]);
        for lane in 0..len {
            part.probes += out.probes[lane].unsigned_abs();
            part.texels += out.texels[lane];
            part.flags.add(out.flags[lane]);
        }
    }
}

impl Engine<EnvJob> for RtlEngine {
    fn render(&self, job: &EnvJob, progress: Progress<'_>) -> Result<Rendering, GpuError> {
        let words = words_of(job);
        let start = Instant::now();
        let filtered = self.filter(&words, progress);
        Ok(filtered.rendering(&self.config, job, start))
    }
}

/// A job's fragments as the unit's ports take them.
pub(super) fn words_of(job: &EnvJob) -> Vec<Words> {
    job.scene.fragments.par_iter().map(|f| encode::words(&f.fragment)).collect()
}

/// Colours and counts of many fragments.
#[derive(Clone, Debug, Default)]
pub struct Filtered {
    /// RGB codes, one a fragment.
    pub colors: Vec<[i64; 3]>,
    /// Probes of all.
    pub probes: u64,
    /// Texels of all.
    pub texels: u64,
    /// Flagged fragments.
    pub flags: FlagCounts,
}

impl Filtered {
    /// Parts in order; `fragments` in all.
    pub(super) fn whole(parts: Vec<Self>, fragments: usize) -> Self {
        let mut whole = Self { colors: Vec::with_capacity(fragments), ..Self::default() };
        for part in parts {
            whole.colors.extend(part.colors);
            whole.probes += part.probes;
            whole.texels += part.texels;
            whole.flags.merge(&part.flags);
        }
        whole
    }

    /// A job's fragments, begun at `start`, as a rendering.
    pub(super) fn rendering(&self, config: &Config, job: &EnvJob, start: Instant) -> Rendering {
        let seconds = start.elapsed().as_secs_f64();
        let colors: Vec<[f64; 3]> = self.colors.iter().map(|c| color(config, *c)).collect();
        Rendering {
            picture: job.picture(&colors),
            seconds,
            probes: self.probes,
            texels: self.texels,
            flags: self.flag_names(config),
            ..Rendering::default()
        }
    }

    /// Names and counts of the flags that were set.
    #[must_use]
    pub fn flag_names(&self, config: &Config) -> BTreeMap<String, u64> {
        let registers = Reg::ALL.iter().map(|reg| overflow_name(config, *reg));
        let events = Event::ALL.iter().map(|event| event.name().to_string());
        let counts = self.flags.overflow.into_iter().chain(self.flags.events);
        registers.chain(events).zip(counts).filter(|(_, count)| *count > 0).collect()
    }
}
