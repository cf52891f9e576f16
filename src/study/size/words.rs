//! The knobs that the search may shorten: words and tables. Policies are the architect's.

use rtl_model::regs::Reg;

use super::ranges::Ranges;
use crate::base::num;
use crate::policy::{Axis, Weights};
use crate::unit::knobs::Value;
use crate::unit::{ReferenceAxis, UnitSpec};

/// A knob with the steps in which it gets shorter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Word {
    /// Fraction bits of a register.
    Fraction(Reg),
    /// Another knob: its path, its least value, and how it gets shorter.
    Knob(&'static str, u32, Step),
}

/// How a knob gets shorter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// By one.
    Bit,
    /// By half.
    Half,
    /// By two: the angle table's entries are even.
    Pair,
}

/// Tables by the registers that are written from them.
const TABLES: &[(&[&str], &[Word])] = &[
    (
        &["local_frame", "eigen", "hit", "surface_footprint"],
        &[
            Word::Knob("tables.rsqrt.entries", 2, Step::Half),
            Word::Knob("tables.rsqrt.order", 0, Step::Bit),
            Word::Knob("tables.rsqrt.frac", 2, Step::Bit),
            Word::Knob("tables.rsqrt.newton", 0, Step::Bit),
            Word::Knob("tables.sqrt.entries", 2, Step::Half),
            Word::Knob("tables.sqrt.order", 0, Step::Bit),
            Word::Knob("tables.sqrt.frac", 2, Step::Bit),
            Word::Knob("tables.sqrt.newton", 0, Step::Bit),
        ],
    ),
    (
        &["cube_face", "hit", "surface_footprint"],
        &[
            Word::Knob("tables.recip.entries", 2, Step::Half),
            Word::Knob("tables.recip.order", 0, Step::Bit),
            Word::Knob("tables.recip.frac", 2, Step::Bit),
            Word::Knob("tables.recip.newton", 0, Step::Bit),
        ],
    ),
    (
        &["footprint"],
        &[
            Word::Knob("tables.log2.entries", 2, Step::Half),
            Word::Knob("tables.log2.order", 0, Step::Bit),
            Word::Knob("tables.log2.frac", 2, Step::Bit),
        ],
    ),
    (
        &["filter"],
        &[
            Word::Knob("filter.weight_bits", 1, Step::Bit),
            Word::Knob("filter.lod_bits", 1, Step::Bit),
            Word::Knob("texel.frac", 4, Step::Bit),
        ],
    ),
];

impl Word {
    /// The knob's path.
    #[must_use]
    pub fn path(&self) -> String {
        match self {
            Self::Fraction(reg) => {
                let info = reg.info();
                format!("registers.{}.{}.frac", info.stage, info.name)
            }
            Self::Knob(path, ..) => (*path).into(),
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
            Self::Knob(path, ..) => match spec.get(path) {
                Some(Value::Integer(n)) => num::u32(n),
                Some(Value::Float(_) | Value::Text(_) | Value::Numbers(_)) | None => 0,
            },
        }
    }

    /// Sets it; false where the knob does not take the value.
    pub fn set(&self, spec: &mut UnitSpec, value: u32) -> bool {
        match self {
            Self::Fraction(reg) => {
                spec.config.formats[reg.index()].frac = value;
                true
            }
            Self::Knob(path, ..) => spec.set(path, &Value::Integer(value.into())).is_ok(),
        }
    }

    /// Least value.
    #[must_use]
    pub fn least(&self) -> u32 {
        match self {
            Self::Fraction(_) => 0,
            Self::Knob(_, least, _) => *least,
        }
    }

    /// One step less.
    #[must_use]
    pub fn below(&self, value: u32) -> Option<u32> {
        let less = match self {
            Self::Fraction(_) | Self::Knob(_, _, Step::Bit) => value.checked_sub(1)?,
            Self::Knob(_, _, Step::Half) => value / 2,
            Self::Knob(_, _, Step::Pair) => value.checked_sub(2)?,
        };
        (less >= self.least()).then_some(less)
    }
}

/// Every word and table that a scene uses.
pub(super) fn all(spec: &UnitSpec, ranges: &Ranges, axis: ReferenceAxis) -> Vec<Word> {
    let mut out: Vec<Word> = ranges.used().map(|(reg, _)| Word::Fraction(reg)).collect();
    let uses = |stages: &[&str]| ranges.used().any(|(reg, _)| stages.contains(&reg.info().stage));
    for (stages, words) in TABLES {
        if uses(stages) {
            out.extend_from_slice(words);
        }
    }
    if spec.config.policy.footprint.axis == Axis::EigenTable {
        out.push(Word::Knob("tables.eigen.frac", 4, Step::Bit));
        // A reference with the same table would not see its entries go.
        if axis == ReferenceAxis::Exact {
            out.push(Word::Knob("eigen.entries", 2, Step::Pair));
        }
    }
    if spec.config.policy.footprint.weights == Weights::Gaussian {
        out.push(Word::Knob("footprint.weight_bits", 1, Step::Bit));
    }
    out
}
