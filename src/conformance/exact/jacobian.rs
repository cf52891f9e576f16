//! Rules of `jacobian` and `roughness`.

use rtl_model::regs::Reg;

use super::Case;
use super::front::{components, rotation};
use super::sheet::{Known, Sheet, real, within, zero};
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
            within(dot(row, exact), size * unseen)
        })
    });
    if rotated.is_some() && exact.iter().any(|x| !s.is_inside(reg, first, *x)) {
        return;
    }
    s.fixed_all(reg, first, rotated.unwrap_or_else(|| exact.map(Known::from)));
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
        let numerator = s.fixed(numerator, c, exact);
        s.fixed(quotient, c, numerator * s.value(Reg::FaceInvMa, 0));
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
            s.fixed_all(Reg::JacDnMod, 3 * col, dn);
        }
        return;
    }
    let n = s.vector(Reg::FrameN, 0);
    if !n.iter().all(|x| x.is_zero()) {
        s.fixed(Reg::JacInvNn, 0, s.recip(dot(n, n)));
    }
    let inv = s.value(Reg::JacInvNn, 0);
    let mut perp = [[zero(); 3]; 2];
    for (col, dn) in dn.into_iter().enumerate() {
        let n_dot_dn = s.fixed(Reg::JacNIdotDn, col, dot(n, dn));
        let along = s.fixed(Reg::JacAlong, col, n_dot_dn * inv);
        perp[col] = s.fixed_all(Reg::JacDnPerp, 3 * col, subtract(dn, scale(along, n)));
    }
    let mut out = perp;
    if s.config.policy.jacobian.dnmod == Dnmod::Frame {
        let e = [s.vector(Reg::FrameE1, 0), s.vector(Reg::FrameE2, 0)];
        let h = s.vector(Reg::FrameH, 0);
        let cotangent = dot(n, h) / dot(e[1], h);
        // Both mantissas are cut to 30 fraction bits.
        let slack = Sheet::share(cotangent, s.tables.recip + 2.0 * libm::ldexp(1.0, -30));
        let cotangent = s.fixed(Reg::JacTurn, 0, within(cotangent, slack));
        let b = [0, 1].map(|k| s.value(Reg::BumpB, k));
        for (col, perp) in perp.into_iter().enumerate() {
            let tilt = [0, 1].map(|k| {
                let perp_dot_e = s.fixed(Reg::JacPerpDotE, 2 * col + k, dot(perp, e[k]));
                s.fixed(Reg::JacTilt, 2 * col + k, perp_dot_e * inv)
            });
            let turn = s.fixed(Reg::JacTurn, 1 + col, tilt[0] * cotangent);
            for k in 0..2 {
                let around = scale(if k == 0 { turn } else { -turn }, e[1 - k]);
                let exact = subtract(around, scale(tilt[k], n));
                let de = s.fixed_all(Reg::JacDe, 6 * col + 3 * k, exact);
                out[col] = add(out[col], scale(b[k], de));
            }
        }
    }
    for (col, dn) in out.into_iter().enumerate() {
        s.fixed_all(Reg::JacDnMod, 3 * col, dn);
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
        let n_dv = s.fixed(Reg::JacNdotDv, col, dot(n, dv));
        let v_dn = s.fixed(Reg::JacVdotDn, col, dot(v, dn));
        let n_dn = s.fixed(Reg::JacNdotDn, col, dot(n, dn));
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
    let d = s.fixed_all(Reg::RoughScaled, 0, scale(scale_by, s.vector(Reg::RoughD, 0)));
    let (v, n) = (s.vector(Reg::ReflectV, 0), s.vector(Reg::ReflectN, 0));
    let nv = s.value(Reg::ReflectNdotV, 0);
    let two = real(2.0);
    for (col, reg) in [Reg::FrameE1, Reg::FrameE2].into_iter().enumerate() {
        let e = s.vector(reg, 0);
        let v_e = s.fixed(Reg::RoughVdotE, col, dot(v, e));
        let n_e = s.fixed(Reg::RoughNdotE, col, dot(n, e));
        let sum = add(scale(two * nv, e), scale(two * v_e, n));
        derivative(s, Reg::RoughDvr, 3 * col, subtract(sum, scale(two * n_e, v)));
        project(s, case, col, [Reg::RoughDvr, Reg::RoughNumerator, Reg::RoughE]);
    }
    let e = |k: usize| s.value(Reg::RoughE, k);
    let exact = [e(0) * d[0], e(0) * d[1] + e(1) * d[2], e(2) * d[0], e(2) * d[1] + e(3) * d[2]];
    s.fixed_all(Reg::RoughB, 0, exact);
}
