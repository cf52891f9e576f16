//! The hit iteration over any distance function, and the march that is its usual alternative.
//!
//! Written for studies, straight from the definition, over a closure: it counts what a unit does not
//! report (overshoots) and serves as an independent twin of the `hit` stage.

/// Which chord a step takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// The paper's: eq. 2 until the first overshoot, then eq. 3.
    FalsePosition,
    /// Before an overshoot the chord through the last two points, at most 4·r long.
    Secant,
    /// False position that halves the residual of an end that stays.
    Illinois,
}

impl Method {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::FalsePosition, Self::Secant, Self::Illinois];

    /// Its name in units and results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::FalsePosition => "false-position",
            Self::Secant => "secant",
            Self::Illinois => "illinois",
        }
    }
}

/// How a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Ending {
    /// |f − 1| ≤ τ.
    Converged,
    /// All look-ups used.
    MaxIterations,
    /// A step that changes nothing, or no chord.
    Stalled,
    /// Nothing in the ray's own direction.
    Escaped,
    /// The ray starts on the surface.
    AtSurface,
    /// The ray starts behind it.
    Outside,
}

impl Ending {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Converged,
        Self::MaxIterations,
        Self::Stalled,
        Self::Escaped,
        Self::AtSurface,
        Self::Outside,
    ];

    /// Its name in results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::MaxIterations => "max-iterations",
            Self::Stalled => "stalled",
            Self::Escaped => "escaped",
            Self::AtSurface => "at-surface",
            Self::Outside => "outside",
        }
    }
}

/// What a search found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// The point (for `Escaped` the direction).
    pub l: [f64; 3],
    /// Its distance along the ray.
    pub d: f64,
    /// Look-ups made in the loop.
    pub look_ups: u32,
    /// How many of them lay behind the surface.
    pub overshoots: u32,
    /// How it ended.
    pub ending: Ending,
}

fn length(a: [f64; 3]) -> f64 {
    (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]).sqrt()
}

fn along(x: [f64; 3], r: [f64; 3], d: f64) -> [f64; 3] {
    [0, 1, 2].map(|i| x[i] + r[i] * d)
}

/// |l| / dist(l): below 1 in front of the surface. 0 where dist is infinite, the largest double where it
/// is 0.
fn ratio(distance: &dyn Fn([f64; 3]) -> f64, l: [f64; 3]) -> f64 {
    let size = length(l);
    if size == 0.0 {
        return 0.0;
    }
    let to = distance(l);
    if to.is_infinite() {
        0.0
    } else if to > 0.0 {
        size / to
    } else {
        f64::MAX
    }
}

/// Looks for the hit of the ray x + d·r, r of unit length, with at most `most` look-ups in the loop.
///
/// Paper: Szirmay-Kalos et al., eq. 2 and 3. Precondition for the first root to be found: a surface that
/// is convex as seen from the reference point. In general the result is some root or none.
#[must_use]
pub fn search(
    distance: &dyn Fn([f64; 3]) -> f64,
    x: [f64; 3],
    r: [f64; 3],
    method: Method,
    most: u32,
    tolerance: f64,
) -> Found {
    let reach = distance(r);
    let mut found = Found {
        l: r,
        d: 0.0,
        look_ups: 0,
        overshoots: 0,
        ending: Ending::Escaped,
    };
    if reach.is_infinite() {
        return found;
    }
    let start = ratio(distance, x);
    if start >= 1.0 - tolerance {
        found.l = x;
        found.ending = if start <= 1.0 + tolerance {
            Ending::AtSurface
        } else {
            Ending::Outside
        };
        return found;
    }
    let (mut d_under, mut p_under) = (0.0, start);
    let mut over: Option<(f64, f64)> = None;
    let mut side_before = 0;
    let mut d = reach * (1.0 - start);
    found.ending = Ending::MaxIterations;
    for _ in 0..most {
        let f = ratio(distance, along(x, r, d));
        found.look_ups += 1;
        let step = if f < 1.0 - tolerance {
            let (d_before, p_before) = (d_under, p_under);
            (d_under, p_under) = (d, f);
            if let Some((d_over, p_over)) = &mut over {
                if method == Method::Illinois && side_before == -1 {
                    *p_over = (1.0 + *p_over) / 2.0;
                }
                side_before = -1;
                (d - *d_over) * (1.0 - f) / (f - *p_over)
            } else {
                let chord = (d - d_before) * (1.0 - f) / (f - p_before);
                if method == Method::Secant && f > p_before {
                    chord.min(4.0 * reach)
                } else {
                    reach * (1.0 - f)
                }
            }
        } else if f > 1.0 + tolerance {
            found.overshoots += 1;
            if method == Method::Illinois && side_before == 1 {
                p_under = (1.0 + p_under) / 2.0;
            }
            side_before = 1;
            over = Some((d, f));
            (d - d_under) * (1.0 - f) / (f - p_under)
        } else {
            found.ending = Ending::Converged;
            break;
        };
        let next = d + step;
        if !step.is_finite() || next.to_bits() == d.to_bits() {
            found.ending = Ending::Stalled;
            break;
        }
        d = next;
    }
    found.d = d;
    found.l = along(x, r, d);
    found
}

