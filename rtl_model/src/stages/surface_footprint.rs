//! `surface_footprint`: from a cone's width to ddx, ddy and D on a 2-D texture (Cline 2023).
//!
//! dPdx = unit(D − ⟨D,N⟩N)·|w|/max(|⟨D,N⟩|, 1/max_anisotropy), dPdy = unit(D × N)·|w|; then ddx = (⟨dPdx,∇s⟩, ⟨dPdx,∇t⟩)
//! with the surface gradients ∇s, ∇t. D − ⟨D,N⟩N = N × (D × N), so that one normalisation gives both directions and they
//! are orthogonal whatever was rounded. A triangle's ∇ are those of its barycentric coordinates.

use super::{Roms, Sink, bits, cross, dot, fits, frac};
use crate::cone::Dyadic;
use crate::config::{Config, ConfigError};
use crate::fx::{Block, Quantizer, block};
use crate::policy::{ConeGradient, ConeRules};
use crate::regs::{Event, Reg, Register};
use crate::stages::footprint::{MAX_FACE, planar_unit};
use crate::tables::rom::{mantissa, mantissa4};
use crate::tap::Tap;

const P: i64 = 30;
/// Fraction bits of the limit above which OptiX Toolkit takes D and N for parallel.
const LIMIT_FRAC: u32 = 24;
/// 0.999 at that fraction.
const LIMIT: i64 = 16_760_439;

/// Compiled configuration.
#[derive(Clone, Debug, Hash)]
pub struct Cfg {
    /// Port of the ray's direction.
    pub direction: Register,
    /// Port of the normal.
    pub normal: Register,
    /// Ports of ∂P/∂s and ∂P/∂t, or of AB and AC.
    pub tangents: [Register; 2],
    /// Port of a triangle's texture coordinates.
    pub edge: Register,
    /// Ports of s and t.
    pub st: [Register; 2],
    inv_length: Register,
    unit: [Register; 2],
    cosine: Register,
    least: i64,
    otk_limit: Option<i64>,
    inv_cosine: Register,
    stretch: Register,
    cross: Register,
    inv_cross: Register,
    across: Register,
    along: Register,
    dp_dx: Register,
    dp_dy: Register,
    gradient: ConeGradient,
    plane: Register,
    inv_square: Register,
    turned: Register,
    grad: [Register; 2],
    barycentric: Register,
    dd: [Register; 2],
    d: Register,
    lift: i64,
    size: [i64; 2],
}

/// A hit of a ray on a textured surface, behind the ports.
#[derive(Clone, Copy, Debug)]
pub struct In {
    /// Mantissas of the ray's direction.
    pub direction: Block<3>,
    /// Mantissas of the normal.
    pub normal: Block<3>,
    /// Mantissas of ∂P/∂s and ∂P/∂t, or of AB and AC.
    pub tangents: [Block<3>; 2],
    /// Of a triangle, the differences of s along AB and AC, then of t.
    pub edge: Option<Block<4>>,
    /// The cone's width.
    pub width: Dyadic,
}

/// The texture request.
#[derive(Clone, Copy, Debug, Default)]
pub struct Out {
    /// Codes of dPdx and dPdy, in units of 2^`exponent`.
    pub dp: [[i64; 3]; 2],
    /// The width's power of two.
    pub exponent: i64,
    /// Mantissas of D row by row, the largest in [1, 2) times 2^`d_exp`.
    pub d: [i64; 4],
    /// Power of two of D in units of half of [`planar_unit`] texels.
    pub d_exp: i64,
}

