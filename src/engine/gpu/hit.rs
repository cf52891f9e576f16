//! The HIT operation on a device.

use std::time::Instant;

use super::{Filtered, GpuEngine, Loaded, Operands, Reports, bit, flag_names, tables};
use crate::base::num;
use crate::cube::CubeMap;
use crate::distance::Distance;
use crate::engine::hit::HitResult;
use crate::engine::{Engine, HitJob, Progress, Rendering};
use crate::fragment::HitFragment;
use crate::gpu::dispatch::Words;
use crate::gpu::kernels::Fused;
use crate::gpu::maps::Maps;
use crate::gpu::{Gpu, GpuError};
use crate::policy::HitStatus;
use crate::reference::Flag;
use crate::settings::Settings;

/// Words of HIT's operands and results.
const HIT_WORDS: Words = Words { input: 9, output: Filtered::WORDS + 7 };

/// How a search ended, by the shader's number.
pub const STATUS: [HitStatus; 6] = [
    HitStatus::Converged,
    HitStatus::MaxIterations,
    HitStatus::Stalled,
    HitStatus::Escaped,
    HitStatus::AtSurface,
    HitStatus::Outside,
];

/// The HIT operation's kernel with its maps.
pub struct GpuHit<'a>(Loaded<'a>);

/// A ray's words.
pub fn encode(operands: &mut Operands, ray: &HitFragment) {
    operands.begin();
    operands.numbers(&ray.x);
    operands.numbers(&scaled(ray.r));
    operands.numbers(&ray.cone.unwrap_or_default());
    operands.word(u32::from(ray.cone.is_some()));
}

/// A direction whose largest component lies in [1, 2): only its direction counts, and f32 keeps that.
fn scaled(r: [f64; 3]) -> [f64; 3] {
    let largest = r.iter().fold(0.0f64, |most, c| most.max(c.abs()));
    if largest == 0.0 || !largest.is_finite() {
        return r;
    }
    let (_, exponent) = libm::frexp(largest);
    r.map(|c| libm::ldexp(c, 1 - exponent))
}

impl<'a> GpuHit<'a> {
    /// Compiles the kernel and uploads distances and, if there is one, the environment.
    ///
    /// # Errors
    ///
    /// A map beyond the device's limits, or the driver's error.
    pub fn new(
        gpu: &'a Gpu,
        settings: &Settings,
        distance: &Distance,
        map: Option<&CubeMap>,
        face_size: usize,
    ) -> Result<Self, GpuError> {
        let mut maps = Maps::new(gpu, settings, &tables(settings))?.with_distance(distance)?;
        if let Some(map) = map {
            maps = maps.with_cube(map)?;
        } else {
            let size = face_size.max(1);
            maps.policy = maps.policy.with_size([size; 2], size.ilog2() as usize + 1);
        }
        Ok(Self(Loaded::new(Fused::Hit, maps, HIT_WORDS)?))
    }

    /// Every ray's result, in order.
    pub fn filter(
        &self,
        rays: &[HitFragment],
        progress: Progress<'_>,
    ) -> Result<Vec<HitResult>, GpuError> {
        Ok(self.reported(rays, &vec![[0; 2]; rays.len()], progress)?.0)
    }

    /// Every ray's result and, by the rays' pixels, what left the range of f32.
    pub fn reported(
        &self,
        rays: &[HitFragment],
        pixels: &[[u32; 2]],
        progress: Progress<'_>,
    ) -> Result<(Vec<HitResult>, Reports), GpuError> {
        let mut operands = Operands::new(Flag::HitNotFinite);
        for ray in rays {
            encode(&mut operands, ray);
        }
        let cones = &mut rays.iter().map(|ray| ray.cone.is_some());
        self.0.run(&operands, pixels.iter().copied(), progress, |filtered, words| {
            result(filtered, words, cones.next() == Some(true))
        })
    }
}

fn result(filtered: Filtered, words: &[u32], has_cone: bool) -> HitResult {
    let number = |i: usize| f64::from(f32::from_bits(words[i]));
    let status = STATUS[num::usize(words[5]).min(5)];
    let (iterations, flags) = (words[4], filtered.flags);
    HitResult {
        d: if status == HitStatus::Escaped { f64::INFINITY } else { number(0) },
        l: [number(1), number(2), number(3)],
        iterations,
        status,
        ratio: (iterations > 0).then(|| number(6)),
        color: filtered.color,
        probes: filtered.probes,
        texels: if has_cone { filtered.texels() } else { 0 },
        overshot: flags & bit(Flag::HitOvershoot) != 0,
        flags: flag_names(flags).into_iter().map(String::from).collect(),
    }
}

impl Engine<HitJob> for GpuEngine<'_> {
    fn render(&self, job: &HitJob, progress: Progress<'_>) -> Result<Rendering, GpuError> {
        let (map, size) = (Some(&job.map), job.map.size());
        let engine = GpuHit::new(self.gpu, &self.settings, &job.distance, map, size)?;
        let rays = job.rays();
        let pixels: Vec<[u32; 2]> = job.scene.rays.iter().map(|ray| ray.pixel).collect();
        let start = Instant::now();
        let (results, reports) = engine.reported(&rays, &pixels, progress)?;
        Ok(Rendering {
            flags: reports.flags,
            beyond_f32: reports.beyond_f32,
            ..job.rendering(start, &results)
        })
    }
}
