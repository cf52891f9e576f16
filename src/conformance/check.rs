//! The judges of a device's vectors: by the integer model's bits, or by the rounding that the formats allow.

use super::exact::{Case, Finding, Judge};
use super::field::{Field, Meaning, digits};
use super::harness::{Build, Device as _, Harness, flag_names, overlay};
#[cfg(feature = "files")]
use super::read::{self, Malformed};
use super::subject::Subject;
#[cfg(feature = "files")]
use super::text::{self, Format};
use crate::base::num;

/// A case's first wrong field.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// The stage, in pipeline order the first that differs.
    pub stage: crate::stage::Stage,
    /// The field.
    pub field: String,
    /// Component.
    pub component: usize,
    /// What the device has, as a vector line writes it.
    pub observed: String,
    /// The expected value.
    pub expected: String,
    /// Fields that differ besides.
    pub more: usize,
}

/// What a line is.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// Everything is as it may be.
    Agrees,
    /// `inputs => observed expected`, with the first differing stage and field.
    Differs(String),
}

/// Reads cases and judges them, one at a time.
pub struct Checker {
    model: Harness,
    judge: Option<Judge>,
    expected: Vec<i64>,
    cases: u64,
    /// By output number: whether it was ever other than 0.
    alive: Vec<bool>,
    /// Cases with a flag.
    flagged: u64,
    judged: u64,
}

/// The first field in which two outputs differ.
#[must_use]
pub fn difference(fields: &[Field], observed: &[i64], expected: &[i64]) -> Option<Difference> {
    let mut at = 0;
    let mut first: Option<Difference> = None;
    for field in fields {
        let range = at..at + field.components;
        at = range.end;
        let (a, b) = (&observed[range.clone()], &expected[range]);
        let Some(component) = a.iter().zip(b).position(|(a, b)| a != b) else {
            continue;
        };
        match &mut first {
            Some(first) => first.more += 1,
            None => {
                let shown = |number: i64| {
                    let mut out = String::new();
                    digits(field, number, &mut out);
                    if let Meaning::Flags(names) = &field.meaning {
                        let names = flag_names(names, number);
                        out = format!("{out} ({})", names.join(" "));
                    }
                    out
                };
                first = Some(Difference {
                    stage: field.stage,
                    field: field.name.clone(),
                    component,
                    observed: shown(a[component]),
                    expected: shown(b[component]),
                    more: 0,
                });
            }
        }
    }
    first
}

/// The first finding that does not hold.
#[must_use]
pub fn beyond(findings: &[Finding]) -> Option<Difference> {
    let mut wrong = findings.iter().filter(|f| !f.holds());
    let first = wrong.next()?;
    let width = |x: f64| {
        if x.abs() < 1e15 { format!("{x:.3}") } else { format!("{x:.6e}") }
    };
    Some(Difference {
        stage: first.stage,
        field: first.name.into(),
        component: first.component,
        observed: first.observed.to_string(),
        expected: format!("{} ± {}", width(first.exact), width(first.bound)),
        more: wrong.count(),
    })
}

impl Difference {
    /// `field[component]: observed expected`.
    #[must_use]
    pub fn text(&self) -> String {
        let more = match self.more {
            0 => String::new(),
            n => format!(" (and {n} more)"),
        };
        format!(
            "stage {}, {}[{}]: {} expected {}{more}",
            self.stage.name(),
            self.field,
            self.component,
            self.observed,
            self.expected
        )
    }
}

impl Checker {
    /// A judge of a subject's vectors; `exact` for the allowed sets of the formats instead of the model's bits.
    #[must_use]
    pub fn new(model: Harness, subject: Subject, build: Build, exact: bool) -> Self {
        let outputs = model.shape().output_len();
        let judge = exact.then(|| Judge::new(model.config(), subject, build));
        Self {
            judge,
            model,
            expected: vec![0; outputs],
            cases: 0,
            alive: vec![false; outputs],
            flagged: 0,
            judged: 0,
        }
    }

    /// Judges one line.
    #[cfg(feature = "files")]
    pub fn line(&mut self, format: Format, line: &str) -> Result<Verdict, Malformed> {
        let mut numbers = Vec::new();
        let parsed = read::parse(self.model.shape(), format, line, &mut numbers);
        parsed.map(|unknown| {
            if let Some(unknown) = unknown {
                return Verdict::Differs(format!("{unknown} expected no unknown digit"));
            }
            let (input, observed) = numbers.split_at(self.model.shape().input_len());
            match self.case(input, observed) {
                None => Verdict::Agrees,
                Some(difference) => {
                    let inputs = text::tokens(&self.model.shape().inputs, input, ' ');
                    Verdict::Differs(format!("{inputs} => {}", difference.text()))
                }
            }
        })
    }

    /// Judges a case; `None` where it agrees.
    pub fn case(&mut self, input: &[i64], observed: &[i64]) -> Option<Difference> {
        self.model.run(input, &mut self.expected);
        self.cases += 1;
        let shape = self.model.shape();
        let mut flagged = false;
        let mut at = 0;
        for field in &shape.outputs {
            let numbers = &observed[at..at + field.components];
            if matches!(field.meaning, Meaning::Flags(_)) {
                flagged |= numbers.iter().any(|n| *n != 0);
            }
            for (alive, number) in self.alive[at..].iter_mut().zip(numbers) {
                *alive |= *number != 0;
            }
            at += field.components;
        }
        self.flagged += u64::from(flagged);
        match &self.judge {
            None => difference(&shape.outputs, observed, &self.expected),
            Some(judge) => {
                let mut probe = self.model.probe().clone();
                overlay(shape, observed, &mut probe);
                let case = Case { shape, input, output: observed, probe: &probe };
                let findings = judge.judge(self.model.config(), &case);
                self.judged += num::u64(findings.len());
                beyond(&findings)
            }
        }
    }

    /// The reason why a comparison proves little: all outputs zero, or every case flagged.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        let mut out = Vec::new();
        if self.cases > 0 && !self.alive.contains(&true) {
            out.push("every output of every case is 0: the comparison shows nothing".into());
        }
        if self.cases > 1 && self.flagged == self.cases {
            out.push("every case raised a flag, as where registers saturate: the comparison shows little".into());
        }
        out
    }

    /// A word about how much was looked at.
    #[must_use]
    pub fn summary(&self) -> String {
        match self.judge {
            Some(_) => format!("; {} components against exact arithmetic", self.judged),
            None => String::new(),
        }
    }

    /// The model.
    pub fn model(&mut self) -> &mut Harness {
        &mut self.model
    }
}
