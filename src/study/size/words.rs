//! The knobs that the search may shorten: words and tables. Policies are the architect's.

use rtl_model::policy::{ROWS, Row};
use rtl_model::regs::Reg;

use super::Ranges;
use crate::policy::{Axis, Weights};
use crate::unit::{ReferenceAxis, UnitSpec};

/// A knob that gets shorter in steps.
#[derive(Clone, Copy, Debug)]
pub enum Word {
    /// Fraction bits of a register.
    Fraction(Reg),
    /// Another knob.
    Knob(&'static Row),
}

/// Rows by the stages whose registers are written from them: every row whose path begins so.
const WORDS: &[(&[&str], &[&str])] = &[
    (&["local_frame", "eigen", "hit", "surface_footprint"], &["tables.rsqrt.", "tables.sqrt."]),
    (&["cube_face", "hit", "surface_footprint"], &["tables.recip."]),
    (&["footprint"], &["tables.log2."]),
    (&["filter"], &["filter.", "texel.frac"]),
];

impl Word {
    /// The knob's path.
    #[must_use]
    pub fn path(&self) -> String {
        match self {
            Self::Fraction(reg) => format!("registers.{reg}.frac"),
            Self::Knob(row) => row.path.into(),
        }
    }

    /// Whether it is a register's fraction.
    #[must_use]
    pub fn is_fraction(&self) -> bool {
        matches!(self, Self::Fraction(_))
    }

    /// Its value in a unit.
    #[must_use]
    pub fn get(&self, spec: &UnitSpec) -> u32 {
        match self {
            Self::Fraction(reg) => spec.config.format(*reg).frac,
            Self::Knob(row) => row.get(&spec.config).unwrap_or(0),
        }
    }

    /// Sets it.
    pub fn set(&self, spec: &mut UnitSpec, value: u32) {
        match self {
            Self::Fraction(reg) => spec.config.formats[reg.index()].frac = value,
            Self::Knob(row) => row.set(&mut spec.config, value),
        }
    }

    /// One step less, where that is legal.
    #[must_use]
    pub fn below(&self, value: u32) -> Option<u32> {
        match self {
            Self::Fraction(_) => value.checked_sub(1),
            Self::Knob(row) => row.legal.below(value),
        }
    }
}

/// Every word and table that a scene uses.
pub(super) fn all(spec: &UnitSpec, ranges: &Ranges, axis: ReferenceAxis) -> Vec<Word> {
    let mut out: Vec<Word> = ranges.used().map(|(reg, _)| Word::Fraction(reg)).collect();
    let uses =
        |stages: &[&str]| ranges.used().any(|(reg, _)| stages.contains(&reg.info().stage.name()));
    let mut take = |prefix: &str| {
        let rows = ROWS.iter().filter(|row| row.is_listed() && row.path.starts_with(prefix));
        out.extend(rows.map(Word::Knob));
    };
    for (_, words) in WORDS.iter().filter(|(stages, _)| uses(stages)) {
        words.iter().for_each(|prefix| take(prefix));
    }
    let footprint = &spec.config.policy.footprint;
    if footprint.axis == Axis::EigenTable {
        take("tables.eigen.frac");
        // A reference with the same table would not see its entries go.
        if axis == ReferenceAxis::Exact {
            take("eigen.entries");
        }
    }
    if footprint.weights != Weights::Box {
        take("footprint.weight_bits");
    }
    out
}
