//! Errors of single register writes and of the tables: where the bounds start.

use crate::base::num;
use rtl_model::Config;
use rtl_model::fx::Rounding;
use rtl_model::regs::Reg;
use rtl_model::tables::TableSpec;

/// √3.
pub(super) const SQRT_3: f64 = 1.732_050_807_568_877_2;

/// 2^−bits.
pub(super) fn power(bits: u32) -> f64 {
    libm::ldexp(1.0, -num::i32(bits))
}

/// Errors of single register writes.
pub(super) struct Words<'a>(pub(super) &'a Config);

impl Words<'_> {
    /// Largest error of a write to a fixed register, absolute in its nominal scale.
    pub(super) fn fixed(&self, reg: Reg) -> f64 {
        let format = self.0.format(reg);
        let lsb = power(format.frac);
        match format.rounding {
            Rounding::Floor | Rounding::Zero => lsb,
            Rounding::HalfUp
            | Rounding::HalfDown
            | Rounding::HalfAway
            | Rounding::HalfZero
            | Rounding::HalfEven
            | Rounding::HalfOdd => lsb / 2.0,
        }
    }

    /// Largest error of a block's component as a share of the block's largest component.
    pub(super) fn block(&self, reg: Reg) -> f64 {
        power(self.0.format(reg).magnitude_bits().saturating_sub(1))
    }

    /// √3 times [`Words::fixed`]: the length of the error of a vector of three.
    pub(super) fn vector(&self, reg: Reg) -> f64 {
        SQRT_3 * self.fixed(reg)
    }
}

/// Largest relative errors of the tables' outputs (of log2: absolute).
#[derive(Clone, Copy, Debug)]
pub struct TableErrors {
    /// Of 1/x.
    pub recip: f64,
    /// Of 1/√x.
    pub rsqrt: f64,
    /// Of √x.
    pub sqrt: f64,
    /// Of log2 x, absolute.
    pub log2: f64,
}

/// Interpolation error for steps `h` where the derivatives are at most `d`, and the entries' rounding.
///
/// Order 0: h/2·f'. 1: h²/8·f''. 2: through three points a half step s apart, f'''/6 times the largest
/// |x(x² − s²)| = 2s³/√27, and entries weigh 1.25 together. Arithmetic on 30 bits: 2^−28.
fn table(spec: TableSpec, binades: u32, d: [f64; 3], entry: f64) -> f64 {
    let h = f64::from(binades) / f64::from(spec.entries);
    let (curve, weight) = match spec.order {
        0 => (h / 2.0 * d[0], 1.0),
        1 => (h * h / 8.0 * d[1], 1.0),
        _ => (d[2] / 6.0 * (h * h * h / 8.0) * (2.0 / (3.0 * SQRT_3)), 1.25),
    };
    curve + weight * entry * power(spec.frac + 1) + power(28)
}

impl TableErrors {
    /// Derived from the tables' knobs.
    #[must_use]
    pub fn new(config: &Config) -> Self {
        let t = &config.tables;
        // 1/x: the derivatives of 1/x times x on [1, 2) are at most 1, 2, 6; an entry of at least ½
        // rounds by 2^−(frac + 1), relative to it twice that. A Newton step squares the error; its two
        // roundings of 2^−31 cost 2^−29.
        let mut recip = table(t.recip, 1, [1.0, 2.0, 6.0], 2.0);
        for _ in 0..t.recip.newton {
            recip = recip * recip + power(29);
        }
        // 1/√x on a binade scaled to [1, 2): ½, ¾, 15/8. A step leaves 3/2·e² + ½·e³.
        let mut rsqrt = table(t.rsqrt, 2, [0.5, 0.75, 1.875], 2.0);
        for _ in 0..t.rsqrt.newton {
            rsqrt = rsqrt * rsqrt * (1.5 + 0.5 * rsqrt) + power(28);
        }
        // √x: ½, ¼, ⅜, entries ≥ 1. A step with 1/√x off by r leaves e²/2 + r(e + e²/2).
        let mut sqrt = table(t.sqrt, 2, [0.5, 0.25, 0.375], 1.0);
        for _ in 0..t.sqrt.newton {
            sqrt = sqrt * sqrt / 2.0 + rsqrt * (sqrt + sqrt * sqrt / 2.0) + power(30);
        }
        // log2 x: 1/ln 2 times 1, 1, 2.
        let ln = std::f64::consts::LOG2_E;
        let log2 = table(t.log2, 1, [ln, ln, 2.0 * ln], 1.0);
        // Arguments are cut to 30 fraction bits.
        Self {
            recip: recip + power(30),
            rsqrt: rsqrt + power(31),
            sqrt: sqrt + power(31),
            log2: log2 + 2.0 * power(30),
        }
    }
}
