//! A scene of the HIT operation as every engine renders it.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use glam::DVec3;
use rayon::prelude::*;

use super::gpu::hit::GpuHit;
use super::hit::{HitF64, HitResult, HitRtl};
use super::probe::{FloatProbe, RtlProbe};
use super::registers::RegisterErrors;
use super::reuse::lines::Line;
use super::{Progress, Rendering, Searches};
use crate::base::num;
use crate::caustic::{Caustic, Photon, photons, searched, traced};
use crate::cube::CubeMap;
use crate::distance::Distance;
use crate::fragment::HitFragment;
use crate::gpu::GpuError;
use crate::impostor::{Impostor, WallCube};
use crate::picture::Picture;
use crate::policy::{HitStatus, Method};
use crate::reference::{NoTap, Texture, ewa_counted};
use crate::scene::hit::HitScene;
use crate::scene::hit::view::Finish;
use crate::scene::world::World;
use crate::settings::Settings;
use crate::truth::texels::PaddedCube;
use crate::truth::{TruthOptions, supersample};

/// Rays that one task takes at a time.
const CHUNK: usize = 256;

/// A scene of rays with its impostor.
#[derive(Clone, Debug)]
pub struct HitSubject {
    /// Rays, eye and world.
    pub scene: HitScene,
    /// Colours of the impostor, or what the user put in their place, with the mip chain.
    pub map: CubeMap,
    /// Distances.
    pub distance: Distance,
    /// Whether `map` shows the scene's own world: then real rays see the world itself, and else the map in
    /// the direction of what they meet.
    pub own_colours: bool,
    /// Colours of the pixels without a ray; black at all others.
    pub background: Vec<[f64; 3]>,
    /// The caustic that lights the world, if there is one.
    pub lit: Option<Lit>,
}

/// The light on the walls from a lamp through the object, by engine.
#[derive(Clone, Debug)]
pub struct Lit {
    /// Photons that entered the object.
    pub photons: Vec<Photon>,
    /// Walls and places by direction.
    uv_map: WallCube,
    /// The caustic that the world shows: searched for by the float reference with the secant method and ten steps.
    pub caustic: Caustic,
}

/// The impostor of a scene's world, lit by its lamp if it has one: the light map is part of the world from then on.
///
/// The search that makes it is not the unit's under test, so that a scene looks the same to every unit.
#[must_use]
pub fn lit(scene: &mut HitScene) -> (Impostor, Option<Lit>) {
    let impostor = Impostor::build(&scene.view.world, DVec3::ZERO, scene.face_size);
    let (Some(lamp), Finish::Glass { index }) = (scene.lamp, scene.view.finish) else {
        return (impostor, None);
    };
    let photons = photons(&lamp, &*scene.view.object, scene.bound, index);
    let distance = Distance::Cube(impostor.distance.clone());
    let settings = Settings::default().with(|p| {
        p.hit.method = Method::Secant;
        p.hit.iterations = 10;
    });
    let engine = HitF64::new(&settings, &distance, None, 1);
    let results = engine.filter(&rays_of(&photons), &|_| {});
    let caustic = searched(&scene.view.world, &impostor.walls, &photons, &ends(&results));
    scene.view.world.light = Some(Arc::new(caustic.map.clone()));
    let bright = Impostor::build(&scene.view.world, DVec3::ZERO, scene.face_size);
    let lit = Lit { photons, uv_map: bright.walls.clone(), caustic };
    (bright, Some(lit))
}

fn rays_of(photons: &[Photon]) -> Vec<HitFragment> {
    photons.iter().map(|p| p.fragment).collect()
}

/// Where the searches ended; nothing for those that escaped.
fn ends(results: &[HitResult]) -> Vec<Option<[f64; 3]>> {
    let found = |r: &HitResult| (r.status != HitStatus::Escaped).then_some(r.l);
    results.iter().map(found).collect()
}

impl Lit {
    /// The caustic by the integer model.
    #[must_use]
    pub fn by_rtl(&self, world: &World, engine: &HitRtl) -> Caustic {
        let results = engine.filter(&rays_of(&self.photons), &|_| {});
        searched(world, &self.uv_map, &self.photons, &ends(&results))
    }

