//! Error budgets: for every register a derived bound and the worst error seen.
//!
//! A register's error is its distance from its formula on the codes that enter it (see [`super::exact`]); the bound
//! follows from its rounding and from what the tables on the way may be off by. What adds up from the unit's inputs on
//! is what `unit show` prints.

use std::collections::BTreeMap;

use rayon::prelude::*;
use rtl_model::Config;
use rtl_model::regs::Reg;

use super::cases::Class;
use super::exact::Finding;
use super::harness::Build;
use super::run::Runner;
use super::stimuli::Stimulus;
use super::subject::Subject;
use crate::base::num;
use crate::engine::{EnvJob, encode};
use crate::error::InputError;
use crate::stage::Stage;
use crate::unit::UnitSpec;

/// One register's budget.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The stage.
    pub stage: Stage,
    /// The register, or a cone's.
    pub name: &'static str,
    /// Largest bound of any case, in LSB.
    pub bound: f64,
    /// Largest error of any case, in LSB.
    pub worst: f64,
    /// Largest error over its own case's bound.
    pub used: f64,
    /// Components judged.
    pub count: u64,
    /// Components beyond their bound.
    pub exceeded: u64,
    /// 2^(bits − 1) of the register in LSB: half of its scale.
    pub half_scale: f64,
}

/// A bound beyond this many times the worst error says nothing.
pub const VACUOUS: f64 = 64.0;
/// Below this an error is the judge's own arithmetic.
const NOTHING: f64 = 1e-6;

/// The verdict on a budget.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The bound holds and means something.
    Holds,
    /// The register never has anything to round.
    Exact,
    /// The bound holds and is far from the errors seen.
    Vacuous,
    /// A register was beyond its bound.
    Exceeded,
}

impl Row {
    /// What it is worth.
    #[must_use]
    pub fn verdict(&self) -> Verdict {
        if self.exceeded > 0 {
            Verdict::Exceeded
        } else if self.bound < NOTHING {
            Verdict::Exact
        } else if self.bound > VACUOUS * self.worst || self.bound >= self.half_scale {
            Verdict::Vacuous
        } else {
            Verdict::Holds
        }
    }

    fn add(&mut self, finding: &Finding) {
        self.bound = self.bound.max(finding.bound);
        self.worst = self.worst.max(finding.error);
        if finding.bound > NOTHING {
            self.used = self.used.max(finding.error / finding.bound);
        }
        self.count += 1;
        self.exceeded += u64::from(!finding.holds());
    }

    fn merge(&mut self, other: &Self) {
        self.bound = self.bound.max(other.bound);
        self.worst = self.worst.max(other.worst);
        self.used = self.used.max(other.used);
        self.count += other.count;
        self.exceeded += other.exceeded;
    }
}

type Rows = BTreeMap<(Stage, usize, &'static str), Row>;

fn note(config: &Config, rows: &mut Rows, finding: &Finding) {
    let cone = finding.stage == Stage::RayCone;
    if finding.reg.is_none() && !cone {
        return;
    }
    let place = finding.reg.map_or(0, Reg::index);
    let bits = finding.reg.map_or(16, |reg| config.format(reg).magnitude_bits());
    rows.entry((finding.stage, place, finding.name))
        .or_insert_with(|| Row {
            stage: finding.stage,
            name: finding.name,
            bound: 0.0,
            worst: 0.0,
            used: 0.0,
            count: 0,
            exceeded: 0,
            half_scale: libm::ldexp(0.5, num::i32(bits)),
        })
        .add(finding);
}

/// Budgets of every register over `cases` cases of each class and operation, in pipeline order.
pub fn registers(
    spec: &UnitSpec,
    cases: u64,
    seed: u64,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Vec<Row>, InputError> {
    let subjects = [Subject::Env, Subject::Hit, Subject::Tex, Subject::Stage(Stage::RayCone)];
    let pairs = subjects.into_iter().flat_map(|subject| Class::ALL.map(|class| (subject, class)));
    let jobs: Vec<(Subject, Class)> =
        pairs.filter(|(subject, class)| class.concerns(*subject)).collect();
    let parts: Vec<Result<Rows, InputError>> = jobs
        .par_iter()
        .map(|(subject, class)| {
            let mut runner = Runner::of(spec, *subject, Build::default(), *class, seed)?;
            let mut rows = Rows::new();
            for index in 0..cases {
                let input = runner.input(index);
                let output = runner.output(&input);
                for finding in runner.findings(&input, &output) {
                    note(&spec.config, &mut rows, &finding);
                }
            }
            progress(cases);
            Ok(rows)
        })
        .collect();
    merged(parts)
}

/// Budgets of the registers of ENV over the fragments of a scene, in pipeline order. The texels are those of the benches.
pub fn scene(spec: &UnitSpec, subject: &EnvJob) -> Result<Vec<Row>, InputError> {
    let needs = subject.needs();
    let build = Build { bump: needs.bump, rough: needs.rough, ..Build::default() };
    let parts: Vec<Result<Rows, InputError>> = subject
        .scene
        .fragments
        .par_chunks(1024)
        .map(|chunk| {
            let mut runner = Runner::of(spec, Subject::Env, build, Class::Ordinary, 0)?;
            let mut rows = Rows::new();
            for fragment in chunk {
                let input = runner.driven(&Stimulus::Fragment(encode::words(&fragment.fragment)));
                let output = runner.output(&input);
                for finding in runner.findings(&input, &output) {
                    note(&spec.config, &mut rows, &finding);
                }
            }
            Ok(rows)
        })
        .collect();
    merged(parts)
}

fn merged(parts: Vec<Result<Rows, InputError>>) -> Result<Vec<Row>, InputError> {
    let mut all = Rows::new();
    for part in parts {
        for (key, row) in part? {
            all.entry(key).and_modify(|seen| seen.merge(&row)).or_insert(row);
        }
    }
    Ok(all.into_values().collect())
}

/// Cases that [`registers`] runs in all.
#[must_use]
pub fn total(cases: u64) -> u64 {
    16 * cases
}
