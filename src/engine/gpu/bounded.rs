//! Doubles with a bound on the distance of a device's f32 from them: the tolerances of the stage checks.
//!
//! The float reference's stages run in this arithmetic at a kernel's own operands. Every operation adds what WGSL
//! allows it (WGSL, "Floating Point Accuracy") to what its operands bring along; nothing is measured or tuned. ε = 2⁻²³
//! is one unit of the last place, relatively, at worst.
//!
//! | operation | allowed | here |
//! |---|---|---|
//! | + − × | correctly rounded in either direction: the adjacent value | ε |
//! | ÷ | 2.5 ulp for divisors from 2⁻¹²⁶ to 2¹²⁶ | 2.5 ε |
//! | sqrt | as 1/inverseSqrt(x), that 2 ulp | 4.5 ε |
//! | log2 | 2⁻²¹ absolutely from ½ to 2, else 3 ulp | the same |
//! | results below 2⁻¹²⁶ | may become 0 | 2⁻¹²⁶ |
//!
//! A comparison whose two sides are nearer than their errors is one that a device may decide otherwise. It is remembered:
//! [`Bounded::undecided`].

use std::cell::Cell;
use std::cmp::Ordering;
use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::reference::real::{Narrow, Real};

/// One ulp at worst, relatively.
pub const EPSILON: f64 = 1.0 / 8_388_608.0;
/// The least normal f32, 2⁻¹²⁶.
const LEAST: f64 = f32::MIN_POSITIVE as f64;

thread_local! {
    static UNDECIDED: Cell<u32> = const { Cell::new(0) };
}

/// A value and the greatest distance of a device's from it.
#[derive(Clone, Copy, Debug)]
pub struct Bounded {
    /// The value in doubles.
    pub value: f64,
    /// The bound; infinite where the device may have left the range of f32.
    pub error: f64,
}

impl Bounded {
    /// An operand, which the kernel holds exactly.
    #[must_use]
    pub fn exact(value: f64) -> Self {
        let error = if value.abs() < LEAST { value.abs() } else { 0.0 };
        Self { value, error }
    }

    /// A result that the device rounds within `ulps`, with what its operands brought along.
    fn rounded(value: f64, carried: f64, ulps: f64) -> Self {
        let size = value.abs() + carried;
        if value == 0.0 && carried == 0.0 {
            return Self { value, error: 0.0 };
        }
        let flushed = if size < 2.0 * LEAST { LEAST } else { 0.0 };
        let error = carried + ulps * EPSILON * size + flushed;
        let beyond = size + error > f64::from(f32::MAX) || !size.is_finite();
        Self { value, error: if beyond { f64::INFINITY } else { error } }
    }

    /// Times a power of two: exact, unless the result lies below the least normal number, where a device may round it or make it 0.
    #[must_use]
    pub fn scaled(self, power: f64) -> Self {
        let (value, error) = (self.value * power, self.error * power);
        let size = value.abs() + error;
        let flushed = if size > 0.0 && size < 2.0 * LEAST { LEAST } else { 0.0 };
        Self { value, error: error + flushed }
    }

    /// Comparisons since the last call that a device may decide otherwise.
    #[must_use]
    pub fn undecided() -> u32 {
        UNDECIDED.replace(0)
    }

    fn doubt() {
        UNDECIDED.set(UNDECIDED.get().saturating_add(1));
    }

    fn is_exact_zero(self) -> bool {
        self.value == 0.0 && self.error == 0.0
    }

    /// A whole number near the value, in doubt where the error reaches across the step.
    fn whole(self, step: fn(f64) -> f64) -> Self {
        let value = step(self.value);
        #[expect(clippy::float_cmp, reason = "whole numbers")]
        let same = step(self.value - self.error) == value && step(self.value + self.error) == value;
        if !same {
            Self::doubt();
        }
        Self { value, error: 0.0 }
    }
}

impl PartialEq for Bounded {
    fn eq(&self, other: &Self) -> bool {
        self.partial_cmp(other) == Some(Ordering::Equal)
    }
}

impl PartialOrd for Bounded {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        let reach = self.error + other.error;
        if reach > 0.0 && (self.value - other.value).abs() <= reach {
            Self::doubt();
        }
        self.value.partial_cmp(&other.value)
    }
}

impl Add for Bounded {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        if self.is_exact_zero() {
            return other;
        }
        if other.is_exact_zero() {
            return self;
        }
        Self::rounded(self.value + other.value, self.error + other.error, 1.0)
    }
}

impl Sub for Bounded {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + (-other)
    }
}

impl Neg for Bounded {
    type Output = Self;

    fn neg(self) -> Self {
        Self { value: -self.value, error: self.error }
    }
}

impl Mul for Bounded {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        if self.is_exact_zero() || other.is_exact_zero() {
            return Self::exact(0.0);
        }
        let carried = self.value.abs() * other.error
            + other.value.abs() * self.error
            + self.error * other.error;
        Self::rounded(self.value * other.value, carried, 1.0)
    }
}