    /// The caustic by a device's kernels.
    ///
    /// # Errors
    ///
    /// The driver's error.
    pub fn by_gpu(&self, world: &World, engine: &GpuHit<'_>) -> Result<Caustic, GpuError> {
        let results = engine.filter(&rays_of(&self.photons), &|_| {})?;
        Ok(searched(world, &self.uv_map, &self.photons, &ends(&results)))
    }

    /// The caustic by the float reference.
    #[must_use]
    pub fn by_f64(&self, world: &World, engine: &HitF64<'_>) -> Caustic {
        let results = engine.filter(&rays_of(&self.photons), &|_| {});
        searched(world, &self.uv_map, &self.photons, &ends(&results))
    }

    /// The caustic by real rays.
    #[must_use]
    pub fn by_rays(&self, world: &World) -> Caustic {
        traced(world, &self.photons)
    }
}

impl HitSubject {
    /// A scene with its maps; the background is the view past the object.
    #[must_use]
    pub fn new(scene: HitScene, map: CubeMap, distance: Distance, own_colours: bool) -> Self {
        let mut covered = vec![false; scene.width * scene.height];
        for ray in &scene.rays {
            covered[place(&scene, ray.pixel)] = true;
        }
        let background = covered
            .par_iter()
            .enumerate()
            .map(|(i, covered)| {
                if *covered { [0.0; 3] } else { scene.view.past(i % scene.width, i / scene.width) }
            })
            .collect();
        Self { scene, map, distance, own_colours, background, lit: None }
    }

    /// The built-in subject of a scene: its own impostor, lit by its own lamp.
    #[must_use]
    pub fn built_in(mut scene: HitScene) -> Self {
        let (impostor, lit) = lit(&mut scene);
        let distance = Distance::Cube(impostor.distance);
        let mut subject = Self::new(scene, impostor.colour, distance, true);
        subject.lit = lit;
        subject
    }

    /// The rays as the unit takes them.
    #[must_use]
    pub fn fragments(&self) -> Vec<HitFragment> {
        self.scene.rays.iter().map(|ray| ray.fragment).collect()
    }

    /// The picture of `colors`, one a ray, over the background: a pixel is the weighted sum over its rays.
    #[must_use]
    pub fn picture(&self, colors: &[[f64; 3]]) -> Picture {
        let mut picture = Picture::new(self.scene.width, self.scene.height);
        picture.rgb.copy_from_slice(&self.background);
        for (ray, color) in self.scene.rays.iter().zip(colors) {
            let index = place(&self.scene, ray.pixel);
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
            standard_error: None,
            searches: Some(Searches::of(results)),
            texture_use: None,
            beyond_f32: None,
        }
    }

    /// By the integer model.
    #[must_use]
    pub fn rtl(&self, engine: &HitRtl, progress: Progress<'_>) -> Rendering {
        let fragments = self.fragments();
        let start = Instant::now();
        self.rendering(start, &engine.filter(&fragments, progress))
    }

