//! Stage `surface_footprint`: from a cone's width to ddx, ddy and D on a 2-D texture (Cline 2023).

use super::flags::{Flag, Flags};
use super::real::Real;
use super::tap::{Tap, put};
use super::vector::{Vector, beside, cross, dot, scale, vector};
use crate::fragment::{Tangents, TexFragment};
use crate::policy::{ConeGradient, ConeRules, Policy};
use crate::stage::Stage;

/// A cone's ellipse on the surface and in the texture.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceFootprint<R> {
    /// dPdx and dPdy in world units.
    pub dp: [Vector<R>; 2],
    /// ddx and ddy: (∂s, ∂t) per pixel.
    pub dd: [[R; 2]; 2],
    /// D in texels of level 0: [∂s/∂x·W, ∂s/∂y·W], [∂t/∂x·H, ∂t/∂y·H].
    pub d: [[R; 2]; 2],
}

/// From |D·N| = 0.999 on OptiX Toolkit takes D and N for parallel.
const OTK_LIMIT: f64 = 0.999;

/// dPdx = unit(D − ⟨D,N⟩N)·|w|/max(|⟨D,N⟩|, 1/max_anisotropy), dPdy = unit(D × N)·|w|, and
/// ddx = (⟨dPdx,∇s⟩, ⟨dPdx,∇t⟩) with the surface gradients of s and t.
///
/// D ∥ N, or one of them 0: any orthogonal pair of length |w| across N, (0, 0, 1) for no N. With OptiX Toolkit's
/// rules w keeps its sign, and that pair is taken from |⟨D,N⟩| = 0.999 on.
pub fn surface_footprint<R: Real, T: Tap>(
    fragment: &TexFragment,
    width: R,
    size: [usize; 2],
    policy: &Policy,
    flags: &mut Flags,
    tap: &mut T,
) -> SurfaceFootprint<R> {
    let zero = R::from_f64(0.0);
    let one = R::from_f64(1.0);
    let otk = policy.cone.rules == ConeRules::Otk;
    let d = unit(vector::<R>(fragment.d));
    let n = unit(vector::<R>(fragment.n));
    let cosine = dot(d, n);
    let crossed = cross(d, n);
    let none = |v: Vector<R>| v.iter().all(|c| c.is_zero());
    let parallel = none(crossed);
    if parallel {
        flags.insert(Flag::SurfParallel);
    }
    let flat = parallel || (otk && cosine.abs() >= R::from_f64(OTK_LIMIT));
    let n = if none(n) { [zero, zero, one] } else { n };
    let across = unit(if flat { beside(n) } else { crossed });
    let along = cross(n, across);
    let width = if otk { width } else { width.abs() };
    let least =
        R::from_f64(1.0) / R::from_f64(f64::from(policy.surface_footprint.max_anisotropy.max(1)));
    let seen = if flat { one } else { cosine.abs().larger(least) };
    let dp = [scale(width / seen, along), scale(width, across)];
    let (grad, edges) = match fragment.tangents {
        Tangents::Surface { dp_ds, dp_dt } => ([dp_ds, dp_dt], None),
        Tangents::Triangle { edges, st } => (edges, Some(st)),
    };
    let grad = gradients(grad.map(vector), policy.cone.gradient, flags, tap);
    let dd = dp.map(|dp| {
        let [b, c] = grad.map(|grad| dot(dp, grad));
        match edges {
            None => [b, c],
            Some(st) => {
                let [to_b, to_c] = st.map(|st| st.map(R::from_f64));
                [b * to_b[0] + c * to_c[0], b * to_b[1] + c * to_c[1]]
            }
        }
    });
    let texels = size.map(|n| R::from_f64(n as f64));
    let d_matrix = [0, 1].map(|row: usize| [0, 1].map(|col: usize| dd[col][row] * texels[row]));
    let stage = Stage::SurfaceFootprint;
    put(tap, stage, "d_unit", &d);
    put(tap, stage, "n_unit", &n);
    put(tap, stage, "cosine", &[cosine]);
    put(tap, stage, "across", &across);
    put(tap, stage, "along", &along);
    put(tap, stage, "dp_dx", &dp[0]);
    put(tap, stage, "dp_dy", &dp[1]);
    put(tap, stage, "ddx", &dd[0]);
    put(tap, stage, "ddy", &dd[1]);
    put(tap, stage, "d", d_matrix.as_flattened());
    SurfaceFootprint { dp, dd, d: d_matrix }
}

/// v/|v|; 0 for 0. The power of two of its largest component is taken out by `R`'s range.
fn unit<R: Real>(v: Vector<R>) -> Vector<R> {
    let square = dot(v, v);
    if square.is_zero() {
        return v;
    }
    let length = square.sqrt();
    v.map(|c| c / length)
}

/// ∇s and ∇t on the surface. With g = ∂P/∂s × ∂P/∂t the normal equations give ∇s = ∂P/∂t × g/|g|² and
/// ∇t = g × ∂P/∂s/|g|²; the note's dot products are ∂P/∂s/|∂P/∂s|² and ∂P/∂t/|∂P/∂t|², which also stand in where g = 0.
fn gradients<R: Real, T: Tap>(
    [s, t]: [Vector<R>; 2],
    policy: ConeGradient,
    flags: &mut Flags,
    tap: &mut T,
) -> [Vector<R>; 2] {
    let zero = R::from_f64(0.0);
    let over = |v: Vector<R>, square: R| {
        if square.is_zero() { [zero; 3] } else { v.map(|c| c / square) }
    };
    let g = cross(s, t);
    let square = dot(g, g);
    let gram = policy == ConeGradient::Gram;
    if gram && square.is_zero() {
        flags.insert(Flag::SurfDegenerate);
    }
    let grad = if gram && !square.is_zero() {
        [over(cross(t, g), square), over(cross(g, s), square)]
    } else {
        [over(s, dot(s, s)), over(t, dot(t, t))]
    };
    put(tap, Stage::SurfaceFootprint, "grad_s", &grad[0]);
    put(tap, Stage::SurfaceFootprint, "grad_t", &grad[1]);
    grad
}
