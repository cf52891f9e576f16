//! Rules of `hit`: the search and the cone's footprint at the hit.

use rtl_model::cone::Dyadic;
use rtl_model::distance::{DistanceMemory, Kind};
use rtl_model::fx::Flags;
use rtl_model::regs::Reg;
use rtl_model::stages::ray_cone::{Cfg, propagate};

use super::Case;
use super::front::{components, rotation};
use super::jacobian::{derivative, project_d};
use super::ports::{vector, word};
use super::sheet::{Sheet, real, within, zero};
use crate::base::num;
use crate::policy::{ConeEnv, HitFootprint, HitStatus, LookUp, Method};
use crate::reference::real::Real;
use crate::reference::vector::{add, beside, cross, dot, scale};
use crate::reference::wide::Wide;

/// How the search ended, as the device says.
fn status(case: &Case<'_>) -> Option<HitStatus> {
    let number = case.output("status").or_else(|| case.output("hit.status"))?;
    HitStatus::ALL.get(usize::try_from(number).ok()?).copied()
}

/// The look-up of a direction in units of its own codes: face by the codes, then (u, v) and texel coordinates.
fn look_up(s: &mut Sheet<'_>, index: usize, q: [Wide; 3], memory: &DistanceMemory) {
    let exact = rotation(s).map_or(q, |a| a.map(|row| dot(row, q)));
    // Only the direction counts: the register's power of two is that of the codes that came.
    let own = s.codes(Reg::HitLookUp).get(3 * index).map_or(0, |c| c.frac);
    s.block_direction(Reg::HitLookUp, 3 * index, exact);
    let Kind::Cube { size, codes } = &memory.kind else {
        return;
    };
    let raw = [0, 1, 2].map(|i| s.codes(Reg::HitLookUp).get(3 * index + i).map_or(0, |c| c.raw));
    let face = rtl_model::stages::cube_face::select(raw);
    let [sc, tc, ma] = components(face, raw.map(|x| Wide::code(x, own)));
    let n = real(f64::from(num::u32(*size)));
    let bilinear = s.config.policy.hit.lookup == LookUp::Bilinear;
    for (i, side) in [sc, tc].into_iter().enumerate() {
        let exact = side / ma;
        let quotient = within(exact, Sheet::share(exact, s.tables.recip));
        let uv = s.fixed_in(Reg::HitUv, 2 * index + i, quotient, real(1.0));
        let shift = if bilinear { real(0.5) } else { zero() };
        s.fixed(Reg::HitS, 2 * index + i, (uv + real(1.0)) * n * real(0.5) - shift);
    }
    if bilinear {
        radius(s, index, face, *size, codes, memory.scale);
    }
}

/// The distance from four texels, where all are finite.
fn radius(s: &mut Sheet<'_>, index: usize, face: usize, size: usize, codes: &[u32], scale: i64) {
    let one = 1i64 << s.config.format(Reg::HitS).frac;
    let most = num::i64(size) - 1;
    let mut place = [(0usize, 0i64); 2];
    for (i, place) in place.iter_mut().enumerate() {
        let code = s.codes(Reg::HitS).get(2 * index + i).map_or(0, |c| c.raw);
        let whole = code.div_euclid(one);
        let clamped = whole.clamp(-1, most);
        let weight = match whole.cmp(&clamped) {
            std::cmp::Ordering::Less => 0,
            std::cmp::Ordering::Equal => code.rem_euclid(one),
            std::cmp::Ordering::Greater => one,
        };
        *place = (num::usize(clamped + 1), weight);
    }
    let [(x, wx), (y, wy)] = place;
    let stride = size + 2;
    let at = (face * stride + y) * stride + x;
    let finite = s.config.format(Reg::HitDistance).max_raw();
    let sub = 2 * i64::from(s.config.format(Reg::HitS).frac);
    let frac = i64::from(s.config.format(Reg::HitDistance).frac) - scale + sub;
    let mut sum = zero();
    for (k, weight) in [
        (0, (one - wx) * (one - wy)),
        (1, wx * (one - wy)),
        (stride, (one - wx) * wy),
        (stride + 1, wx * wy),
    ] {
        let code = codes.get(at + k).copied().map_or(i64::MAX, i64::from);
        if weight > 0 && code > finite {
            return;
        }
        sum = sum + Wide::code(code.min(finite) * weight, frac);
    }
    s.fixed(Reg::HitRadius, index, sum);
}

