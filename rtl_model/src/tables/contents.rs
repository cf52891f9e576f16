//! Correctly rounded table contents by integer arithmetic.

/// ⌊√x⌋.
#[must_use]
pub fn isqrt(x: u128) -> u128 {
    x.isqrt()
}

/// p/q rounded to the nearest integer, ties to even.
#[must_use]
pub fn div_half_even(p: u128, q: u128) -> u128 {
    let (floor, rest) = (p / q, p % q);
    let up = match (rest * 2).cmp(&q) {
        core::cmp::Ordering::Less => false,
        core::cmp::Ordering::Equal => floor & 1 == 1,
        core::cmp::Ordering::Greater => true,
    };
    floor + u128::from(up)
}

/// 1/(p/q) · 2^frac.
#[must_use]
pub fn recip(p: u64, q: u64, frac: u32) -> u128 {
    div_half_even(u128::from(q) << frac, u128::from(p))
}

/// √(p/q) · 2^frac, for p/q < 2^16, q ≤ 2^20, frac ≤ 30.
#[must_use]
pub fn sqrt(p: u64, q: u64, frac: u32) -> u128 {
    // √ of ⌊p·4^(frac+1)/q⌋ has the same floor as √ of the fraction itself.
    let scaled = u128::from(p) << (2 * (frac + 1));
    let twice = isqrt(scaled / u128::from(q));
    let exact = twice * twice * u128::from(q) == scaled;
    round_twice(twice, exact)
}

/// 1/√(p/q) · 2^frac.
#[must_use]
pub fn rsqrt(p: u64, q: u64, frac: u32) -> u128 {
    sqrt(q, p, frac)
}

/// log2(p/q) · 2^frac for 1 ≤ p/q ≤ 2, by repeated squaring of an interval.
///
/// Each squaring doubles the logarithm: a square ≥ 2 yields a 1 and is halved. The interval's ends
/// must agree on every bit; the width starts at 2^−62 and doubles with each of the ≤ 31 squarings,
/// and no table point other than 1 and 2 comes that near to a power 2^(k/2^j).
#[must_use]
pub fn log2(p: u64, q: u64, frac: u32) -> Option<u128> {
    if p == q {
        return Some(0);
    }
    if p == 2 * q {
        return Some(1 << frac);
    }
    const ONE: u128 = 1 << 62;
    let mut low = (u128::from(p) << 62) / u128::from(q);
    let mut high = low + 1;
    let mut twice = 0;
    for _ in 0..=frac {
        low = (low * low) >> 62;
        high = ((high * high) >> 62) + 1;
        match (low >= 2 * ONE, high >= 2 * ONE) {
            (false, false) => twice *= 2,
            (true, true) => {
                twice = twice * 2 + 1;
                low >>= 1;
                high = (high >> 1) + 1;
            }
            _ => return None,
        }
    }
    // The logarithm of a rational that is no power of two is irrational: there is no tie.
    Some(round_twice(twice, false))
}

/// Rounds t/2 to nearest; `exact` says that t has no remainder, so that an odd t is a tie.
fn round_twice(twice: u128, exact: bool) -> u128 {
    let floor = twice >> 1;
    let up = twice & 1 == 1 && (!exact || floor & 1 == 1);
    floor + u128::from(up)
}

/// Fraction bits of the series.
const SERIES_FRAC: u32 = 60;
/// ⌊π · 2^60⌋.
const PI: i128 = 3_622_009_729_038_561_421;

/// Half the width of the interval that the series returns, in units of 2^−60: each of the ≤ 16 terms
/// loses < 2 by its two floors, and the argument is off by < 2.
const SERIES_ERROR: i128 = 64;

/// Sine or cosine of π·p/q (0 ≤ p/q ≤ 1/2) with 60 fraction bits, off by at most `SERIES_ERROR`.
fn series(p: u32, q: u32, cosine: bool) -> i128 {
    let x = PI * i128::from(p) / i128::from(q);
    let square = (x * x) >> SERIES_FRAC;
    let mut term = if cosine { 1i128 << SERIES_FRAC } else { x };
    let mut sum = term;
    let mut k = if cosine { 1 } else { 2 };
    while term != 0 && k < 40 {
        term = -(((term * square) >> SERIES_FRAC) / (k * (k + 1)));
        sum += term;
        k += 2;
    }
    sum
}

