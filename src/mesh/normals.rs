//! Normals at corners: the file's, or the mean of the faces that meet there.
//!
//! The mean is weighted by the angle of each face at the corner, so that it does not depend on how a
//! flat part is cut into triangles. Corners are the same where their positions are (−0 is +0): a seam
//! of the texture or a change of material is no edge of the surface.

use std::collections::HashMap;

use glam::DVec3;

use super::{Corner, Soup};
use crate::base::vector;

/// Unit normals of every triangle's corners, and how many were computed.
///
/// A file's normal that is zero counts as absent. Where the mean vanishes too, the face's own stands in.
pub(super) fn complete(
    soup: &Soup,
    triangles: &[[Corner; 3]],
    positions: &[DVec3],
) -> (Vec<[DVec3; 3]>, usize) {
    let given = |corner: &Corner| unit(soup.normals[corner.normal? as usize].into());
    let mut missing = 0;
    for corner in triangles.iter().flatten() {
        missing += usize::from(given(corner).is_none());
    }
    let means = if missing > 0 { means(triangles, positions) } else { HashMap::new() };
    let normals = triangles
        .iter()
        .map(|corners| {
            corners.map(|corner| {
                given(&corner)
                    .or_else(|| unit(*means.get(&key(positions[corner.position as usize]))?))
                    .or_else(|| unit(face(corners, positions)))
                    .unwrap_or(DVec3::Z)
            })
        })
        .collect();
    (normals, missing)
}

/// Sum of angle · unit normal of the faces around each place, in the triangles' order.
fn means(triangles: &[[Corner; 3]], positions: &[DVec3]) -> HashMap<[u64; 3], DVec3> {
    let mut sums: HashMap<[u64; 3], DVec3> = HashMap::new();
    for corners in triangles {
        let places = corners.map(|c| positions[c.position as usize]);
        let Some(normal) = unit(face(corners, positions)) else {
            continue;
        };
        for i in 0..3 {
            let [a, b, c] = [0, 1, 2].map(|k| places[(i + k) % 3]);
            let (ab, ac) = (b - a, c - a);
            let angle = libm::atan2(ab.cross(ac).length(), ab.dot(ac));
            *sums.entry(key(a)).or_default() += angle * normal;
        }
    }
    sums
}

/// (b − a) × (c − a).
fn face(corners: &[Corner; 3], positions: &[DVec3]) -> DVec3 {
    let [a, b, c] = corners.map(|c| positions[c.position as usize]);
    (b - a).cross(c - a)
}

/// A place by its bits, −0 as +0.
fn key(position: DVec3) -> [u64; 3] {
    position.to_array().map(|c| (c + 0.0).to_bits())
}

/// The vector at length 1; scaled by its largest component first. `None` for zero.
fn unit(n: DVec3) -> Option<DVec3> {
    let largest = n.abs().max_element();
    (largest > 0.0).then(|| vector::unit(n / largest))
}