impl Cfg {
    /// Compiles and checks the stage for a texture of `size` columns and rows.
    pub fn new(config: &Config, size: [u32; 2]) -> Result<Self, ConfigError> {
        let f = |reg| frac(config, reg);
        let q = |reg, frac_in| config.register(reg, frac_in);
        let b = |reg| bits(config, reg);
        let max = config.policy.surface_footprint.max_anisotropy.max(1);
        for (reg, inv) in [(Reg::SurfDirection, Reg::SurfD), (Reg::SurfNormal, Reg::SurfN)] {
            fits(Reg::SurfInvLength, 2 * b(reg) + 2)?;
            fits(inv, b(reg) + b(Reg::SurfInvLength))?;
        }
        let unit = b(Reg::SurfD).max(b(Reg::SurfN));
        fits(Reg::SurfCosine, 2 * unit + 2)?;
        fits(Reg::SurfCross, 2 * unit + 1)?;
        fits(Reg::SurfInvCross, 2 * b(Reg::SurfCross) + 2)?;
        fits(Reg::SurfAcross, b(Reg::SurfCross) + b(Reg::SurfInvCross))?;
        fits(Reg::SurfAlong, unit + b(Reg::SurfAcross) + 1)?;
        // A cone's significand has at most 24 bits.
        fits(Reg::SurfStretch, 24 + b(Reg::SurfInvCosine))?;
        fits(Reg::SurfDpDx, b(Reg::SurfAlong) + b(Reg::SurfStretch))?;
        fits(Reg::SurfDpDy, b(Reg::SurfAcross) + 24)?;
        let tangent = b(Reg::SurfDpDs).max(b(Reg::SurfDpDt));
        fits(Reg::SurfPlane, 2 * tangent + 1)?;
        fits(Reg::SurfInvSquare, 2 * tangent.max(b(Reg::SurfPlane)) + 2)?;
        fits(Reg::SurfTurned, tangent + b(Reg::SurfPlane) + 1)?;
        let turned = tangent.max(b(Reg::SurfTurned));
        fits(Reg::SurfGradS, turned + b(Reg::SurfInvSquare))?;
        let along = b(Reg::SurfDpDx).max(b(Reg::SurfDpDy));
        let grad = b(Reg::SurfGradS).max(b(Reg::SurfGradT));
        fits(Reg::SurfDdx, along + grad + 2)?;
        fits(Reg::SurfDdx, b(Reg::SurfBarycentric) + b(Reg::SurfEdge) + 1)?;
        let sized = b(Reg::SurfDdx).max(b(Reg::SurfDdy)) + MAX_FACE.ilog2() + 1;
        fits(Reg::SurfJac, sized)?;
        Ok(Self {
            direction: q(Reg::SurfDirection, 0),
            normal: q(Reg::SurfNormal, 0),
            tangents: [q(Reg::SurfDpDs, 0), q(Reg::SurfDpDt, 0)],
            edge: q(Reg::SurfEdge, 0),
            st: [q(Reg::SurfS, 0), q(Reg::SurfT, 0)],
            inv_length: q(Reg::SurfInvLength, 0),
            unit: [q(Reg::SurfD, 0), q(Reg::SurfN, 0)],
            cosine: q(Reg::SurfCosine, f(Reg::SurfD) + f(Reg::SurfN)),
            least: ((2 << f(Reg::SurfCosine)) / i64::from(max) + 1) / 2,
            otk_limit: (config.policy.cone.rules == ConeRules::Otk).then(|| {
                let up = f(Reg::SurfCosine) - i64::from(LIMIT_FRAC);
                if up >= 0 { LIMIT << up } else { LIMIT >> -up }
            }),
            inv_cosine: q(Reg::SurfInvCosine, 0),
            stretch: q(Reg::SurfStretch, 0),
            cross: q(Reg::SurfCross, 0),
            inv_cross: q(Reg::SurfInvCross, 0),
            across: q(Reg::SurfAcross, 0),
            along: q(Reg::SurfAlong, f(Reg::SurfN) + f(Reg::SurfAcross)),
            dp_dx: q(Reg::SurfDpDx, 0),
            dp_dy: q(Reg::SurfDpDy, 0),
            gradient: config.policy.cone.gradient,
            plane: q(Reg::SurfPlane, 0),
            inv_square: q(Reg::SurfInvSquare, 0),
            turned: q(Reg::SurfTurned, 0),
            grad: [q(Reg::SurfGradS, 0), q(Reg::SurfGradT, 0)],
            barycentric: q(Reg::SurfBarycentric, 0),
            dd: [q(Reg::SurfDdx, 0), q(Reg::SurfDdy, 0)],
            d: q(Reg::SurfJac, 0),
            lift: i64::from(planar_unit(size).ilog2()) - 1,
            size: size.map(|n| i64::from(n.clamp(1, MAX_FACE))),
        })
    }
}

