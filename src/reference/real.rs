//! The arithmetic of the front end: plain doubles, or doubles of twice the precision and any exponent.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A real number of the front end. Every operation is total and no result is NaN in its own range.
pub trait Real:
    Copy
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// What is left where a result needs no more than a double: see [`Real::narrow`].
    type Narrow: Narrow;

    /// The same value; −0 becomes +0.
    fn from_f64(value: f64) -> Self;

    /// The nearest double, ±`f64::MAX` beyond the range; −0 becomes +0.
    fn to_f64(self) -> f64;

    /// Whether `to_f64` has to saturate.
    fn is_beyond_range(self) -> bool;

    /// Whether the value is zero.
    fn is_zero(self) -> bool;

    /// The square root of a value that is not negative.
    #[must_use]
    fn sqrt(self) -> Self;

    /// The magnitude.
    #[must_use]
    fn abs(self) -> Self;

    /// The value in the arithmetic of the stages after the axes, ±`f64::MAX` beyond the range of doubles.
    #[must_use]
    fn narrow(self) -> Self::Narrow;

    /// The larger of two, `other` where they are equal.
    #[must_use]
    fn larger(self, other: Self) -> Self {
        if self > other { self } else { other }
    }

    /// How far the value can be from what another arithmetic makes of the same lines; 0 where that is not tracked.
    fn error(self) -> f64 {
        0.0
    }

    /// a·b − c·d with an error of at most a few ulp of the result, whatever cancels.
    #[must_use]
    fn product_difference(a: Self, b: Self, c: Self, d: Self) -> Self;
}

/// The arithmetic behind the axes: numbers that are counted in texels.
pub trait Narrow: Real<Narrow = Self> {
    /// The least whole number that is not below.
    #[must_use]
    fn ceil(self) -> Self;

    /// The largest whole number that is not above.
    #[must_use]
    fn floor(self) -> Self;

    /// The binary logarithm of a positive number.
    #[must_use]
    fn log2(self) -> Self;

    /// ±`f64::MAX` where the value is beyond the range.
    #[must_use]
    fn saturated(self) -> Self;

    /// The next larger number of the arithmetic's format.
    #[must_use]
    fn next_up(self) -> Self;
}

/// The sum of two doubles and its rounding error (Knuth).
#[inline]
pub(super) fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_part = sum - a;
    (sum, (a - (sum - b_part)) + (b - b_part))
}

/// The product of two doubles and its rounding error (Veltkamp and Dekker, without a fused
/// multiply-add). Exact while nothing overflows and the error does not underflow.
#[inline]
pub(super) fn two_product(a: f64, b: f64) -> (f64, f64) {
    let split = |x: f64| {
        let high = 134_217_729.0 * x;
        let high = high - (high - x);
        (high, x - high)
    };
    let product = a * b;
    let ((ah, al), (bh, bl)) = (split(a), split(b));
    (product, ((ah * bh - product) + ah * bl + al * bh) + al * bl)
}

/// A double that is finite and not −0.
#[inline]
pub(super) fn saturate(value: f64) -> f64 {
    value.clamp(-f64::MAX, f64::MAX) + 0.0
}

impl Narrow for f64 {
    #[inline]
    fn ceil(self) -> Self {
        Self::ceil(self)
    }

    #[inline]
    fn floor(self) -> Self {
        Self::floor(self)
    }

    #[inline]
    fn log2(self) -> Self {
        libm::log2(self)
    }

    #[inline]
    fn saturated(self) -> Self {
        saturate(self)
    }

    #[inline]
    fn next_up(self) -> Self {
        Self::next_up(self)
    }
}

impl Real for f64 {
    type Narrow = Self;

    #[inline]
    fn narrow(self) -> Self {
        saturate(self)
    }

    #[inline]
    fn from_f64(value: f64) -> Self {
        value + 0.0
    }

    #[inline]
    fn to_f64(self) -> f64 {
        saturate(self)
    }

    #[inline]
    fn is_beyond_range(self) -> bool {
        self.is_infinite()
    }

    #[inline]
    fn is_zero(self) -> bool {
        self == 0.0
    }

    #[inline]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }

    #[inline]
    fn abs(self) -> Self {
        Self::abs(self)
    }

    #[inline]
    fn product_difference(a: Self, b: Self, c: Self, d: Self) -> Self {
        let (ab, ab_error) = two_product(a, b);
        let (cd, cd_error) = two_product(c, d);
        let (difference, error) = two_sum(ab, -cd);
        difference + (error + (ab_error - cd_error))
    }
}
