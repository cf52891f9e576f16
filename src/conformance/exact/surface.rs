//! Rules of `surface_footprint`.

use rtl_model::cone::Dyadic;
use rtl_model::regs::Reg;
use rtl_model::stages::footprint::planar_unit;

use super::Case;
use super::ports::{vector, word};
use super::sheet::{Known, Sheet, real, within, zero};
use crate::policy::{ConeGradient, ConeRules};
use crate::reference::real::Real;
use crate::reference::vector::{beside, cross, dot, scale};
use crate::reference::wide::Wide;

/// Mantissas of a block as a vector whose largest component lies in [1, 2).
fn nominal(s: &Sheet<'_>, reg: Reg) -> [Wide; 3] {
    let width = i64::from(s.config.format(reg).magnitude_bits());
    [0, 1, 2].map(|i| s.codes(reg).get(i).map_or(zero(), |c| Wide::code(c.raw, width - 1)))
}

/// The cone's width, signed.
fn width(s: &Sheet<'_>, case: &Case<'_>) -> Option<Wide> {
    let code = u32::try_from(case.input("width", 0)?).ok()?;
    let (Dyadic { negative, m, e }, _) = s.config.policy.cone.format.float().unpack(code);
    let raw = i64::try_from(m).ok()?;
    Some(Wide::code(if negative { -raw } else { raw }, -e))
}

/// |⟨D,N⟩| as it divides, dPdx and dPdy.
fn project(s: &mut Sheet<'_>, case: &Case<'_>) {
    for (k, (port, to)) in
        [(Reg::SurfDirection, Reg::SurfD), (Reg::SurfNormal, Reg::SurfN)].into_iter().enumerate()
    {
        let v = nominal(s, port);
        let all_zero = v.iter().all(|x| x.is_zero());
        if !all_zero {
            // Relative to the mantissas' own power of two.
            let shift = s.codes(port).first().map_or(0, |c| c.frac)
                - i64::from(s.config.format(port).magnitude_bits())
                + 1;
            let Known { value, slack } = s.rsqrt(dot(v, v));
            let inv = within(value.times_power(shift), slack.times_power(shift));
            let inv = s.scalar(Reg::SurfInvLength, k, inv).times_power(-shift);
            s.fixed_all(to, 0, scale(inv, v));
        }
    }
    let (d, n) = (s.vector(Reg::SurfD, 0), s.vector(Reg::SurfN, 0));
    s.fixed(Reg::SurfCosine, 0, dot(d, n));
    let mut across = cross(d, n);
    let parallel = across.iter().all(|x| x.is_zero());
    let otk = s.config.policy.cone.rules == ConeRules::Otk;
    let cosine = s.value(Reg::SurfCosine, 0).abs();
    let flat = otk && cosine >= real(16_760_439.0 / 16_777_216.0);
    let n = if n.iter().all(|x| x.is_zero()) { [zero(), zero(), real(1.0)] } else { n };
    if parallel || flat {
        across = beside(n);
    }
    let across = s.block(Reg::SurfCross, 0, across);
    let inv = s.scalar(Reg::SurfInvCross, 0, s.rsqrt(dot(across, across)));
    let across = s.fixed_all(Reg::SurfAcross, 0, scale(inv, across));
    let along = s.fixed_all(Reg::SurfAlong, 0, cross(n, across));
    let lsb = s.lsb(Reg::SurfCosine, 0);
    let least = real(1.0 / f64::from(s.config.policy.surface_footprint.max_anisotropy.max(1)));
    let (divisor, rounded) = if parallel || flat {
        (real(1.0), zero())
    } else if cosine > least {
        (cosine, zero())
    } else {
        // The limit itself is rounded to the cosine's fraction, where that has not all of its bits.
        let exact =
            s.config.policy.surface_footprint.max_anisotropy.is_power_of_two() && least >= lsb;
        (least, if exact { zero() } else { lsb })
    };
    let Known { value, slack } = s.recip(divisor);
    let inv = within(value, slack + value * value * rounded);
    let inv = s.scalar(Reg::SurfInvCosine, 0, inv);
    let Some(w) = width(s, case) else { return };
    let w = if otk { w } else { w.abs() };
    let stretch = s.scalar(Reg::SurfStretch, 0, w * inv);
    s.fixed_all(Reg::SurfDpDx, 0, scale(stretch, along));
    s.fixed_all(Reg::SurfDpDy, 0, scale(w, across));
}

