//! The `rtl` engine: the integer model over blocks of fragments, all cores.

use std::collections::BTreeMap;
use std::time::Instant;

use rayon::prelude::*;
use rtl_model::fx::flags::FlagCounts;
use rtl_model::regs::{Event, Reg};
use rtl_model::unit::{Needs, Results, Words};
use rtl_model::{Config, Texture, Unit};

use super::dispatch::{self, Blocks, GROUP, Group, LANES, Level, Source};
use super::{Engine, Progress, Rendering, Rung, Subject, encode};
use crate::base::num;
use crate::cube::CubeMap;
use crate::error::InputError;
use crate::unit::{UnitSpec, refused};

/// Blocks that one task of the thread pool takes at a time.
const BLOCKS: usize = 32;

/// The integer model with its textures.
#[derive(Clone, Debug)]
pub struct RtlEngine {
    /// The compiled unit.
    pub unit: Unit,
    /// Texel memory.
    pub texture: Texture,
    /// The configuration that both were made from.
    pub config: Config,
    /// Instructions that blocks run under.
    pub level: Level,
}

impl RtlEngine {
    /// Compiles a unit for what a scene needs and encodes its environment.
    pub fn new(spec: &UnitSpec, needs: Needs, map: &CubeMap) -> Result<Self, InputError> {
        let size = num::u32(map.size());
        Ok(Self {
            unit: Unit::new(&spec.config, needs, size).map_err(refused)?,
            texture: encode::texture(&spec.config, map).map_err(refused)?,
            config: spec.config.clone(),
            level: Level::detect(),
        })
    }

    /// Filters fragments; colours as integers with the fraction bits of `filter.color`.
    #[must_use]
    pub fn filter(&self, words: &[Words], progress: Progress<'_>) -> Filtered {
        let mut colors = vec![[0; 3]; words.len()];
        let parts = words
            .par_chunks(LANES * BLOCKS)
            .zip(colors.par_chunks_mut(LANES * BLOCKS))
            .map(|(chunk, colors)| self.part(Source::Words(chunk), colors, progress))
            .collect();
        Filtered::whole(colors, parts)
    }

    /// Filters the fragments of kept groups from step `first` on: the steps before it have run there.
    #[must_use]
    pub fn refilter(
        &self,
        groups: &mut [Box<Group>],
        fragments: usize,
        first: usize,
        progress: Progress<'_>,
    ) -> Filtered {
        let mut colors = vec![[0; 3]; fragments];
        let parts = groups
            .par_chunks_mut(BLOCKS / GROUP)
            .zip(colors.par_chunks_mut(LANES * BLOCKS))
            .map(|(groups, colors)| self.part(Source::Kept(groups, first), colors, progress))
            .collect();
        Filtered::whole(colors, parts)
    }

    fn part(
        &self,
        source: Source<'_>,
        colors: &mut [[i64; 3]],
        progress: Progress<'_>,
    ) -> Filtered {
        let count = num::u64(colors.len());
        let mut part = Filtered::default();
        let mut colors = colors.iter_mut();
        let blocks = Blocks {
            unit: &self.unit,
            source,
            texture: Some(&self.texture),
            each: |out: &Results<LANES>, len| {
                for (color, to) in out.color[..len].iter().zip(&mut colors) {
                    *to = *color;
                }
                part.count(out, len);
            },
        };
        dispatch::run(self.level, blocks);
        progress(count);
        part
    }

    /// A colour code as a double: exact, as the register has at most 48 bits.
    #[must_use]
    pub fn color(&self, code: [i64; 3]) -> [f64; 3] {
        let frac = num::i32(self.config.format(Reg::FilterColor).frac);
        code.map(|c| crate::engine::probe::to_f64(c, frac))
    }
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
    fn whole(colors: Vec<[i64; 3]>, parts: Vec<Self>) -> Self {
        let mut whole = Self { colors, ..Self::default() };
        for part in &parts {
            whole.add(part);
        }
        whole
    }

    fn count(&mut self, out: &Results<LANES>, len: usize) {
        for lane in 0..len {
            self.probes += out.probes[lane].unsigned_abs();
            self.texels += out.texels[lane];
            self.flags.add(out.flags[lane]);
        }
    }

    fn add(&mut self, part: &Self) {
        self.probes += part.probes;
        self.texels += part.texels;
        self.flags.merge(&part.flags);
    }

    /// Names and counts of what was flagged.
    #[must_use]
    pub fn flag_names(&self, config: &Config) -> BTreeMap<String, u64> {
        let mut out = BTreeMap::new();
        for (reg, count) in Reg::ALL.iter().zip(self.flags.overflow) {
            if count > 0 {
                out.insert(overflow_name(config, *reg), count);
            }
        }
        for (event, count) in Event::ALL.iter().zip(self.flags.events) {
            if count > 0 {
                out.insert(event.name().to_string(), count);
            }
        }
        out
    }
}

/// `<stage>.<register>.saturated`, or `.wrapped` where the register wraps.
#[must_use]
pub fn overflow_name(config: &Config, reg: Reg) -> String {
    let info = reg.info();
    let how = match config.format(reg).overflow {
        rtl_model::fx::Overflow::Wrap => "wrapped",
        rtl_model::fx::Overflow::Saturate
        | rtl_model::fx::Overflow::SaturateSymmetric
        | rtl_model::fx::Overflow::Zero => "saturated",
    };
    format!("{}.{}.{how}", info.stage, info.name)
}

impl Engine for RtlEngine {
    fn rung(&self) -> Rung {
        Rung::Rtl
    }

    fn render(&self, subject: &Subject, progress: Progress<'_>) -> Rendering {
        let words: Vec<Words> =
            subject.scene.fragments.par_iter().map(|f| encode::words(&f.fragment)).collect();
        let start = Instant::now();
        let filtered = self.filter(&words, progress);
        self.rendering(subject, &filtered, start.elapsed().as_secs_f64())
    }
}

impl RtlEngine {
    /// What became of a subject's fragments, as a rendering.
    #[must_use]
    pub fn rendering(&self, subject: &Subject, filtered: &Filtered, seconds: f64) -> Rendering {
        let colors: Vec<[f64; 3]> = filtered.colors.iter().map(|c| self.color(*c)).collect();
        Rendering {
            picture: subject.picture(&colors),
            seconds,
            probes: filtered.probes,
            texels: filtered.texels,
            flags: filtered.flag_names(&self.config),
            standard_error: None,
            searches: None,
            texture_use: None,
            beyond_f32: None,
        }
    }
}
