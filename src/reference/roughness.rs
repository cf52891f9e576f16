//! Stage `roughness`: the roughness ellipse carried to the face.

use super::jacobian::{Surface, by_normal};
use super::local_frame::Frame;
use super::real::Real;
use super::tap::{Tap, put};
use super::vector::{Vector, dot, largest, scale, transform};
use crate::stage::Stage;

/// s·B' and the size of the terms that were added to make it.
#[derive(Clone, Copy, Debug)]
pub struct Rough<R> {
    /// s·B', row by row.
    pub b: [[R; 2]; 2],
    /// About the largest magnitude that entered a sum.
    pub terms: R,
}

/// s·B' = G·A·J_n·[e1 e2]·(s·B), B = [d1 d2; 0 d3] (Schilling, eq. 10 and 11).
#[inline]
pub fn roughness<R: Real, T: Tap>(
    surface: &Surface<R>,
    frame: &Frame<R>,
    d: [R; 3],
    s: R,
    rotation: Option<&[[R; 3]; 3]>,
    tap: &mut T,
) -> Rough<R> {
    let stage = Stage::Roughness;
    let [d1, d2, d3] = d.map(|x| s * x);
    let basis = [frame.e1, frame.e2];
    let v_dot_e = basis.map(|e| dot(surface.v, e));
    let n_dot_e = basis.map(|e| dot(surface.n_mod, e));
    let dv_r: [Vector<R>; 2] = std::array::from_fn(|i| {
        let half = by_normal(surface, basis[i], v_dot_e[i], n_dot_e[i]);
        let whole = scale(R::from_f64(2.0), half);
        rotation.map_or(whole, |matrix| transform(matrix, whole))
    });
    let numerators = dv_r.map(|derivative| surface.facing.numerator(derivative));
    let inv_ma = surface.facing.inv_ma;
    let e: [[R; 2]; 2] =
        std::array::from_fn(|row| [numerators[0][row] * inv_ma, numerators[1][row] * inv_ma]);
    let b = e.map(|[by_e1, by_e2]| [by_e1 * d1, by_e1 * d2 + by_e2 * d3]);

    put(tap, stage, "d_scaled", &[d1, d2, d3]);
    put(tap, stage, "v_dot_e", &v_dot_e);
    put(tap, stage, "n_dot_e", &n_dot_e);
    put(tap, stage, "dv_r", dv_r.as_flattened());
    let [x, y] = numerators;
    put(tap, stage, "numerator", &[x[0], y[0], x[1], y[1]]);
    put(tap, stage, "e", e.as_flattened());
    put(tap, stage, "b", b.as_flattened());

    let terms = largest(surface.n_mod)
        * largest(surface.v)
        * frame.n_length
        * inv_ma
        * largest([d1, d2, d3]);
    Rough { b, terms }
}
