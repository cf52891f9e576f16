//! What the tests of the integer model through the crate share: subjects, engines, traces.

use rtl_model::regs::Reg;
use rtl_model::unit::Needs;
use rtl_model::{Texture, Unit};
use tapline::cube::CubeMap;
use tapline::engine::probe::{Code, RtlFragment, RtlProbe, rtl};
use tapline::engine::rtl::RtlEngine;
use tapline::engine::{EnvJob, encode};
use tapline::fragment::Fragment;
use tapline::mips::build_mips;
use tapline::scene::{SceneOptions, build};
use tapline::settings::Settings;
use tapline::unit::bounds::bounds;
use tapline::unit::{ReferenceAxis, UnitSpec};

/// A scene with its own environment, or with `map`.
pub fn subject_with(name: &str, size: usize, settings: &Settings, map: Option<CubeMap>) -> EnvJob {
    let options = SceneOptions { width: size, height: size, ..SceneOptions::default() };
    let scene = build(name, &options, settings).unwrap();
    let map = map.unwrap_or_else(|| build_mips(scene.environment()));
    assert!(!scene.fragments.is_empty(), "{name} shows nothing");
    EnvJob::new(scene, map, settings)
}

/// A scene with its own environment, `size` pixels square.
pub fn subject(name: &str, size: usize, spec: &UnitSpec) -> EnvJob {
    subject_with(name, size, &spec.settings(ReferenceAxis::Exact), None)
}

/// What the first fragment of a subject needs; all of a scene need the same.
pub fn needs(subject: &EnvJob) -> Needs {
    encode::needs(&subject.scene.fragments[0].fragment)
}

/// The engine of a subject.
pub fn engine(spec: &UnitSpec, subject: &EnvJob) -> RtlEngine {
    RtlEngine::new(spec, needs(subject), &subject.map).unwrap()
}

/// A fragment's registers and what came out.
pub struct Traced {
    /// What came out.
    pub out: RtlFragment,
    /// The registers.
    pub probe: RtlProbe,
}

impl Traced {
    /// Component `i` of a register, as a double.
    pub fn value(&self, reg: Reg, i: usize) -> f64 {
        self.probe.get(reg)[i].value()
    }

    /// All components of a register, as doubles.
    pub fn values(&self, reg: Reg) -> Vec<f64> {
        self.probe.get(reg).iter().map(|c| c.value()).collect()
    }

    /// The codes of a register.
    pub fn raw(&self, reg: Reg) -> Vec<i64> {
        self.probe.get(reg).iter().map(|c| c.raw).collect()
    }

    /// One code with its fraction bits.
    pub fn code(&self, reg: Reg, i: usize) -> Code {
        self.probe.get(reg)[i]
    }

    /// Whether a flag was raised.
    pub fn flagged(&self, name: &str) -> bool {
        self.out.flags.iter().any(|f| f == name)
    }
}

/// Traces one fragment through a unit made for it.
pub fn trace(
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
pub fn bound(name: &str) -> f64 {
    let all = bounds(&UnitSpec::default().config);
    all.iter().find(|b| b.name == name).unwrap().bound
}

/// The traced level of detail.
pub fn lod(t: &Traced) -> f64 {
    t.value(Reg::FootLod, 0)
}

/// Fails unless the two are within `slack`.
#[track_caller]
pub fn near(found: f64, want: f64, slack: f64) {
    assert!((found - want).abs() <= slack, "{found}, not {want} ± {slack:e}");
}
