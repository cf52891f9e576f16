//! Rules of `local_frame`, `bump`, `reflect` and `cube_face`.

use rtl_model::config::ROTATION_FRAC;
use rtl_model::regs::Reg;
use rtl_model::stages::cube_face::{FACES, select};

use super::Case;
use super::sheet::{Sheet, real, zero};
use crate::reference::real::Real;
use crate::reference::vector::{add, beside, cross, dot, scale, subtract};
use crate::reference::wide::Wide;

/// e1 = (h × n)/|h × n|·|n|, e2 = (n × e1)/|n|.
pub(super) fn local_frame(s: &mut Sheet<'_>) {
    let (n, h) = (s.vector(Reg::FrameN, 0), s.vector(Reg::FrameH, 0));
    let across = cross(h, n);
    let parallel = across.iter().all(|x| x.is_zero());
    let across = if parallel { beside(n) } else { across };
    s.block(Reg::FrameCross, 0, &across, zero());
    let c = s.vector(Reg::FrameCross, 0);
    if c.iter().all(|x| x.is_zero()) {
        // n = 0: what is multiplied by it does not matter.
        return;
    }
    let (inv, slack) = s.rsqrt(dot(c, c));
    s.block(Reg::FrameInvLength, 0, &[inv], slack);
    let (length, slack) = s.sqrt(dot(n, n));
    s.fixed(Reg::FrameLength, 0, length, slack);
    let inv = s.value(Reg::FrameInvLength, 0);
    s.block(Reg::FrameScale, 0, &[s.value(Reg::FrameLength, 0) * inv], zero());
    let e1 = scale(s.value(Reg::FrameScale, 0), c);
    let n_cross = cross(n, c);
    let e2 = scale(inv, s.vector(Reg::FrameNCross, 0));
    for i in 0..3 {
        s.fixed(Reg::FrameE1, i, e1[i], zero());
        s.fixed(Reg::FrameNCross, i, n_cross[i], zero());
        s.fixed(Reg::FrameE2, i, e2[i], zero());
    }
}

/// n_mod = n + b1 e1 + b2 e2.
pub(super) fn bump(s: &mut Sheet<'_>) {
    let (e1, e2) = (s.vector(Reg::FrameE1, 0), s.vector(Reg::FrameE2, 0));
    let [b1, b2] = [0, 1].map(|i| s.value(Reg::BumpB, i));
    let sum = add(s.vector(Reg::FrameN, 0), add(scale(b1, e1), scale(b2, e2)));
    for (i, x) in sum.into_iter().enumerate() {
        s.fixed(Reg::BumpN, i, x, zero());
    }
}

/// v_r = 2n⟨n,v⟩ − v⟨n,n⟩.
pub(super) fn reflect(s: &mut Sheet<'_>) {
    if s.has(Reg::BumpN, 0) {
        s.block(Reg::ReflectN, 0, &s.vector(Reg::BumpN, 0), zero());
    } else if s.has(Reg::FrameN, 0) {
        s.block(Reg::ReflectN, 0, &s.vector(Reg::FrameN, 0), zero());
    }
    let (n, v) = (s.vector(Reg::ReflectN, 0), s.vector(Reg::ReflectV, 0));
    s.fixed(Reg::ReflectNdotV, 0, dot(n, v), zero());
    s.fixed(Reg::ReflectNdotN, 0, dot(n, n), zero());
    let twice = real(2.0) * s.value(Reg::ReflectNdotV, 0);
    let exact = subtract(scale(twice, n), scale(s.value(Reg::ReflectNdotN, 0), v));
    s.block(Reg::ReflectVr, 0, &exact, zero());
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
        s.block(Reg::FaceRotated, 0, &a.map(|row| dot(row, d)), zero());
        reg = Reg::FaceRotated;
    }
    // A ray without a cone looks nothing up.
    let Some(face) = case.face().filter(|_| s.has(Reg::FaceInvMa, 0)) else {
        return;
    };
    let expected = i64::try_from(select(looked_up(s, reg))).unwrap_or(4);
    s.choice("face", i64::try_from(face).unwrap_or(4), expected);
    let [sc, tc, ma] = components(face, s.vector(reg, 0));
    let (inv, slack) = s.recip(ma);
    s.block(Reg::FaceInvMa, 0, &[inv], slack);
    let inv = s.value(Reg::FaceInvMa, 0);
    for (reg, side) in [(Reg::FaceU, sc), (Reg::FaceV, tc)] {
        s.fixed_in(reg, 0, side * inv, zero(), Some(real(1.0)));
    }
}
