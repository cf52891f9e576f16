//! Propagation and conversion of many cones: 64-bit words, no branch, the bits of [`super::exact::sum2`].
//!
//! [`propagate`] takes one cone of any codes; [`propagate_block`] takes many at a time in loops that become vector code
//! and leaves subnormal numbers, infinities and NaN to the former.
//!
//! For codes of at most 16 bits and distances in binary32 a product has at most 35 bits. Both terms
//! put their leading one on bit 61, which leaves 26 bits for what an alignment shifts out; below them
//! the last bit is set if anything was lost.

use super::small::{SmallFloat, StoreRounding};
use super::{Angle, Cone, Width};

/// Exponent of a term that is zero: below every other one.
const NOTHING: i64 = -100_000;

/// A code as magnitude and exponent; ∞ is the largest number, NaN is 0.
#[inline(always)]
fn unpack(format: SmallFloat, code: u32) -> (bool, u64, i64) {
    let infinite = format.largest() + 1;
    let raw = code & (format.sign() - 1);
    let raw = if raw == infinite { raw - 1 } else { raw };
    let raw = if raw > infinite { 0 } else { raw };
    let biased = raw >> format.mantissa_bits;
    let hidden = 1u32 << format.mantissa_bits;
    let m = (raw & (hidden - 1)) | if biased == 0 { 0 } else { hidden };
    (code & format.sign() != 0, u64::from(m), i64::from(biased.max(1)) - 1)
}

/// Puts the leading one on bit 61.
#[inline(always)]
fn normal(m: u64, e: i64) -> (u64, i64) {
    let shift = m.leading_zeros().saturating_sub(2).min(61);
    let e = if m == 0 { NOTHING } else { e - i64::from(shift) };
    (m << shift, e)
}

/// Rounds a magnitude whose leading one is bit 61, or 0.
#[inline(always)]
fn store(format: SmallFloat, rounding: StoreRounding, random: u32, m: u64, e: i64) -> (u32, bool) {
    let lowest = format.lowest_exponent();
    let lsb = (e + 61 - i64::from(format.mantissa_bits)).max(lowest);
    let down = lsb - e;
    let shift = down.min(63);
    let kept = m >> shift;
    let steps = match rounding {
        StoreRounding::Rne => {
            let half = 1u64 << (shift - 1);
            (m + (half - 1) + (kept & 1)) >> shift
        }
        StoreRounding::Truncate => kept,
        StoreRounding::Stochastic => {
            let rest = m - (kept << shift);
            let fraction = rest >> (down - 32).min(63);
            kept + u64::from(u64::from(random) < fraction)
        }
    };
    let binade = (lsb - lowest).unsigned_abs();
    let magnitude = (binade << format.mantissa_bits) + steps;
    let magnitude = if m == 0 { 0 } else { magnitude };
    let largest = u64::from(format.largest());
    let saturated = magnitude > largest;
    (u32::try_from(magnitude.min(largest)).unwrap_or(0), saturated)
}

/// A binary32 code as one of a format of at most 16 bits, and whether it saturated.
#[inline(always)]
#[must_use]
pub fn convert(format: SmallFloat, rounding: StoreRounding, random: u32, code: u32) -> (u32, bool) {
    let (negative, m, e) = unpack(SmallFloat::F32, code);
    let (m, e) = normal(m, e + SmallFloat::F32.lowest_exponent());
    let (magnitude, saturated) = store(format, rounding, random, m, e);
    let sign = if negative && magnitude != 0 { format.sign() } else { 0 };
    (magnitude | sign, saturated)
}

