//! What the checks of a GPU's stages found, whether or not this build has a GPU.

use crate::fragment::TexFragment;
use crate::reference::ray_cone::{Cone, Step};
use crate::stage::Stage;

/// How the registers of one name compared.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The stage.
    pub stage: Stage,
    /// The register.
    pub register: &'static str,
    /// Components compared.
    pub compared: u64,
    /// Largest |gpu − f64| in ulp of the f64 value, where that is a normal f32.
    pub worst_ulp: f64,
    /// Largest |gpu − f64| over its tolerance, both of those that were decided.
    pub worst_share: f64,
    /// Components beyond their tolerance behind a comparison that a device may decide otherwise.
    pub undecided: u64,
    /// Components without a finite tolerance.
    pub unbounded: u64,
    /// Components that nothing explains.
    pub unexplained: u64,
}

/// A register outside its tolerance.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// The stage.
    pub stage: Stage,
    /// The register.
    pub register: &'static str,
    /// The fragment's pixel.
    pub pixel: [u32; 2],
    /// Words of the kernel's operands.
    pub operands: Vec<u32>,
    /// The register as the device has it.
    pub gpu: Vec<f64>,
    /// The same in doubles.
    pub f64: Vec<f64>,
    /// How far they may be apart.
    pub tolerance: Vec<f64>,
    /// The integer model's register of that pixel behind its own stages, where it took part and has one of that name.
    pub rtl: Option<Vec<f64>>,
}

/// The results of the checks of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StageChecks {
    /// Registers in the order of the stages.
    pub rows: Vec<Row>,
    /// The first difference that nothing explains, by stage.
    pub first: Option<Difference>,
    /// Fragments.
    pub fragments: u64,
}

impl StageChecks {
    /// Whether some difference is unexplained.
    #[must_use]
    pub fn fails(&self) -> bool {
        self.first.is_some()
    }
}

/// Requests to one texture and steps of cones, each with its pixel.
#[derive(Clone, Debug, Default)]
pub struct Requests {
    /// A ray at a surface and the width of its cone.
    pub surfaces: Vec<([u32; 2], TexFragment, f64)>,
    /// A cone before a step, and the step.
    pub steps: Vec<([u32; 2], Cone, Step)>,
}
