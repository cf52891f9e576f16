//! Every register of every stage: a kernel of one stage against the float reference at the kernel's own operands.
//!
//! The operands of a stage are those of the float reference, rounded to f32, so that no stage inherits what the one before
//! it did. The reference's lines run in [`Bounded`], which yields each register with its tolerance. Registers of `hit`,
//! `address` and `filter` that depend on registers of the same stage are checked from the device's own ones, step by step.
//! A result beyond its tolerance is explained only where a comparison lies nearer to its limit than the errors of its sides.

mod behind;
mod env;
mod hit;
mod hit_stage;
mod probes;
mod tex;

use env::{Rotation, rotation};

pub use env::check_env;
pub use hit::check_hit;
pub use tex::{Requests, check_requests, check_tex};

use std::collections::HashMap;

use super::bounded::{Bounded, EPSILON};
use crate::gpu::dispatch::{Program, Words};
use crate::gpu::kernels::Kernel;
use crate::gpu::maps::Maps;
use crate::gpu::policy::{Policy, to_f32};
use crate::gpu::{Gpu, GpuError};
use crate::reference::{Flag, Flags, Tap};
use crate::stage::Stage;

/// Fragments whose operands are put together before the kernels run.
const CHUNK: usize = 1 << 14;

/// A register of a kernel's results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Register {
    /// Its name in its stage.
    pub name: &'static str,
    /// Words.
    pub words: usize,
    /// Whether it is a whole number and not an f32.
    pub whole: bool,
}

/// A register of f32.
const fn float(name: &'static str, words: usize) -> Register {
    Register { name, words, whole: false }
}

/// A register that is one whole number.
const fn whole(name: &'static str) -> Register {
    Register { name, words: 1, whole: true }
}

/// What a word of the results must be: the value, and how far a device may be from it. No value: not compared.
pub type Expected = Option<(f64, f64)>;

/// One fragment at one stage.
#[derive(Clone, Debug, Default)]
pub struct Case {
    /// The fragment's pixel.
    pub pixel: [u32; 2],
    /// The kernel's operands.
    pub operands: Vec<u32>,
    /// What its results must be, word by word; empty where that follows from the results themselves.
    pub expected: Vec<Expected>,
    /// Whether a device may decide a comparison otherwise.
    pub undecided: bool,
}

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

/// A register that is not what it must be.
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

/// What the checks of a scene found.
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

    fn judge(&mut self, stage: Stage, registers: &[Register], case: &Case, results: &[u32]) {
        let mut at = 0;
        for register in registers {
            let range = at..at + register.words;
            at = range.end;
            let Some(expected) = case.expected.get(range.clone()) else {
                continue;
            };
            let shown = |word: &u32| {
                if register.whole { f64::from(*word) } else { number(*word) }
            };
            let values: Vec<f64> = results[range].iter().map(shown).collect();
            let row = self.row(stage, register.name);
            let before = row.unexplained;
            for (gpu, (value, tolerance)) in
                values.iter().zip(expected).filter_map(|(v, e)| e.map(|e| (*v, e)))
            {
                row.add(gpu, value, tolerance, case.undecided);
            }
            if row.unexplained > before && self.first.is_none() {
                let of = |pick: fn((f64, f64)) -> f64| {
                    expected.iter().map(|e| e.map_or(f64::NAN, pick)).collect()
                };
                self.first = Some(Difference {
                    stage,
                    register: register.name,
                    pixel: case.pixel,
                    operands: case.operands.clone(),
                    gpu: values,
                    f64: of(|e| e.0),
                    tolerance: of(|e| e.1),
                    rtl: None,
                });
            }
        }
    }

    fn row(&mut self, stage: Stage, register: &'static str) -> &mut Row {
        let found = self.rows.iter().position(|r| (r.stage, r.register) == (stage, register));
        let at = found.unwrap_or_else(|| {
            self.rows.push(Row {
                stage,
                register,
                compared: 0,
                worst_ulp: 0.0,
                worst_share: 0.0,
                undecided: 0,
                unbounded: 0,
                unexplained: 0,
            });
            self.rows.len() - 1
        });
        &mut self.rows[at]
    }
}

