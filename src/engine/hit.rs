//! The HIT operation over many rays, on all cores: the integer model and the float reference, with one result shape.

use rayon::prelude::*;
use rtl_model::distance::DistanceMemory;
use rtl_model::regs::{Event, Reg};
use rtl_model::unit::{HitBlock, HitUnit, HitWords, Memory, Results};
use rtl_model::{Config, ConfigError};

use super::Progress;
use super::dispatch::Source;
use super::probe::{Code, RtlProbe};
use super::reuse::lines::Line;
use super::rtl::Rtl;
use crate::base::num;
use crate::cube::{CubeMap, FACE_NAMES, across_edge};
use crate::distance::Distance;
use crate::error::InputError;
use crate::fragment::HitFragment;
use crate::policy::HitStatus;
use crate::reference::{self, Distances, Prepared, hit_env};
use crate::settings::Settings;
use crate::unit::{UnitSpec, refused};

/// Rays that one task of the float reference takes at a time.
const CHUNK: usize = 512;

/// An engine's result for one ray.
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
    /// Names of the ray's flags.
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
pub fn distances_of(config: &Config, distance: &Distance) -> Result<DistanceMemory, ConfigError> {
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

/// The integer model of HIT.
pub type HitRtl = Rtl<HitUnit>;

/// The float reference with its maps.
#[derive(Debug)]
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
        Self::again(None, spec, distance, map, face_size)
    }

    /// [`HitRtl::new`] with the memories of the engine before, made from the same maps.
    pub(super) fn again(
        before: Option<Self>,
        spec: &UnitSpec,
        distance: &Distance,
        map: Option<&CubeMap>,
        face_size: usize,
    ) -> Result<Self, InputError> {
        let config = &spec.config;
        let size = num::u32(map.map_or(face_size, CubeMap::size));
        let unit = HitUnit::new(config, size).map_err(refused)?;
        let (texture, distances) = Self::memory_for(before, config);
        let memory = Memory {
            texture: match (texture, map) {
                (None, Some(map)) => Some(super::encode::texture(config, map).map_err(refused)?),
                (texture, _) => texture,
            },
            distances: match distances {
                Some(distances) => distances,
                None => distances_of(config, distance).map_err(refused)?,
            },
        };
        Ok(Self::around(spec, unit, memory))
    }

    /// Every ray's result, in order.
    #[must_use]
    pub fn filter(&self, rays: &[HitFragment], progress: Progress<'_>) -> Vec<HitResult> {
        let words: Vec<HitWords> = rays.iter().map(words).collect();
        self.parts(Source::Words(&words), progress, Self::add).concat()
    }

    /// Adds the results of a block to a part.
    pub(super) fn add<const N: usize>(
        &self,
        part: &mut Vec<HitResult>,
        block: &HitBlock<N>,
        out: &Results<N>,
    ) {
        part.extend((0..block.env.len).map(|lane| self.result(block, out, lane)));
    }

    /// Runs one ray with a recording tap.
    pub fn trace(&self, ray: &HitFragment, probe: &mut RtlProbe) -> (HitResult, &'static str) {
        probe.clear();
        let (block, out) = self.lanes::<1, _>(&[words(ray)], probe);
        (self.result(&block, &out, 0), FACE_NAMES[block.env.face_of(0)])
    }

    /// One lane's result.
    #[must_use]
    pub fn result<const N: usize>(
        &self,
        block: &HitBlock<N>,
        out: &Results<N>,
        lane: usize,
    ) -> HitResult {
        let hit = &block.front.hit;
        let status = hit.status[lane];
        let escaped = status == HitStatus::Escaped;
        let value = |raw, reg: Reg, scale| {
            Code { raw, frac: i64::from(self.config.format(reg).frac) - scale }.value()
        };
        let scale = self.memory.distances.scale;
        let (l_reg, l_scale) = if escaped { (Reg::HitR, 0) } else { (Reg::HitL, scale) };
        let flags = out.flags[lane];
        let cone = block.front.has_cone(lane);
        let textured = cone && self.memory.texture.is_some();
        HitResult {
            d: if escaped { f64::INFINITY } else { value(hit.d[lane], Reg::HitD, scale) },
            l: std::array::from_fn(|c| value(hit.l[c][lane], l_reg, l_scale)),
            iterations: hit.iterations[lane],
            status,
            ratio: hit.ratio[lane].map(|raw| value(raw, Reg::HitRatio, 0)),
            color: if textured { self.color(out.color[lane]) } else { [0.0; 3] },
            probes: if cone { num::u32(out.probes[lane]) } else { 0 },
            texels: if textured { out.texels[lane] } else { 0 },
            overshot: flags.has_event(Event::HitOvershoot),
            flags: self.flag_names(flags),
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
