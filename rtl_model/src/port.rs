//! Input ports: binary64 words become normalised registers.
//!
//! A port takes the 64 bits of an IEEE 754 binary64 number. The vectors n, v and h are each
//! normalised by one power of two, taken from their largest component; derivatives shift with their
//! vector. One rounding, that of the register.

use crate::fx::{Block, Quantizer};

/// sign·mantissa and exponent of a binary64 word: value = m · 2^e; `false` where it is not finite
/// (±∞ reads as the largest finite number, NaN as 0).
#[inline(always)]
#[must_use]
pub fn unpack(word: u64) -> (i64, i64, bool) {
    let biased = (word >> 52) & 0x7ff;
    let fraction = word & ((1 << 52) - 1);
    let (magnitude, biased, finite) = match biased {
        0 => (fraction, 1, true),
        0x7ff if fraction == 0 => ((1 << 53) - 1, 0x7fe, false),
        0x7ff => (0, 1, false),
        _ => (fraction | 1 << 52, biased, true),
    };
    let m = magnitude.cast_signed();
    let m = if word >> 63 == 1 { -m } else { m };
    (m, biased.cast_signed() - 1075, finite)
}

/// A vector of words normalised into the block register `q`, and whether all were finite.
#[inline(always)]
#[must_use]
pub fn vector<const C: usize>(standard: bool, q: &Quantizer, words: [u64; C]) -> (Block<C>, bool) {
    let mut top = i64::MIN;
    let mut finite = true;
    let parts = words.map(unpack);
    for (m, e, f) in parts {
        finite &= f;
        if m != 0 {
            top = top.max(e + 63 - i64::from(m.unsigned_abs().leading_zeros()));
        }
    }
    let width = q.bits();
    if top == i64::MIN {
        return (Block { m: [0; C], frac: width - 1 }, finite);
    }
    let lsb = top + 1 - width;
    let max = q.format.max_raw();
    let m = parts.map(|(m, e, _)| {
        let shift = (lsb - e).min(62);
        q.round_as(standard, m, shift).clamp(-max, max)
    });
    (Block { m, frac: -lsb }, finite)
}

/// One word written to the fixed register `q` after division by 2^`exponent`: code, overflow, finite.
#[inline(always)]
#[must_use]
pub fn scalar(standard: bool, q: &Quantizer, word: u64, exponent: i64) -> (i64, bool, bool) {
    let (m, e, finite) = unpack(word);
    // Every shift beyond 62 leaves nothing of 53 bits but, for some roundings, a sign.
    let shift = exponent - e - q.frac();
    let shift = if standard { shift.min(62) } else { shift };
    let (code, over) = q.write_as(standard, m, shift);
    (code, over, finite)
}
