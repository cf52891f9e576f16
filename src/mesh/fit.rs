//! Where a mesh goes and which of its triangles count.

use super::{Corner, Soup};
use crate::base::dual::{cross, difference, dot};
use crate::error::InputError;

/// Positions moved and scaled: the middle of the bounding box of all used corners goes to `centre`, the
/// farthest used corner to the distance `radius`. Directions stay.
pub(super) fn fitted(
    soup: &Soup,
    subject: &str,
    centre: [f64; 3],
    radius: f64,
) -> Result<Vec<[f64; 3]>, InputError> {
    let used = || soup.triangles.iter().flatten();
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for corner in used() {
        let position = soup.positions[corner.position as usize];
        for i in 0..3 {
            low[i] = low[i].min(position[i]);
            high[i] = high[i].max(position[i]);
        }
    }
    let middle = [0, 1, 2].map(|i| low[i] + (high[i] - low[i]) / 2.0);
    // Distances by the largest component first, so that tiny meshes do not underflow.
    let span = (0..3).map(|i| high[i] - low[i]).fold(0.0, f64::max);
    let farthest = used()
        .map(|c| {
            let away = difference(soup.positions[c.position as usize], middle).map(|c| c / span);
            dot(away, away)
        })
        .fold(0.0, f64::max)
        .sqrt();
    let scale = radius / span / farthest;
    if !(scale.is_finite() && scale > 0.0) {
        return Err(InputError::new(
            subject,
            "a mesh that has an extent",
            "all corners in one place, or nearly so",
            "check the mesh in the program that wrote it",
        ));
    }
    let place = |p: &[f64; 3]| [0, 1, 2].map(|i| centre[i] + (p[i] - middle[i]) * scale);
    Ok(soup.positions.iter().map(place).collect())
}

/// The triangles whose corners span an area, and how many do not.
pub(super) fn with_area(
    triangles: &[[Corner; 3]],
    positions: &[[f64; 3]],
) -> (Vec<[Corner; 3]>, usize) {
    let kept: Vec<[Corner; 3]> = triangles
        .iter()
        .filter(|corners| {
            let [a, b, c] = corners.map(|c| positions[c.position as usize]);
            let n = cross(difference(b, a), difference(c, a));
            dot(n, n) > 0.0
        })
        .copied()
        .collect();
    let dropped = triangles.len() - kept.len();
    (kept, dropped)
}
