//! The HIT operation over many rays, on all cores: the integer model and the float reference, with one result shape.

use rayon::prelude::*;
use rtl_model::distance::DistanceMemory;
use rtl_model::regs::{Event, Reg};
use rtl_model::unit::{HitPorts, HitResults, HitState, HitUnit, HitWords};
use rtl_model::{Config, ConfigError, NoTap, NoTapStandard, Tap, Texture};

use super::Progress;
use super::dispatch::{self, LANES, Level, Task};
use super::probe::{Code, RtlProbe, to_f64};
use super::reuse::lines::Line;
use super::rtl::overflow_name;
use crate::base::num;
use crate::cube::{CubeMap, FACE_NAMES, across_edge};
use crate::distance::Distance;
use crate::error::InputError;
use crate::fragment::HitFragment;
use crate::policy::HitStatus;
use crate::reference::{self, Distances, Prepared, hit_env};
use crate::settings::Settings;
use crate::unit::{UnitSpec, refused};

/// Rays that one task of the thread pool takes at a time.
const CHUNK: usize = 16 * LANES;

/// What an engine made of one ray.
#[derive(Clone, Debug, PartialEq)]
pub struct HitResult {
    /// Ray parameter along the unit direction; ∞ where the ray escaped.
    pub d: f64,
    /// The hit; the unit direction where the ray escaped.
    pub l: [f64; 3],
    /// Look-ups in the loop.
    pub iterations: u32,
    /// How the search ended.
    pub status: HitStatus,
    /// The last |l|/dist(l) of the loop.
    pub ratio: Option<f64>,
    /// Filtered colour; black without a cone or a map.
    pub color: [f64; 3],
    /// Probes of the filter; 0 without a cone.
    pub probes: u32,
    /// Texels that the filter read.
    pub texels: u64,
    /// Names of what the ray reported.
    pub flags: Vec<String>,
    /// Whether a step went beyond the reference surface.
    pub overshot: bool,
}

/// A ray as the unit's ports take it.
#[must_use]
pub fn words(fragment: &HitFragment) -> HitWords {
    let bits = |v: [f64; 3]| v.map(f64::to_bits);
    HitWords {
        x: bits(fragment.x),
        r: bits(fragment.r),
        cone: fragment.cone.map(|cone| cone.map(f64::to_bits)),
    }
}

/// Distances in the unit's memory format.
pub fn memory(config: &Config, distance: &Distance) -> Result<DistanceMemory, ConfigError> {
    match distance {
        Distance::Box(half_edges) => {
            DistanceMemory::ideal_box(config, half_edges.map(f64::to_bits))
        }
        Distance::Sphere(radius) => DistanceMemory::sphere(config, radius.to_bits()),
        Distance::Cube(cube) => {
            let words: Vec<u32> = cube.texels.iter().map(|t| t.to_bits()).collect();
            DistanceMemory::cube(config, cube.size, &words, &across_edge)
        }
    }
}

/// The integer model with its memories.
#[derive(Clone, Debug)]
pub struct HitRtl {
    /// The compiled unit.
    pub unit: HitUnit,
    /// Distances.
    pub memory: DistanceMemory,
    /// Texels, if there is a map.
    pub texture: Option<Texture>,
    /// The configuration that all were made from.
    pub config: Config,
    /// Instructions that blocks run under.
    pub level: Level,
}

/// The float reference with its maps.
#[derive(Clone, Debug)]
pub struct HitF64<'a> {
    prepared: Prepared,
    distances: Distances,
    texture: Option<reference::Texture<'a>>,
    face_size: usize,
}

impl HitRtl {
    /// Compiles a unit and encodes distances and, if there is one, the environment.
    pub fn new(
        spec: &UnitSpec,
        distance: &Distance,
        map: Option<&CubeMap>,
        face_size: usize,
    ) -> Result<Self, InputError> {
        let size = map.map_or(face_size, CubeMap::size);
        let size = num::u32(size);
        let texture = match map {
            Some(map) => Some(super::encode::texture(&spec.config, map).map_err(refused)?),
            None => None,
        };
        Ok(Self {
            unit: HitUnit::new(&spec.config, size).map_err(refused)?,
            memory: memory(&spec.config, distance).map_err(refused)?,
            texture,
            config: spec.config.clone(),
            level: Level::detect(),
        })
    }

    /// Every ray's result, in order.
    #[must_use]
    pub fn filter(&self, rays: &[HitFragment], progress: Progress<'_>) -> Vec<HitResult> {
        let parts: Vec<Vec<HitResult>> =
            rays.par_chunks(CHUNK).map(|chunk| self.part(Source::Rays(chunk), progress)).collect();
        parts.into_iter().flatten().collect()
    }

