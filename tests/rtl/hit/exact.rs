//! The float reference beside the same steps in numbers of twice the precision, written a second time.

use tapline::engine::hit::HitF64;
use tapline::policy::{HitStatus, Method};
use tapline::reference::real::Real;
use tapline::reference::wide::Wide;
use tapline::unit::{ReferenceAxis, UnitSpec};

use super::{ROOM, rays};

const HALF_EDGES: [f64; 3] = [4.0, 3.0, 2.5];

fn wide(x: f64) -> Wide {
    Wide::from_f64(x)
}

fn less(a: Wide, b: Wide) -> bool {
    a < b
}

/// The gauge of the box: |q|/dist(q) = max |q_i|/h_i. No root, no direction: another form than the reference's.
fn gauge(q: [Wide; 3]) -> Wide {
    let mut most = wide(0.0);
    for (q, h) in q.into_iter().zip(HALF_EDGES) {
        let here = q.abs() / wide(h);
        if less(most, here) {
            most = here;
        }
    }
    most
}

struct End {
    d: Wide,
    l: [Wide; 3],
    status: HitStatus,
    /// Distance of the nearest decision from its threshold, and the smallest denominator.
    margin: f64,
}

/// `steps` steps from x along r; 1 − τ ≤ f ≤ 1 + τ ends them.
fn search(x: [f64; 3], r: [f64; 3], method: Method, steps: u32) -> End {
    let x = x.map(wide);
    let r = r.map(wide);
    let length = (r[0] * r[0] + r[1] * r[1] + r[2] * r[2]).sqrt();
    let r = r.map(|c| c / length);
    let one = wide(1.0);
    let tau = wide(1.0 / 1024.0);
    let far = one / gauge(r);
    let p_start = gauge(x);
    let at = |d: Wide| {
        let mut l = x;
        for (l, r) in l.iter_mut().zip(r) {
            *l = *l + r * d;
        }
        l
    };
    let mut d = far * (one - p_start);
    let mut under = (wide(0.0), p_start);
    let mut over: Option<(Wide, Wide)> = None;
    let mut before = 0;
    let mut margin = f64::INFINITY;
    let mut status = HitStatus::MaxIterations;
    for _ in 0..steps {
        let f = gauge(at(d));
        for limit in [one - tau, one + tau] {
            margin = margin.min((f - limit).abs().to_f64());
        }
        let front = less(f, one - tau);
        if !front && !less(one + tau, f) {
            status = HitStatus::Converged;
            break;
        }
        let side = if front { -1 } else { 1 };
        let mut other = if front {
            let last = under;
            under = (d, f);
            match over {
                Some(over) => over,
                None if method == Method::Secant && less(last.1, f) => last,
                None => {
                    d = d + far * (one - f);
                    before = side;
                    continue;
                }
            }
        } else {
            over = Some((d, f));
            under
        };
        if method == Method::Illinois && before == side {
            other.1 = (one + other.1) / wide(2.0);
            if front {
                over = Some(other);
            } else {
                under = other;
            }
        }
        let span = f - other.1;
        margin = margin.min(span.abs().to_f64() * 1e-3);
        let mut step = (d - other.0) * (one - f) / span;
        if over.is_none() && less(wide(4.0) * far, step) {
            step = wide(4.0) * far;
        }
        d = d + step;
        before = side;
    }
    End { d, l: at(d), status, margin }
}

#[test]
fn f64_agrees_with_the_same_steps_in_twice_the_precision_to_1e_9() {
    for method in [Method::FalsePosition, Method::Secant, Method::Illinois] {
        let mut spec = UnitSpec::default();
        spec.config.policy.hit.method = method;
        spec.config.policy.hit.iterations = 8;
        let rays = rays(2000);
        let settings = spec.settings(ReferenceAxis::Exact);
        let results = HitF64::new(&settings, &ROOM, None, 64).filter(&rays, &|_| {});
        let (mut compared, mut longest) = (0, 0);
        for (ray, result) in rays.iter().zip(&results) {
            let end = search(ray.x, ray.r, method, 8);
            // A decision, or a denominator, within the doubles' own rounding may fall either way.
            if end.margin < 1e-11 {
                continue;
            }
            compared += 1;
            longest = longest.max(result.iterations);
            assert_eq!(result.status, end.status, "{method:?} {ray:?}");
            let bound = 1e-9 * 16.0;
            let off = (result.d - end.d.to_f64()).abs();
            assert!(off < bound, "{method:?} {ray:?}: d is off by {off}");
            for (here, there) in result.l.iter().zip(end.l) {
                assert!((here - there.to_f64()).abs() < bound, "{method:?} {ray:?}");
            }
        }
        assert!(compared > 1990 && longest > 3, "{compared}, {longest}");
    }
}
