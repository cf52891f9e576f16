//! A scene of any operation: what its pictures depend on, and its references.

use super::cost::texels::Maps;
use crate::base::num;
use crate::engine::float::{EwaEngine, TruthEngine};
use crate::engine::hit_subject::HitSubject;
use crate::engine::reuse::lines::{Line, TexLine};
use crate::engine::tex_subject::TexSubject;
use crate::engine::{Engine as _, Rendering, Rung, Subject, float};
use crate::operation::Operation;
use crate::policy::{FootprintPolicy, Policy};
use crate::settings::Settings;
use crate::truth::TruthOptions;
use crate::unit::UnitSpec;

/// A scene of one of the three operations.
#[derive(Debug)]
pub enum Scene {
    /// Fragments of reflections.
    Env(Box<Subject>),
    /// Rays against an impostor.
    Hit(Box<HitSubject>),
    /// Paths with ray cones.
    Tex(Box<TexSubject>),
}

impl Scene {
    /// The part of a float engine's settings that this scene's picture depends on.
    pub(super) fn settings_that_count(&self, rung: Rung, settings: &Settings) -> Settings {
        let plain = Settings::default();
        let mut s = settings.clone();
        let Policy { cone, surface_footprint, address, hit, .. } = plain.policy;
        match self {
            Self::Env(_) => s.policy = Policy { cone, surface_footprint, address, hit, ..s.policy },
            Self::Hit(_) | Self::Tex(_) => {
                s.roughness_scale = plain.roughness_scale;
                s.policy.jacobian = plain.policy.jacobian;
            }
        }
        let (mine, none) = (&mut s.policy, &plain.policy);
        if rung != Rung::F64 {
            // Neither takes probes.
            mine.footprint =
                FootprintPolicy { max_probes: mine.footprint.max_probes, ..none.footprint };
            s.reference_table = None;
        }
        if rung == Rung::Ewa && matches!(self, Self::Env(_)) {
            // The Gaussian follows from K alone.
            (mine.footprint, mine.eigen) = (none.footprint, none.eigen);
        }
        if rung == Rung::Truth {
            // Rays see the environment's rotation and how textures repeat.
            let policy = Policy { address: s.policy.address, ..plain.policy };
            s = Settings { policy, rotation: s.rotation, ..plain };
        }
        s
    }

    /// Fragments, rays or requests.
    #[must_use]
    pub fn fragments(&self) -> u64 {
        match self {
            Self::Env(s) => num::u64(s.scene.fragments.len()),
            Self::Hit(s) => num::u64(s.scene.rays.len()),
            Self::Tex(s) => s.requests,
        }
    }

    /// What the unit must be able to do for it.
    #[must_use]
    pub fn operation(&self) -> Operation {
        match self {
            Self::Env(s) => Operation::Env(s.needs()),
            Self::Hit(_) => Operation::Hit,
            Self::Tex(_) => Operation::Tex,
        }
    }

    pub(super) fn maps(&self, spec: &UnitSpec) -> Maps {
        match self {
            Self::Env(s) => Maps::cube(&s.map),
            Self::Hit(s) => Maps::cube(&s.map),
            Self::Tex(s) => {
                Maps::planar(&s.scene.textures, spec.config.policy.address.wrap(), &s.sky)
            }
        }
    }
}

/// Renders a reference, f64 with its probe lines and, for textures, the cones' widths.
pub(super) fn render_reference(
    scene: &Scene,
    rung: Rung,
    settings: &Settings,
    truth: &TruthOptions,
) -> (Rendering, Vec<Line>, Vec<f64>) {
    let none = |rendering| (rendering, Vec::new(), Vec::new());
    let (own, options) = (settings.clone(), *truth);
    let quiet = &|_| {};
    match (scene, rung) {
        (Scene::Env(s), Rung::Ewa) => none(EwaEngine { settings: own }.render(s, quiet)),
        (Scene::Env(s), Rung::Truth) => {
            none(TruthEngine { settings: own, options }.render(s, quiet))
        }
        (Scene::Hit(s), Rung::Ewa) => none(s.ewa(settings, quiet)),
        (Scene::Hit(s), Rung::Truth) => none(s.truth(truth, quiet)),
        (Scene::Tex(s), Rung::Ewa) => none(s.ewa(settings, quiet)),
        (Scene::Tex(s), Rung::Truth) => none(s.truth(settings, truth, quiet)),
        (Scene::Env(s), Rung::F64 | Rung::Rtl | Rung::Gpu | Rung::Sampler) => {
            let (rendering, lines) = float::env_lines(settings, s);
            (rendering, lines, Vec::new())
        }
        (Scene::Hit(s), Rung::F64 | Rung::Rtl | Rung::Gpu | Rung::Sampler) => {
            let (rendering, lines) = s.f64_lines(settings);
            (rendering, lines, Vec::new())
        }
        (Scene::Tex(s), Rung::F64 | Rung::Rtl | Rung::Gpu | Rung::Sampler) => {
            let (rendering, lines): (_, Vec<TexLine>) = s.f64_lines(settings);
            let widths = lines.iter().map(|l| l.width).collect();
            (rendering, lines.into_iter().map(|l| l.line).collect(), widths)
        }
    }
}