    /// Every ray's result, in order, from step `first` on: the steps before it have run in these blocks.
    #[must_use]
    pub fn refilter(
        &self,
        blocks: &mut [Box<Block>],
        first: usize,
        progress: Progress<'_>,
    ) -> Vec<HitResult> {
        let parts: Vec<Vec<HitResult>> = blocks
            .par_chunks_mut(CHUNK / LANES)
            .map(|blocks| self.part(Source::Kept(blocks, first), progress))
            .collect();
        parts.into_iter().flatten().collect()
    }

    fn part(&self, source: Source<'_>, progress: Progress<'_>) -> Vec<HitResult> {
        let mut part = Vec::new();
        let blocks = Blocks {
            engine: self,
            source,
            each: |block: &Block| {
                for (lane, ray) in block.rays.iter().enumerate() {
                    let cone = ray.cone.is_some();
                    part.push(self.result(&block.state, &block.out, lane, cone));
                }
            },
        };
        dispatch::run(self.level, blocks);
        progress(num::u64(part.len()));
        part
    }

    /// Runs one ray with a recording tap.
    pub fn trace(&self, ray: &HitFragment, probe: &mut RtlProbe) -> (HitResult, &'static str) {
        probe.clear();
        let (state, out) = self.lanes::<1, _>(std::slice::from_ref(ray), probe);
        let face = FACE_NAMES[state.env.face.face[0]];
        (self.result(&state, &out, 0, ray.cone.is_some()), face)
    }

    /// Runs up to `N` rays as one block.
    pub fn lanes<const N: usize, T: Tap>(
        &self,
        rays: &[HitFragment],
        tap: &mut T,
    ) -> (HitState<N>, HitResults<N>) {
        let mut ports = HitPorts::<N>::default();
        for ray in rays {
            self.unit.load(&mut ports, &self.memory, &words(ray), tap);
        }
        let mut state = HitState::default();
        let mut out = HitResults::default();
        let texture = self.texture.as_ref();
        self.unit.run(&ports, &self.memory, texture, &mut state, &mut out, tap);
        (state, out)
    }

    /// A length's code in true units.
    fn length(&self, raw: i64, reg: Reg, scale: i64) -> Code {
        Code { raw, frac: i64::from(self.config.format(reg).frac) - scale }
    }

    /// One lane's result.
    #[must_use]
    pub fn result<const N: usize>(
        &self,
        state: &HitState<N>,
        out: &HitResults<N>,
        lane: usize,
        cone: bool,
    ) -> HitResult {
        let hit = &state.hit;
        let status = hit.status[lane];
        let escaped = status == HitStatus::Escaped;
        let scale = self.memory.scale;
        let ratio_frac = i64::from(self.config.format(Reg::HitRatio).frac);
        let value = |raw, frac| Code { raw, frac }.value();
        let flags = out.env.flags[lane];
        let mut names = Vec::new();
        for reg in Reg::ALL.iter().filter(|reg| flags.has(**reg)) {
            names.push(overflow_name(&self.config, *reg));
        }
        for event in Event::ALL.iter().filter(|event| flags.has_event(**event)) {
            names.push(event.name().to_string());
        }
        let color_frac = num::i32(self.config.format(Reg::FilterColor).frac);
        let textured = cone && self.texture.is_some();
        HitResult {
            d: if escaped {
                f64::INFINITY
            } else {
                self.length(hit.d[lane], Reg::HitD, scale).value()
            },
            l: std::array::from_fn(|c| {
                let raw = hit.l[c][lane];
                if escaped {
                    self.length(raw, Reg::HitR, 0).value()
                } else {
                    self.length(raw, Reg::HitL, scale).value()
                }
            }),
            iterations: hit.iterations[lane],
            status,
            ratio: hit.ratio[lane].map(|raw| value(raw, ratio_frac)),
            color: if textured {
                out.env.color[lane].map(|c| to_f64(c, color_frac))
            } else {
                [0.0; 3]
            },
            probes: if cone { num::u32(out.env.probes[lane]) } else { 0 },
            texels: if textured { out.env.texels[lane] } else { 0 },
            overshot: flags.has_event(Event::HitOvershoot),
            flags: names,
        }
    }
}

/// A block of rays with everything that becomes of them.
#[derive(Clone, Debug, Default)]
pub struct Block {
    rays: Vec<HitFragment>,
    ports: HitPorts<LANES>,
    state: HitState<LANES>,
    out: HitResults<LANES>,
}

impl Block {
    /// A block whose results stay from unit to unit; nothing has run yet.
    #[must_use]
    pub fn kept(rays: &[HitFragment]) -> Box<Self> {
        Box::new(Self { rays: rays.to_vec(), state: HitState::kept(), ..Self::default() })
    }

    /// What the steps have left.
    #[must_use]
    pub fn state(&self) -> &HitState<LANES> {
        &self.state
    }

