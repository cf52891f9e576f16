//! Stage `eigen`: the axes of the ellipse.

use super::angle::Angles;
use super::real::{Narrow, Real};
use super::tap::{Tap, put};
use crate::policy::{Axis, Minor};
use crate::stage::Stage;

/// The axes of the footprint.
#[derive(Clone, Copy, Debug)]
pub struct Axes<R: Real> {
    /// λ1, λ2 (under `longer-derivative` λ2 can be the larger).
    pub lambda: [R; 2],
    /// Direction of λ1: unit, first component > 0, or (0, 1). Order 1 tables leave it a little short.
    pub axis: [R::Narrow; 2],
    /// Their squares.
    pub lambda_sq: [R; 2],
}

/// λ² = ½(a + c ± √((c − a)² + 4b²)) (Schilling, eq. 16 and 17) and the direction of the major axis.
///
/// `minor` `det` takes λ2² = det K/λ1² instead of eq. 17. The axis is exact unless `angles` holds a
/// table; K isotropic gives (1, 0) where it is exact. `longer-derivative` takes the longest of the
/// columns of [D, s·B'] (the first of equal ones) for λ1 and its direction, and λ2² = a + c − λ1²,
/// which is the sum of the squares of the other columns and is computed as that.
#[inline]
pub fn eigen<R: Real, T: Tap>(
    k: [R; 3],
    columns: [Option<&[[R; 2]; 2]>; 2],
    policy: (Axis, Minor),
    angles: Option<&Angles>,
    tap: &mut T,
) -> Axes<R> {
    let [a, b, c] = k;
    let zero = R::from_f64(0.0);
    let half = R::from_f64(0.5);
    let two_b = b + b;
    let difference = c - a;
    let root = (difference * difference + two_b * two_b).sqrt();
    let (lambda_sq, axis) = if policy.0 == Axis::LongerDerivative {
        longer_derivative(columns)
    } else {
        let major = half * (a + c + root);
        let minor = match policy.1 {
            Minor::Paper => half * (a + c - root),
            Minor::Det if major.is_zero() => zero,
            Minor::Det => R::product_difference(a, c, b, b) / major,
        };
        let minor = minor.larger(zero);
        let axis = match angles {
            Some(angles) => table_axis(angles, difference, two_b, root),
            None => exact_axis(difference, two_b, root),
        };
        ([major, minor], axis)
    };
    let lambda = lambda_sq.map(R::sqrt);
    put(tap, Stage::Eigen, "root", &[root]);
    put(tap, Stage::Eigen, "lambda_sq", &lambda_sq);
    put(tap, Stage::Eigen, "lambda", &lambda);
    put(tap, Stage::Eigen, "axis", &axis);
    Axes { lambda, axis, lambda_sq }
}

/// The eigenvector of the larger eigenvalue, from the one of its two forms that cancels nothing.
fn exact_axis<R: Real>(difference: R, two_b: R, root: R) -> [R::Narrow; 2] {
    let [zero, one] = [0.0, 1.0].map(R::Narrow::from_f64);
    if root.is_zero() {
        return [one, zero];
    }
    // (long, short) is the eigenvector with its larger component first; |short| ≤ long.
    let slope = (two_b / (root + difference.abs())).narrow();
    let long = one / (one + slope * slope).sqrt();
    let short = slope * long;
    if difference < R::from_f64(0.0) { [long, short] } else { with_first_positive(short, long) }
}

/// (short, long) turned so that its first component is positive, or (0, 1).
fn with_first_positive<N: Narrow>(short: N, long: N) -> [N; 2] {
    let zero = N::from_f64(0.0);
    if short > zero {
        [short, long]
    } else if short < zero {
        [-short, -long]
    } else {
        [zero, N::from_f64(1.0)]
    }
}

/// The axis from the table: r1 = (cos α, −sin α) where c − a < 0, r2 = (sin α, cos α) elsewhere, with
/// the sign of α that of 2b/(c − a) (Schilling, eq. 18 to 20, roles corrected).
fn table_axis<R: Real>(angles: &Angles, difference: R, two_b: R, root: R) -> [R::Narrow; 2] {
    if root.is_zero() {
        return [1.0, 0.0].map(R::Narrow::from_f64);
    }
    let zero = R::from_f64(0.0);
    let doubled = [difference, two_b].map(|x| (x.abs() / root).to_f64());
    let [cos, sin] = angles.look_up(doubled);
    let negative = (two_b < zero) != (difference < zero) && !two_b.is_zero();
    let sin = if negative { -sin } else { sin };
    if difference < zero {
        [cos, 0.0 - sin].map(R::Narrow::from_f64)
    } else {
        with_first_positive(R::Narrow::from_f64(sin), R::Narrow::from_f64(cos))
    }
}

/// λ1², λ2² and the axis from the longest column; columns are those of D, then those of s·B'.
fn longer_derivative<R: Real>(columns: [Option<&[[R; 2]; 2]>; 2]) -> ([R; 2], [R::Narrow; 2]) {
    let zero = R::from_f64(0.0);
    let columns = [0, 1, 2, 3].map(|i: usize| match columns[i / 2] {
        Some(m) => [m[0][i % 2], m[1][i % 2]],
        None => [zero; 2],
    });
    let squares = columns.map(|[x, y]| x * x + y * y);
    let mut longest = 0;
    for i in 1..4 {
        if squares[i] > squares[longest] {
            longest = i;
        }
    }
    let rest = (0..4).filter(|&i| i != longest).fold(zero, |sum, i| sum + squares[i]);
    let [x, y] = columns[longest];
    let length = squares[longest].sqrt();
    let axis = if length.is_zero() {
        [1.0, 0.0].map(R::Narrow::from_f64)
    } else if x.is_zero() {
        [0.0, 1.0].map(R::Narrow::from_f64)
    } else {
        let [x, y] = [x, y].map(|t| (t / length).narrow());
        let zero = R::Narrow::from_f64(0.0);
        if x < zero { [-x, zero - y] } else { [x, y] }
    };
    ([squares[longest], rest], axis)
}
