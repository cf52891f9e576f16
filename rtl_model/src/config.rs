//! Configuration of a unit: formats, tables and policies, all of them data.

use alloc::string::String;

use crate::fx::Format;
use crate::policy::Policy;
use crate::regs::Reg;
use crate::tables::TableSpec;

/// Fraction bits of `Config::roughness_scale`.
pub const SCALE_FRAC: u32 = 20;
/// Fraction bits of `Config::rotation`.
pub const ROTATION_FRAC: u32 = 24;
/// Widest sum of products that the model's 64-bit integers hold with room for a rounding constant.
pub const LIMIT_BITS: u32 = 62;

/// Knobs of the five tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Tables {
    /// 1/x.
    pub recip: TableSpec,
    /// 1/√x.
    pub rsqrt: TableSpec,
    /// √x.
    pub sqrt: TableSpec,
    /// log2 x.
    pub log2: TableSpec,
    /// The eigen angle: `entries` over 90°.
    pub eigen: TableSpec,
}

/// Everything that an architect chooses about a unit.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Config {
    /// Format of every register, by `Reg::index`.
    pub formats: [Format; Reg::COUNT],
    /// Tables.
    pub tables: Tables,
    /// Everything else that has a path.
    pub policy: Policy,
    /// s of K = D Dᵀ + s² K3, with `SCALE_FRAC` fraction bits.
    pub roughness_scale: i64,
    /// Rotation of the environment, row by row, with `ROTATION_FRAC` bits; `None` is the identity.
    pub rotation: Option<[[i64; 3]; 3]>,
}

impl Default for Config {
    fn default() -> Self {
        let mut formats = [Format::signed(1, 22); Reg::COUNT];
        for (format, reg) in formats.iter_mut().zip(Reg::ALL) {
            *format = reg.info().format;
        }
        let table = |entries, order, frac, newton| TableSpec { entries, order, frac, newton };
        Self {
            formats,
            tables: Tables {
                recip: table(64, 1, 16, 1),
                rsqrt: table(64, 1, 16, 1),
                sqrt: table(64, 1, 18, 1),
                log2: table(64, 1, 16, 0),
                eigen: table(32, 0, 20, 0),
            },
            policy: Policy::default(),
            roughness_scale: 1 << SCALE_FRAC,
            rotation: None,
        }
    }
}

impl Config {
    /// The same with other knobs.
    #[must_use]
    pub fn with(mut self, change: impl FnOnce(&mut Policy)) -> Self {
        change(&mut self.policy);
        self
    }

    /// The format of a register.
    #[must_use]
    #[inline(always)]
    pub fn format(&self, reg: Reg) -> Format {
        self.formats.get(reg.index()).copied().unwrap_or(reg.info().format)
    }
}

/// A configuration that the model refuses, by name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConfigError {
    /// The path of the knob or the register whose exact input does not fit.
    pub path: String,
    /// A description of legal values.
    pub expected: String,
    /// What was found: the value, or the bits that the exact intermediate needs.
    pub found: String,
}
