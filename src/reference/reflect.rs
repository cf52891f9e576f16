//! Stage `reflect`: the reflected direction.

use super::real::Real;
use super::tap::{Tap, put};
use super::vector::{Vector, dot, scale, subtract};
use crate::stage::Stage;

/// The reflected direction and the products that the derivatives use again.
#[derive(Clone, Copy, Debug)]
pub struct Reflection<R> {
    /// The direction; its length is |v|·|n|².
    pub v_r: Vector<R>,
    /// ⟨n, v⟩.
    pub n_dot_v: R,
    /// ⟨n, n⟩.
    pub n_dot_n: R,
}

/// v_r = 2n⟨v, n⟩ − v⟨n, n⟩ with n the modified normal (Schilling, eq. 4). Nothing is normalised.
#[inline]
pub fn reflect<R: Real, T: Tap>(v: Vector<R>, n: Vector<R>, tap: &mut T) -> Reflection<R> {
    let n_dot_v = dot(n, v);
    let n_dot_n = dot(n, n);
    let v_r = subtract(scale(R::from_f64(2.0) * n_dot_v, n), scale(n_dot_n, v));
    let stage = Stage::Reflect;
    put(tap, stage, "v", &v);
    put(tap, stage, "n", &n);
    put(tap, stage, "n_dot_v", &[n_dot_v]);
    put(tap, stage, "n_dot_n", &[n_dot_n]);
    put(tap, stage, "v_r", &v_r);
    Reflection { v_r, n_dot_v, n_dot_n }
}
