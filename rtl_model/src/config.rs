//! Configuration of a unit: formats, tables and policies, all of them data.

use alloc::string::String;

use crate::cone::{ConeFormat, LaneOrder, StoreRounding};
use crate::fx::Format;
use crate::policy::{
    Axis, ConeRules, Count, Dnmod, HitPolicy, Minor, Placement, SetDiffuse, TexPolicy, Weights,
};
use crate::regs::Reg;
use crate::tables::TableSpec;

/// Fraction bits of `Config::roughness_scale`.
pub const SCALE_FRAC: u32 = 20;
/// Fraction bits of `Config::rotation`.
pub const ROTATION_FRAC: u32 = 24;
/// Widest sum of products that the model's 64-bit integers hold with room for a rounding constant.
pub const LIMIT_BITS: u32 = 62;

/// How texels are stored in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TexelFormat {
    /// Fixed point with the datapath's own `texel.int`, `texel.frac`.
    Q,
    /// 8 bits, c/255.
    Unorm8,
    /// Shared exponent: three 9-bit mantissas, one 5-bit exponent.
    Rgb9e5,
    /// IEEE 754 binary16.
    Half,
}

impl TexelFormat {
    /// Every value.
    pub const ALL: &'static [Self] = &[Self::Half, Self::Q, Self::Unorm8, Self::Rgb9e5];

    /// The literal that unit files use.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Q => "q",
            Self::Unorm8 => "unorm8",
            Self::Rgb9e5 => "rgb9e5",
            Self::Half => "half",
        }
    }

    /// The value with that literal, if there is one.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|f| f.name() == text)
    }
}

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

/// Knobs of the cones' registers and rules.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct ConeConfig {
    /// Format of both registers.
    pub format: ConeFormat,
    /// Rounding of their stores.
    pub rounding: StoreRounding,
    /// Order of the two in a packed word.
    pub order: LaneOrder,
    /// Seed of stochastic stores.
    pub seed: u32,
    /// The note's rules or those of OptiX Toolkit's code.
    pub rules: ConeRules,
    /// What a diffuse scatter of OptiX Toolkit writes.
    pub set_diffuse: SetDiffuse,
}

/// Everything that an architect chooses about a unit.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Config {
    /// Format of every register, by `Reg::index`.
    pub formats: [Format; Reg::COUNT],
    /// Tables.
    pub tables: Tables,
    /// Where the angle table's entries lie.
    pub placement: Placement,
    /// Most probes of a fragment (1…64).
    pub max_probes: u32,
    /// Rule of the probe count.
    pub count: Count,
    /// Direction of the probe line.
    pub axis: Axis,
    /// Probe weights.
    pub weights: Weights,
    /// Bits of gaussian probe weights: they sum to 2^bits.
    pub probe_weight_bits: u32,
    /// How λ2 is found.
    pub minor: Minor,
    /// What stands for ∂n_mod.
    pub dnmod: Dnmod,
    /// s of K = D Dᵀ + s² K3, with `SCALE_FRAC` fraction bits.
    pub roughness_scale: i64,
    /// Rotation of the environment, row by row, with `ROTATION_FRAC` bits; `None` is the identity.
    pub rotation: Option<[[i64; 3]; 3]>,
    /// Bits of a bilinear weight.
    pub weight_bits: u32,
    /// Bits of the weight between two levels.
    pub lod_bits: u32,
    /// How texels are stored.
    pub texel_format: TexelFormat,
    /// Policies of the HIT operation.
    pub hit: HitPolicy,
    /// Integer bits of a decoded texel.
    pub texel_int: u32,
    /// Fraction bits of a decoded texel.
    pub texel_frac: u32,
    /// Registers and rules of ray cones.
    pub cone: ConeConfig,
    /// Policies of the TEX operation.
    pub tex: TexPolicy,
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
            placement: Placement::Edges,
            max_probes: 16,
            count: Count::Ceil,
            axis: Axis::EigenTable,
            weights: Weights::Box,
            probe_weight_bits: 8,
            minor: Minor::Paper,
            dnmod: Dnmod::Normal,
            roughness_scale: 1 << SCALE_FRAC,
            rotation: None,
            weight_bits: 8,
            lod_bits: 8,
            texel_format: TexelFormat::Half,
            hit: HitPolicy::default(),
            texel_int: 17,
            texel_frac: 24,
            cone: ConeConfig::default(),
            tex: TexPolicy::default(),
        }
    }
}

impl Config {
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
    /// What a legal value is.
    pub expected: String,
    /// What was found: the value, or the bits that the exact intermediate needs.
    pub found: String,
}
