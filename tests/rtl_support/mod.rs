//! What the tests of the integer model through the crate share: subjects, engines, traces.
#![allow(dead_code, reason = "each test binary uses its own part of this module")]
#![expect(
    clippy::unwrap_used,
    reason = "a test stops at the first thing that is not as it should be"
)]

use rtl_model::regs::Reg;
use rtl_model::unit::Needs;
use rtl_model::{Texture, Unit};
use tapline::cube::CubeMap;
use tapline::engine::probe::{Code, RtlFragment, RtlProbe, rtl};
use tapline::engine::rtl::RtlEngine;
use tapline::engine::{Subject, encode};
use tapline::fragment::Fragment;
use tapline::image::mips::build_mips;
use tapline::scene::{SceneOptions, build};
use tapline::settings::Settings;
use tapline::truth::background;
use tapline::unit::bounds::bounds;
use tapline::unit::{ReferenceAxis, UnitSpec};

/// A scene with its own environment, or with `map`.
pub(crate) fn subject_with(
    name: &str,
    size: usize,
    settings: &Settings,
    map: Option<CubeMap>,
) -> Subject {
    let options = SceneOptions { width: size, height: size, ..SceneOptions::default() };
    let scene = build(name, &options, settings).unwrap();
    let map = map.unwrap_or_else(|| build_mips(scene.environment()));
    let background = background(&scene, &map, settings);
    assert!(!scene.fragments.is_empty(), "{name} shows nothing");
    Subject { scene, map, background }
}

/// A scene with its own environment, `size` pixels square.
pub(crate) fn subject(name: &str, size: usize, spec: &UnitSpec) -> Subject {
    subject_with(name, size, &spec.settings(ReferenceAxis::Exact), None)
}

/// What the first fragment of a subject needs; all of a scene need the same.
pub(crate) fn needs(subject: &Subject) -> Needs {
    encode::needs(&subject.scene.fragments[0].fragment)
}

/// The engine of a subject.
pub(crate) fn engine(spec: &UnitSpec, subject: &Subject) -> RtlEngine {
    RtlEngine::new(spec, needs(subject), &subject.map).unwrap()
}

/// A fragment's registers and what came out.
pub(crate) struct Traced {
    pub(crate) out: RtlFragment,
    pub(crate) probe: RtlProbe,
}

impl Traced {
    /// Component `i` of a register, as a double.
    pub(crate) fn value(&self, reg: Reg, i: usize) -> f64 {
        self.probe.get(reg)[i].value()
    }

    /// All components of a register, as doubles.
    pub(crate) fn values(&self, reg: Reg) -> Vec<f64> {
        self.probe.get(reg).iter().map(|c| c.value()).collect()
    }

    /// The codes of a register.
    pub(crate) fn raw(&self, reg: Reg) -> Vec<i64> {
        self.probe.get(reg).iter().map(|c| c.raw).collect()
    }

    /// One code with its fraction bits.
    pub(crate) fn code(&self, reg: Reg, i: usize) -> Code {
        self.probe.get(reg)[i]
    }

    /// Whether a flag was raised.
    pub(crate) fn flagged(&self, name: &str) -> bool {
        self.out.flags.iter().any(|f| f == name)
    }
}

/// Traces one fragment through a unit made for it.
pub(crate) fn trace(
    spec: &UnitSpec,
    fragment: &Fragment,
    face_size: u32,
    texture: Option<&Texture>,
) -> Traced {
    let unit = Unit::new(&spec.config, encode::needs(fragment), face_size).unwrap();
    let mut probe = RtlProbe::default();
    let out = rtl(&unit, &spec.config, fragment, texture, &mut probe);
    Traced { out, probe }
}

/// A bound of the default unit.
pub(crate) fn bound(name: &str) -> f64 {
    let all = bounds(&UnitSpec::default().config);
    all.iter().find(|b| b.name == name).unwrap().bound
}

/// The traced level of detail.
pub(crate) fn lod(t: &Traced) -> f64 {
    t.value(Reg::FootLod, 0)
}

/// Fails unless the two are within `slack`.
#[track_caller]
pub(crate) fn near(found: f64, want: f64, slack: f64) {
    assert!((found - want).abs() <= slack, "{found}, not {want} ± {slack:e}");
}
