//! Suites on a GPU: each kernel of a stage at operands of its own, held against the float reference and its tolerance.
//!
//! A suite of an operation runs every stage of it on the suite's cases; stages have no suites of their own there, because
//! the kernels get their operands from the reference and never from the stage before.

use rtl_model::unit::Needs;

use super::env::fragment;
use super::hit::ray;
use super::memory;
use super::ray_cone::operation;
use super::run::Runner;
use super::subject::Subject;
use super::suite::Suite;
use super::tex::request;
use crate::base::num;
use crate::engine::gpu::check::{Requests, StageChecks, check_env, check_hit, check_requests};
use crate::engine::tex::value;
use crate::error::InputError;
use crate::fragment::PixelFragment;
use crate::gpu::{Gpu, GpuError};
use crate::reference::ray_cone::{Angle, Cone, Width};
use crate::stage::Stage;
use crate::unit::ReferenceAxis;

/// The result of a suite on the GPU.
#[derive(Clone, Debug)]
pub struct Checked {
    /// Cases.
    pub cases: u64,
    /// Components that were compared.
    pub judged: u64,
    /// Components that nothing explains.
    pub unexplained: u64,
    /// The first of them: its case, its stage, its register, and both values.
    pub first: Option<(u64, Stage, &'static str, String)>,
}

/// Whether a suite runs on a GPU.
#[must_use]
pub fn concerns(suite: &Suite) -> bool {
    matches!(
        suite.subject,
        Subject::Env | Subject::Hit | Subject::Tex | Subject::Stage(Stage::RayCone)
    )
}

/// The place of a case as the pixel that the checks name.
fn pixel(index: u64) -> [u32; 2] {
    [num::u32(index), 0]
}

/// Registers within 2^±60: their squares are normal numbers of binary32.
const POWER: i32 = 60;

/// Whether binary32 can hold all values of a case. Shaders have no exponents next to their vectors: what is beyond is no
/// input of theirs.
fn is_single(runner: &mut Runner, subject: Subject, input: &[i64]) -> bool {
    let words = input.iter().map(|x| f64::from_bits(x.cast_unsigned()));
    let cone = subject == Subject::Stage(Stage::RayCone);
    let (low, high) = (libm::ldexp(1.0, -POWER), libm::ldexp(1.0, POWER));
    // A cone's codes and the small numbers of a choice look like subnormal words.
    let fits = |x: f64| x == 0.0 || x.abs() < f64::MIN_POSITIVE || (low..high).contains(&x.abs());
    words.into_iter().all(fits) && (cone || runner.is_within(input, POWER))
}

fn refused(error: &GpuError) -> InputError {
    InputError::new(
        "gpu",
        "a device that runs the kernels",
        error.to_string(),
        "choose another with --adapter",
    )
}

/// Runs cases of a suite on a device.
pub fn run(
    gpu: &Gpu,
    suite: Suite,
    seed: u64,
    range: std::ops::Range<u64>,
) -> Result<Checked, InputError> {
    let spec = suite.configuration.unit()?;
    let build = suite.configuration.build();
    let settings = spec.settings(ReferenceAxis::Exact);
    let mut runner = Runner::new(suite, seed)?;
    let mut inputs: Vec<(u64, Vec<i64>)> = Vec::new();
    for index in range {
        let input = runner.input(index);
        if is_single(&mut runner, suite.subject, &input) {
            inputs.push((index, input));
        }
    }
    let cases = num::u64(inputs.len());
    let cube = memory::cube(build.size);
    let found = match suite.subject {
        Subject::Hit => {
            let rays: Vec<_> = inputs.iter().map(|(k, input)| (pixel(*k), ray(input))).collect();
            check_hit(gpu, &settings, (&cube, &memory::room(build.size)), &rays, &|_| ())
        }
        Subject::Tex | Subject::Stage(Stage::RayCone) => {
            let mut requests = Requests::default();
            for (k, input) in &inputs {
                let number = |code| value(spec.config.policy.cone.format.float().unpack(code).0);
                if suite.subject == Subject::Tex {
                    let (fragment, width) = request(input);
                    requests.surfaces.push((pixel(*k), fragment, number(width)));
                } else {
                    let (cone, step, _) = operation(input);
                    let [angle, width] = cone.map(number);
                    let cone = Cone { angle: Angle(angle), width: Width(width) };
                    requests.steps.push((pixel(*k), cone, step));
                }
            }
            check_requests(gpu, &settings, &memory::planar(build.size), &requests)
        }
        Subject::Env | Subject::Stage(_) => {
            let needs = Needs { bump: build.bump, rough: build.rough };
            let fragments: Vec<PixelFragment> = inputs
                .iter()
                .map(|(k, input)| PixelFragment {
                    pixel: pixel(*k),
                    fragment: fragment(input, needs),
                })
                .collect();
            check_env(gpu, &settings, &cube, &fragments, &|_| ())
        }
    };
    Ok(summary(cases, &found.map_err(|e| refused(&e))?))
}

fn summary(cases: u64, found: &StageChecks) -> Checked {
    Checked {
        cases,
        judged: found.rows.iter().map(|row| row.compared).sum(),
        unexplained: found.rows.iter().map(|row| row.unexplained).sum(),
        first: found.first.as_ref().map(|d| {
            let text = format!("{:?} expected {:?} ± {:?}", d.gpu, d.f64, d.tolerance);
            (d.pixel[0].into(), d.stage, d.register, text)
        }),
    }
}
