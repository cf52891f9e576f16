//! The march along a ray that is the usual alternative to the hit iteration.

use super::study::Found;
use crate::policy::{HitStatus, LookUp};
use crate::reference::Distances;

fn along(x: [f64; 3], r: [f64; 3], d: f64) -> [f64; 3] {
    [0, 1, 2].map(|i| x[i] + r[i] * d)
}

/// Whether a point lies behind the surface.
fn behind_wall(distance: &Distances, l: [f64; 3]) -> bool {
    let size = (l[0] * l[0] + l[1] * l[1] + l[2] * l[2]).sqrt();
    size > 0.0 && size > distance.read(l, LookUp::Bilinear)
}

/// The usual alternative: `steps` equal steps over `range` until the first point behind the surface, then
/// `halvings` of the last step. Look-ups as made; hardware without early exit pays steps + halvings.
#[must_use]
pub fn march(
    distance: &Distances,
    x: [f64; 3],
    r: [f64; 3],
    range: f64,
    steps: u32,
    halvings: u32,
) -> Found {
    let mut found =
        Found { l: r, d: range, look_ups: 0, overshot: false, status: HitStatus::Escaped };
    let (mut low, mut high) = (0.0, range);
    let mut behind = false;
    for step in 1..=steps {
        high = range * f64::from(step) / f64::from(steps);
        found.look_ups += 1;
        if behind_wall(distance, along(x, r, high)) {
            behind = true;
            break;
        }
        low = high;
    }
    if !behind {
        return found;
    }
    for _ in 0..halvings {
        let middle = 0.5 * (low + high);
        found.look_ups += 1;
        if behind_wall(distance, along(x, r, middle)) {
            high = middle;
        } else {
            low = middle;
        }
    }
    found.status = HitStatus::Converged;
    found.overshot = true;
    found.d = 0.5 * (low + high);
    found.l = along(x, r, found.d);
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distance::Distance;

    #[test]
    fn the_march_brackets_the_wall_within_its_last_step() {
        let distance = Distances::new(&Distance::Box([4.0, 3.0, 5.0]));
        let got = march(&distance, [0.5, 0.5, 0.5], [0.6, 0.0, 0.8], 16.0, 32, 6);
        // The wall z = 5 is 4.5/0.8 away, nearer than x = 4; half a step after six halvings is 16/32/128.
        assert!((got.d - 4.5 / 0.8).abs() <= 16.0 / 32.0 / 128.0);
        assert_eq!(got.status, HitStatus::Converged);
        assert_eq!(got.look_ups, 12 + 6);
    }
}
