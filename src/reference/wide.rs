//! Doubles of twice the precision and any exponent, for inputs that plain doubles cannot hold.

use crate::base::num;
use std::cmp::Ordering;
use std::ops::{Add, Div, Mul, Neg, Sub};

use super::real::{Real, saturate, two_product, two_sum};

/// (high + low)·2^exponent with 1 ≤ |high| < 2 and |low| ≤ 2⁻⁵³, or zero.
///
/// Sums, products, quotients and roots are within 2⁻⁹⁹ of the true value, relatively (sums of numbers
/// of opposite sign: of the larger one). Nothing overflows: exponents are 64-bit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wide {
    high: f64,
    low: f64,
    exponent: i64,
}

const ZERO: Wide = Wide { high: 0.0, low: 0.0, exponent: 0 };

/// 2^power for −1022 ≤ power ≤ 1023, else the nearest of those.
fn power_of_two(power: i64) -> f64 {
    let biased = (power.clamp(-1022, 1023) + 1023).unsigned_abs();
    f64::from_bits(biased << 52)
}

/// Exponent of a double that is neither zero nor subnormal.
fn exponent_of(x: f64) -> i64 {
    (x.to_bits() >> 52 & 0x7ff).cast_signed() - 1023
}

impl Wide {
    /// 0.
    pub const ZERO: Self = ZERO;

    /// raw · 2^−frac, exactly.
    #[must_use]
    pub fn code(raw: i64, frac: i64) -> Self {
        #[expect(clippy::cast_precision_loss, reason = "32 bits each")]
        let (high, low) = ((raw >> 32) as f64, (raw & 0xffff_ffff) as f64);
        let high = Self::of_sum(high, 0.0, 32);
        let low = Self::of_sum(low, 0.0, 0);
        (high + low).times_power(-frac)
    }

    /// The value times 2^power.
    #[must_use]
    pub fn times_power(self, power: i64) -> Self {
        if self.high == 0.0 {
            return ZERO;
        }
        Self { exponent: self.exponent + power, ..self }
    }

    /// Renormalises a sum of two doubles, both far from the ends of the range, times 2^exponent.
    fn of_sum(high: f64, low: f64, exponent: i64) -> Self {
        let (high, low) = two_sum(high, low);
        if high == 0.0 {
            return ZERO;
        }
        let shift = exponent_of(high);
        let scale = power_of_two(-shift);
        Self { high: high * scale, low: low * scale, exponent: exponent + shift }
    }
}

impl Neg for Wide {
    type Output = Self;

    fn neg(self) -> Self {
        if self.high == 0.0 {
            return ZERO;
        }
        Self { high: -self.high, low: -self.low, exponent: self.exponent }
    }
}

impl Add for Wide {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let (big, small) = if self.high == 0.0 {
            return other;
        } else if other.high == 0.0 {
            return self;
        } else if self.exponent >= other.exponent {
            (self, other)
        } else {
            (other, self)
        };
        let shift = small.exponent - big.exponent;
        if shift < -200 {
            return big;
        }
        let scale = power_of_two(shift);
        let (high, high_error) = two_sum(big.high, small.high * scale);
        let (low, low_error) = two_sum(big.low, small.low * scale);
        let (high, middle) = two_sum(high, high_error + low);
        Self::of_sum(high, middle + low_error, big.exponent)
    }
}

impl Sub for Wide {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Wide {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let (product, error) = two_product(self.high, other.high);
        let rest = error + (self.high * other.low + self.low * other.high);
        Self::of_sum(product, rest, self.exponent + other.exponent)
    }
}

impl Div for Wide {
    type Output = Self;

    /// Division by zero gives zero: no stage divides by it.
    fn div(self, other: Self) -> Self {
        if self.high == 0.0 || other.high == 0.0 {
            return ZERO;
        }
        let digit = |rest: Self| {
            let quotient = rest.high / other.high;
            Self::of_sum(quotient, 0.0, rest.exponent - other.exponent)
        };
        let first = digit(self);
        let rest = self - first * other;
        let second = digit(rest);
        let third = digit(rest - second * other);
        first + (second + third)
    }
}

impl PartialOrd for Wide {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        (*self - *other).high.partial_cmp(&0.0)
    }
}

impl Real for Wide {
    type Narrow = f64;

    fn narrow(self) -> f64 {
        self.to_f64()
    }

    fn from_f64(value: f64) -> Self {
        // Subnormals first become normal.
        if value.abs() < f64::MIN_POSITIVE {
            Self::of_sum(value * power_of_two(200), 0.0, -200)
        } else {
            let shift = exponent_of(value);
            // Two factors, because 2^1023 has no reciprocal among the normal doubles.
            let half = shift / 2;
            let high = value * power_of_two(-half) * power_of_two(half - shift);
            Self { high, low: 0.0, exponent: shift }
        }
    }

