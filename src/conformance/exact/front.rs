//! Rules of `local_frame`, `bump`, `reflect` and `cube_face`.

use rtl_model::config::ROTATION_FRAC;
use rtl_model::regs::Reg;
use rtl_model::stages::cube_face::{FACES, select};

use super::Case;
use super::sheet::{Sheet, real};
use crate::reference::real::Real;
use crate::reference::vector::{add, beside, cross, dot, scale, subtract};
use crate::reference::wide::Wide;

/// e1 = (h × n)/|h × n|·|n|, e2 = (n × e1)/|n|.
pub(super) fn local_frame(s: &mut Sheet<'_>) {
    let (n, h) = (s.vector(Reg::FrameN, 0), s.vector(Reg::FrameH, 0));
    let across = cross(h, n);
    let parallel = across.iter().all(|x| x.is_zero());
    let across = if parallel { beside(n) } else { across };
    let c = s.block(Reg::FrameCross, 0, across);
    if c.iter().all(|x| x.is_zero()) {
        // n = 0: what is multiplied by it does not matter.
        return;
    }
    let inv = s.scalar(Reg::FrameInvLength, 0, s.rsqrt(dot(c, c)));
    let length = s.fixed(Reg::FrameLength, 0, s.sqrt(dot(n, n)));
    let scale_by = s.scalar(Reg::FrameScale, 0, length * inv);
    s.fixed_all(Reg::FrameE1, 0, scale(scale_by, c));
    let n_cross = s.fixed_all(Reg::FrameNCross, 0, cross(n, c));
    s.fixed_all(Reg::FrameE2, 0, scale(inv, n_cross));
}

/// n_mod = n + b1 e1 + b2 e2.
pub(super) fn bump(s: &mut Sheet<'_>) {
    let (e1, e2) = (s.vector(Reg::FrameE1, 0), s.vector(Reg::FrameE2, 0));
    let [b1, b2] = [0, 1].map(|i| s.value(Reg::BumpB, i));
    let sum = add(s.vector(Reg::FrameN, 0), add(scale(b1, e1), scale(b2, e2)));
    s.fixed_all(Reg::BumpN, 0, sum);
}

/// v_r = 2n⟨n,v⟩ − v⟨n,n⟩.
pub(super) fn reflect(s: &mut Sheet<'_>) {
    if s.has(Reg::BumpN, 0) {
        s.block(Reg::ReflectN, 0, s.vector(Reg::BumpN, 0));
    } else if s.has(Reg::FrameN, 0) {
        s.block(Reg::ReflectN, 0, s.vector(Reg::FrameN, 0));
    }
    let (n, v) = (s.vector(Reg::ReflectN, 0), s.vector(Reg::ReflectV, 0));
    let n_dot_v = s.fixed(Reg::ReflectNdotV, 0, dot(n, v));
    let n_dot_n = s.fixed(Reg::ReflectNdotN, 0, dot(n, n));
    let v_r = subtract(scale(real(2.0) * n_dot_v, n), scale(n_dot_n, v));
    s.block(Reg::ReflectVr, 0, v_r);
}

/// (sc, tc, |ma|) of a vector on a face.
pub(super) fn components(face: usize, d: [Wide; 3]) -> [Wide; 3] {
    FACES[face].map(|(axis, negative)| if negative { -d[axis] } else { d[axis] })
}

/// The rotation's rows.
pub(super) fn rotation(s: &Sheet<'_>) -> Option<[[Wide; 3]; 3]> {
    let rows = s.config.rotation?;
    Some(rows.map(|row| row.map(|x| Wide::code(x, i64::from(ROTATION_FRAC)))))
}

/// The direction that is looked up, as codes with one exponent.
fn looked_up(s: &Sheet<'_>, reg: Reg) -> [i64; 3] {
    [0, 1, 2].map(|i| s.codes(reg).get(i).map_or(0, |c| c.raw))
}

/// Face, 1/|ma|, u = sc/|ma|, v = tc/|ma|.
pub(super) fn cube_face(s: &mut Sheet<'_>, case: &Case<'_>) {
    let mut reg = if s.has(Reg::HitTo, 0) { Reg::HitTo } else { Reg::ReflectVr };
    if let Some(a) = rotation(s) {
        let d = s.vector(reg, 0);
        s.block(Reg::FaceRotated, 0, a.map(|row| dot(row, d)));
        reg = Reg::FaceRotated;
    }
    // A ray without a cone looks nothing up.
    let Some(face) = case.face().filter(|_| s.has(Reg::FaceInvMa, 0)) else {
        return;
    };
    let expected = i64::try_from(select(looked_up(s, reg))).unwrap_or(4);
    s.choice("face", i64::try_from(face).unwrap_or(4), expected);
    let [sc, tc, ma] = components(face, s.vector(reg, 0));
    let inv = s.scalar(Reg::FaceInvMa, 0, s.recip(ma));
    for (reg, side) in [(Reg::FaceU, sc), (Reg::FaceV, tc)] {
        s.fixed_in(reg, 0, side * inv, real(1.0));
    }
}
