//! A scene of the HIT operation as every engine renders it.

use std::collections::BTreeMap;
use std::time::Instant;

use rayon::prelude::*;

use super::Model;
use super::lit::{Lit, lit};
use crate::base::num;
use crate::cube::{CubeMap, FACE_NAMES};
use crate::distance::Distance;
use crate::engine::float::{EwaEngine, F64Engine, TruthEngine};
use crate::engine::hit::{HitF64, HitResult, HitRtl};
use crate::engine::probe::RtlProbe;
use crate::engine::registers::{RegisterErrors, Sides};
use crate::engine::reuse::lines::Line;
use crate::engine::{Engine, Progress, Rendering, Searches};
use crate::fragment::HitFragment;
use crate::gpu::GpuError;
use crate::picture::Picture;
use crate::reference::{NoTap, Texture, ewa_counted};
use crate::scene::hit::{HitScene, PixelRay};
use crate::settings::Settings;
use crate::truth::texels::PaddedCube;
use crate::truth::{each, supersample};

/// Rays that one task takes at a time.
const CHUNK: usize = 256;

/// A scene of rays with its impostor.
#[derive(Clone, Debug)]
pub struct HitJob {
    /// Rays, eye and world.
    pub scene: HitScene,
    /// Colours of the impostor, or what the user put in their place, with the mip chain.
    pub map: CubeMap,
    /// Distances.
    pub distance: Distance,
    /// Whether `map` shows the scene's own world: then real rays see the world itself, and else the map in
    /// the direction of what they meet.
    pub own_colours: bool,
    /// Colours of the pixels that show no ray, and black elsewhere.
    pub background: Vec<[f64; 3]>,
    /// The caustic that lights the world, if there is one.
    pub lit: Option<Lit>,
}

impl HitJob {
    /// A job; the background is what the eye sees past the object.
    #[must_use]
    pub fn new(scene: HitScene, map: CubeMap, distance: Distance, own_colours: bool) -> Self {
        let mut past = Picture::new(scene.width, scene.height);
        for ray in &scene.rays {
            let index = past.index(ray.pixel);
            past.covered[index] = true;
        }
        let Picture { width, mut rgb, covered, .. } = past;
        rgb.par_iter_mut().zip(&covered).enumerate().for_each(|(i, (color, covered))| {
            if !covered {
                *color = scene.view.past(i % width, i / width);
            }
        });
        Self { scene, map, distance, own_colours, background: rgb, lit: None }
    }

    /// A scene with its own impostor, lit by its own lamp.
    #[must_use]
    pub fn built_in(scene: HitScene) -> Self {
        Self::with(scene, None, None)
    }

    /// [`HitJob::built_in`] with other colours or distances, where there are some.
    #[must_use]
    pub fn with(mut scene: HitScene, map: Option<CubeMap>, distance: Option<Distance>) -> Self {
        let own_colours = map.is_none();
        let (impostor, lit) = lit(&mut scene);
        let map = map.unwrap_or(impostor.colour);
        let distance = distance.unwrap_or(Distance::Cube(impostor.distance));
        Self { lit, ..Self::new(scene, map, distance, own_colours) }
    }

    /// The rays as the unit takes them.
    #[must_use]
    pub fn rays(&self) -> Vec<HitFragment> {
        self.scene.rays.iter().map(|ray| ray.fragment).collect()
    }

    /// The picture of `colors`, one a ray, over the background: a pixel is the weighted sum over its rays.
    #[must_use]
    pub fn picture(&self, colors: &[[f64; 3]]) -> Picture {
        let mut picture = Picture::new(self.scene.width, self.scene.height);
        picture.rgb.copy_from_slice(&self.background);
        for (ray, color) in self.scene.rays.iter().zip(colors) {
            let index = picture.index(ray.pixel);
            picture.covered[index] = true;
            let weighted = ray.weight.iter().zip(color);
            for (sum, (weight, color)) in picture.rgb[index].iter_mut().zip(weighted) {
                *sum += weight * color;
            }
        }
        picture
    }

    /// A rendering of each ray's result, begun at `start`.
    #[must_use]
    pub fn rendering(&self, start: Instant, results: &[HitResult]) -> Rendering {
        let seconds = start.elapsed().as_secs_f64();
        let mut flags = BTreeMap::new();
        for name in results.iter().flat_map(|r| &r.flags) {
            *flags.entry(name.clone()).or_default() += 1;
        }
        let colors: Vec<[f64; 3]> = results.iter().map(|r| r.color).collect();
        Rendering {
            picture: self.picture(&colors),
            seconds,
            probes: results.iter().map(|r| u64::from(r.probes)).sum(),
            texels: results.iter().map(|r| r.texels).sum(),
            flags,
            searches: Some(Searches::of(results)),
            ..Rendering::default()
        }
    }