    fn to_f64(self) -> f64 {
        let exponent = num::i32(self.exponent.clamp(-4000, 4000));
        saturate(libm::scalbn(self.high, exponent))
    }

    fn is_beyond_range(self) -> bool {
        self.high != 0.0 && self.exponent > 1023
    }

    fn is_zero(self) -> bool {
        self.high == 0.0
    }

    fn sqrt(self) -> Self {
        if self.high <= 0.0 {
            return ZERO;
        }
        let odd = self.exponent.rem_euclid(2);
        let even = self.exponent - odd;
        let scale = power_of_two(odd);
        let radicand = Self::of_sum(self.high * scale, self.low * scale, 0);
        let root = f64::sqrt(self.high * scale);
        let (square, error) = two_product(root, root);
        let rest = radicand - Self::of_sum(square, error, 0);
        let correction = rest.high * power_of_two(rest.exponent) / (2.0 * root);
        Self::of_sum(root, correction, even / 2)
    }

    fn abs(self) -> Self {
        if self.high < 0.0 { -self } else { self }
    }

    fn product_difference(a: Self, b: Self, c: Self, d: Self) -> Self {
        a * b - c * d
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wide(x: f64) -> Wide {
        Wide::from_f64(x)
    }

    /// An integer of up to 106 bits.
    fn whole(x: i128) -> Wide {
        let high = (x >> 53) as f64;
        let low = (x & ((1 << 53) - 1)) as f64;
        wide(high) * wide(2f64.powi(53)) + wide(low)
    }

    fn integers() -> impl Iterator<Item = (i64, i64)> {
        let mut state = 1u64;
        std::iter::from_fn(move || {
            let mut next = || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                let shift = 11 + (state >> 33) % 50;
                state.cast_signed() >> shift
            };
            Some((next(), next()))
        })
        .take(2000)
    }

    #[test]
    fn sums_and_products_of_integers_are_exact() {
        for (a, b) in integers() {
            let (x, y) = (wide(a as f64), wide(b as f64));
            assert_eq!(x * y, whole(i128::from(a) * i128::from(b)));
            assert_eq!(x + y, whole(i128::from(a) + i128::from(b)));
            assert_eq!(x - y, whole(i128::from(a) - i128::from(b)));
            let square = i128::from(a) * i128::from(a) - i128::from(b) * i128::from(b);
            assert_eq!((x + y) * (x - y), whole(square));
            assert_eq!(Wide::product_difference(x, x, y, y), whole(square));
            assert_eq!(x.partial_cmp(&y), a.partial_cmp(&b));
        }
    }

    #[test]
    fn quotients_and_roots_are_within_2_to_minus_99() {
        let bound = wide(2f64.powi(-99));
        for (a, b) in integers() {
            if a == 0 || b == 0 {
                continue;
            }
            let (x, y) = (wide(a as f64), wide(b as f64));
            assert!(((x / y) * y - x).abs() <= x.abs() * bound, "{a}/{b}");
            let root = x.abs().sqrt();
            assert!((root * root - x.abs()).abs() <= x.abs() * bound, "√|{a}|");
        }
    }

    #[test]
    fn every_kind_of_double_passes_through_unchanged() {
        let ends = [f64::MAX, f64::MIN_POSITIVE, f64::from_bits(1), f64::EPSILON, 1.0, 0.0];
        for x in ends {
            assert_eq!(wide(x).to_f64().to_bits(), x.to_bits());
            assert_eq!(wide(-x).to_f64().to_bits(), (0.0 - x).to_bits());
        }
        for (a, b) in integers() {
            let bits = (a.cast_unsigned() << 12) ^ b.cast_unsigned();
            let x = f64::from_bits(bits);
            if x.is_finite() {
                assert_eq!(wide(x).to_f64().to_bits(), (x + 0.0).to_bits());
            }
        }
    }

    #[test]
    fn powers_beyond_the_range_of_doubles_come_back() {
        let mut x = wide(f64::MAX);
        for _ in 0..20 {
            x = x * x;
        }
        assert!(x.is_beyond_range());
        assert_eq!(x.to_f64().to_bits(), f64::MAX.to_bits());
        assert_eq!((-x).to_f64().to_bits(), (-f64::MAX).to_bits());
        let tiny = wide(1.0) / x;
        assert!(!tiny.is_zero());
        assert_eq!(tiny.to_f64().to_bits(), 0);
        assert_eq!(
            (x * tiny - wide(1.0)).to_f64().abs().max(2f64.powi(-99)).to_bits(),
            2f64.powi(-99).to_bits()
        );
    }
}
