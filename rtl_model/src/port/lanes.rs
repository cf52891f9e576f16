//! Ports for whole lane arrays: the same bits as [`super::vector`] and [`super::scalar`].
//!
//! The loops take normal numbers and zeros into registers that round half-even and whose range the
//! value keeps to. A block with anything else (a subnormal, an infinity, NaN, an overflow, another
//! rounding) is settled lane by lane.

use super::{scalar, vector};
use crate::fx::{Flags, Quantizer, Rounding};
use crate::lanes::{each, fill};
use crate::regs::Register;
use crate::stages::Lanes;

const FRACTION: i64 = (1 << 52) - 1;
const EXPONENT: i64 = 0x7ff;
/// Biased exponent of a number whose last fraction bit is 1.
const UNIT: i64 = 1075;

/// The parts of one component's words that the loops read.
struct Parts<const N: usize> {
    magnitude: [i64; N],
    biased: [i64; N],
    /// All ones where negative.
    sign: [i64; N],
    /// Whether any word is subnormal or not finite.
    special: bool,
}

impl<const N: usize> Parts<N> {
    #[inline(always)]
    fn new(n: usize, words: &[u64; N]) -> Self {
        let mut out = Self { magnitude: [0; N], biased: [0; N], sign: [0; N], special: false };
        let mut special = 0;
        for i in 0..n.min(N) {
            let word = words[i].cast_signed();
            let (biased, fraction) = ((word >> 52) & EXPONENT, word & FRACTION);
            let none = -i64::from(biased == 0);
            special |= (none & fraction) | i64::from(biased == EXPONENT);
            out.magnitude[i] = (fraction | 1 << 52) & !none;
            out.biased[i] = biased;
            out.sign[i] = word >> 63;
        }
        out.special = special != 0;
        out
    }

    /// The magnitude of lane `i` shifted right by 1 to 62 bits, to nearest, ties to even.
    #[inline(always)]
    fn round(&self, i: usize, right: i64) -> i64 {
        let m = self.magnitude[i].cast_unsigned();
        let low = i64::MAX.cast_unsigned() >> ((64 - right) & 63);
        ((m + low + ((m >> (right & 63)) & 1)) >> (right & 63)).cast_signed()
    }

    /// A magnitude with the sign of lane `i`.
    #[inline(always)]
    fn signed(&self, i: usize, magnitude: i64) -> i64 {
        (magnitude ^ self.sign[i]) - self.sign[i]
    }
}

/// [`super::vector`] of every lane. Lanes with a component that is not finite are cleared in `finite`.
#[inline(always)]
pub(crate) fn vector_lanes<const N: usize>(
    n: usize,
    q: &Quantizer,
    words: &[[u64; N]; 3],
    finite: &mut [bool; N],
    out: &mut Lanes<N, 3>,
    frac: &mut [i64; N],
) {
    let width = q.bits();
    let max = q.format.max_raw();
    let [x, y, z] = words;
    let parts = [Parts::new(n, x), Parts::new(n, y), Parts::new(n, z)];
    let top: [i64; N] = each(n, |i| {
        let [x, y, z] = [parts[0].biased[i], parts[1].biased[i], parts[2].biased[i]];
        x.max(y).max(z)
    });
    fill(n, frac, |i| if top[i] == 0 { width - 1 } else { UNIT - 53 + width - top[i] });
    let mut special = q.format.rounding != Rounding::HalfEven;
    for (m, parts) in out.iter_mut().zip(&parts) {
        fill(n, m, |i| {
            let right = (top[i] - parts.biased[i] + 53 - width).min(62);
            parts.signed(i, parts.round(i, right).min(max))
        });
        special |= parts.special;
    }
    if special {
        settle_vector(n, q, [x, y, z], out, frac, finite);
    }
}

/// [`super::scalar`] of every lane: one word each, written after division by 2^exponent.
#[inline(always)]
pub(crate) fn scalar_lanes<const N: usize>(
    n: usize,
    q: &Register,
    words: &[u64; N],
    exponent: &[i64; N],
    finite: &mut [bool; N],
    flags: &mut [Flags],
    out: &mut [i64; N],
) {
    let parts = Parts::new(n, words);
    let (bias, beyond) = (-q.format.min_raw(), !(q.format.max_raw() - q.format.min_raw()));
    let fixed = UNIT - q.frac();
    let mut any = 0;
    for i in 0..n.min(N) {
        // Less than 1 overflows any register of up to 50 bits; beyond 62 nothing is left.
        let right = (exponent[i] + fixed - parts.biased[i]).clamp(1, 62);
        let code = parts.signed(i, parts.round(i, right));
        any |= code + bias;
        out[i] = code;
    }
    let plain = Quantizer::is_standard(q.format) && q.format.magnitude_bits() <= 50;
    if any & beyond != 0 || parts.special || !plain {
        settle_scalar(q, words, exponent, &mut out[..n], finite, flags);
    }
}

#[cold]
#[inline(never)]
fn settle_vector<const N: usize>(
    n: usize,
    q: &Quantizer,
    [x, y, z]: [&[u64; N]; 3],
    out: &mut Lanes<N, 3>,
    frac: &mut [i64; N],
    finite: &mut [bool; N],
) {
    for i in 0..n {
        let (block, all_finite) = vector(false, q, [x[i], y[i], z[i]]);
        finite[i] &= all_finite;
        frac[i] = block.frac;
        for (m, value) in out.iter_mut().zip(block.m) {
            m[i] = value;
        }
    }
}

#[cold]
#[inline(never)]
fn settle_scalar(
    q: &Register,
    words: &[u64],
    exponent: &[i64],
    codes: &mut [i64],
    finite: &mut [bool],
    flags: &mut [Flags],
) {
    let lanes = words.iter().zip(exponent).zip(codes.iter_mut().zip(finite));
    for (i, ((word, exponent), (code, finite))) in lanes.enumerate() {
        let (limited, over, is_finite) = scalar(false, q, *word, *exponent);
        *code = limited;
        *finite &= is_finite;
        if let Some(flags) = flags.get_mut(i) {
            flags.register(q.reg, over);
        }
    }
}