    /// The float reference over this job's maps.
    #[must_use]
    pub fn reference(&self, settings: &Settings) -> HitF64<'_> {
        HitF64::new(settings, &self.distance, Some(&self.map), self.map.size())
    }

    /// By the float reference, with the probe line of every ray.
    pub(super) fn lines(&self, settings: &Settings) -> (Rendering, Vec<Line>) {
        let start = Instant::now();
        let (results, lines) = self.reference(settings).lines(&self.rays());
        (self.rendering(start, &results), lines)
    }

    /// The environment in the direction of R alone, as if every ray started at the reference point.
    #[must_use]
    pub fn classic(&self, settings: &Settings) -> Picture {
        let mut fragments = self.rays();
        for fragment in &mut fragments {
            fragment.x = [0.0; 3];
        }
        let results = self.reference(settings).filter(&fragments, &|_| {});
        let colors: Vec<[f64; 3]> = results.iter().map(|r| r.color).collect();
        self.picture(&colors)
    }
}

impl Engine<HitJob> for HitRtl {
    fn render(&self, job: &HitJob, progress: Progress<'_>) -> Result<Rendering, GpuError> {
        let fragments = job.rays();
        let start = Instant::now();
        Ok(job.rendering(start, &self.filter(&fragments, progress)))
    }
}

impl Engine<HitJob> for F64Engine {
    fn render(&self, job: &HitJob, progress: Progress<'_>) -> Result<Rendering, GpuError> {
        let fragments = job.rays();
        let start = Instant::now();
        let results = job.reference(&self.settings).filter(&fragments, progress);
        Ok(job.rendering(start, &results))
    }
}

/// The Gaussian of the float reference's covariance at the float reference's hit.
impl Engine<HitJob> for EwaEngine {
    fn render(&self, job: &HitJob, progress: Progress<'_>) -> Result<Rendering, GpuError> {
        let start = Instant::now();
        let engine = HitF64::new(&self.settings, &job.distance, None, job.map.size());
        let texture = Texture::new(&job.map);
        let parts: Vec<Vec<([f64; 3], u64)>> = job
            .scene
            .rays
            .par_chunks(CHUNK)
            .map(|chunk| {
                let one = |ray: &PixelRay| {
                    let env = engine.trace(&ray.fragment, &mut NoTap).env;
                    let ewa = env.map(|env| ewa_counted(&env, &texture));
                    ewa.map_or(([0.0; 3], 0), |ewa| (ewa.color, ewa.points))
                };
                let part = chunk.iter().map(one).collect();
                progress(num::u64(chunk.len()));
                part
            })
            .collect();
        let seconds = start.elapsed().as_secs_f64();
        let (colors, points): (Vec<_>, Vec<u64>) = parts.into_iter().flatten().unzip();
        Ok(Rendering {
            picture: job.picture(&colors),
            seconds,
            probes: num::u64(colors.len()),
            texels: points.iter().sum(),
            ..Rendering::default()
        })
    }
}

/// Real rays into the world.
impl Engine<HitJob> for TruthEngine {
    fn render(&self, job: &HitJob, progress: Progress<'_>) -> Result<Rendering, GpuError> {
        let start = Instant::now();
        let texels = PaddedCube::new(&job.map.levels[0]);
        let view = &job.scene.view;
        let shade = |px: f64, py: f64| {
            if job.own_colours {
                return view.shade(px, py);
            }
            let mut sum = [0.0; 3];
            view.leaving(px, py, &mut |leaving| {
                let sight = view.world.look(leaving.fragment.x.into(), leaving.fragment.r.into());
                let found = texels.look_up(sight.map_or(leaving.fragment.r, |s| s.point.into()));
                for c in 0..3 {
                    sum[c] += leaving.weight[c] * found[c];
                }
            })
            .then_some(sum)
        };
        let size = [job.scene.width, job.scene.height];
        let pixels = job.scene.pixels();
        let result = supersample(size, &pixels, &each(shade), &self.options, progress);
        Ok(Rendering::by_rays(start, result, &job.background))
    }
}

impl Model for (&HitJob, HitRtl) {
    fn render(&self, progress: Progress<'_>) -> Result<Rendering, GpuError> {
        self.1.render(self.0, progress)
    }

    /// Of every ray whose search took the same way in both engines.
    fn registers(&self, settings: &Settings, progress: Progress<'_>) -> RegisterErrors {
        let (job, engine) = self;
        let reference = job.reference(settings);
        let each = |ray: &PixelRay, sides: &mut Sides| {
            let (here, face) = engine.trace(&ray.fragment, &mut sides.mine);
            let there = reference.trace(&ray.fragment, &mut sides.theirs);
            let hit = &there.hit;
            if (here.status, here.iterations) != (hit.status, hit.iterations) {
                sides.errors.other_search += 1;
                sides.errors.fragments += 1;
                return;
            }
            let same_face = there.env.is_none_or(|env| FACE_NAMES[env.face] == face);
            let same_count = there.env.is_none_or(|env| env.probes == here.probes);
            sides.add(ray.pixel, same_face, same_count);
        };
        RegisterErrors::of(&job.scene.rays, CHUNK, progress, each)
    }

    fn trace(&self, pixel: [u32; 2], probe: &mut RtlProbe) -> Option<Vec<String>> {
        let (job, engine) = self;
        let ray = job.scene.rays.iter().find(|r| r.pixel == pixel)?;
        Some(engine.trace(&ray.fragment, probe).0.flags)
    }

    fn search(&self, rays: &[HitFragment]) -> Option<Vec<HitResult>> {
        Some(self.1.filter(rays, &|_| {}))
    }
}
