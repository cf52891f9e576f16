//! Test benches: they run a stage or the unit on a case's inputs and return its outputs.

use rtl_model::Config;
use rtl_model::fx::Flags;
use rtl_model::regs::Reg;

use super::env::{EnvStage, EnvUnit};
use super::field::{Meaning, Shape, events, group};
use super::hit::HitBench;
use super::ray_cone::ConeBench;
use super::stimuli::Stimulus;
use super::subject::Subject;
use super::tex::TexBench;
use crate::engine::probe::{Code, RtlProbe};
use crate::error::InputError;
use crate::stage::Stage;
use crate::unit::UnitSpec;

/// Something that turns a case's inputs into its outputs: the integer model, or a device next to it.
///
/// Every engine that runs stages alone is one of these; suites, vectors and the judge know no more of it.
pub trait Bench: Send {
    /// The inputs and outputs.
    fn shape(&self) -> &Shape;

    /// Runs one case: `input` and `output` hold the numbers of [`Shape`]'s fields, in order.
    fn run(&mut self, input: &[i64], output: &mut [i64]);
}

/// A bench of the integer model, which also knows its registers in true units.
pub trait Model: Bench {
    /// The registers that the last case read and wrote.
    fn probe(&self) -> &RtlProbe;

    /// The configuration.
    fn config(&self) -> &Config;

    /// The numbers of this bench's inputs when `stimulus` comes to the unit: the results of the stages before it.
    fn drive(&mut self, stimulus: &Stimulus, input: &mut [i64]);
}

/// Which parts of the unit a bench has, and its memories.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Build {
    /// Whether bump offsets come in.
    pub bump: bool,
    /// Whether roughness comes in.
    pub rough: bool,
    /// Texels along a face; columns of a 2-D texture.
    pub size: u32,
}

impl Default for Build {
    fn default() -> Self {
        Self { bump: true, rough: true, size: 32 }
    }
}

/// The integer model's bench of a subject.
pub fn model(
    spec: &UnitSpec,
    subject: Subject,
    build: Build,
) -> Result<Box<dyn Model>, InputError> {
    Ok(match subject {
        Subject::Env => Box::new(EnvUnit::new(spec, build)?),
        Subject::Hit | Subject::Stage(Stage::Hit) => Box::new(HitBench::new(spec, subject, build)?),
        Subject::Tex | Subject::Stage(Stage::SurfaceFootprint) => {
            Box::new(TexBench::new(spec, subject, build)?)
        }
        Subject::Stage(Stage::RayCone) => Box::new(ConeBench::new(spec)),
        Subject::Stage(stage) => Box::new(EnvStage::new(spec, stage, build)?),
    })
}

/// Outputs of a stage that are no registers.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Extra {
    pub(super) face: i64,
    pub(super) count: i64,
    pub(super) status: i64,
    pub(super) iterations: i64,
}

/// Puts registers, flags and the rest into the outputs of a shape.
pub(super) fn record(
    shape: &Shape,
    probe: &RtlProbe,
    flags: Flags,
    extra: Extra,
    output: &mut [i64],
) {
    let mut at = 0;
    for field in &shape.outputs {
        let end = at + field.components;
        let Some(out) = output.get_mut(at..end) else {
            return;
        };
        at = end;
        match &field.meaning {
            Meaning::Code(reg) | Meaning::Mantissa(reg) => {
                let codes = probe.get(*reg).iter();
                let written = codes.map(|c| if c.is_written() { c.raw } else { 0 });
                for (out, raw) in out.iter_mut().zip(written.chain(std::iter::repeat(0))) {
                    *out = raw;
                }
            }
            Meaning::Fraction(reg) => {
                let codes = probe.get(*reg);
                for (k, out) in out.iter_mut().enumerate() {
                    let code = codes.get(k * group(*reg)).filter(|c| c.is_written());
                    let [low, high] = field.range;
                    *out = code.map_or(0, |c| c.frac.clamp(low, high));
                }
            }
            Meaning::Flags(_) => out.fill(flag_bits(shape, field.stage, flags)),
            Meaning::Word
            | Meaning::Power
            | Meaning::Small
            | Meaning::Choice(_)
            | Meaning::Count(..) => {
                let last = field.name.rsplit('.').next().unwrap_or("");
                out.fill(match last {
                    "face" => extra.face,
                    "count" => extra.count,
                    "status" => extra.status,
                    _ => extra.iterations,
                });
            }
        }
    }
}

/// A stage's own flags, its registers' first.
pub(super) fn flag_bits(shape: &Shape, stage: Stage, flags: Flags) -> i64 {
    let mut bits = 0;
    let mut k = 0;
    for reg in written(shape, stage) {
        bits |= i64::from(flags.has(reg)) << k;
        k += 1;
    }
    for event in events(stage) {
        bits |= i64::from(flags.has_event(event)) << k;
        k += 1;
    }
    bits
}

/// Registers of a stage among a shape's outputs.
pub(super) fn written(shape: &Shape, stage: Stage) -> impl Iterator<Item = Reg> {
    shape
        .outputs
        .iter()
        .filter(move |field| field.stage == stage)
        .filter_map(|field| field.meaning.register())
}

/// Replaces the model's registers by a device's outputs: what the judge by exact arithmetic looks at.
pub fn overlay(shape: &Shape, output: &[i64], probe: &mut RtlProbe) {
    let mut at = 0;
    for field in &shape.outputs {
        let numbers = output.get(at..at + field.components).unwrap_or(&[]);
        at += field.components;
        let (Meaning::Code(reg) | Meaning::Mantissa(reg) | Meaning::Fraction(reg)) = field.meaning
        else {
            continue;
        };
        let each = group(reg);
        for (k, code) in probe.registers[reg.index()].iter_mut().enumerate() {
            if !code.is_written() {
                continue;
            }
            let is_fraction = matches!(field.meaning, Meaning::Fraction(_));
            let Some(number) = numbers.get(if is_fraction { k / each } else { k }) else {
                continue;
            };
            *code = if is_fraction {
                Code { frac: *number, ..*code }
            } else {
                Code { raw: *number, ..*code }
            };
        }
    }
}

/// Names of the flags in a number.
#[must_use]
pub fn flag_names(names: &[&'static str], bits: i64) -> Vec<&'static str> {
    let set = |k: usize| bits >> k & 1 == 1;
    (0..names.len().min(63)).filter(|k| set(*k)).map(|k| names[k]).collect()
}

/// Copies words to numbers.
pub(super) fn put_words(words: impl IntoIterator<Item = u64>, input: &mut [i64]) {
    for (number, word) in input.iter_mut().zip(words) {
        *number = word.cast_signed();
    }
}