/// A cone moved by the distance with the binary32 code `distance`, and whether the width saturated.
///
/// `format` must have at most 16 bits. The result is that of the stage's `propagate`.
#[inline(always)]
#[must_use]
pub fn propagate(
    format: SmallFloat,
    rounding: StoreRounding,
    random: u32,
    cone: Cone,
    distance: u32,
) -> (Cone, bool) {
    let lowest = format.lowest_exponent();
    let (a_negative, am, ae) = unpack(format, cone.angle.0);
    let (w_negative, wm, we) = unpack(format, cone.width.0);
    let (d_negative, dm, de) = unpack(SmallFloat::F32, distance);
    let (pm, pe) = normal(am * dm, ae + de + lowest + SmallFloat::F32.lowest_exponent());
    let p_negative = a_negative != d_negative;
    let (wm, we) = normal(wm, we + lowest);
    let product_first = pe >= we;
    let (big, big_e, big_negative) =
        if product_first { (pm, pe, p_negative) } else { (wm, we, w_negative) };
    let (small, small_e) = if product_first { (wm, we) } else { (pm, pe) };
    let shift = (big_e - small_e).min(63);
    let moved = small >> shift;
    let moved = moved | u64::from(moved << shift != small);
    let difference = big.cast_signed() - moved.cast_signed();
    let opposite = p_negative != w_negative;
    let m = if opposite { difference.unsigned_abs() } else { big + moved };
    let negative = (big_negative != (opposite && difference < 0)) && m != 0;
    let e = big_e;
    // A sum of two may have its leading one on bit 62.
    let carried = m >> 62;
    let m = (m >> carried) | (m & carried);
    let (m, e) = normal(m, e + carried.cast_signed());
    let (magnitude, saturated) = store(format, rounding, random, m, e);
    let sign = |negative: bool, magnitude: u32| {
        if negative && magnitude != 0 { magnitude | format.sign() } else { magnitude }
    };
    // A converging cone whose width has passed zero diverges.
    let a_magnitude = {
        let infinite = format.largest() + 1;
        let raw = format.abs(cone.angle.0);
        let raw = if raw == infinite { raw - 1 } else { raw };
        if raw > infinite { 0 } else { raw }
    };
    let a_negative = a_negative && am != 0;
    let flip = a_negative && negative;
    (
        Cone {
            angle: Angle(sign(a_negative && !flip, a_magnitude)),
            width: Width(sign(negative && !flip, magnitude)),
        },
        saturated,
    )
}

/// Cones that [`propagate_block`] takes.
pub const BLOCK: usize = 32;

/// A magnitude's fields: significand with its hidden one (0 for 0) and biased exponent; whether the code is one that
/// blocks leave alone.
#[inline(always)]
fn normal_fields(format: SmallFloat, code: u32) -> (u64, u64, bool) {
    let raw = u64::from(code & (format.sign() - 1));
    let biased = raw >> format.mantissa_bits;
    let hidden = 1u64 << format.mantissa_bits;
    let top = (1u64 << format.exponent_bits) - 1;
    let zero = raw == 0;
    let m = (raw & (hidden - 1)) | hidden;
    let odd = (biased == 0) & !zero | (biased == top);
    (if zero { 0 } else { m }, biased, odd)
}