/// The state of the search: the last undershoot and overshoot as (d, ratio).
struct Bracket {
    under: (Wide, Wide),
    over: Option<(Wide, Wide)>,
    side: i32,
}

/// The rules.
pub(super) fn hit(s: &mut Sheet<'_>, case: &Case<'_>, memory: Option<&DistanceMemory>) {
    let (Some(memory), Some(status)) = (memory, status(case)) else {
        return;
    };
    for c in 0..3 {
        if let Some(x) = word(case, "x", c) {
            s.fixed(Reg::HitX, c, x);
        }
    }
    vector(s, case, Reg::HitDirection, "r");
    let width = i64::from(s.config.format(Reg::HitDirection).magnitude_bits());
    let mantissas = [0, 1, 2].map(|i| s.codes(Reg::HitDirection).get(i).map_or(0, |c| c.raw));
    let v = if mantissas == [0; 3] {
        [zero(), zero(), real(1.0)]
    } else {
        mantissas.map(|m| Wide::code(m, width - 1))
    };
    let inv = s.scalar(Reg::HitInvNorm, 0, s.rsqrt(dot(v, v)));
    let r = s.fixed_all(Reg::HitR, 0, scale(inv, v));
    let x = s.vector(Reg::HitX, 0);
    look_up(s, 0, r, memory);
    look_up(s, 1, x, memory);
    measure(s, 0, x, 1);
    let far = s.value(Reg::HitRadius, 0);
    let p = s.value(Reg::HitRatio, 0);
    if s.has(Reg::HitD, 0) {
        let stopped = matches!(status, HitStatus::AtSurface | HitStatus::Outside);
        let first = if stopped { zero() } else { far * (real(1.0) - p) };
        s.fixed(Reg::HitD, 0, first);
    }
    point(s, 0, x, r);
    let mut bracket = Bracket { under: (zero(), p), over: None, side: 0 };
    for k in 0..num::usize(s.config.policy.hit.iterations) {
        if !s.has(Reg::HitLength, k + 1) {
            break;
        }
        // A component of an earlier look-up holds its place where none was made.
        let l = s.vector(Reg::HitL, 3 * k);
        look_up(s, k + 2, l, memory);
        measure(s, k + 1, l, k + 2);
        step(s, k, far, &mut bracket);
        if s.has(Reg::HitD, k + 1) {
            s.fixed(Reg::HitD, k + 1, s.value(Reg::HitD, k) + s.value(Reg::HitStep, k));
            point(s, k + 1, x, r);
        }
    }
    let last = (0..).take_while(|k| s.has(Reg::HitL, 3 * k)).last();
    let to = match last {
        Some(k) if status != HitStatus::Escaped => s.vector(Reg::HitL, 3 * k),
        _ => r,
    };
    s.block(Reg::HitTo, 0, to);
    basis(s, r);
}

/// |q| and |q|/dist(q).
fn measure(s: &mut Sheet<'_>, index: usize, q: [Wide; 3], look_up: usize) {
    let length = s.fixed(Reg::HitLength, index, s.sqrt(dot(q, q)));
    let radius = s.value(Reg::HitRadius, look_up);
    if !s.has(Reg::HitRadius, look_up) || radius.is_zero() || length.is_zero() {
        return;
    }
    let exact = length / radius;
    // 1/dist goes through a register of its own, of which a trace shows the last value alone.
    let word = libm::ldexp(1.0, 1 - num::i32(s.config.format(Reg::HitInvRadius).magnitude_bits()));
    let share = (1.0 + s.tables.recip) * (1.0 + word) - 1.0;
    s.fixed(Reg::HitRatio, index, within(exact, Sheet::share(exact, share)));
}

/// l = x + R d.
fn point(s: &mut Sheet<'_>, index: usize, x: [Wide; 3], r: [Wide; 3]) {
    s.fixed_all(Reg::HitL, 3 * index, add(x, scale(s.value(Reg::HitD, index), r)));
}

