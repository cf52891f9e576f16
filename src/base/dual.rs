//! Numbers that carry their derivatives: a surface is written once and gives both its points and
//! their exact screen derivatives.

use std::ops::{Add, Div, Mul, Neg, Sub};

use glam::DVec3;

/// What a surface needs of a number. The value part of a [`Dual`] and a plain `f64` take the same
/// operations in the same order, so that a fragment and a sample at the same place agree bit for bit.
pub trait Scalar:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// A number that does not depend on the screen position.
    fn constant(value: f64) -> Self;
    /// The number without its derivatives.
    fn value(self) -> f64;
    /// Square root; of zero the derivatives are not finite.
    fn sqrt(self) -> Self;
    /// Angle of the point (other, self), in radians.
    fn atan2(self, other: Self) -> Self;
    /// Angle in 0…π whose cosine is the number.
    fn acos(self) -> Self;
}

impl Scalar for f64 {
    fn constant(value: f64) -> Self {
        value
    }
    fn value(self) -> f64 {
        self
    }
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }
    fn atan2(self, other: Self) -> Self {
        libm::atan2(self, other)
    }
    fn acos(self) -> Self {
        libm::acos(self.clamp(-1.0, 1.0))
    }
}

/// A value with its derivatives by the two image coordinates (forward differentiation).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual {
    /// The value.
    pub value: f64,
    /// ∂ per pixel to the right.
    pub dx: f64,
    /// ∂ per pixel downwards.
    pub dy: f64,
}

impl Add for Dual {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self { value: self.value + o.value, dx: self.dx + o.dx, dy: self.dy + o.dy }
    }
}

impl Sub for Dual {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Self { value: self.value - o.value, dx: self.dx - o.dx, dy: self.dy - o.dy }
    }
}

impl Mul for Dual {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        Self {
            value: self.value * o.value,
            dx: self.dx * o.value + self.value * o.dx,
            dy: self.dy * o.value + self.value * o.dy,
        }
    }
}

impl Div for Dual {
    type Output = Self;
    fn div(self, o: Self) -> Self {
        let value = self.value / o.value;
        Self {
            value,
            dx: (self.dx - value * o.dx) / o.value,
            dy: (self.dy - value * o.dy) / o.value,
        }
    }
}

impl Neg for Dual {
    type Output = Self;
    fn neg(self) -> Self {
        Self { value: -self.value, dx: -self.dx, dy: -self.dy }
    }
}

impl Scalar for Dual {
    fn constant(value: f64) -> Self {
        Self { value, dx: 0.0, dy: 0.0 }
    }
    fn value(self) -> f64 {
        self.value
    }
    fn sqrt(self) -> Self {
        let value = self.value.sqrt();
        Self { value, dx: self.dx / (2.0 * value), dy: self.dy / (2.0 * value) }
    }
    fn atan2(self, o: Self) -> Self {
        let square = self.value * self.value + o.value * o.value;
        let along = |s: f64, c: f64| (s * o.value - self.value * c) / square;
        Self {
            value: libm::atan2(self.value, o.value),
            dx: along(self.dx, o.dx),
            dy: along(self.dy, o.dy),
        }
    }
    fn acos(self) -> Self {
        let c = self.value.clamp(-1.0, 1.0);
        let slope = -1.0 / (1.0 - c * c).sqrt();
        Self { value: libm::acos(c), dx: slope * self.dx, dy: slope * self.dy }
    }
}

/// ⟨a, b⟩.
#[inline]
pub fn dot<S: Scalar>(a: [S; 3], b: [S; 3]) -> S {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// A vector of constants.
#[inline]
pub fn constants<S: Scalar>(a: DVec3) -> [S; 3] {
    [S::constant(a.x), S::constant(a.y), S::constant(a.z)]
}

/// A vector without its derivatives.
#[inline]
pub fn values<S: Scalar>(a: [S; 3]) -> DVec3 {
    DVec3::new(a[0].value(), a[1].value(), a[2].value())
}

/// k·a.
// Written out, here and below: `map` is a call.
#[inline]
pub fn scaled<S: Scalar>(a: [S; 3], k: S) -> [S; 3] {
    [a[0] * k, a[1] * k, a[2] * k]
}

/// a + b.
#[inline]
pub fn sum<S: Scalar>(a: [S; 3], b: [S; 3]) -> [S; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// a − b.
#[inline]
pub fn difference<S: Scalar>(a: [S; 3], b: [S; 3]) -> [S; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
