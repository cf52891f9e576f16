//! Running suites: cases in parallel, the first failure minimised.

use super::cases::{Class, Place, fill};
use super::check::{Difference, beyond, difference};
use super::exact::{Case, Finding, Judge};
use super::harness::{Build, Device as _, Harness, overlay};
use super::stimuli::Stimulus;
use super::subject::Subject;
use super::suite::Suite;
use crate::base::named::named;
use crate::base::num;
use crate::engine::probe::RtlProbe;
use crate::error::InputError;
use crate::unit::UnitSpec;

named! {
    /// An engine of the suites.
    pub enum Engine {
        /// The integer model against itself: one lane after other cases, every code within its register.
        Rtl = "rtl",
        /// The integer model against exact arithmetic.
        F64 = "f64",
        /// The shaders against exact arithmetic.
        Gpu = "gpu",
    }
}

/// A failed case.
#[derive(Clone, Debug)]
pub struct Failure {
    /// Which engine's judgement.
    pub engine: Engine,
    /// Index in the suite.
    pub index: u64,
    /// The case's inputs, as simple as they can be with the failure still there.
    pub input: Vec<i64>,
    /// The outputs for them.
    pub output: Vec<i64>,
    /// What is wrong.
    pub difference: Difference,
}

/// The result of a suite.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Cases run.
    pub cases: u64,
    /// Cases that failed, by engine in the order asked for.
    pub failed: u64,
    /// The first failure.
    pub failure: Option<Failure>,
    /// Components that were judged by exact arithmetic.
    pub judged: u64,
    /// Whether every output was 0, or every case raised a flag.
    pub vacuous: Option<&'static str>,
}

/// A subject's harness in a unit, with what judges it.
pub struct Runner {
    subject: Subject,
    class: Class,
    model: Harness,
    /// Another instance, whose registers hold other cases: nothing may be left of them.
    fresh: Harness,
    judge: Judge,
    level: u32,
    seed: u64,
}

impl Runner {
    /// Builds the suite's unit.
    pub fn new(suite: Suite, seed: u64) -> Result<Self, InputError> {
        let (spec, build) = (suite.configuration.unit()?, suite.configuration.build());
        Self::of(&spec, suite.subject, build, suite.class, seed)
    }

    /// A subject in any unit.
    pub fn of(
        spec: &UnitSpec,
        subject: Subject,
        build: Build,
        class: Class,
        seed: u64,
    ) -> Result<Self, InputError> {
        Ok(Self {
            subject,
            class,
            model: super::harness(spec, subject, build)?,
            fresh: super::harness(spec, subject, build)?,
            judge: Judge::new(&spec.config, subject, build),
            level: 2,
            seed,
        })
    }

    /// The harness.
    #[must_use]
    pub fn model(&self) -> &Harness {
        &self.model
    }

    /// The inputs of a case.
    pub fn input(&mut self, index: u64) -> Vec<i64> {
        let place = Place { class: self.class, level: self.level, seed: self.seed, index };
        let mut input = vec![0; self.model.shape().input_len()];
        fill(&mut self.model, self.subject, place, &mut input);
        input
    }

    /// The inputs that a stimulus of the unit makes.
    pub fn driven(&mut self, stimulus: &Stimulus) -> Vec<i64> {
        let mut input = vec![0; self.model.shape().input_len()];
        self.model.drive(stimulus, &mut input);
        input
    }

    /// Whether every register of a case is 0 or lies within 2^±`power`.
    pub fn is_within(&mut self, input: &[i64], power: i32) -> bool {
        self.output(input);
        let (low, high) = (libm::ldexp(1.0, -power), libm::ldexp(1.0, power));
        let codes = self.model.probe().registers.iter().flatten();
        codes
            .filter(|code| code.is_written() && code.raw != 0)
            .all(|code| (low..high).contains(&code.value().abs()))
    }

