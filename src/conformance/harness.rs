//! Harnesses: a stage or the unit between a case's numbers in and its numbers out.

use rtl_model::Config;
use rtl_model::fx::Flags;
use rtl_model::regs::Reg;
use rtl_model::stages::Roms;

use super::field::{Meaning, Shape, events, group};
use super::stimuli::Stimulus;
use crate::base::num;
use crate::engine::probe::{Code, RtlProbe};
use crate::stage::Stage;

/// Something that turns a case's inputs into its outputs: the integer model, or a device next to it.
pub trait Device {
    /// The inputs and outputs.
    fn shape(&self) -> &Shape;

    /// Runs one case: `input` and `output` hold the numbers of [`Shape`]'s fields, in order.
    fn run(&mut self, input: &[i64], output: &mut [i64]);
}

/// A part of the integer model behind the fields of a shape.
pub(super) trait Circuit: Send {
    /// Runs one case. The probe gets its registers; its sticky flags and its other numbers come back.
    fn run(&mut self, input: &[i64], probe: &mut RtlProbe) -> (Flags, Extra);

    /// The numbers of the inputs when `stimulus` comes to the unit: what the stages before this part make of it.
    fn drive(&mut self, stimulus: &Stimulus, input: &mut [i64]);

    /// The tables, where the part has any.
    fn roms(&mut self) -> Option<&mut Roms> {
        None
    }
}

/// A stage or an operation of the integer model, with its registers in true units.
pub struct Harness {
    shape: Shape,
    config: Config,
    probe: RtlProbe,
    circuit: Box<dyn Circuit>,
}

impl Harness {
    pub(super) fn new(shape: Shape, config: &Config, circuit: impl Circuit + 'static) -> Self {
        let probe = RtlProbe::default();
        Self { shape, config: config.clone(), probe, circuit: Box::new(circuit) }
    }

    /// The registers that the last case read and wrote.
    #[must_use]
    pub fn probe(&self) -> &RtlProbe {
        &self.probe
    }

    /// The configuration.
    #[must_use]
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// The numbers of the inputs when `stimulus` comes to the unit: what the stages before it make of it.
    pub fn drive(&mut self, stimulus: &Stimulus, input: &mut [i64]) {
        self.circuit.drive(stimulus, input);
    }

    /// The tables, to be changed by who tests the judges; of an operation of ENV alone.
    pub fn roms(&mut self) -> Option<&mut Roms> {
        self.circuit.roms()
    }
}

impl Device for Harness {
    fn shape(&self) -> &Shape {
        &self.shape
    }

    fn run(&mut self, input: &[i64], output: &mut [i64]) {
        self.probe.clear();
        let (flags, extra) = self.circuit.run(input, &mut self.probe);
        record(&self.shape, &self.probe, flags, extra, output);
    }
}

/// Which parts of the unit a harness has, and its memories.
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

/// Numbers beside the registers that a stage yields.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Extra {
    pub(super) face: i64,
    pub(super) count: i64,
    pub(super) status: i64,
    pub(super) iterations: i64,
    pub(super) angle: i64,
    pub(super) width: i64,
}

/// The numbers of a case's inputs, one after the other; 0 behind the last one.
pub(super) struct Numbers<'a>(std::slice::Iter<'a, i64>);

impl<'a> Numbers<'a> {
    pub(super) fn new(input: &'a [i64]) -> Self {
        Self(input.iter())
    }

    pub(super) fn next(&mut self) -> i64 {
        self.0.next().copied().unwrap_or(0)
    }

    /// A code of at most 32 bits.
    pub(super) fn code(&mut self) -> u32 {
        num::u32(self.next())
    }

    /// Words of binary64.
    pub(super) fn reals<const N: usize>(&mut self) -> [f64; N] {
        std::array::from_fn(|_| f64::from_bits(self.next().cast_unsigned()))
    }
}

/// Puts registers, flags and the rest into the outputs of a shape.
fn record(shape: &Shape, probe: &RtlProbe, flags: Flags, extra: Extra, output: &mut [i64]) {
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
                    "angle" => extra.angle,
                    "width" => extra.width,
                    _ => extra.iterations,
                });
            }
        }
    }
}

/// A stage's own flags, its registers' first.
fn flag_bits(shape: &Shape, stage: Stage, flags: Flags) -> i64 {
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
fn written(shape: &Shape, stage: Stage) -> impl Iterator<Item = Reg> {
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
