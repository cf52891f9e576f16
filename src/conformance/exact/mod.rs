//! The judge by exact arithmetic: every register against the formula of its own step, on the codes that enter it.
//!
//! Each rule evaluates one formula of the specification in double-double arithmetic on the codes that a device's earlier
//! registers hold, and says how far a correct register may be from it: half an LSB of its own rounding (one for floor
//! and to-zero), and what the tables on the way may be off by. Nothing accumulates, so that a wrong register is found
//! where it is wrong, and nothing is measured: the bounds come from formats and table knobs alone.

mod back;
mod cone;
mod fetch;
mod front;
mod hit;
mod jacobian;
mod ports;
mod sheet;
mod surface;

pub use sheet::{Finding, Sheet};

use rtl_model::Config;
use rtl_model::distance::DistanceMemory;

use super::field::Shape;
use super::harness::Build;
use super::memory;
use super::subject::Subject;
use crate::cube::CubeMap;
use crate::engine::hit::distances_of;
use crate::engine::probe::RtlProbe;
use crate::stage::Stage;

/// The data of a unit, apart from its registers, that the rules use.
pub struct Judge {
    subject: Subject,
    build: Build,
    map: CubeMap,
    distances: Option<DistanceMemory>,
}

/// A case as the rules see it.
pub struct Case<'a> {
    /// The fields' description.
    pub shape: &'a Shape,
    /// Inputs.
    pub input: &'a [i64],
    /// Outputs.
    pub output: &'a [i64],
    /// Registers in true units, the device's where it has them.
    pub probe: &'a RtlProbe,
}

impl Case<'_> {
    /// An output that is no register.
    #[must_use]
    pub fn output(&self, name: &str) -> Option<i64> {
        self.shape.output_at(name).and_then(|at| self.output.get(at).copied())
    }

    /// A number of an input field.
    #[must_use]
    pub fn input(&self, name: &str, component: usize) -> Option<i64> {
        let mut at = 0;
        for field in &self.shape.inputs {
            if field.name == name {
                return self.input.get(at + component).copied();
            }
            at += field.components;
        }
        None
    }

    /// The face: an output of the unit and of `cube_face`, an input of the stages after it.
    #[must_use]
    pub fn face(&self) -> Option<usize> {
        let face = self
            .output("face")
            .or_else(|| self.output("cube_face.face"))
            .or_else(|| self.input("face", 0));
        face.and_then(|f| usize::try_from(f).ok()).filter(|f| *f < 6)
    }

    /// The probe count.
    #[must_use]
    pub fn count(&self) -> Option<i64> {
        self.output("count")
            .or_else(|| self.output("footprint.count"))
            .or_else(|| self.input("count", 0))
    }
}

impl Judge {
    /// The rules of a subject.
    #[must_use]
    pub fn new(config: &Config, subject: Subject, build: Build) -> Self {
        let searches = matches!(subject, Subject::Hit | Subject::Stage(Stage::Hit));
        let distances = searches.then(|| distances_of(config, &memory::room(build.size)).ok());
        Self { subject, build, map: memory::cube(build.size), distances: distances.flatten() }
    }

    /// The finding of every rule, in pipeline order.
    #[must_use]
    pub fn judge(&self, config: &Config, case: &Case<'_>) -> Vec<Finding> {
        let mut sheet = Sheet::new(config, case.probe);
        if matches!(self.subject, Subject::Env) {
            ports::ports(&mut sheet, case);
        }
        let planar = matches!(self.subject, Subject::Tex);
        for stage in self.subject.stages() {
            sheet.stage = stage;
            match stage {
                Stage::LocalFrame => front::local_frame(&mut sheet),
                Stage::Bump => front::bump(&mut sheet),
                Stage::Reflect => front::reflect(&mut sheet),
                Stage::CubeFace => front::cube_face(&mut sheet, case),
                Stage::Jacobian if self.subject == Subject::Hit => {
                    hit::projected(&mut sheet, case, self.distances.as_ref());
                }
                Stage::Jacobian => jacobian::jacobian(&mut sheet, case),
                Stage::Roughness => jacobian::roughness(&mut sheet, case),
                Stage::RayCone => cone::ray_cone(&mut sheet, case),
                Stage::Hit => hit::hit(&mut sheet, case, self.distances.as_ref()),
                Stage::SurfaceFootprint => {
                    surface::surface_footprint(&mut sheet, case, self.build.size)
                }
                Stage::Covariance => back::covariance(&mut sheet, planar),
                Stage::Eigen => back::eigen(&mut sheet),
                Stage::Footprint => back::footprint(&mut sheet, case, self.build.size, planar),
                Stage::Address => fetch::address(&mut sheet, case, self.build.size, planar),
                Stage::Filter => fetch::filter(&mut sheet, case, (!planar).then_some(&self.map)),
            }
        }
        sheet.findings
    }
}
