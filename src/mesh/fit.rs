//! The placing of a mesh, and the choice of its triangles that count.

use glam::DVec3;

use super::{Corner, Soup};
use crate::error::InputError;

/// Positions moved and scaled: the middle of the bounding box of all used corners goes to `centre`, the
/// farthest used corner to the distance `radius`. Directions stay.
pub(super) fn fitted(
    soup: &Soup,
    subject: &str,
    centre: DVec3,
    radius: f64,
) -> Result<Vec<DVec3>, InputError> {
    let used = || {
        let corners = soup.triangles.iter().flatten();
        corners.map(|c| DVec3::from(soup.positions[c.position as usize]))
    };
    let low = used().fold(DVec3::INFINITY, DVec3::min);
    let high = used().fold(DVec3::NEG_INFINITY, DVec3::max);
    let middle = low + (high - low) / 2.0;
    // Distances by the largest component first, so that tiny meshes do not underflow.
    let span = (high - low).max_element().max(0.0);
    let farthest =
        used().map(|p| ((p - middle) / span).length_squared()).fold(0.0, f64::max).sqrt();
    let scale = radius / span / farthest;
    if !(scale.is_finite() && scale > 0.0) {
        return Err(InputError::new(
            subject,
            "a mesh that has an extent",
            "all corners in one place, or nearly so",
            "check the mesh in the program that wrote it",
        ));
    }
    Ok(soup.positions.iter().map(|p| centre + (DVec3::from(*p) - middle) * scale).collect())
}

/// The triangles whose corners span an area, and how many do not.
pub(super) fn with_area(
    triangles: &[[Corner; 3]],
    positions: &[DVec3],
) -> (Vec<[Corner; 3]>, usize) {
    let kept: Vec<[Corner; 3]> = triangles
        .iter()
        .filter(|corners| {
            let [a, b, c] = corners.map(|c| positions[c.position as usize]);
            (b - a).cross(c - a).length_squared() > 0.0
        })
        .copied()
        .collect();
    let dropped = triangles.len() - kept.len();
    (kept, dropped)
}
