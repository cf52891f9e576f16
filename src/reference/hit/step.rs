//! The next step of the search, by the method of the unit.

use crate::policy::Method;
use crate::reference::real::Narrow;

/// The state of the search's loop.
#[derive(Clone, Copy, Debug)]
pub struct Ray<N> {
    /// dist(R).
    pub far: N,
    /// Where the ray is.
    pub d: N,
    /// (d, ratio) of the last undershoot.
    pub under: (N, N),
    /// (d, ratio) of the last overshoot, if there was one.
    pub over: Option<(N, N)>,
    /// Which side the last result was on: −1, 0 (none), 1.
    pub side: i8,
}

/// The step after ratio `f` on `side` (−1 undershoot, 1 overshoot). 0 or NaN where there is none.
pub fn step<N: Narrow>(method: Method, ray: &mut Ray<N>, f: N, side: i8) -> N {
    let number = N::from_f64;
    let again = ray.side == side;
    ray.side = side;
    let before = ray.under;
    let halves = method == Method::Illinois && again;
    let half = |p: N| number(0.5) + p / number(2.0);
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
        let (low, high) =
            if ray.under.0 < over.0 { (ray.under.0, over.0) } else { (over.0, ray.under.0) };
        // A bracket of at most one unit of the last place.
        if low.next_up() >= high {
            return number(0.0);
        }
        return between(ray.d, f, other);
    }
    if method == Method::Secant && f > before.1 {
        let most = number(4.0) * ray.far;
        return -(-between(ray.d, f, before)).larger(-most);
    }
    // Eq. 2: towards the far point.
    ray.far * (number(1.0) - f)
}

/// Eq. 3: (d − d0)(1 − f)/(f − p); NaN where the denominator is 0.
fn between<N: Narrow>(d: N, f: N, (d0, p): (N, N)) -> N {
    let span = f - p;
    if span.is_zero() {
        return N::from_f64(f64::NAN);
    }
    (d - d0) * ((N::from_f64(1.0) - f) / span)
}