/// Moves each cone by the distance with the binary32 code of the same index. `random` decides where the rounding is
/// stochastic. False, and nothing changed, where a number is subnormal, infinite or NaN.
///
/// The leading ones of both terms are on bit 58 or 59: products of significands need no search for theirs.
#[inline(always)]
#[must_use]
pub fn propagate_block(
    format: SmallFloat,
    rounding: StoreRounding,
    random: &[u32; BLOCK],
    cones: &mut [Cone; BLOCK],
    distances: &[u32; BLOCK],
) -> bool {
    const LOW: u64 = 0xffff_ffff;
    let mantissa = format.mantissa_bits;
    let signed = i64::from(mantissa);
    let lowest = format.lowest_exponent();
    let product_lift = 35 - mantissa;
    let width_lift = 59 - mantissa;
    let product_exponent = lowest + SmallFloat::F32.lowest_exponent() - 2 - (35 - signed);
    let width_exponent = lowest - 1 - (59 - signed);
    let sign_bit = u64::from(format.sign());
    let largest = u64::from(format.largest());
    let mut strange = false;
    let mut angles = [0u64; BLOCK];
    let mut widths = [0u64; BLOCK];
    for i in 0..BLOCK {
        let (angle, width) = (cones[i].angle.0, cones[i].width.0);
        let (am, ae, a_odd) = normal_fields(format, angle);
        let (wm, we, w_odd) = normal_fields(format, width);
        let (dm, de, d_odd) = normal_fields(SmallFloat::F32, distances[i]);
        strange |= a_odd | w_odd | d_odd;
        let product = ((am & LOW) * (dm & LOW)) << product_lift;
        let pe = (ae + de).cast_signed() + product_exponent;
        let pe = if product == 0 { NOTHING } else { pe };
        let other = wm << width_lift;
        let we = we.cast_signed() + width_exponent;
        let we = if other == 0 { NOTHING } else { we };
        let sign_of = |code: u32, format: SmallFloat| u64::from(code & format.sign() != 0);
        let a_sign = sign_of(angle, format) & u64::from(am != 0);
        let p_sign = sign_of(angle, format) ^ sign_of(distances[i], SmallFloat::F32);
        let w_sign = sign_of(width, format);
        let product_first = pe >= we;
        let big = if product_first { product } else { other };
        let small = if product_first { other } else { product };
        let e = if product_first { pe } else { we };
        let low_e = if product_first { we } else { pe };
        let shift = (e - low_e).min(63).cast_unsigned();
        let kept = small >> shift;
        let moved = kept | u64::from(kept << shift != small);
        let opposite = p_sign ^ w_sign;
        // big − moved or big + moved; a negative difference turns the sign.
        let flip = 0u64.wrapping_sub(opposite);
        let sum = big.wrapping_add((moved ^ flip).wrapping_sub(flip));
        let below = (sum >> 63) & opposite;
        let turn = 0u64.wrapping_sub(below);
        let mut m = (sum ^ turn).wrapping_sub(turn);
        let big_sign = if product_first { p_sign } else { w_sign };
        let negative = (big_sign ^ below) & u64::from(m != 0);
        let mut e = if m == 0 { NOTHING } else { e };
        // The leading one to bit 61.
        for step in [32u32, 16, 8, 4, 2, 1] {
            let lower = m >> (62 - step) == 0;
            m <<= if lower { step } else { 0 };
            e -= if lower { i64::from(step) } else { 0 };
        }
        let lsb = (e + 61 - signed).max(lowest);
        let down = lsb - e;
        let shift = down.min(63).cast_unsigned();
        let kept = m >> shift;
        let steps = match rounding {
            StoreRounding::Rne => {
                let half = 1u64 << (shift - 1);
                (m + (half - 1) + (kept & 1)) >> shift
            }
            StoreRounding::Truncate => kept,
            StoreRounding::Stochastic => {
                let rest = m - (kept << shift);
                let fraction = rest >> (down - 32).min(63).cast_unsigned();
                kept + u64::from(u64::from(random[i]) < fraction)
            }
        };
        let magnitude = ((lsb - lowest).cast_unsigned() << mantissa) + steps;
        let magnitude = if m == 0 { 0 } else { magnitude.min(largest) };
        // A converging cone whose width has passed zero diverges.
        let passed = a_sign & negative;
        let a_sign = if (a_sign & !passed) != 0 { sign_bit } else { 0 };
        let w_sign = (negative & !passed) != 0 && magnitude != 0;
        angles[i] = (u64::from(angle) & (sign_bit - 1)) | a_sign;
        widths[i] = magnitude | if w_sign { sign_bit } else { 0 };
    }
    if strange {
        return false;
    }
    for (cone, (angle, width)) in cones.iter_mut().zip(angles.into_iter().zip(widths)) {
        cone.angle = Angle(u32::try_from(angle & LOW).unwrap_or(0));
        cone.width = Width(u32::try_from(width & LOW).unwrap_or(0));
    }
    true
}