    /// Its rays, one a lane.
    #[must_use]
    pub fn rays(&self) -> &[HitFragment] {
        &self.rays
    }

    /// Runs the block's rays from a step on.
    #[inline(always)]
    fn pass<T: Tap>(&mut self, engine: &HitRtl, first: usize, tap: &mut T) {
        let Self { rays, ports, state, out } = self;
        if first == 0 {
            ports.len = 0;
            for ray in rays {
                engine.unit.load(ports, &engine.memory, &words(ray), tap);
            }
        }
        let (memory, texture) = (&engine.memory, engine.texture.as_ref());
        engine.unit.run_from(first, ports, memory, texture, state, out, tap);
    }
}

/// Where blocks of rays come from.
enum Source<'a> {
    /// Rays, through the whole unit.
    Rays(&'a [HitFragment]),
    /// Blocks that stay from unit to unit, from this step on.
    Kept(&'a mut [Box<Block>], usize),
}

/// Blocks of rays through the unit.
struct Blocks<'a, F> {
    engine: &'a HitRtl,
    source: Source<'a>,
    each: F,
}

impl<F: FnMut(&Block)> Task for Blocks<'_, F> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let mut passing = Box::<Block>::default();
        let mut number = 0;
        loop {
            let (block, first) = match &mut self.source {
                Source::Rays(rays) if !rays.is_empty() => {
                    let (now, later) = rays.split_at(rays.len().min(LANES));
                    passing.rays.clear();
                    passing.rays.extend_from_slice(now);
                    *rays = later;
                    (&mut passing, 0)
                }
                Source::Kept(blocks, first) if number < blocks.len() => {
                    number += 1;
                    (&mut blocks[number - 1], *first)
                }
                Source::Rays(_) | Source::Kept(..) => return,
            };
            // Only the search's and the filter's registers are read of lanes with a cone.
            if self.engine.unit.is_standard() {
                block.pass(self.engine, first, &mut NoTapStandard);
            } else {
                block.pass(self.engine, first, &mut NoTap);
            }
            (self.each)(block);
        }
    }
}

impl<'a> HitF64<'a> {
    /// Prepares policies, distances and, if there is one, the environment.
    #[must_use]
    pub fn new(
        settings: &Settings,
        distance: &Distance,
        map: Option<&'a CubeMap>,
        face_size: usize,
    ) -> Self {
        Self {
            prepared: Prepared::new(settings),
            distances: Distances::new(distance),
            texture: map.map(reference::Texture::new),
            face_size: map.map_or(face_size, CubeMap::size),
        }
    }

    /// Every ray's result, in order.
    #[must_use]
    pub fn filter(&self, rays: &[HitFragment], progress: Progress<'_>) -> Vec<HitResult> {
        let parts: Vec<Vec<HitResult>> = rays
            .par_chunks(CHUNK)
            .map(|chunk| {
                let part = chunk.iter().map(|ray| self.one(ray)).collect();
                progress(num::u64(chunk.len()));
                part
            })
            .collect();
        parts.into_iter().flatten().collect()
    }

    /// Everything about one ray; a tap sees its registers.
    pub fn trace<T: reference::Tap>(&self, ray: &HitFragment, tap: &mut T) -> reference::HitEnv {
        hit_env(&self.prepared, &self.distances, ray, self.face_size, self.texture.as_ref(), tap)
    }

    /// Every ray's result and its probe line, in order. A ray without a cone has the line of no footprint.
    #[must_use]
    pub fn lines(&self, rays: &[HitFragment]) -> (Vec<HitResult>, Vec<Line>) {
        let each = |ray: &HitFragment| {
            let both = self.trace(ray, &mut reference::NoTap);
            let line = both.env.map_or(Line::NONE, |env| Line::of_env(&env, self.face_size));
            (Self::result(&both), line)
        };
        rays.par_iter().map(each).unzip()
    }

    fn one(&self, ray: &HitFragment) -> HitResult {
        Self::result(&self.trace(ray, &mut reference::NoTap))
    }

    fn result(both: &reference::HitEnv) -> HitResult {
        let hit = &both.hit;
        let flags = both.env.map_or(hit.flags, |env| env.flags);
        HitResult {
            d: hit.d,
            l: hit.l,
            iterations: hit.iterations,
            status: hit.status,
            ratio: hit.ratio,
            color: both.env.map_or([0.0; 3], |env| env.color),
            probes: both.env.map_or(0, |env| env.probes),
            texels: both.env.map_or(0, |env| {
                let levels = if env.lod.fract() == 0.0 { 1 } else { 2 };
                4 * levels * u64::from(env.probes)
            }),
            overshot: flags.contains(reference::Flag::HitOvershoot),
            flags: flags.names().map(String::from).collect(),
        }
    }
}