    /// The float reference over this subject's maps.
    #[must_use]
    pub fn reference(&self, settings: &Settings) -> HitF64<'_> {
        HitF64::new(settings, &self.distance, Some(&self.map), self.map.size())
    }

    /// By the float reference.
    #[must_use]
    pub fn f64(&self, settings: &Settings, progress: Progress<'_>) -> Rendering {
        let fragments = self.fragments();
        let start = Instant::now();
        let results = self.reference(settings).filter(&fragments, progress);
        self.rendering(start, &results)
    }

    /// By the float reference, with the probe line of every ray.
    #[must_use]
    pub fn f64_lines(&self, settings: &Settings) -> (Rendering, Vec<Line>) {
        let start = Instant::now();
        let (results, lines) = self.reference(settings).lines(&self.fragments());
        (self.rendering(start, &results), lines)
    }

    /// By the kernels of a device.
    ///
    /// # Errors
    ///
    /// The driver's error.
    pub fn gpu(&self, engine: &GpuHit<'_>, progress: Progress<'_>) -> Result<Rendering, GpuError> {
        let fragments = self.fragments();
        let pixels: Vec<[u32; 2]> = self.scene.rays.iter().map(|ray| ray.pixel).collect();
        let start = Instant::now();
        let (results, reports) = engine.reported(&fragments, &pixels, progress)?;
        let mut out = self.rendering(start, &results);
        out.flags = reports.flags;
        out.beyond_f32 = reports.beyond_f32;
        Ok(out)
    }

    /// The environment in the direction of R alone, as if every ray started at the reference point.
    #[must_use]
    pub fn classic(&self, settings: &Settings) -> Picture {
        let mut fragments = self.fragments();
        for fragment in &mut fragments {
            fragment.x = [0.0; 3];
        }
        let results = self.reference(settings).filter(&fragments, &|_| {});
        let colors: Vec<[f64; 3]> = results.iter().map(|r| r.color).collect();
        self.picture(&colors)
    }

    /// By the elliptical Gaussian of the float reference's covariance at the float reference's hit.
    #[must_use]
    pub fn ewa(&self, settings: &Settings, progress: Progress<'_>) -> Rendering {
        let start = Instant::now();
        let engine = HitF64::new(settings, &self.distance, None, self.map.size());
        let texture = Texture::new(&self.map);
        let parts: Vec<Vec<([f64; 3], u64)>> = self
            .scene
            .rays
            .par_chunks(CHUNK)
            .map(|chunk| {
                let part = chunk
                    .iter()
                    .map(|ray| {
                        let env = engine.trace(&ray.fragment, &mut NoTap).env;
                        env.map_or(([0.0; 3], 0), |env| {
                            let ewa = ewa_counted(&env, &texture);
                            (ewa.color, ewa.points)
                        })
                    })
                    .collect();
                progress(num::u64(chunk.len()));
                part
            })
            .collect();
        let seconds = start.elapsed().as_secs_f64();
        let (colors, points): (Vec<_>, Vec<u64>) = parts.into_iter().flatten().unzip();
        Rendering {
            picture: self.picture(&colors),
            seconds,
            probes: num::u64(colors.len()),
            texels: points.iter().sum(),
            flags: BTreeMap::new(),
            standard_error: None,
            searches: None,
            texture_use: None,
            beyond_f32: None,
        }
    }

    /// By real rays into the world.
    #[must_use]
    pub fn truth(&self, options: &TruthOptions, progress: Progress<'_>) -> Rendering {
        let start = Instant::now();
        let texels = PaddedCube::new(&self.map.levels[0]);
        let view = &self.scene.view;
        let shade = |px: f64, py: f64| {
            if self.own_colours {
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
        let pixels = self.scene.pixels();
        let size = [self.scene.width, self.scene.height];
        let result = supersample(size, &pixels, &shade, options, progress);
        let seconds = start.elapsed().as_secs_f64();
        let mut picture = result.picture;
        for (i, background) in self.background.iter().enumerate() {
            if !picture.covered[i] {
                picture.rgb[i] = *background;
            }
        }
        Rendering::by_rays(picture, seconds, result.samples, result.rms_standard_error)
    }

    /// Compares every register of every ray whose search took the same way in both engines.
    #[must_use]
    pub fn registers(
        &self,
        engine: &HitRtl,
        settings: &Settings,
        progress: Progress<'_>,
    ) -> RegisterErrors {
        let reference = self.reference(settings);
        let parts: Vec<RegisterErrors> = self
            .scene
            .rays
            .par_chunks(CHUNK)
            .map(|chunk| {
                let mut errors = RegisterErrors::default();
                let (mut mine, mut theirs) = (RtlProbe::default(), FloatProbe::default());
                for ray in chunk {
                    let (here, face) = engine.trace(&ray.fragment, &mut mine);
                    theirs.clear();
                    let there = reference.trace(&ray.fragment, &mut theirs);
                    let hit = &there.hit;
                    if (here.status, here.iterations) != (hit.status, hit.iterations) {
                        errors.other_search += 1;
                        errors.fragments += 1;
                        continue;
                    }
                    let same_face =
                        there.env.is_none_or(|env| crate::cube::FACE_NAMES[env.face] == face);
                    let same_count = there.env.is_none_or(|env| env.probes == here.probes);
                    errors.add(&mine, &theirs, ray.pixel, same_face, same_count);
                }
                progress(num::u64(chunk.len()));
                errors
            })
            .collect();
        parts.iter().fold(RegisterErrors::default(), RegisterErrors::merge)
    }
}

/// Index of a pixel.
fn place(scene: &HitScene, [column, row]: [u32; 2]) -> usize {
    let whole = |x: u32| num::usize(x);
    whole(row) * scene.width + whole(column)
}