/// The registers of one fragment at one stage, with their errors, as the reference puts them.
#[derive(Clone, Debug, Default)]
struct Recorder {
    put: Vec<(&'static str, usize, f64, f64)>,
}

impl Tap for Recorder {
    fn put(&mut self, stage: Stage, register: &'static str, component: usize, value: f64) {
        self.put_with_error(stage, register, component, value, 0.0);
    }

    fn put_with_error(
        &mut self,
        _: Stage,
        register: &'static str,
        component: usize,
        value: f64,
        error: f64,
    ) {
        self.put.push((register, component, value, error));
    }

    fn event(&mut self, _: &'static str) {}
}

impl Recorder {
    fn get(&self, register: &str, component: usize) -> Expected {
        self.put
            .iter()
            .find(|(name, c, ..)| *name == register && *c == component)
            .map(|(_, _, value, error)| (*value, *error))
    }

    /// The words of a kernel that writes `registers`.
    fn expected(&self, registers: &[Register]) -> Vec<Expected> {
        let words = registers.iter().flat_map(|r| (0..r.words).map(|c| (r.name, c)));
        words.map(|(name, c)| self.get(name, c)).collect()
    }

    fn add(&mut self, register: &'static str, value: u32) {
        self.put.push((register, 0, value.into(), 0.0));
    }

    fn flags(&mut self, flags: Flags) {
        let bits = Flag::ALL
            .into_iter()
            .filter(|flag| flags.contains(*flag))
            .fold(0, |bits, flag| bits | super::bit(flag));
        self.add("flags", bits);
    }
}

/// A number as the next stage gets it.
fn handed_on(x: Bounded) -> Bounded {
    Bounded::exact(f64::from(to_f32(x.value)))
}

fn handed<const N: usize>(v: [Bounded; N]) -> [Bounded; N] {
    v.map(handed_on)
}

/// Doubles as a kernel gets them.
fn ports<const N: usize>(v: [f64; N]) -> [Bounded; N] {
    v.map(|x| Bounded::exact(f64::from(to_f32(x))))
}

/// The words of numbers that are f32.
fn bits(values: &[Bounded]) -> impl Iterator<Item = u32> {
    values.iter().map(|x| to_f32(x.value).to_bits())
}

/// The number in a word.
fn number(word: u32) -> f64 {
    f64::from(f32::from_bits(word))
}

/// A number that the device itself has made.
fn own(word: u32) -> Bounded {
    Bounded::exact(number(word))
}

fn expect(x: Bounded) -> Expected {
    Some((x.value, x.error))
}

fn exactly(x: u32) -> Expected {
    Some((x.into(), 0.0))
}

/// Where checks of a scene run.
struct Checker<'a> {
    gpu: &'a Gpu,
    programs: HashMap<Kernel, Program>,
    found: StageChecks,
}

/// A stage's kernel, the maps and the policy that it runs with, and its results' registers.
struct Station<'a> {
    kernel: Kernel,
    maps: &'a Maps,
    policy: &'a Policy,
    registers: &'a [Register],
}

impl<'a> Checker<'a> {
    fn new(gpu: &'a Gpu) -> Self {
        Self { gpu, programs: HashMap::new(), found: StageChecks::default() }
    }

