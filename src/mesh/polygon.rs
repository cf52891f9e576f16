//! Polygons with an inward corner, cut into ears by the crate `earcut`.

use glam::{DVec2, DVec3};

use super::{Corner, Soup};
use crate::base::num;
use crate::base::quiet::guarded;

/// Most corners of a polygon that is cut into ears; a larger one stays a fan.
const MAX_CORNERS: usize = 1 << 12;

/// Recuts the fan of `count` triangles from `start` where it is not convex. Returns whether it was
/// not and could not be recut: it crosses itself, has no plane, or is too large.
pub(super) fn recut(soup: &mut Soup, start: usize, count: usize) -> bool {
    let fan = &soup.triangles[start..start + count];
    let corners: Vec<Corner> = fan
        .first()
        .map(|t| [t[0], t[1]])
        .into_iter()
        .flatten()
        .chain(fan.iter().map(|t| t[2]))
        .collect();
    let places: Vec<DVec3> =
        corners.iter().map(|c| soup.positions[c.position as usize].into()).collect();
    let edge = |i: usize| places[(i + 1) % places.len()] - places[i % places.len()];
    // Twice the area, as a vector: sums about the first corner keep digits.
    let normal: DVec3 = (1..places.len()).map(|i| (places[i] - places[0]).cross(edge(i))).sum();
    if !normal.is_finite() || normal == DVec3::ZERO {
        return false;
    }
    // A millionth of a right angle's: what rounding makes of a straight corner.
    let inward = |i: usize| {
        let (a, b) = (edge(i), edge(i + 1));
        a.cross(b).dot(normal) < -1e-6 * a.length() * b.length() * normal.length()
    };
    if !(0..places.len()).any(inward) {
        return false;
    }
    if corners.len() > MAX_CORNERS {
        return true;
    }
    let u = normal.any_orthogonal_vector().normalize();
    let v = normal.cross(u) / normal.length();
    let flat: Vec<[f64; 2]> =
        places.iter().map(|p| [(*p - places[0]).dot(u), (*p - places[0]).dot(v)]).collect();
    let cut = guarded(|| {
        let mut out: Vec<u32> = Vec::new();
        earcut::Earcut::new().earcut(flat.iter().copied(), &[], &mut out);
        out
    });
    let Ok(cut) = cut else { return true };
    let area = |t: [usize; 3]| {
        let [a, b, c] = t.map(|i| DVec2::from(flat[i]));
        (b - a).perp_dot(c - a)
    };
    let mut sum = 0.0;
    let mut ears = Vec::new();
    for ear in cut.chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|i| num::usize(ear[i]));
        let turned = if area([a, b, c]) < 0.0 { [a, c, b] } else { [a, b, c] };
        sum += area(turned);
        ears.push(turned);
    }
    // The ears of a polygon that crosses itself do not fill it.
    if ears.len() > count || (sum - normal.length()).abs() > 1e-3 * normal.length() {
        return true;
    }
    // Straight corners make no ear: their triangles have no area.
    let nothing = [corners[0]; 3];
    let new = ears.iter().map(|ear| ear.map(|i| corners[i])).chain(std::iter::repeat(nothing));
    for (slot, triangle) in soup.triangles[start..start + count].iter_mut().zip(new) {
        *slot = triangle;
    }
    false
}
