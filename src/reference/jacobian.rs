//! Stage `jacobian`: D, the derivatives of the face coordinates by screen position.

use super::cube_face::Facing;
use super::local_frame::Frame;
use super::real::Real;
use super::reflect::Reflection;
use super::tap::{Tap, put};
use super::vector::{Vector, add, cross, dot, largest, scale, subtract, transform};
use crate::policy::Dnmod;
use crate::stage::Stage;

/// The inputs of the derivatives.
#[derive(Clone, Copy, Debug)]
pub struct Derivatives<R> {
    /// ∂v by x and by y.
    pub dv: [Vector<R>; 2],
    /// ∂n by x and by y, of the interpolated normal.
    pub dn: [Vector<R>; 2],
}

/// The surface at the fragment.
#[derive(Clone, Copy, Debug)]
pub struct Surface<R> {
    /// Direction to the eye.
    pub v: Vector<R>,
    /// Interpolated normal.
    pub n: Vector<R>,
    /// Modified normal (n without a bump).
    pub n_mod: Vector<R>,
    /// Frame and offsets, with a bump.
    pub bump: Option<(Frame<R>, [R; 2])>,
    /// Reflected direction.
    pub reflection: Reflection<R>,
    /// Where it meets the cube.
    pub facing: Facing<R>,
}

/// D, row by row, and the size of the terms that were added to make it.
#[derive(Clone, Copy, Debug)]
pub struct Jacobian<R> {
    /// [∂u/∂x, ∂u/∂y], [∂v/∂x, ∂v/∂y].
    pub d: [[R; 2]; 2],
    /// About the largest magnitude that entered a sum: what cancels is known to this times 2⁻⁵³.
    pub terms: R,
}

/// D = G·A·(J_v·∂v + J_n·∂n_mod), J_v = 2nnᵀ − ⟨n,n⟩I, J_n = 2⟨n,v⟩I + 2nvᵀ − 2vnᵀ, n the modified
/// normal (Schilling, eq. 5, 6, 8, 9; unit.md section 4 for the signs of the faces and for ∂n_mod).
#[inline]
pub fn jacobian<R: Real, T: Tap>(
    surface: &Surface<R>,
    derivatives: &Derivatives<R>,
    dnmod: Dnmod,
    rotation: Option<&[[R; 3]; 3]>,
    tap: &mut T,
) -> Jacobian<R> {
    let stage = Stage::Jacobian;
    put(tap, stage, "dv_dx", &derivatives.dv[0]);
    put(tap, stage, "dv_dy", &derivatives.dv[1]);
    put(tap, stage, "dn_dx", &derivatives.dn[0]);
    put(tap, stage, "dn_dy", &derivatives.dn[1]);
    let (dn_mod, dn_terms) = normal_derivatives(surface, derivatives, dnmod, tap);

    let n = surface.n_mod;
    let two = R::from_f64(2.0);
    let n_dot_dv = derivatives.dv.map(|dv| dot(n, dv));
    let v_dot_dn = dn_mod.map(|dn| dot(surface.v, dn));
    let n_dot_dn = dn_mod.map(|dn| dot(n, dn));
    let dv_r: [Vector<R>; 2] = std::array::from_fn(|i| {
        let by_v = subtract(
            scale(two * n_dot_dv[i], n),
            scale(surface.reflection.n_dot_n, derivatives.dv[i]),
        );
        let by_n = scale(two, by_normal(surface, dn_mod[i], v_dot_dn[i], n_dot_dn[i]));
        let sum = add(by_v, by_n);
        rotation.map_or(sum, |matrix| transform(matrix, sum))
    });
    let numerators = dv_r.map(|derivative| surface.facing.numerator(derivative));
    let inv_ma = surface.facing.inv_ma;
    let d: [[R; 2]; 2] =
        std::array::from_fn(|row| std::array::from_fn(|column| numerators[column][row] * inv_ma));

    put(tap, stage, "n_dot_dv", &n_dot_dv);
    put(tap, stage, "v_dot_dn", &v_dot_dn);
    put(tap, stage, "n_dot_dn", &n_dot_dn);
    put(tap, stage, "dv_r", dv_r.as_flattened());
    let [x, y] = numerators;
    put(tap, stage, "numerator", &[x[0], y[0], x[1], y[1]]);
    put(tap, stage, "d", d.as_flattened());

    let largest_of = |pair: [Vector<R>; 2]| {
        let [x, y] = pair.map(largest);
        x.larger(y)
    };
    let size = largest(n);
    let terms = size * (size * largest_of(derivatives.dv) + largest(surface.v) * dn_terms) * inv_ma;
    Jacobian { d, terms }
}