    /// Runs the cases of a stage; `from_results` completes what follows from the device's own results.
    fn stage(
        &mut self,
        station: &Station<'_>,
        cases: &mut [Case],
        from_results: &dyn Fn(&mut Case, &[u32]),
    ) -> Result<(), GpuError> {
        let Some(first) = cases.first() else {
            return Ok(());
        };
        let words = Words {
            input: first.operands.len(),
            output: station.registers.iter().map(|r| r.words).sum(),
        };
        let input: Vec<u32> = cases.iter().flat_map(|c| c.operands.iter().copied()).collect();
        let program = match self.programs.entry(station.kernel) {
            std::collections::hash_map::Entry::Occupied(entry) => entry.into_mut(),
            std::collections::hash_map::Entry::Vacant(entry) => {
                entry.insert(Program::new(self.gpu, station.kernel)?)
            }
        };
        let (maps, policy) = (station.maps, station.policy);
        let results = program.run(self.gpu, maps, policy, words, (&input, &[]), &|_| {})?;
        let stage = match station.kernel {
            Kernel::Stage(stage) => stage,
            Kernel::FilterPlanar | Kernel::Fused(_) => Stage::Filter,
        };
        for (case, results) in cases.iter_mut().zip(results.chunks_exact(words.output)) {
            from_results(case, results);
            self.found.judge(stage, station.registers, case, results);
        }
        Ok(())
    }
}

impl Row {
    fn add(&mut self, gpu: f64, value: f64, tolerance: f64, undecided: bool) {
        self.compared += 1;
        if !tolerance.is_finite() {
            self.unbounded += 1;
            return;
        }
        let off = (gpu - value).abs();
        if off <= tolerance {
            if tolerance > 0.0 {
                self.worst_share = self.worst_share.max(off / tolerance);
            }
            if value.abs() >= f64::from(f32::MIN_POSITIVE) {
                self.worst_ulp = self.worst_ulp.max(off / (EPSILON * value.abs()));
            }
        } else if undecided {
            self.undecided += 1;
        } else {
            self.unexplained += 1;
        }
    }
}

/// Runs `work` with a recorder and tells whether it made a comparison that a device may decide otherwise.
fn recorded<T>(work: impl FnOnce(&mut Recorder, &mut Flags) -> T) -> (T, Recorder, bool) {
    let mut recorder = Recorder::default();
    let mut flags = Flags::default();
    let _ = Bounded::undecided();
    let out = work(&mut recorder, &mut flags);
    let undecided = Bounded::undecided() > 0;
    recorder.flags(flags);
    (out, recorder, undecided)
}

#[cfg(test)]
mod tests {
    use super::*;

    const REGISTERS: &[Register] = &[float("k", 2), whole("probes")];

    fn case(undecided: bool) -> Case {
        Case {
            pixel: [7, 9],
            operands: vec![1, 2],
            expected: vec![Some((1.0, 1e-6)), None, Some((4.0, 0.0))],
            undecided,
        }
    }

    fn words(k: f32, probes: u32) -> [u32; 3] {
        [k.to_bits(), 0, probes]
    }

    #[test]
    fn a_register_beyond_its_tolerance_is_located_with_all_its_values() {
        let mut found = StageChecks::default();
        let stage = Stage::Covariance;
        found.judge(stage, REGISTERS, &case(false), &words(1.0, 4));
        assert!(!found.fails());
        found.judge(stage, REGISTERS, &case(false), &words(1.0001, 4));
        found.judge(stage, REGISTERS, &case(false), &words(1.0, 5));
        let first = found.first.as_ref().expect("two differences");
        assert_eq!((first.register, first.pixel), ("k", [7, 9]));
        assert_eq!((first.f64[0], first.operands.as_slice()), (1.0, &[1, 2][..]));
        let unexplained: Vec<u64> = found.rows.iter().map(|r| r.unexplained).collect();
        assert_eq!(unexplained, [1, 1]);
        assert_eq!(found.rows[0].compared, 3, "what is not expected is not compared");
    }

    #[test]
    fn only_a_comparison_in_doubt_explains_a_difference() {
        let mut found = StageChecks::default();
        found.judge(Stage::Footprint, REGISTERS, &case(true), &words(1.5, 5));
        assert!(!found.fails());
        assert!(found.rows.iter().all(|r| r.undecided == 1));
        found.judge(Stage::Footprint, REGISTERS, &case(false), &words(f32::NAN, 4));
        assert!(found.fails(), "NaN is within no tolerance");
    }
}
