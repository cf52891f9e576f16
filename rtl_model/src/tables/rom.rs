//! Tables over one or two binades: address, interpolation, Newton steps.

use alloc::vec::Vec;

use lanes::Vector;

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

    /// The interpolated values for `t` in [0, 1) of the binade whose run starts at `base`, `PORT_FRAC` bits in and out.
    #[inline(always)]
    fn interpolate<V: Vector>(&self, base: V, t: V) -> V {
        let rest_bits = P - self.log_intervals;
        let (interval, rest) = (t.down(rest_bits), t.and((1 << rest_bits) - 1));
        let lift = P - i64::from(self.spec.frac);
        match self.spec.order {
            0 => (base + interval).look_up(&self.values).up(lift),
            1 => {
                let k = base + interval;
                let (a, b) = (k.look_up(&self.values), k.plus(1).look_up(&self.values));
                shift_round(a.up(rest_bits) + (b - a).mul(rest), rest_bits - lift)
            }
            _ => {
                let (k, r) = (base + interval.up(1), rest.up(self.log_intervals));
                let (a, m) = (k.look_up(&self.values), k.plus(1).look_up(&self.values));
                let b = k.plus(2).look_up(&self.values);
                let square = r.mul(r).down(P);
                let (first, second) = (m.up(2) - a.up(1) - a - b, (a - m.up(1) + b).up(1));
                shift_round(a.up(P) + first.mul(r) + second.mul(square), P - lift)
            }
        }
    }

    /// 1/x for x in [1, 2) with `PORT_FRAC` bits; result in (½, 1].
    #[inline(always)]
    #[must_use]
    pub fn recip<V: Vector>(&self, x: V) -> V {
        let mut y = self.interpolate(x.like(0), x.plus(-ONE));
        for _ in 0..self.spec.newton {
            let e = x.like(2 * ONE) - shift_round(x.mul_unsigned(y), P);
            y = shift_round(y.mul_unsigned(e), P);
        }
        y
    }

    /// 1/√x for x in [1, 4) with `PORT_FRAC` bits; result in (½, 1].
    #[inline(always)]
    #[must_use]
    pub fn rsqrt<V: Vector>(&self, x: V) -> V {
        let mut y = self.two_binades(x);
        for _ in 0..self.spec.newton {
            let square = shift_round(y.mul_unsigned(y), P);
            let e = x.like(3 * ONE) - shift_round(x.mul_unsigned(square), P);
            y = shift_round(y.mul_unsigned(e), P + 1);
        }
        y
    }

    /// √x for x in [1, 4) with `PORT_FRAC` bits; result in [1, 2]. A Newton step divides by 2√x
    /// through `rsqrt`.
    #[inline(always)]
    #[must_use]
    pub fn sqrt<V: Vector>(&self, x: V, rsqrt: &Self) -> V {
        let mut y = self.two_binades(x);
        if self.spec.newton > 0 {
            let r = rsqrt.rsqrt(x);
            for _ in 0..self.spec.newton {
                let rest = x - shift_round(y.mul_unsigned(y), P);
                y = y + shift_round(rest.mul(r), P + 1);
            }
        }
        y
    }

    /// log2 x for x in [1, 2) with `PORT_FRAC` bits; result in [0, 1].
    #[inline(always)]
    #[must_use]
    pub fn log2<V: Vector>(&self, x: V) -> V {
        self.interpolate(x.like(0), x.plus(-ONE))
    }

    #[inline(always)]
    fn two_binades<V: Vector>(&self, x: V) -> V {
        let upper = x.down(P + 1);
        let run = x.like(i64::try_from(self.run).unwrap_or(0));
        self.interpolate(-upper & run, x.sra(upper).plus(-ONE))
    }
}

/// x·2^−shift to nearest, ties up; the table ports' internal rounding. Shift ≥ 0.
#[inline(always)]
fn shift_round<V: Vector>(x: V, shift: i64) -> V {
    if shift <= 0 {
        return x.up(-shift);
    }
    x.plus(1 << (shift - 1)).down(shift)
}

/// A positive integer as mantissa in [1, 2) with `PORT_FRAC` bits and its power of two:
/// x = m · 2^e. Bits below 2^−30 of the mantissa are dropped.
#[inline(always)]
#[must_use]
pub fn mantissa<V: Vector>(x: V) -> (V, V) {
    let zeros = x.leading_zeros();
    (x.shl(zeros).shr(x.like(63 - P)), x.like(63) - zeros)
}

/// A positive integer as m·4^q, m in [1, 4) with `PORT_FRAC` bits.
#[inline(always)]
#[must_use]
pub fn mantissa4<V: Vector>(x: V) -> (V, V) {
    let q = (x.like(63) - x.leading_zeros()).down(1);
    (x.shl(x.like(62) - q.up(1)).shr(x.like(62 - P)), q)
}