/// ∇s and ∇t.
fn gradients(s: &mut Sheet<'_>) {
    let tangents = [s.vector(Reg::SurfDpDs, 0), s.vector(Reg::SurfDpDt, 0)];
    let regs = [Reg::SurfGradS, Reg::SurfGradT];
    let gram = s.config.policy.cone.gradient == ConeGradient::Gram;
    if gram {
        s.block(Reg::SurfPlane, 0, cross(tangents[0], tangents[1]));
    }
    let plane = s.vector(Reg::SurfPlane, 0);
    if !gram || plane.iter().all(|x| x.is_zero()) {
        for (i, v) in tangents.into_iter().enumerate() {
            let inv = s.scalar(Reg::SurfInvSquare, i, s.recip(dot(v, v)));
            s.block(regs[i], 0, scale(inv, v));
        }
        return;
    }
    let inv = s.scalar(Reg::SurfInvSquare, 0, s.recip(dot(plane, plane)));
    let turned = [cross(tangents[1], plane), cross(plane, tangents[0])];
    for (i, exact) in turned.into_iter().enumerate() {
        let turned = s.block(Reg::SurfTurned, 3 * i, exact);
        s.block(regs[i], 0, scale(inv, turned));
    }
}

/// A register pair with one exponent, gathered from sums of unlike exponents: bits far below the largest are cut.
fn gathered(s: &mut Sheet<'_>, regs: [(Reg, usize); 4], exact: [Wide; 4]) {
    // The narrowest register's bits count for all.
    let widths = regs.map(|(reg, _)| s.config.format(reg).magnitude_bits());
    let width = widths.into_iter().min().unwrap_or(1);
    let codes = regs.map(|(reg, c)| s.codes(reg).get(c).map_or(0, |c| c.raw.unsigned_abs()));
    let most = codes.into_iter().max().unwrap_or(0);
    let is_normal = most >> (width - 1) != 0 && most >> width == 0;
    for ((reg, c), x) in regs.into_iter().zip(exact) {
        // Aligning may cut bits before the rounding: one LSB more.
        let slack = s.lsb(reg, c);
        s.mantissas(reg, c, [within(x, slack)], is_normal || most == 0);
    }
}

/// The stage.
pub(super) fn surface_footprint(s: &mut Sheet<'_>, case: &Case<'_>, size: u32) {
    for (reg, name) in [
        (Reg::SurfDirection, "d"),
        (Reg::SurfNormal, "n"),
        (Reg::SurfDpDs, "dp_ds"),
        (Reg::SurfDpDt, "dp_dt"),
    ] {
        vector(s, case, reg, name);
    }
    for (k, reg) in [Reg::SurfS, Reg::SurfT].into_iter().enumerate() {
        if let Some(x) = word(case, "st", k) {
            s.fixed(reg, 0, x);
        }
    }
    project(s, case);
    gradients(s);
    let dp = [s.vector(Reg::SurfDpDx, 0), s.vector(Reg::SurfDpDy, 0)];
    let grad = [s.vector(Reg::SurfGradS, 0), s.vector(Reg::SurfGradT, 0)];
    let sums = [0, 1, 2, 3].map(|c: usize| dot(dp[c / 2], grad[c % 2]));
    let dd = [(Reg::SurfDdx, 0), (Reg::SurfDdx, 1), (Reg::SurfDdy, 0), (Reg::SurfDdy, 1)];
    if case.input("triangle", 0) == Some(1) {
        if let [Some(a), Some(b), Some(c), Some(d)] = [0, 1, 2, 3].map(|k| word(case, "edge_st", k))
        {
            s.block(Reg::SurfEdge, 0, [a, b, c, d]);
        }
        let at = [0, 1, 2, 3].map(|c| (Reg::SurfBarycentric, c));
        gathered(s, at, sums);
        let [b_x, c_x, b_y, c_y] = at.map(|(reg, c)| s.value(reg, c));
        let [s_b, s_c, t_b, t_c] = [0, 1, 2, 3].map(|c| s.value(Reg::SurfEdge, c));
        let sums = [
            b_x * s_b + c_x * s_c,
            b_x * t_b + c_x * t_c,
            b_y * s_b + c_y * s_c,
            b_y * t_b + c_y * t_c,
        ];
        gathered(s, dd, sums);
    } else {
        gathered(s, dd, sums);
    }
    let [s_x, t_x, s_y, t_y] = dd.map(|(reg, c)| s.value(reg, c));
    let [columns, rows] = [size, (size / 2).max(1)].map(|n| real(f64::from(n)));
    let texels = [s_x * columns, s_y * columns, t_x * rows, t_y * rows];
    // The stage alone counts D in half of a power of two of texels; the tap brings it back.
    debug_assert!(planar_unit([size, size]) >= 1);
    s.block(Reg::SurfJac, 0, texels);
}