/// The stage for one hit.
#[inline(always)]
pub fn surface_footprint<T: Tap>(
    cfg: &Cfg,
    roms: &Roms,
    input: &In,
    sink: &mut Sink<'_, T>,
) -> Out {
    let mut out = Out::default();
    project(cfg, roms, input, &mut out, sink);
    let grad = gradients(cfg, roms, input.tangents, sink);
    let mut dot_frac = [0; 4];
    let mut sums = [0; 4];
    for (c, (sum, sum_frac)) in sums.iter_mut().zip(&mut dot_frac).enumerate() {
        let (j, i) = (c / 2, c % 2);
        *sum = dot(out.dp[j], grad[i].m);
        let q = [&cfg.dp_dx, &cfg.dp_dy][j];
        *sum_frac = q.frac() + grad[i].frac - out.exponent;
    }
    // ddx then ddy, with one exponent.
    let [x, y] = &cfg.dd;
    let dd: [&Quantizer; 4] = [x, x, y, y];
    let dd = match input.edge {
        None => block::gather(T::STANDARD, dd, &sums, &dot_frac),
        Some(edge) => {
            let at = block::gather(T::STANDARD, [&cfg.barycentric; 4], &sums, &dot_frac);
            sink.put(&cfg.barycentric, 0, &at, 0);
            let [b_x, c_x, b_y, c_y] = at.m;
            let [s_b, s_c, t_b, t_c] = edge.m;
            let sums = [
                b_x * s_b + c_x * s_c,
                b_x * t_b + c_x * t_c,
                b_y * s_b + c_y * s_c,
                b_y * t_b + c_y * t_c,
            ];
            block::gather(T::STANDARD, dd, &sums, &[at.frac + edge.frac; 4])
        }
    };
    for (c, m) in dd.m.iter().enumerate() {
        sink.tap.put(sink.lane, cfg.dd[c / 2].reg, c % 2, *m, dd.frac);
    }
    let [s_x, t_x, s_y, t_y] = dd.m;
    let [columns, rows] = cfg.size;
    let texels = [s_x * columns, s_y * columns, t_x * rows, t_y * rows];
    let d = block::normalize(T::STANDARD, &cfg.d, &texels, dd.frac + cfg.lift);
    sink.put(&cfg.d, 0, &d, 0);
    out.d = d.m;
    out.d_exp = cfg.d.block_frac() - d.frac;
    out
}

/// A vector's unit vector.
#[inline(always)]
fn unit<T: Tap>(
    cfg: &Cfg,
    roms: &Roms,
    index: usize,
    v: &Block<3>,
    sink: &mut Sink<'_, T>,
) -> [i64; 3] {
    let (m, e) = mantissa4(dot(v.m, v.m).max(1));
    let inv = block::normalize(T::STANDARD, &cfg.inv_length, &[roms.rsqrt.rsqrt(m)], P + e);
    let q = &cfg.unit[index];
    // Relative to the mantissas, so that the vector's own power of two does not count.
    sink.put(&cfg.inv_length, index, &inv, v.frac);
    let shift = inv.frac - q.frac();
    let mut out = [0; 3];
    for (i, o) in out.iter_mut().enumerate() {
        *o = sink.shift(q, i, v.m[i] * inv.m[0], shift, 0);
    }
    out
}

