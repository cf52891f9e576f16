//! The next step of the search, by the method of the unit.

use super::Ray;
use crate::policy::Method;

/// The step after ratio `f` on `side` (−1 undershoot, 1 overshoot). 0 or NaN where there is none.
pub(super) fn step(method: Method, ray: &mut Ray, f: f64, side: i8) -> f64 {
    let again = ray.side == side;
    ray.side = side;
    let before = ray.under;
    let halves = method == Method::Illinois && again;
    let half = |p: f64| 0.5 + p / 2.0;
    let other = if side > 0 {
        ray.over = Some((ray.d, f));
        if halves {
            ray.under.1 = half(ray.under.1);
        }
        Some(ray.under)
    } else {
        ray.under = (ray.d, f);
        if let Some(over) = ray.over.as_mut().filter(|_| halves) {
            over.1 = half(over.1);
        }
        ray.over
    };
    if let (Some(other), Some(over)) = (other, ray.over) {
        let (low, high) = if ray.under.0 < over.0 {
            (ray.under.0, over.0)
        } else {
            (over.0, ray.under.0)
        };
        // A bracket of at most one unit of the last place.
        if low.next_up() >= high {
            return 0.0;
        }
        return between(ray.d, f, other);
    }
    if method == Method::Secant && f > before.1 {
        return between(ray.d, f, before).min(4.0 * ray.far);
    }
    // Eq. 2: towards the far point.
    ray.far * (1.0 - f)
}

/// Eq. 3: (d − d0)(1 − f)/(f − p); NaN where the denominator is 0.
fn between(d: f64, f: f64, (d0, p): (f64, f64)) -> f64 {
    let span = f - p;
    if span == 0.0 {
        return f64::NAN;
    }
    (d - d0) * ((1.0 - f) / span)
}
