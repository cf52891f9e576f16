//! The HIT operation on a device.

use std::time::Instant;

use super::{Filtered, GpuEngine, Operands, Reports, bit, flag_names, tables};
use crate::base::num;
use crate::cube::CubeMap;
use crate::distance::Distance;
use crate::engine::hit::HitResult;
use crate::engine::{Engine, HitJob, Progress, Rendering};
use crate::fragment::HitFragment;
use crate::gpu::dispatch::{Program, Words};
use crate::gpu::kernels::{Fused, Kernel};
use crate::gpu::maps::Maps;
use crate::gpu::policy::Policy;
use crate::gpu::{Gpu, GpuError};
use crate::policy::HitStatus;
use crate::reference::Flag;
use crate::settings::Settings;

/// Words of HIT's operands and results.
pub const HIT_WORDS: Words = Words { input: 9, output: Filtered::WORDS + 7 };

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
pub struct GpuHit<'a> {
    pub(super) gpu: &'a Gpu,
    pub(super) program: Program,
    pub(super) maps: Maps,
    pub(super) policy: Policy,
}

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
        let tables = tables(settings);
        let policy = Policy::new(settings, &tables).with_distance(distance);
        let mut maps =
            Maps::none(gpu)?.with_distance(gpu, distance)?.with_tables(gpu, &tables.words())?;
        let policy = if let Some(map) = map {
            maps = maps.with_cube(gpu, map)?;
            policy.with_cube(map)
        } else {
            let size = face_size.max(1);
            policy.with_size([size; 2], size.ilog2() as usize + 1)
        };
        let out =
            Self { program: Program::new(gpu, Kernel::Fused(Fused::Hit))?, maps, policy, gpu };
        out.program.warm(gpu, &out.maps, &out.policy, HIT_WORDS)?;
        Ok(out)
    }

    /// Every ray's result, in order.
    ///
    /// # Errors
    ///
    /// The driver's error.
    pub fn filter(
        &self,
        rays: &[HitFragment],
        progress: Progress<'_>,
    ) -> Result<Vec<HitResult>, GpuError> {
        Ok(self.reported(rays, &vec![[0; 2]; rays.len()], progress)?.0)
    }

    /// Every ray's result and, by the rays' pixels, what left the range of f32.
    ///
    /// # Errors
    ///
    /// The driver's error.
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
        let words = self.program.run(
            self.gpu,
            &self.maps,
            &self.policy,
            HIT_WORDS,
            (&operands.words, &[]),
            &|n| progress(n),
        )?;
        let mut reports = Reports::default();
        let results = words.chunks_exact(HIT_WORDS.output).zip(rays).zip(&operands.flags);
        let results = results
            .zip(pixels)
            .map(|(((words, ray), flags), pixel)| {
                let filtered = Filtered::of(words);
                let flags = filtered.flags | flags;
                reports.add(flags, *pixel);
                result(filtered, flags, &words[Filtered::WORDS..], ray)
            })
            .collect();
        Ok((results, reports))
    }
}

fn result(filtered: Filtered, flags: u32, words: &[u32], ray: &HitFragment) -> HitResult {
    let number = |i: usize| f64::from(f32::from_bits(words[i]));
    let status = STATUS[num::usize(words[5]).min(5)];
    let iterations = words[4];
    let cone = ray.cone.is_some();
    HitResult {
        d: if status == HitStatus::Escaped { f64::INFINITY } else { number(0) },
        l: [number(1), number(2), number(3)],
        iterations,
        status,
        ratio: (iterations > 0).then(|| number(6)),
        color: filtered.color,
        probes: filtered.probes,
        texels: if cone { filtered.texels() } else { 0 },
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