/// The usual alternative: `steps` equal steps over `range` until the first point behind the surface, then
/// `halvings` of the last step. Look-ups as made; hardware without early exit pays steps + halvings.
#[must_use]
pub fn march(
    distance: &dyn Fn([f64; 3]) -> f64,
    x: [f64; 3],
    r: [f64; 3],
    range: f64,
    steps: u32,
    halvings: u32,
) -> Found {
    let mut found = Found {
        l: r,
        d: range,
        look_ups: 0,
        overshoots: 0,
        ending: Ending::Escaped,
    };
    let (mut low, mut high) = (0.0, range);
    let mut behind = false;
    for step in 1..=steps {
        high = range * f64::from(step) / f64::from(steps);
        found.look_ups += 1;
        if ratio(distance, along(x, r, high)) > 1.0 {
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
        if ratio(distance, along(x, r, middle)) > 1.0 {
            high = middle;
        } else {
            low = middle;
        }
    }
    found.ending = Ending::Converged;
    found.overshoots = 1;
    found.d = 0.5 * (low + high);
    found.l = along(x, r, found.d);
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The distance to the inside of a box about the origin.
    fn cuboid(half: [f64; 3]) -> impl Fn([f64; 3]) -> f64 {
        move |d| {
            let most = (0..3).fold(0.0, |m: f64, i| m.max(d[i].abs() / half[i]));
            length(d) / most
        }
    }

    #[test]
    fn a_planar_wall_takes_one_step_and_one_look_up() {
        let distance = cuboid([4.0, 3.0, 5.0]);
        // x and r see +x: n·x ≥ 0, and so does every point between.
        let x = [1.0, 0.2, -0.3];
        let r = [0.96, 0.28, 0.0];
        for method in Method::ALL {
            let found = search(&distance, x, r, method, 4, libm::ldexp(1.0, -10));
            assert_eq!((found.ending, found.look_ups), (Ending::Converged, 1));
            assert!((found.l[0] - 4.0).abs() < 1e-14);
        }
    }

    #[test]
    fn a_convex_room_is_never_overshot_by_eq_2_and_every_method_ends_on_the_wall() {
        let half = [4.0, 3.0, 5.0];
        let distance = cuboid(half);
        let mut tried = 0;
        for i in 0..2000 {
            let turn = f64::from(i);
            let x = [
                3.0 * libm::sin(turn),
                2.0 * libm::sin(1.3 * turn),
                4.0 * libm::cos(0.7 * turn),
            ];
            let aim = [
                libm::sin(2.1 * turn),
                libm::cos(3.3 * turn),
                libm::sin(0.9 * turn + 1.0),
            ];
            let r = aim.map(|c| c / length(aim));
            let quick = search(&distance, x, r, Method::FalsePosition, 60, 0.0);
            // The gauge of a convex body: rounding alone can put f above 1, by a few ulp.
            let f = ratio(&distance, quick.l);
            assert!(f < 1.0 + 1e-14, "{f}");
            for method in [Method::Secant, Method::Illinois] {
                let found = search(&distance, x, r, method, 200, 1e-9);
                let f = ratio(&distance, found.l);
                assert!((f - 1.0).abs() <= 2e-9, "{method:?} {found:?} {f}");
            }
            tried += usize::from(quick.look_ups > 1);
        }
        assert!(tried > 500, "{tried} rays that need more than a step");
    }

    #[test]
    fn rays_that_see_nothing_or_start_on_the_wall_make_no_look_up() {
        let open = |d: [f64; 3]| if d[0] > 0.0 { f64::INFINITY } else { 1.0 };
        let got = search(
            &open,
            [-0.2, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            Method::Secant,
            4,
            1e-3,
        );
        assert_eq!((got.ending, got.look_ups), (Ending::Escaped, 0));
        for (x, ending) in [(-1.0, Ending::AtSurface), (-2.0, Ending::Outside)] {
            let got = search(
                &open,
                [x, 0.0, 0.0],
                [-1.0, 0.0, 0.0],
                Method::Secant,
                4,
                1e-3,
            );
            assert_eq!((got.ending, got.look_ups), (ending, 0));
        }
        let none = search(
            &open,
            [0.5, 0.0, 0.0],
            [-1.0, 0.0, 0.0],
            Method::Secant,
            0,
            1e-3,
        );
        assert_eq!((none.ending, none.look_ups), (Ending::MaxIterations, 0));
    }

    #[test]
    fn the_march_brackets_the_wall_within_its_last_step() {
        let distance = cuboid([4.0, 3.0, 5.0]);
        let got = march(&distance, [0.5, 0.5, 0.5], [0.6, 0.0, 0.8], 16.0, 32, 6);
        // The wall z = 5 is 4.5/0.8 away, nearer than x = 4; half a step after six halvings is 16/32/128.
        assert!((got.d - 4.5 / 0.8).abs() <= 16.0 / 32.0 / 128.0);
        assert_eq!(got.ending, Ending::Converged);
        assert_eq!(got.look_ups, 12 + 6);
    }
}