/// ½·J_n·d = ⟨n,v⟩d + n⟨v,d⟩ − v⟨n,d⟩ with the two products given.
#[inline]
pub(super) fn by_normal<R: Real>(
    surface: &Surface<R>,
    d: Vector<R>,
    v_dot_d: R,
    n_dot_d: R,
) -> Vector<R> {
    let first = scale(surface.reflection.n_dot_v, d);
    let second = scale(v_dot_d, surface.n_mod);
    subtract(add(first, second), scale(n_dot_d, surface.v))
}

/// ∂n_mod by x and y under the policy, and the largest magnitude that went into it.
#[inline]
fn normal_derivatives<R: Real, T: Tap>(
    surface: &Surface<R>,
    derivatives: &Derivatives<R>,
    dnmod: Dnmod,
    tap: &mut T,
) -> ([Vector<R>; 2], R) {
    let zero = R::from_f64(0.0);
    let mut terms = zero;
    let mut count = |size: R| terms = size.larger(terms);
    for dn in derivatives.dn {
        count(largest(dn));
    }
    let mut dn_mod = derivatives.dn;
    if let Some((frame, [b1, b2])) = &surface.bump {
        if dnmod != Dnmod::Paper {
            let n = surface.n;
            let n_dot_n = dot(n, n);
            let along = derivatives
                .dn
                .map(|dn| if n_dot_n.is_zero() { zero } else { dot(n, dn) / n_dot_n });
            put(tap, Stage::Jacobian, "along", &along);
            for (dn, along) in dn_mod.iter_mut().zip(along) {
                *dn = subtract(*dn, scale(along, n));
            }
        }
        if dnmod == Dnmod::Frame {
            for dn in &mut dn_mod {
                let (de1, de2) = frame_derivatives(surface.n, frame, *dn);
                let turn = add(scale(*b1, de1), scale(*b2, de2));
                let size = largest(de1) * b1.abs() + largest(de2) * b2.abs();
                count(
                    size + largest(scale(frame.inv_length * frame.n_length, cross(frame.h, *dn)))
                        * b1.abs(),
                );
                *dn = add(*dn, turn);
            }
        }
        put(tap, Stage::Jacobian, "dn_mod", dn_mod.as_flattened());
    }
    (dn_mod, terms)
}

/// ∂e1 and ∂e2 while n changes by dn ⟂ n and h stays.
///
/// With c = h × n and ĉ = c/|c|: ∂ĉ = (∂c − ĉ⟨ĉ,∂c⟩)/|c|, ∂c = h × dn; e1 = |n|ĉ and e2 = n × ĉ, and
/// |n| does not change because dn ⟂ n.
#[inline]
fn frame_derivatives<R: Real>(
    n: Vector<R>,
    frame: &Frame<R>,
    dn: Vector<R>,
) -> (Vector<R>, Vector<R>) {
    let dc = cross(frame.h, dn);
    let direction = frame.direction;
    let across = subtract(dc, scale(dot(direction, dc), direction));
    let turn = scale(frame.inv_length, across);
    (scale(frame.n_length, turn), add(cross(dn, direction), cross(n, turn)))
}
