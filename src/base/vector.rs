//! Vectors of world geometry are `glam`'s: its sums and products are written out from left to right, and nothing is fused.

use glam::DVec3;

/// `v` at length 1. `DVec3::normalize` multiplies by a reciprocal instead, which rounds once more.
#[must_use]
pub fn unit(v: DVec3) -> DVec3 {
    v / v.length()
}
