//! Suites on a GPU: each kernel of a stage at operands of its own, held against the float reference and its tolerance.
//!
//! A suite of an operation runs every stage of it on the suite's cases; stages have no suites of their own there, because
//! the kernels get their operands from the reference and never from the stage before.

use super::run::Runner;
use super::subject::Subject;
use super::suite::Suite;
use crate::base::num;
use crate::engine::gpu::check::{Requests, StageChecks, check_env, check_hit, check_requests};
use crate::engine::tex::value;
use crate::error::InputError;
use crate::fragment::{Fragment, HitFragment, PixelFragment, Tangents, TexFragment};
use crate::gpu::{Gpu, GpuError};
use crate::reference::ray_cone::{Angle, Cone, Step, Width};
use crate::stage::Stage;
use crate::unit::{ReferenceAxis, UnitSpec};

use super::memory;

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

/// Numbers of an input as doubles.
struct Reals<'a>(std::slice::Iter<'a, i64>);

impl Reals<'_> {
    fn next(&mut self) -> f64 {
        self.0.next().map_or(0.0, |x| f64::from_bits(x.cast_unsigned()))
    }

    fn many<const N: usize>(&mut self) -> [f64; N] {
        std::array::from_fn(|_| self.next())
    }

    fn code(&mut self) -> u32 {
        self.0.next().and_then(|x| u32::try_from(*x).ok()).unwrap_or(0)
    }
}

fn fragment(input: &[i64], parts: bool) -> Fragment {
    let mut reals = Reals(input.iter());
    Fragment {
        v: reals.many(),
        n: reals.many(),
        dv_dx: reals.many(),
        dv_dy: reals.many(),
        dn_dx: reals.many(),
        dn_dy: reals.many(),
        h: parts.then(|| reals.many()),
        bump: parts.then(|| reals.many()),
        rough: parts.then(|| reals.many()),
    }
}

fn ray(input: &[i64]) -> HitFragment {
    let mut reals = Reals(input.iter());
    let (x, r, cone) = (reals.many(), reals.many(), reals.many());
    HitFragment { x, r, cone: (reals.code() == 1).then_some(cone) }
}

fn request(spec: &UnitSpec, input: &[i64]) -> (TexFragment, f64) {
    let mut reals = Reals(input.iter());
    let width = value(spec.config.policy.cone.format.float().unpack(reals.code()).0);
    let (d, n, dp_ds, dp_dt) = (reals.many(), reals.many(), reals.many(), reals.many());
    let [s_b, s_c, t_b, t_c] = reals.many();
    let tangents = if reals.code() == 1 {
        Tangents::Triangle { edges: [dp_ds, dp_dt], st: [[s_b, t_b], [s_c, t_c]] }
    } else {
        Tangents::Surface { dp_ds, dp_dt }
    };
    let st = reals.many();
    let fragment = TexFragment { d, n, tangents, st };
    (fragment, width)
}

fn operation(spec: &UnitSpec, input: &[i64]) -> (Cone, Step) {
    let format = spec.config.policy.cone.format.float();
    let mut reals = Reals(input.iter());
    let operation = reals.code();
    let [angle, width] = [reals.code(), reals.code()].map(|code| value(format.unpack(code).0));
    let [first, second, third] = reals.many();
    let step = match operation {
        0 => Step::Propagate(first),
        1 => Step::Reflect(first),
        2 => Step::Refract { curvature: first, outside: second, inside: third },
        _ => Step::Scatter(first),
    };
    let cone = Cone { angle: Angle(angle), width: Width(width) };
    (cone, step)
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
                if suite.subject == Subject::Tex {
                    let (fragment, width) = request(&spec, input);
                    requests.surfaces.push((pixel(*k), fragment, width));
                } else {
                    let (cone, step) = operation(&spec, input);
                    requests.steps.push((pixel(*k), cone, step));
                }
            }
            check_requests(gpu, &settings, &memory::planar(build.size), &requests)
        }
        Subject::Env | Subject::Stage(_) => {
            let fragments: Vec<PixelFragment> = inputs
                .iter()
                .map(|(k, input)| PixelFragment {
                    pixel: pixel(*k),
                    fragment: fragment(input, build.bump),
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
