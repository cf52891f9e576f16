//! Vectors of world geometry are `glam`'s: its sums and products are written out from left to right, and nothing is fused.

use glam::DVec3;

/// `v` at length 1. `DVec3::normalize` multiplies by a reciprocal instead, which rounds once more.
#[must_use]
pub fn unit(v: DVec3) -> DVec3 {
    v / v.length()
}

/// The angle between two directions in degrees; 180 where one of them is zero.
#[must_use]
pub fn degrees(a: [f64; 3], b: [f64; 3]) -> f64 {
    let [a, b] = [a, b].map(DVec3::from);
    if a.length() == 0.0 || b.length() == 0.0 {
        return 180.0;
    }
    libm::atan2(a.cross(b).length(), a.dot(b)).to_degrees()
}
