//! Rules of `jacobian` and `roughness`.

use rtl_model::regs::Reg;

use super::Case;
use super::front::{components, rotation};
use super::sheet::{Sheet, real, zero};
use crate::policy::Dnmod;
use crate::reference::real::Real;
use crate::reference::vector::{add, dot, scale, subtract};
use crate::reference::wide::Wide;

type Vector = [Wide; 3];

/// A derivative of v_r in its register. With a rotation the register is written twice, and what was written first is
/// not seen: its rounding counts for each entry of A, and where it left its range nothing is known.
pub(super) fn derivative(s: &mut Sheet<'_>, reg: Reg, first: usize, exact: Vector) {
    let unseen = s.unseen(reg, first);
    let rotated = rotation(s).map(|a| {
        a.map(|row| {
            let size = row.iter().fold(zero(), |sum, x| sum + x.abs());
            (dot(row, exact), size * unseen)
        })
    });
    if rotated.is_some() && exact.iter().any(|x| !s.is_inside(reg, first, *x)) {
        return;
    }
    let rows = rotated.unwrap_or_else(|| exact.map(|x| (x, zero())));
    for (i, (x, slack)) in rows.into_iter().enumerate() {
        s.fixed(reg, first + i, x, slack);
    }
}

/// ∂sc − u·∂|ma| and ∂tc − v·∂|ma|, then times 1/|ma|: one column of D or of E.
fn project(
    s: &mut Sheet<'_>,
    case: &Case<'_>,
    column: usize,
    [derivative, numerator, quotient]: [Reg; 3],
) {
    let Some(face) = case.face() else { return };
    // v_r = 0 has no derivatives.
    let zero_direction = match case.input("zero", 0) {
        Some(zero) => zero == 1,
        None => s.value(Reg::FaceInvMa, 0).is_zero(),
    };
    let [sc, tc, ma] = components(face, s.vector(derivative, 3 * column));
    for (row, (side, at)) in [(sc, Reg::FaceU), (tc, Reg::FaceV)].into_iter().enumerate() {
        let c = 2 * row + column;
        let exact = if zero_direction { zero() } else { side - s.value(at, 0) * ma };
        s.fixed(numerator, c, exact, zero());
        let quotient_exact = s.value(numerator, c) * s.value(Reg::FaceInvMa, 0);
        s.fixed(quotient, c, quotient_exact, zero());
    }
}

/// D from derivatives of v_r.
pub(super) fn project_d(s: &mut Sheet<'_>, case: &Case<'_>, column: usize) {
    project(s, case, column, [Reg::JacDvr, Reg::JacNumerator, Reg::JacD]);
}

/// ∂n_mod by the unit's policy.
fn normal(s: &mut Sheet<'_>) {
    let dn = [s.vector(Reg::JacDnDx, 0), s.vector(Reg::JacDnDy, 0)];
    let bumped = s.has(Reg::BumpN, 0) || s.has(Reg::BumpB, 0);
    if !bumped || s.config.policy.jacobian.dnmod == Dnmod::Paper {
        for (col, dn) in dn.into_iter().enumerate() {
            for (i, x) in dn.into_iter().enumerate() {
                s.fixed(Reg::JacDnMod, 3 * col + i, x, zero());
            }
        }
        return;
    }
    let n = s.vector(Reg::FrameN, 0);
    if !n.iter().all(|x| x.is_zero()) {
        let (inv, slack) = s.recip(dot(n, n));
        s.fixed(Reg::JacInvNn, 0, inv, slack);
    }
    let inv = s.value(Reg::JacInvNn, 0);
    let mut perp = [[zero(); 3]; 2];
    for (col, dn) in dn.into_iter().enumerate() {
        s.fixed(Reg::JacNIdotDn, col, dot(n, dn), zero());
        s.fixed(Reg::JacAlong, col, s.value(Reg::JacNIdotDn, col) * inv, zero());
        let exact = subtract(dn, scale(s.value(Reg::JacAlong, col), n));
        for (i, x) in exact.into_iter().enumerate() {
            s.fixed(Reg::JacDnPerp, 3 * col + i, x, zero());
        }
        perp[col] = s.vector(Reg::JacDnPerp, 3 * col);
    }
    let mut out = perp;
    if s.config.policy.jacobian.dnmod == Dnmod::Frame {
        let e = [s.vector(Reg::FrameE1, 0), s.vector(Reg::FrameE2, 0)];
        let h = s.vector(Reg::FrameH, 0);
        let cotangent = dot(n, h) / dot(e[1], h);
        // Both mantissas are cut to 30 fraction bits.
        let slack = Sheet::share(cotangent, s.tables.recip + 2.0 * libm::ldexp(1.0, -30));
        s.fixed(Reg::JacTurn, 0, cotangent, slack);
        let b = [0, 1].map(|k| s.value(Reg::BumpB, k));
        for (col, perp) in perp.into_iter().enumerate() {
            let mut tilt = [zero(); 2];
            for (k, tilt) in tilt.iter_mut().enumerate() {
                let c = 2 * col + k;
                s.fixed(Reg::JacPerpDotE, c, dot(perp, e[k]), zero());
                s.fixed(Reg::JacTilt, c, s.value(Reg::JacPerpDotE, c) * inv, zero());
                *tilt = s.value(Reg::JacTilt, c);
            }
            s.fixed(Reg::JacTurn, 1 + col, tilt[0] * s.value(Reg::JacTurn, 0), zero());
            let turn = s.value(Reg::JacTurn, 1 + col);
            for k in 0..2 {
                let around = scale(if k == 0 { turn } else { -turn }, e[1 - k]);
                let exact = subtract(around, scale(tilt[k], n));
                let at = 6 * col + 3 * k;
                for (i, x) in exact.into_iter().enumerate() {
                    s.fixed(Reg::JacDe, at + i, x, zero());
                }
                out[col] = add(out[col], scale(b[k], s.vector(Reg::JacDe, at)));
            }
        }
    }
    for (col, dn) in out.into_iter().enumerate() {
        for (i, x) in dn.into_iter().enumerate() {
            s.fixed(Reg::JacDnMod, 3 * col + i, x, zero());
        }
    }
}

