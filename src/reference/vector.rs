//! Three-vectors over any `Real`.

use super::real::Real;

/// A vector of three components.
pub type Vector<R> = [R; 3];

/// The vector of three doubles.
pub fn vector<R: Real>(values: [f64; 3]) -> Vector<R> {
    values.map(R::from_f64)
}

/// ⟨a, b⟩, summed from the left.
#[inline]
pub fn dot<R: Real>(a: Vector<R>, b: Vector<R>) -> R {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a × b, each component to a few ulp of itself.
#[inline]
pub fn cross<R: Real>(a: Vector<R>, b: Vector<R>) -> Vector<R> {
    [
        R::product_difference(a[1], b[2], a[2], b[1]),
        R::product_difference(a[2], b[0], a[0], b[2]),
        R::product_difference(a[0], b[1], a[1], b[0]),
    ]
}

/// a + b.
#[inline]
pub fn add<R: Real>(a: Vector<R>, b: Vector<R>) -> Vector<R> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// a − b.
#[inline]
pub fn subtract<R: Real>(a: Vector<R>, b: Vector<R>) -> Vector<R> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// s · a.
#[inline]
pub fn scale<R: Real>(s: R, a: Vector<R>) -> Vector<R> {
    a.map(|x| s * x)
}

/// The matrix times the vector; rows come first.
pub fn transform<R: Real>(matrix: &[[R; 3]; 3], a: Vector<R>) -> Vector<R> {
    [dot(matrix[0], a), dot(matrix[1], a), dot(matrix[2], a)]
}

/// The largest magnitude of a component.
#[inline]
pub fn largest<R: Real>(a: Vector<R>) -> R {
    a.into_iter().fold(R::from_f64(0.0), |most, x| x.abs().larger(most))
}

/// e_k × v, k the smallest |v_k| (ties z, y, x).
pub fn beside<R: Real>([x, y, z]: Vector<R>) -> Vector<R> {
    let zero = R::from_f64(0.0);
    let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
    if az <= ax && az <= ay {
        [-y, x, zero]
    } else if ay <= ax {
        [z, zero, -x]
    } else {
        [zero, -z, y]
    }
}