/// dPdx and dPdy.
#[inline(always)]
fn project<T: Tap>(cfg: &Cfg, roms: &Roms, input: &In, out: &mut Out, sink: &mut Sink<'_, T>) {
    let d = unit(cfg, roms, 0, &input.direction, sink);
    let n = unit(cfg, roms, 1, &input.normal, sink);
    let cosine = sink.write(&cfg.cosine, 0, dot(d, n), 0);
    let mut crossed = cross(d, n);
    let parallel = crossed == [0; 3];
    sink.flags.event(Event::SurfParallel, parallel);
    let flat = cfg.otk_limit.is_some_and(|limit| cosine.abs() >= limit);
    let n = if n == [0; 3] { [0, 0, 1 << cfg.unit[1].format.frac] } else { n };
    let mut crossed_frac = cfg.unit[0].frac() + cfg.unit[1].frac();
    if parallel || flat {
        crossed = beside(n);
        crossed_frac = cfg.unit[1].frac();
    }
    let crossed = sink.block(&cfg.cross, &crossed, crossed_frac, 0);
    let (m, e) = mantissa4(dot(crossed.m, crossed.m).max(1));
    let inv = [roms.rsqrt.rsqrt(m)];
    let inv = sink.block(&cfg.inv_cross, &inv, P + e - crossed.frac, 0);
    let shift = crossed.frac + inv.frac - cfg.across.frac();
    let mut across = [0; 3];
    for (i, a) in across.iter_mut().enumerate() {
        let product = crossed.m[i] * inv.m[0];
        *a = sink.shift(&cfg.across, i, product, shift, 0);
    }
    let turned = cross(n, across);
    let mut along = [0; 3];
    for (i, a) in along.iter_mut().enumerate() {
        *a = sink.write(&cfg.along, i, turned[i], 0);
    }
    // |w| in [1, 2) times 2^exponent.
    let width = input.width;
    let top = 63 - i64::from(width.m.max(1).leading_zeros());
    out.exponent = if width.is_zero() { 0 } else { width.e + top };
    let w = i64::try_from(width.m).unwrap_or(0);
    let w = if cfg.otk_limit.is_some() && width.negative { -w } else { w };
    let one = 1i64 << cfg.cosine.format.frac;
    let (m, e) = mantissa(if flat || parallel { one } else { cosine.abs().max(cfg.least).max(1) });
    let inv_frac = P + e - cfg.cosine.frac();
    let inv = [roms.recip.recip(m)];
    let inv = sink.block(&cfg.inv_cosine, &inv, inv_frac, 0);
    let stretch = [w * inv.m[0]];
    let stretch_frac = inv.frac + top;
    let stretch = sink.block(&cfg.stretch, &stretch, stretch_frac, out.exponent);
    for i in 0..3 {
        let q = &cfg.dp_dx;
        let shift = cfg.along.frac() + stretch.frac - q.frac();
        let product = along[i] * stretch.m[0];
        out.dp[0][i] = sink.shift(q, i, product, shift, out.exponent);
        let q = &cfg.dp_dy;
        let shift = cfg.across.frac() + top - q.frac();
        out.dp[1][i] = sink.shift(q, i, across[i] * w, shift, out.exponent);
    }
}

/// e_k × v, k the smallest |v_k| (ties z, y, x).
#[inline(always)]
pub(crate) fn beside([x, y, z]: [i64; 3]) -> [i64; 3] {
    let [ax, ay, az] = [x, y, z].map(i64::abs);
    if az <= ax && az <= ay {
        [-y, x, 0]
    } else if ay <= ax {
        [z, 0, -x]
    } else {
        [0, -z, y]
    }
}

/// ∇s and ∇t on the surface.
#[inline(always)]
fn gradients<T: Tap>(
    cfg: &Cfg,
    roms: &Roms,
    [s, t]: [Block<3>; 2],
    sink: &mut Sink<'_, T>,
) -> [Block<3>; 2] {
    let plane = if cfg.gradient == ConeGradient::Gram {
        sink.block(&cfg.plane, &cross(s.m, t.m), s.frac + t.frac, 0)
    } else {
        Block { m: [0; 3], frac: 0 }
    };
    let flat = plane.m == [0; 3];
    sink.flags.event(Event::SurfDegenerate, flat && cfg.gradient == ConeGradient::Gram);
    let mut out = [Block { m: [0; 3], frac: 0 }; 2];
    if flat {
        for (i, v) in [s, t].into_iter().enumerate() {
            let inv = inverse(cfg, roms, i, dot(v.m, v.m), 2 * v.frac, sink);
            let scaled = v.m.map(|c| c * inv.m[0]);
            out[i] = sink.block(&cfg.grad[i], &scaled, v.frac + inv.frac, 0);
        }
        return out;
    }
    let inv = inverse(cfg, roms, 0, dot(plane.m, plane.m), 2 * plane.frac, sink);
    for (i, (turned, v)) in
        [(cross(t.m, plane.m), t), (cross(plane.m, s.m), s)].into_iter().enumerate()
    {
        let turned = block::normalize(T::STANDARD, &cfg.turned, &turned, v.frac + plane.frac);
        sink.put(&cfg.turned, 3 * i, &turned, 0);
        let scaled = turned.m.map(|c| c * inv.m[0]);
        out[i] = sink.block(&cfg.grad[i], &scaled, turned.frac + inv.frac, 0);
    }
    out
}

/// 1/x as a block register; 0 for 0.
#[inline(always)]
fn inverse<T: Tap>(
    cfg: &Cfg,
    roms: &Roms,
    index: usize,
    x: i64,
    x_frac: i64,
    sink: &mut Sink<'_, T>,
) -> Block<1> {
    let (m, e) = mantissa(x.max(1));
    let y = if x == 0 { 0 } else { roms.recip.recip(m) };
    let inv = block::normalize(T::STANDARD, &cfg.inv_square, &[y], P + e - x_frac);
    sink.put(&cfg.inv_square, index, &inv, 0);
    inv
}