    /// What exact arithmetic finds in a case whose outputs `device` holds.
    pub fn findings(&mut self, input: &[i64], device: &[i64]) -> Vec<Finding> {
        let mut own = vec![0; device.len()];
        self.model.run(input, &mut own);
        let mut probe: RtlProbe = self.model.probe().clone();
        overlay(self.model.shape(), device, &mut probe);
        let case = Case { shape: self.model.shape(), input, output: device, probe: &probe };
        self.judge.judge(self.model.config(), &case)
    }

    /// The outputs of the integer model.
    pub fn output(&mut self, input: &[i64]) -> Vec<i64> {
        let mut output = vec![0; self.model.shape().output_len()];
        self.model.run(input, &mut output);
        output
    }

    /// An engine's judgement of a case's outputs.
    fn judged(
        &mut self,
        engine: Engine,
        input: &[i64],
        output: &[i64],
    ) -> (Option<Difference>, u64) {
        match engine {
            Engine::Rtl => {
                let mut other = vec![0; output.len()];
                self.fresh.run(input, &mut other);
                let shape = self.model.shape();
                let differs = difference(&shape.outputs, output, &other);
                (differs.or_else(|| out_of_range(&self.model, output)), 0)
            }
            Engine::F64 | Engine::Gpu => {
                let findings = self.findings(input, output);
                let count = num::u64(findings.len());
                (beyond(&findings), count)
            }
        }
    }

    /// Runs cases `range` and judges them by `engines`.
    pub fn run(&mut self, engines: &[Engine], range: std::ops::Range<u64>) -> Outcome {
        let mut outcome = Outcome::default();
        let (mut alive, mut flagged) = (false, 0);
        let flags = super::field::flag_places(self.model.shape());
        for index in range {
            let input = self.input(index);
            let output = self.output(&input);
            outcome.cases += 1;
            alive |= output.iter().any(|x| *x != 0);
            flagged += u64::from(flags.iter().any(|at| output[*at] != 0));
            for engine in engines {
                let (differs, count) = self.judged(*engine, &input, &output);
                outcome.judged += count;
                if let Some(difference) = differs {
                    outcome.failed += 1;
                    if outcome.failure.is_none() {
                        let failure = self.minimised(*engine, index, input.clone(), difference);
                        outcome.failure = Some(failure);
                    }
                    break;
                }
            }
        }
        if outcome.cases > 0 && !alive {
            outcome.vacuous = Some("every output is 0");
        } else if outcome.cases > 1 && flagged == outcome.cases {
            outcome.vacuous = Some("every case raised a flag");
        }
        outcome
    }

    /// Sets inputs to 0 as long as the same stage and field stay wrong.
    fn minimised(
        &mut self,
        engine: Engine,
        index: u64,
        mut input: Vec<i64>,
        mut difference: Difference,
    ) -> Failure {
        let fields: Vec<[i64; 2]> =
            self.model.shape().numbers().map(|(field, _)| field.range).collect();
        for k in 0..input.len() {
            let [low, high] = fields[k];
            let (was, simple) = (input[k], 0i64.clamp(low, high));
            if was == simple {
                continue;
            }
            input[k] = simple;
            let output = self.output(&input);
            let (found, _) = self.judged(engine, &input, &output);
            match found {
                Some(found) if found.field == difference.field => difference = found,
                _ => input[k] = was,
            }
        }
        let output = self.output(&input);
        Failure { engine, index, input, output, difference }
    }
}

/// The first output outside of its field.
fn out_of_range(model: &Harness, output: &[i64]) -> Option<Difference> {
    let mut at = 0;
    for field in &model.shape().outputs {
        let [low, high] = field.range;
        for (component, number) in output[at..at + field.components].iter().enumerate() {
            if !(low..=high).contains(number) {
                return Some(Difference {
                    stage: field.stage,
                    field: field.name.clone(),
                    component,
                    observed: number.to_string(),
                    expected: format!("{low} to {high}"),
                    more: 0,
                });
            }
        }
        at += field.components;
    }
    None
}
