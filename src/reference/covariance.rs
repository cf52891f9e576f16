//! Stage `covariance`: K, the quadratic form of the footprint.

use super::real::Real;
use super::tap::{Tap, put};
use crate::stage::Stage;

/// K = D·Dᵀ + (sB')(sB')ᵀ = (a, b; b, c) (Schilling, eq. 3 corrected, 12 and 13).
#[inline]
pub fn covariance<R: Real, T: Tap>(
    d: &[[R; 2]; 2],
    rough: Option<&[[R; 2]; 2]>,
    tap: &mut T,
) -> [R; 3] {
    let outer = |m: &[[R; 2]; 2]| {
        let row = |i: usize, j: usize| m[i][0] * m[j][0] + m[i][1] * m[j][1];
        [row(0, 0), row(0, 1), row(1, 1)]
    };
    let mut k = outer(d);
    if let Some(b) = rough {
        let [a, b, c] = outer(b);
        k = [k[0] + a, k[1] + b, k[2] + c];
    }
    put(tap, Stage::Covariance, "k", &k);
    k
}
