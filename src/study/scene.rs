//! A scene of any operation: what its pictures depend on, and its references.

use super::cost::texels::Maps;
use crate::base::num;
use crate::engine::float::{EwaEngine, TruthEngine};
use crate::engine::hit_subject::HitSubject;
use crate::engine::reuse::lines::{Line, TexLine};
use crate::engine::tex_subject::TexSubject;
use crate::engine::{Engine as _, Rendering, Rung, Subject, float};
use crate::operation::Operation;
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
        match self {
            Self::Env(_) => {
                (s.hit, s.tex) = (plain.hit, plain.tex);
                (s.cone_rules, s.set_diffuse) = (plain.cone_rules, plain.set_diffuse);
            }
            Self::Hit(_) | Self::Tex(_) => {
                s.roughness_scale = plain.roughness_scale;
                s.dnmod = plain.dnmod;
            }
        }
        if rung != Rung::F64 {
            // Neither takes probes.
            (s.count, s.weights, s.probe_weight_bits) =
                (plain.count, plain.weights, plain.probe_weight_bits);
            (s.axis, s.reference_table) = (plain.axis, None);
        }
        if rung == Rung::Ewa && matches!(self, Self::Env(_)) {
            // The Gaussian follows from K alone.
            (s.max_probes, s.minor) = (plain.max_probes, plain.minor);
        }
        if rung == Rung::Truth {
            // Rays see the environment's rotation and how textures repeat.
            s = Settings { rotation: s.rotation, tex: s.tex, ..plain };
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
            Self::Tex(s) => Maps::planar(&s.scene.textures, spec.config.tex.wrap, &s.sky),
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
