//! Block registers: several components with one shared power of two.
//!
//! The mantissas fill the register: the largest component's leading bit lands on the top bit. The
//! shared shift is found by a priority encoder; value = mantissa · 2^−frac with a `frac` that the
//! block carries with it.

use super::quantize::Quantizer;

/// Components that share one exponent: value i = `m[i] · 2^−frac`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Block<const C: usize> {
    /// Mantissas.
    pub m: [i64; C],
    /// Fraction bits of all of them; may be negative.
    pub frac: i64,
}

/// Position of the leading one of the largest magnitude; −1 where all are zero.
#[inline(always)]
#[must_use]
pub fn top_bit<const C: usize>(x: &[i64; C]) -> i64 {
    let mut any = 0u64;
    for value in x {
        any |= value.unsigned_abs();
    }
    63 - i64::from(any.leading_zeros())
}

/// Normalises `x · 2^−frac` into the register `q`: the common shift depends on the largest of all.
///
/// A mantissa that rounds up to the next power of two stays at the largest code (at most ½ LSB
/// more error) and is no overflow.
#[inline(always)]
#[must_use]
pub fn normalize<const C: usize>(
    standard: bool,
    q: &Quantizer,
    x: &[i64; C],
    frac: i64,
) -> Block<C> {
    let top = top_bit(x);
    let width = q.bits();
    let shift = if top < 0 { 0 } else { top + 1 - width };
    shifted(standard, q, x, frac, shift)
}

/// Normalises numbers with fraction bits of their own, each into its register; the narrowest one's bits count for all.
#[inline(always)]
#[must_use]
pub fn gather<const C: usize>(
    standard: bool,
    q: [&Quantizer; C],
    x: &[i64; C],
    frac: &[i64; C],
) -> Block<C> {
    let bits = q.iter().map(|q| q.format.magnitude_bits());
    let width = bits.min().unwrap_or(1);
    let tops = x.iter().zip(frac).filter(|(x, _)| **x != 0);
    let tops = tops.map(|(x, frac)| 63 - i64::from(x.unsigned_abs().leading_zeros()) - frac);
    let lsb = tops.max().unwrap_or(0) + 1 - i64::from(width);
    let max = (1i64 << width) - 1;
    let mut m = [0; C];
    for (((out, &value), frac), q) in m.iter_mut().zip(x).zip(frac).zip(q) {
        let shift = if value == 0 { 0 } else { (lsb + frac).min(62) };
        *out = q.round_as(standard, value, shift).clamp(-max, max);
    }
    Block { m, frac: -lsb }
}

/// Like [`normalize`] with a given shift, for components that must keep an even `frac`.
#[inline(always)]
#[must_use]
pub fn shifted<const C: usize>(
    standard: bool,
    q: &Quantizer,
    x: &[i64; C],
    frac: i64,
    shift: i64,
) -> Block<C> {
    let max = q.format.max_raw();
    let mut m = [0; C];
    for (out, &value) in m.iter_mut().zip(x) {
        *out = q.round_as(standard, value, shift).clamp(-max, max);
    }
    Block { m, frac: frac - shift }
}
