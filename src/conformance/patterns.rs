//! Patterns that arithmetic fails on: exponent classes times significand patterns, and codes at the ends of a register.

use super::field::{Field, Meaning};
use crate::base::num;
use crate::base::random::Random;

/// Exponents of binary64 words at level 1: zero, the subnormals, the ends, around 1, and where registers end.
const EXPONENTS: [u64; 17] =
    [0, 1, 2, 700, 963, 997, 999, 1011, 1021, 1022, 1023, 1024, 1027, 1030, 1083, 1500, 2046];

/// Level 2 has every exponent from 2^−32 to 2^31 besides.
const FIRST: u64 = 1023 - 32;
const MORE: u64 = 64;

/// Significands of a word by number: all zeros, the last bit, all ones, ties of a 23-bit register and their
/// neighbours, alternating bits.
const SIGNIFICANDS: [u64; 9] = [
    0,
    1,
    (1 << 52) - 1,
    1 << 28,
    (1 << 28) + 1,
    (1 << 28) - 1,
    3 << 28,
    0x5_5555_5555_5555,
    0xa_aaaa_aaaa_aaaa,
];

/// How many patterns a number of a field has at a level.
#[must_use]
pub fn count(field: &Field, level: u32) -> u64 {
    match field.meaning {
        Meaning::Word => {
            let significands = if level > 1 { 9 + 2 * 52 } else { 9 };
            let exponents = if level > 1 { 17 + MORE } else { 17 };
            // ±, and ∞, −∞, NaN.
            2 * significands * exponents + 3
        }
        Meaning::Choice(_) | Meaning::Count(..) => {
            let [low, high] = field.range;
            high.abs_diff(low).saturating_add(1).min(64)
        }
        Meaning::Code(_)
        | Meaning::Mantissa(_)
        | Meaning::Fraction(_)
        | Meaning::Power
        | Meaning::Flags(_)
        | Meaning::Small => {
            // 0, both ends with a neighbour, alternating bits; powers of two with neighbours, each sign.
            8 + 6 * u64::from(field.bits) + if level > 1 { 2 * u64::from(field.bits) } else { 0 }
        }
    }
}

/// Pattern `k` of a number.
#[must_use]
pub fn pattern(field: &Field, level: u32, k: u64, random: &mut Random) -> i64 {
    let [low, high] = field.range;
    match field.meaning {
        Meaning::Word => word(level, k).cast_signed(),
        Meaning::Choice(_) | Meaning::Count(..) => {
            let span = high.abs_diff(low).saturating_add(1);
            low + (k % span).cast_signed()
        }
        // A small change of what came: powers far from their mantissas are no case of their own, and K's is even.
        Meaning::Power | Meaning::Fraction(_) => 2 * random.between(-4, 4),
        Meaning::Code(_) | Meaning::Mantissa(_) | Meaning::Flags(_) | Meaning::Small => {
            code(field, k, random).clamp(low, high)
        }
    }
}

/// Binary64 pattern `k`.
fn word(level: u32, k: u64) -> u64 {
    const INFINITY: u64 = 0x7ff << 52;
    match k {
        0 => return INFINITY,
        1 => return INFINITY | 1 << 63,
        2 => return INFINITY | 1 << 51,
        _ => {}
    }
    let k = k - 3;
    let (sign, k) = (k & 1, k >> 1);
    let exponents = 17 + if level > 1 { MORE } else { 0 };
    let (exponent, k) = (k % exponents, k / exponents);
    let exponent =
        EXPONENTS.get(num::usize(exponent)).copied().unwrap_or(FIRST + exponent.saturating_sub(17));
    let significand = match num::usize(k) {
        k if k < 9 => SIGNIFICANDS[k],
        // A walking one, then a walking zero.
        k if k < 61 => 1 << (k - 9),
        k => !(1u64 << (k.min(112) - 61)) & ((1 << 52) - 1),
    };
    sign << 63 | exponent << 52 | significand
}

/// Register pattern `k`.
fn code(field: &Field, k: u64, random: &mut Random) -> i64 {
    let [low, high] = field.range;
    match k {
        0 => 0,
        1 => high,
        2 => high - 1,
        3 => low,
        4 => low + 1,
        5 => 0x5555_5555_5555_5555 & high,
        6 => 0x2aaa_aaaa_aaaa_aaaa & high,
        7 => random.between(low, high),
        _ => {
            let k = k - 8;
            let (bit, kind) = (k / 6 % u64::from(field.bits), k % 6);
            let power = 1i64 << bit.min(62);
            let near = power + num::i64(kind % 3) - 1;
            if kind < 3 { near } else { -near }
        }
    }
}