/// sin(π·p/q) · 2^frac or cos(π·p/q) · 2^frac, 0 ≤ p/q ≤ 1/2, frac ≤ 40, correctly rounded.
///
/// 0, ½ and 1 are exact; every other value is irrational or far from a tie, and `None` says that
/// 60 bits do not decide it.
#[must_use]
pub fn sin_cos(p: u32, q: u32, cosine: bool, frac: u32) -> Option<i64> {
    let value = series(p, q, cosine);
    let drop = SERIES_FRAC - frac;
    let half = 1i128 << (drop - 1);
    let low = (value - SERIES_ERROR + half) >> drop;
    let high = (value + SERIES_ERROR + half) >> drop;
    if low == high { i64::try_from(low).ok() } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn division_rounds_ties_to_even() {
        assert_eq!(div_half_even(5, 2), 2);
        assert_eq!(div_half_even(7, 2), 4);
        assert_eq!(div_half_even(8, 3), 3);
        assert_eq!(div_half_even(7, 3), 2);
    }

    #[test]
    fn roots_satisfy_their_definition_within_half_an_lsb() {
        // (2r − 1)² q ≤ 4·p·4^frac ≤ (2r + 1)² q is |r − √(p/q)·2^frac| ≤ ½.
        for frac in [4, 12, 28] {
            for p in (1u64 << 8)..(1 << 10) {
                let q = 1u64 << 8;
                let four = u128::from(p) << (2 * frac + 2);
                let r = sqrt(p, q, frac);
                assert!((2 * r - 1).pow(2) * u128::from(q) <= four);
                assert!((2 * r + 1).pow(2) * u128::from(q) >= four);
                let four = u128::from(q) << (2 * frac + 2);
                let r = rsqrt(p, q, frac);
                assert!((2 * r - 1).pow(2) * u128::from(p) <= four);
                assert!((2 * r + 1).pow(2) * u128::from(p) >= four);
            }
        }
    }

    #[test]
    fn log2_of_every_table_point_is_decided_and_inverts() {
        for frac in [8, 16, 28] {
            for entries in [2u64, 64, 4096] {
                let mut before = None;
                for i in 0..=2 * entries {
                    let value = log2(2 * entries + i, 2 * entries, frac);
                    assert!(value.is_some(), "log2 of 1 + {i}/{} at {frac} bits", 2 * entries);
                    assert!(before <= value);
                    before = value;
                }
                assert_eq!(before, Some(1 << frac));
            }
        }
        // log2 3 − 1 = 0.100101011100000000011010001110011111010110110101… in binary.
        assert_eq!(log2(3, 2, 17), Some(0b1_0010_1011_1000_0000));
    }

    #[test]
    fn sine_and_cosine_are_decided_and_lie_on_the_unit_circle() {
        for n in [2u32, 4, 10, 32, 90, 1024] {
            for k in 0..=n {
                for frac in [4, 16, 20, 28] {
                    let s = sin_cos(k, 2 * n, false, frac);
                    let c = sin_cos(k, 2 * n, true, frac);
                    let (Some(s), Some(c)) = (s, c) else {
                        panic!("sin or cos of π·{k}/{} is undecided at {frac} bits", 2 * n)
                    };
                    // |s − S| ≤ ½, |c − C| ≤ ½, S² + C² = R²: |s² + c² − R²| ≤ √2·R + ½.
                    let r = 1i64 << frac;
                    let off = (s * s + c * c - r * r).abs();
                    assert!(off * off <= 2 * r * r + 2 * r + 1, "{k}/{n}: {off}");
                }
            }
        }
        assert_eq!(sin_cos(1, 6, false, 20), Some(1 << 19));
        assert_eq!(sin_cos(1, 3, true, 20), Some(1 << 19));
        assert_eq!(sin_cos(1, 2, true, 20), Some(0));
        assert_eq!(sin_cos(1, 2, false, 20), Some(1 << 20));
    }
}
