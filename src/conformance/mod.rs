//! Conformance: test vectors, named suites, and judges of a device's results.
//!
//! A [`field::Shape`] describes a stage once: what goes in, which registers come out and in which formats. Everything
//! else follows from it: harnesses fill its numbers, [`text`] writes and [`read`] reads them, [`header`] declares them for C and
//! SystemVerilog, [`cases`] sweeps their patterns, and the judges name the field that is wrong.

pub mod attribution;
pub mod budget;
pub mod cases;
pub mod certify;
pub mod check;
mod env;
pub mod exact;
pub mod extremes;
pub mod field;
pub mod gpu;
pub mod harness;
pub mod header;
mod hit;
pub mod memory;
pub mod patterns;
pub mod ray_cone;
#[cfg(feature = "files")]
pub mod read;
pub mod run;
pub mod stimuli;
pub mod subject;
pub mod suite;
mod tex;
#[cfg(feature = "files")]
pub mod text;

pub use harness::{Build, Device, Harness};

use self::subject::Subject;
use crate::error::InputError;
use crate::stage::Stage;
use crate::unit::UnitSpec;

/// The integer model's harness of a subject.
///
/// # Errors
/// A unit that the model refuses, or one that has no such stage.
pub fn harness(spec: &UnitSpec, subject: Subject, build: Build) -> Result<Harness, InputError> {
    match subject {
        Subject::Env => env::whole(spec, build),
        Subject::Hit | Subject::Stage(Stage::Hit) => hit::harness(spec, subject, build),
        Subject::Tex | Subject::Stage(Stage::SurfaceFootprint) => {
            tex::harness(spec, subject, build)
        }
        Subject::Stage(Stage::RayCone) => Ok(ray_cone::harness(spec)),
        Subject::Stage(stage) => env::stage(spec, stage, build),
    }
}
