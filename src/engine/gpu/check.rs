//! Every register of every stage: a kernel of one stage against the float reference at the kernel's own operands.
//!
//! The operands of a stage are those of the float reference, rounded to f32, so that no stage inherits what the one before
//! it did. The reference's lines run in [`Bounded`], which yields each register with its tolerance. Registers of `hit`,
//! `address` and `filter` that depend on registers of the same stage are checked from the device's own ones, step by step.
//! A result beyond its tolerance is explained only where a comparison lies nearer to its limit than the errors of its sides.

mod back_end;
mod cases;
mod env;
mod hit;
mod hit_stage;
mod probes;
mod tex;

use back_end::BackEnd;

pub use env::check_env;
pub use hit::check_hit;
pub use tex::{check_requests, check_tex};

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use super::bounded::{Bounded, EPSILON};
use crate::engine::stage_checks::{Difference, Row};
pub use crate::engine::stage_checks::{Requests, StageChecks};
use crate::gpu::GpuError;
use crate::gpu::dispatch::{Program, Words};
use crate::gpu::kernels::{Kernel, Register};
use crate::stage::Stage;

/// Fragments whose operands are put together before the kernels run.
const CHUNK: usize = 1 << 14;

/// The expected word of a result: the value, and the tolerance around it. No value: not compared.
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

impl StageChecks {
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

/// The expected words of a case's results, from the case's index, its operands and the results themselves.
type FromResults<'a> = &'a dyn Fn(usize, &[u32], &[u32]) -> Vec<Expected>;

/// The kernels of a scene's checks, and what they found.
#[derive(Default)]
struct Checker {
    programs: HashMap<Kernel, Program>,
    found: StageChecks,
}

impl Checker {
    /// Runs the cases of a stage with the maps and the policy of `back`; `from_results` says what follows from the device's
    /// own results.
    fn stage(
        &mut self,
        back: &BackEnd<'_>,
        (kernel, registers): (Kernel, &[Register]),
        mut cases: Vec<Case>,
        from_results: Option<FromResults<'_>>,
    ) -> Result<(), GpuError> {
        let Some(first) = cases.first() else {
            return Ok(());
        };
        let words =
            Words { input: first.operands.len(), output: registers.iter().map(|r| r.words).sum() };
        let input: Vec<u32> = cases.iter().flat_map(|c| c.operands.iter().copied()).collect();
        let program = match self.programs.entry(kernel) {
            Entry::Occupied(entry) => entry.into_mut(),
            Entry::Vacant(entry) => entry.insert(Program::new(back.maps.gpu, kernel)?),
        };
        let results = program.run(&back.maps, words, (&input, &[]), &|_| {})?;
        let stage = match kernel {
            Kernel::Stage(stage) => stage,
            Kernel::FilterPlanar | Kernel::Fused(_) => Stage::Filter,
        };
        let results = results.chunks_exact(words.output);
        for (index, (case, results)) in cases.iter_mut().zip(results).enumerate() {
            if let Some(from_results) = from_results {
                let _ = Bounded::undecided();
                case.expected = from_results(index, &case.operands, results);
                case.undecided = Bounded::undecided() > 0;
            }
            self.found.judge(stage, registers, case, results);
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

#[cfg(test)]
mod tests {
    use super::*;

    const REGISTERS: &[Register] = &[
        Register { name: "k", words: 2, whole: false },
        Register { name: "probes", words: 1, whole: true },
    ];

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
