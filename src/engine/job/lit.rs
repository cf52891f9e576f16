//! The caustic of a lamp through a scene's object.

use std::sync::Arc;

use glam::DVec3;

use super::Model;
use super::hit::HitJob;
use crate::caustic::{Caustic, Photon, photons, searched, traced};
use crate::distance::Distance;
use crate::engine::EngineKind;
use crate::engine::gpu::hit::GpuHit;
use crate::engine::hit::{HitF64, HitResult};
use crate::fragment::HitFragment;
use crate::gpu::{Gpu, GpuError};
use crate::impostor::{Impostor, WallCube};
use crate::policy::{HitStatus, Method};
use crate::scene::hit::HitScene;
use crate::scene::hit::view::Finish;
use crate::settings::Settings;

/// The light that walls get from a lamp through the object.
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

/// A scene's caustic by those engines that search, and by real rays.
#[derive(Clone, Debug)]
pub struct Caustics {
    /// Photons that entered the object.
    pub photons: usize,
    /// In the ladder's order; `truth` is real rays.
    pub by: Vec<(EngineKind, Caustic)>,
}

impl HitJob {
    /// The caustic by the engines of `kinds`; nothing where no lamp shines through the object.
    ///
    /// # Errors
    /// The driver's error.
    pub fn caustics(
        &self,
        kinds: &[EngineKind],
        model: Option<&dyn Model>,
        gpu: Option<&Gpu>,
        settings: &Settings,
    ) -> Result<Option<Caustics>, GpuError> {
        let Some(lit) = &self.lit else {
            return Ok(None);
        };
        let world = &self.scene.view.world;
        let rays = rays_of(&lit.photons);
        let mut by = Vec::new();
        let mut found = |kind, results: &[HitResult]| {
            by.push((kind, searched(world, &lit.uv_map, &lit.photons, &ends(results))));
        };
        if let Some(results) = model.and_then(|model| model.search(&rays)) {
            found(EngineKind::Rtl, &results);
        }
        if let Some(gpu) = gpu.filter(|_| kinds.contains(&EngineKind::Gpu)) {
            let engine = GpuHit::new(gpu, settings, &self.distance, None, 1)?;
            found(EngineKind::Gpu, &engine.filter(&rays, &|_| {})?);
        }
        if kinds.contains(&EngineKind::F64) {
            found(EngineKind::F64, &self.reference(settings).filter(&rays, &|_| {}));
        }
        by.push((EngineKind::Truth, traced(world, &lit.photons)));
        Ok(Some(Caustics { photons: lit.photons.len(), by }))
    }
}