/// The step after ratio f, by the unit's method.
fn step(s: &mut Sheet<'_>, k: usize, far: Wide, bracket: &mut Bracket) {
    let one = real(1.0);
    let (d, f) = (s.value(Reg::HitD, k), s.value(Reg::HitRatio, k + 1));
    let tau = s.config.policy.hit.tolerance_bits.map_or(zero(), |bits| Wide::code(1, bits.into()));
    let side = if f > one + tau {
        1
    } else if f < one - tau {
        -1
    } else {
        return;
    };
    let again = bracket.side == side;
    bracket.side = side;
    let before = bracket.under;
    let halves = s.config.policy.hit.method == Method::Illinois && again;
    let mut other = if side > 0 {
        bracket.over = Some((d, f));
        bracket.under
    } else {
        bracket.under = (d, f);
        bracket.over.unwrap_or((zero(), zero()))
    };
    if halves && bracket.over.is_some() {
        other.1 = s.fixed(Reg::HitHalved, k, (one + other.1) * real(0.5));
        if side > 0 {
            bracket.under = other;
        } else {
            bracket.over = Some(other);
        }
    }
    if !s.has(Reg::HitStep, k) {
        return;
    }
    let secant =
        bracket.over.is_none() && s.config.policy.hit.method == Method::Secant && f > before.1;
    if bracket.over.is_none() && !secant {
        s.fixed(Reg::HitStep, k, far * (one - f));
        return;
    }
    let (d0, p) = if secant { before } else { other };
    let exact = (d - d0) * (one - f) / (f - p);
    let exact = match secant {
        true if exact > far * real(4.0) => far * real(4.0),
        _ => exact,
    };
    let word = |reg: Reg| libm::ldexp(1.0, 1 - num::i32(s.config.format(reg).magnitude_bits()));
    let share =
        (1.0 + s.tables.recip) * (1.0 + word(Reg::HitInvSpan)) * (1.0 + word(Reg::HitQuotient))
            - 1.0;
    s.fixed(Reg::HitStep, k, within(exact, Sheet::share(exact, share)));
}

/// t1 = unit(e_k × R), t2 = R × t1, where the footprint is a disc.
fn basis(s: &mut Sheet<'_>, r: [Wide; 3]) {
    if !s.has(Reg::HitInvAcross, 0) {
        return;
    }
    let across = beside(r);
    let inv = s.scalar(Reg::HitInvAcross, 0, s.rsqrt(dot(across, across)));
    if s.config.policy.hit.footprint == HitFootprint::Disc {
        let t1 = s.fixed_all(Reg::HitTangent, 0, scale(inv, across));
        s.fixed_all(Reg::HitTangent, 3, cross(r, t1));
    }
}

/// D = G(l)·|w|·[t1 t2].
pub(super) fn projected(s: &mut Sheet<'_>, case: &Case<'_>, memory: Option<&DistanceMemory>) {
    let (Some(status), Some(memory)) = (status(case), memory) else {
        return;
    };
    let escaped = status == HitStatus::Escaped;
    if escaped && s.config.policy.cone.env == ConeEnv::Otk || !s.has(Reg::JacDvr, 0) {
        return;
    }
    let Some(width) = width(s, case, escaped, memory) else {
        return;
    };
    for col in 0..2 {
        let t = s.vector(Reg::HitTangent, 3 * col);
        derivative(s, Reg::JacDvr, 3 * col, scale(width, t));
        project_d(s, case, col);
    }
}

/// The width (of a ray that escaped: the angle) of the cone at the hit. The cone's registers have rules of their own.
fn width(s: &Sheet<'_>, case: &Case<'_>, escaped: bool, memory: &DistanceMemory) -> Option<Wide> {
    if case.input("has_cone", 0)? == 0 {
        return Some(zero());
    }
    let words = |name: &str, n: usize| -> Option<Vec<u64>> {
        (0..n).map(|c| case.input(name, c).map(i64::cast_unsigned)).collect()
    };
    let (x, r, cone) = (words("x", 3)?, words("r", 3)?, words("cone", 2)?);
    let cfg = Cfg::new(s.config);
    let ray = x.iter().chain(&r).chain(&cone);
    let mut dither =
        cfg.dither(ray.fold(0, |sum, word| (sum ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15)));
    let mut flags = Flags::default();
    let cone = cfg.load([cone[0], cone[1]], &mut dither, &mut flags);
    let value = if escaped {
        cfg.angle(cone.angle)
    } else {
        let d = s.codes(Reg::HitD).iter().rev().find(|c| c.is_written())?;
        let _ = memory;
        let d = Dyadic::fixed(d.raw, d.frac);
        cfg.width(propagate(&cfg, cone, d, &mut dither, &mut flags).width)
    };
    let raw = i64::try_from(value.m).ok()?;
    Some(Wide::code(raw, -value.e))
}
