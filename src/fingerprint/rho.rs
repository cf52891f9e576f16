//! Rules for the length that the level of detail is the logarithm of.

use crate::base::named::named;
use crate::cube::{FACE_AXES, face_uv};

named! {
    /// The length of a footprint, by one of several rules, with derivatives ∂(s, t)/∂x and ∂(s, t)/∂y in texels of level 0.
    pub enum Rho {
        /// The longer of the two derivatives: the ideal of D3D and Vulkan.
        Longer = "max(|dx|, |dy|), the D3D and Vulkan ideal",
        /// The largest component of either.
        LargestComponent = "max(|ds/dx|, |dt/dx|, |ds/dy|, |dt/dy|)",
        /// The longer side of the box around the parallelogram: |∂s/∂x| + |∂s/∂y|, or that of t.
        Box = "max(|ds/dx| + |ds/dy|, |dt/dx| + |dt/dy|)",
        /// The larger of |∂s/∂x| + |∂t/∂x| and |∂s/∂y| + |∂t/∂y|.
        Taxicab = "max(|ds/dx| + |dt/dx|, |ds/dy| + |dt/dy|)",
        /// The longer of the rows (∂s/∂x, ∂s/∂y) and (∂t/∂x, ∂t/∂y).
        LongerRow = "max(|(ds/dx, ds/dy)|, |(dt/dx, dt/dy)|)",
        /// The major axis of the ellipse.
        Ellipse = "major axis of the ellipse",
        /// √ of the sum of all squares.
        Frobenius = "square root of the sum of squares",
        /// Of the derivatives' max + min/2 of |∂s|, |∂t|, the larger.
        Octagon = "max over x, y of larger + smaller/2",
    }
}

impl Rho {
    /// The length.
    #[must_use]
    pub fn length(self, dx: [f64; 2], dy: [f64; 2]) -> f64 {
        let ([a, b], [c, d]) = (dx.map(f64::abs), dy.map(f64::abs));
        let octagon = |p: f64, q: f64| p.max(q) + p.min(q) / 2.0;
        match self {
            Self::Longer => libm::hypot(a, b).max(libm::hypot(c, d)),
            Self::LargestComponent => a.max(b).max(c).max(d),
            Self::Box => (a + c).max(b + d),
            Self::Taxicab => (a + b).max(c + d),
            Self::LongerRow => libm::hypot(a, c).max(libm::hypot(b, d)),
            Self::Ellipse => axes(dx, dy).0,
            Self::Frobenius => libm::hypot(libm::hypot(a, b), libm::hypot(c, d)),
            Self::Octagon => octagon(a, b).max(octagon(c, d)),
        }
    }
}

/// Lengths of the major and minor axis of the ellipse, and the major one's direction.
#[must_use]
pub fn axes(dx: [f64; 2], dy: [f64; 2]) -> (f64, f64, [f64; 2]) {
    let k = [
        dx[0] * dx[0] + dy[0] * dy[0],
        dx[0] * dx[1] + dy[0] * dy[1],
        dx[1] * dx[1] + dy[1] * dy[1],
    ];
    let (half, mean) = ((k[0] - k[2]) / 2.0, f64::midpoint(k[0], k[2]));
    let root = libm::hypot(half, k[1]);
    let angle = libm::atan2(k[1], half) / 2.0;
    let axis = [libm::cos(angle), libm::sin(angle)];
    let minor =
        (dx[0] * dy[1] - dx[1] * dy[0]).abs() / libm::sqrt(mean + root).max(f64::MIN_POSITIVE);
    (libm::sqrt(mean + root), minor, axis)
}

named! {
    /// How 3-D derivatives become derivatives on a cube's face.
    pub enum Projection {
        /// By the quotient rule: exact.
        Exact = "projected exactly (quotient rule)",
        /// Divided by the major component, whose own derivative is left out.
        NoQuotient = "divided by the major component, its own derivative left out",
        /// All three components, divided by the major one; the third counts as one more coordinate.
        ThreeComponents = "all three components, divided by the major one",
    }
}

impl Projection {
    /// Derivatives on the face of `at`, in texels.
    #[must_use]
    pub fn on_face(self, at: [f64; 3], d: [f64; 3], size: f64) -> [f64; 2] {
        let (face, u, v) = face_uv(at);
        let [s, t, m] = FACE_AXES[face].map(|(axis, sign)| sign * d[axis]);
        let ma = at[FACE_AXES[face][2].0].abs();
        let moved = if self == Self::Exact { m } else { 0.0 };
        [s - u * moved, t - v * moved].map(|c| c / ma * size / 2.0)
    }

    /// The length of a pair of 3-D derivatives by a rule, in texels.
    #[must_use]
    pub fn length(self, rule: Rho, at: [f64; 3], [dx, dy]: [[f64; 3]; 2], size: f64) -> f64 {
        let [x, y] = [dx, dy].map(|d| self.on_face(at, d, size));
        let planar = rule.length(x, y);
        if self != Self::ThreeComponents {
            return planar;
        }
        let (face, _, _) = face_uv(at);
        let (major, _) = FACE_AXES[face][2];
        let ma = at[major].abs();
        let [p, q] = [dx, dy].map(|d| (d[major] / ma * size / 2.0).abs());
        match rule {
            Rho::Longer => {
                libm::hypot(libm::hypot(x[0], x[1]), p).max(libm::hypot(libm::hypot(y[0], y[1]), q))
            }
            Rho::LargestComponent => planar.max(p).max(q),
            Rho::Box => planar.max(p + q),
            Rho::LongerRow => planar.max(libm::hypot(p, q)),
            Rho::Taxicab => (x[0].abs() + x[1].abs() + p).max(y[0].abs() + y[1].abs() + q),
            Rho::Frobenius => libm::hypot(planar, libm::hypot(p, q)),
            Rho::Ellipse | Rho::Octagon => planar,
        }
    }
}
