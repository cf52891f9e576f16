//! Tables over one or two binades: address, interpolation, Newton steps.

mod lanes;

use alloc::vec::Vec;

use super::contents;

/// Fraction bits of a table's argument and result ports.
pub const PORT_FRAC: u32 = 30;
const P: i64 = 30;
const ONE: i64 = 1 << PORT_FRAC;

/// The contents of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Function {
    /// 1/x on [1, 2).
    Recip,
    /// 1/√x on [1, 4): half of the entries for each binade.
    Rsqrt,
    /// √x on [1, 4): half of the entries for each binade.
    Sqrt,
    /// log2 x on [1, 2).
    Log2,
}

/// Knobs of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TableSpec {
    /// Intervals (a power of two; for the angle table an even number over 90°).
    pub entries: u32,
    /// 0: interval midpoints; 1: linear between ends; 2: quadratic through ends and midpoint.
    pub order: u32,
    /// Fraction bits of an entry.
    pub frac: u32,
    /// Newton steps after the look-up.
    pub newton: u32,
}

/// A table and its address logic.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rom {
    /// Which function.
    pub function: Function,
    /// Knobs.
    pub spec: TableSpec,
    /// Entries: `entries` (order 0), `entries + 1` (1) or `2·entries + 1` (2), with `spec.frac`
    /// fraction bits. With order 1 and 2 a table over two binades holds two runs of
    /// `entries/2 + 1` or `entries + 1`.
    pub values: Vec<i64>,
    log_intervals: i64,
    run: usize,
}

impl Rom {
    /// Builds the table; `None` where an entry cannot be rounded correctly in the series' width.
    #[must_use]
    pub fn new(function: Function, spec: TableSpec) -> Option<Self> {
        let binades = match function {
            Function::Recip | Function::Log2 => 1,
            Function::Rsqrt | Function::Sqrt => 2,
        };
        let per_binade = spec.entries / binades;
        let mut values = Vec::new();
        for binade in 0..binades {
            // Points in units of 1/(2·per_binade) of the binade's start.
            let (first, last, step) = match spec.order {
                0 => (1, 2 * per_binade, 2),
                1 => (0, 2 * per_binade + 1, 2),
                _ => (0, 2 * per_binade + 1, 1),
            };
            let mut i = first;
            while i < last {
                let q = u64::from(2 * per_binade);
                let p = (q + u64::from(i)) << binade;
                let value = match function {
                    Function::Recip => contents::recip(p, q, spec.frac),
                    Function::Rsqrt => contents::rsqrt(p, q, spec.frac),
                    Function::Sqrt => contents::sqrt(p, q, spec.frac),
                    Function::Log2 => contents::log2(p, q, spec.frac)?,
                };
                values.push(i64::try_from(value).ok()?);
                i += step;
            }
        }
        let run = values.len() / usize::try_from(binades).ok()?;
        Some(Self { function, spec, values, log_intervals: i64::from(per_binade.ilog2()), run })
    }

    /// Table bits: entries times entry width (one integer bit).
    #[must_use]
    pub fn bits(&self) -> u64 {
        u64::try_from(self.values.len()).unwrap_or(u64::MAX) * u64::from(self.spec.frac + 1)
    }

    /// The interpolated value for `t` in [0, 1) of a binade, `PORT_FRAC` bits in and out.
    #[inline(always)]
    fn interpolate(&self, binade: usize, t: i64) -> i64 {
        let rest_bits = P - self.log_intervals;
        let interval = to_index(t >> rest_bits);
        let lift = P - i64::from(self.spec.frac);
        let base = binade * self.run;
        let at = |k: usize| self.values.get(base + k).copied().unwrap_or(0);
        match self.spec.order {
            0 => at(interval) << lift,
            1 => {
                let r = t & ((1 << rest_bits) - 1);
                let (a, b) = (at(interval), at(interval + 1));
                shift_round((a << rest_bits) + (b - a) * r, rest_bits - lift)
            }
            _ => {
                let r = (t & ((1 << rest_bits) - 1)) << self.log_intervals;
                let k = 2 * interval;
                let (a, m, b) = (at(k), at(k + 1), at(k + 2));
                let square = (r * r) >> P;
                let sum = (a << P) + (4 * m - 3 * a - b) * r + (2 * a - 4 * m + 2 * b) * square;
                shift_round(sum, P - lift)
            }
        }
    }

    /// 1/x for x in [1, 2) with `PORT_FRAC` bits; result in (½, 1].
    #[inline(always)]
    #[must_use]
    pub fn recip(&self, x: i64) -> i64 {
        let mut y = self.interpolate(0, x - ONE);
        for _ in 0..self.spec.newton {
            let e = 2 * ONE - shift_round(x * y, P);
            y = shift_round(y * e, P);
        }
        y
    }

    /// 1/√x for x in [1, 4) with `PORT_FRAC` bits; result in (½, 1].
    #[inline(always)]
    #[must_use]
    pub fn rsqrt(&self, x: i64) -> i64 {
        let mut y = self.two_binades(x);
        for _ in 0..self.spec.newton {
            let e = 3 * ONE - shift_round(x * shift_round(y * y, P), P);
            y = shift_round(y * e, P + 1);
        }
        y
    }

    /// √x for x in [1, 4) with `PORT_FRAC` bits; result in [1, 2]. A Newton step divides by 2√x
    /// through `rsqrt`.
    #[inline(always)]
    #[must_use]
    pub fn sqrt(&self, x: i64, rsqrt: &Self) -> i64 {
        let mut y = self.two_binades(x);
        if self.spec.newton > 0 {
            let r = rsqrt.rsqrt(x);
            for _ in 0..self.spec.newton {
                let rest = x - shift_round(y * y, P);
                y += shift_round(rest * r, P + 1);
            }
        }
        y
    }

    /// log2 x for x in [1, 2) with `PORT_FRAC` bits; result in [0, 1].
    #[inline(always)]
    #[must_use]
    pub fn log2(&self, x: i64) -> i64 {
        self.interpolate(0, x - ONE)
    }

    #[inline(always)]
    fn two_binades(&self, x: i64) -> i64 {
        if x < 2 * ONE { self.interpolate(0, x - ONE) } else { self.interpolate(1, (x >> 1) - ONE) }
    }
}

/// x·2^−shift to nearest, ties up; the table ports' internal rounding. Shift ≥ 0.
#[inline(always)]
fn shift_round(x: i64, shift: i64) -> i64 {
    if shift <= 0 {
        return x << -shift;
    }
    (x + (1 << (shift - 1))) >> shift
}

/// A table index; never negative by construction.
#[inline(always)]
fn to_index(x: i64) -> usize {
    usize::try_from(x).unwrap_or(0)
}

/// A positive integer as mantissa in [1, 2) with `PORT_FRAC` bits and its power of two:
/// x = m · 2^e. Bits below 2^−30 of the mantissa are dropped.
#[inline(always)]
#[must_use]
pub fn mantissa(x: i64) -> (i64, i64) {
    let e = 63 - i64::from(x.leading_zeros());
    let m = if e > P { x >> (e - P) } else { x << (P - e) };
    (m, e)
}

/// A positive integer as m·4^q, m in [1, 4) with `PORT_FRAC` bits.
#[inline(always)]
#[must_use]
pub fn mantissa4(x: i64) -> (i64, i64) {
    let q = (63 - i64::from(x.leading_zeros())) >> 1;
    let s = 2 * q - P;
    let m = if s > 0 { x >> s } else { x << -s };
    (m, q)
}