/// D = G A [J_v ∂v + J_n ∂n_mod].
pub(super) fn jacobian(s: &mut Sheet<'_>, case: &Case<'_>) {
    normal(s);
    let (v, n) = (s.vector(Reg::ReflectV, 0), s.vector(Reg::ReflectN, 0));
    let [nv, nn] = [s.value(Reg::ReflectNdotV, 0), s.value(Reg::ReflectNdotN, 0)];
    let two = real(2.0);
    for (col, port) in [Reg::JacDvDx, Reg::JacDvDy].into_iter().enumerate() {
        let (dv, dn) = (s.vector(port, 0), s.vector(Reg::JacDnMod, 3 * col));
        s.fixed(Reg::JacNdotDv, col, dot(n, dv), zero());
        s.fixed(Reg::JacVdotDn, col, dot(v, dn), zero());
        s.fixed(Reg::JacNdotDn, col, dot(n, dn), zero());
        let [n_dv, v_dn, n_dn] =
            [Reg::JacNdotDv, Reg::JacVdotDn, Reg::JacNdotDn].map(|reg| s.value(reg, col));
        let by_v = subtract(scale(two * n_dv, n), scale(nn, dv));
        let by_n = subtract(add(scale(two * nv, dn), scale(two * v_dn, n)), scale(two * n_dn, v));
        derivative(s, Reg::JacDvr, 3 * col, add(by_v, by_n));
        project_d(s, case, col);
    }
}

/// s·B' = G A J_n [e1 e2] · s·B.
pub(super) fn roughness(s: &mut Sheet<'_>, case: &Case<'_>) {
    if !s.has(Reg::RoughScaled, 0) {
        return;
    }
    let scale_by = Wide::code(s.config.roughness_scale, i64::from(rtl_model::config::SCALE_FRAC));
    for i in 0..3 {
        s.fixed(Reg::RoughScaled, i, scale_by * s.value(Reg::RoughD, i), zero());
    }
    let (v, n) = (s.vector(Reg::ReflectV, 0), s.vector(Reg::ReflectN, 0));
    let nv = s.value(Reg::ReflectNdotV, 0);
    let two = real(2.0);
    for (col, reg) in [Reg::FrameE1, Reg::FrameE2].into_iter().enumerate() {
        let e = s.vector(reg, 0);
        s.fixed(Reg::RoughVdotE, col, dot(v, e), zero());
        s.fixed(Reg::RoughNdotE, col, dot(n, e), zero());
        let [v_e, n_e] = [Reg::RoughVdotE, Reg::RoughNdotE].map(|reg| s.value(reg, col));
        let sum = add(scale(two * nv, e), scale(two * v_e, n));
        derivative(s, Reg::RoughDvr, 3 * col, subtract(sum, scale(two * n_e, v)));
        project(s, case, col, [Reg::RoughDvr, Reg::RoughNumerator, Reg::RoughE]);
    }
    let e = |k: usize| s.value(Reg::RoughE, k);
    let d = [0, 1, 2].map(|k| s.value(Reg::RoughScaled, k));
    let exact = [e(0) * d[0], e(0) * d[1] + e(1) * d[2], e(2) * d[0], e(2) * d[1] + e(3) * d[2]];
    for (c, x) in exact.into_iter().enumerate() {
        s.fixed(Reg::RoughB, c, x, zero());
    }
}
