//! A ray and a triangle: watertight, after Woop, Benthin and Wald, *Watertight Ray/Triangle
//! Intersection* (JCGT 2013), in doubles and in numbers with derivatives.
//!
//! Corners are sheared so that the ray becomes the z axis; three products tell on which side of the ray
//! each edge passes. Both triangles at an edge shear its ends to the same numbers and get products that
//! are exact negatives of each other (no fused multiply-add), and a product of zero counts as inside:
//! a ray through a closed mesh meets one of the two, or both at the same distance.

use super::Triangle;
use crate::base::dual::{Scalar, constants, difference};

/// Weights of a triangle's corners at a ray's hit, and the multiple of the direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Barycentric<S> {
    /// Weights; their sum is 1 but for rounding.
    pub weights: [S; 3],
    /// Multiple of the ray's direction.
    pub distance: S,
}

/// Meets the plane of a triangle inside its edges; `None` outside, and where the ray lies in the plane.
/// Both sides count. The value parts of a dual take the operations of an `f64` in the same order.
pub fn meet<S: Scalar>(
    triangle: &Triangle,
    origin: [S; 3],
    direction: [S; 3],
) -> Option<Barycentric<S>> {
    // The axis along which the direction is longest becomes z; the others keep their order around it.
    let size = direction.map(|c| c.value().abs());
    let z = if size[0] > size[1] {
        if size[0] > size[2] { 0 } else { 2 }
    } else if size[1] > size[2] {
        1
    } else {
        2
    };
    let (x, y) = ((z + 1) % 3, (z + 2) % 3);
    let shear_x = direction[x] / direction[z];
    let shear_y = direction[y] / direction[z];
    let corners = triangle.positions.map(|p| {
        let p = difference(constants(p), origin);
        [p[x] - shear_x * p[z], p[y] - shear_y * p[z], p[z]]
    });
    let [a, b, c] = corners;
    let u = c[0] * b[1] - c[1] * b[0];
    let v = a[0] * c[1] - a[1] * c[0];
    let w = b[0] * a[1] - b[1] * a[0];
    let three = [u, v, w].map(S::value);
    if three.iter().any(|e| *e < 0.0) && three.iter().any(|e| *e > 0.0) {
        return None;
    }
    let sum = u + v + w;
    if sum.value() == 0.0 || !sum.value().is_finite() {
        return None;
    }
    let along = (u * a[2] + v * b[2] + w * c[2]) / sum;
    Some(Barycentric { weights: [u / sum, v / sum, w / sum], distance: along / direction[z] })
}