impl Div for Bounded {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let value = self.value / other.value;
        let divisor = other.value.abs();
        let covered = (LEAST..=1.0 / LEAST).contains(&divisor) && other.error < divisor;
        if !covered {
            return Self { value, error: f64::INFINITY };
        }
        if self.is_exact_zero() {
            return self;
        }
        let carried = (self.error + value.abs() * other.error) / (divisor - other.error);
        Self::rounded(value, carried, 2.5)
    }
}

impl Real for Bounded {
    type Narrow = Self;

    /// A constant of the source: exact where it is an f32, else rounded once.
    fn from_f64(value: f64) -> Self {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::float_cmp,
            reason = "whether a constant is an f32"
        )]
        let exact = f64::from(value as f32) == value;
        if exact { Self::exact(value) } else { Self::rounded(value, 0.0, 1.0) }
    }

    fn to_f64(self) -> f64 {
        self.value
    }

    fn is_beyond_range(self) -> bool {
        !self.value.is_finite()
    }

    fn is_zero(self) -> bool {
        if self.error > 0.0 && self.value.abs() <= self.error {
            Self::doubt();
        }
        self.value == 0.0
    }

    fn sqrt(self) -> Self {
        if self.is_exact_zero() {
            return self;
        }
        let root = self.value.max(0.0).sqrt();
        let least = (self.value - self.error).max(0.0).sqrt();
        let most = (self.value.max(0.0) + self.error).sqrt();
        // Results that are flushed come from radicands below the least normal number.
        Self::rounded(root, (root - least).max(most - root), 4.5)
    }

    fn abs(self) -> Self {
        Self { value: self.value.abs(), error: self.error }
    }

    fn narrow(self) -> Self {
        self
    }

    fn larger(self, other: Self) -> Self {
        Self { value: self.value.max(other.value), error: self.error.max(other.error) }
    }

    fn error(self) -> f64 {
        self.error
    }

    fn product_difference(a: Self, b: Self, c: Self, d: Self) -> Self {
        a * b - c * d
    }
}

impl Narrow for Bounded {
    fn ceil(self) -> Self {
        self.whole(f64::ceil)
    }

    fn floor(self) -> Self {
        self.whole(f64::floor)
    }

    fn log2(self) -> Self {
        let value = libm::log2(self.value);
        let low = self.value - self.error;
        if low <= 0.0 {
            return Self { value, error: f64::INFINITY };
        }
        let carried = value - libm::log2(low);
        let own = if (0.5..=2.0).contains(&low) || (0.5..=2.0).contains(&(self.value + self.error))
        {
            libm::exp2(-21.0)
        } else {
            3.0 * EPSILON * (value.abs() + carried)
        };
        Self { value, error: carried + own }
    }

    fn saturated(self) -> Self {
        self
    }

    fn next_up(self) -> Self {
        let value = f64::from(crate::gpu::policy::to_f32(self.value).next_up());
        Self { value, error: self.error }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sums and products in f32 stay within the bound, and the bound is no more than the ulps allow.
    #[test]
    fn the_bound_holds_what_f32_does_and_little_more() {
        let mut state = 1u32;
        let mut number = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f32::from_bits(0x3f00_0000 | (state >> 9)) - 0.75
        };
        let mut worst = 0.0f64;
        for _ in 0..10_000 {
            let [a, b, c, d] = [number(), number(), number(), number()];
            let device = (a * b - c * d) / (a * a + 1.0);
            let [x, y, z, w] = [a, b, c, d].map(|v| Bounded::exact(v.into()));
            let bounded = (x * y - z * w) / (x * x + Bounded::exact(1.0));
            let off = (f64::from(device) - bounded.value).abs();
            assert!(off <= bounded.error, "{device} {bounded:?}");
            worst = worst.max(off / bounded.error);
        }
        // f32 on the host rounds to nearest: half an ulp of each of the ulps that are allowed.
        assert!(worst > 0.1, "the bound is loose: {worst}");
        let _ = Bounded::undecided();
    }

    #[test]
    fn a_power_of_two_is_exact_down_to_the_least_normal_number_and_may_be_flushed_below() {
        let x = Bounded { value: 1.5, error: 1e-7 };
        let normal = x.scaled(libm::ldexp(1.0, -100));
        assert_eq!(
            [normal.value, normal.error].map(f64::to_bits),
            [1.5, 1e-7].map(|y| libm::ldexp(y, -100).to_bits())
        );
        let below = x.scaled(libm::ldexp(1.0, -130));
        assert!(below.error >= below.value && below.error < 2.0 * LEAST);
        assert_eq!(Bounded::exact(0.0).scaled(0.25).error.to_bits(), 0);
    }

    #[test]
    fn comparisons_in_doubt_are_counted_and_others_are_not() {
        let _ = Bounded::undecided();
        let near = Bounded { value: 1.0, error: 1e-6 };
        assert!(near < Bounded::exact(2.0));
        assert_eq!(Bounded::undecided(), 0);
        assert!(near < Bounded::exact(1.000_000_5));
        assert_eq!(Bounded::undecided(), 1);
        let _ = Bounded { value: 3.0 - 1e-9, error: 1e-8 }.floor();
        assert_eq!(Bounded::undecided(), 1);
    }
}
