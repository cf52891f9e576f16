//! The footprint at the hit: D = G(l)·|w|·[t1 t2], t1 and t2 across the ray, or moved along it onto the wall.

use super::{P, look_up};
use crate::config::{Config, ConfigError, ROTATION_FRAC};
use crate::distance::{BEYOND, DistanceMemory, Kind};
use crate::fx::block;
use crate::policy::{ConeEnv, HitFootprint};
use crate::regs::{Event, Reg, Register};
use crate::stages::cube_face::{components, direction};
use crate::stages::surface_footprint::beside;
use crate::stages::{Roms, Sink, bits, cross, dot, fits, frac};
use crate::tables::rom::{mantissa, mantissa4};
use crate::tap::Tap;

/// Fraction bits of [`FOUR_OVER_PI`].
const CONSTANT_FRAC: i64 = 30;
/// 4/π to the nearest 2^−30: 1.273239544735…
const FOUR_OVER_PI: i64 = 1_367_130_551;

/// Compiled configuration.
#[derive(Clone, Debug, Hash)]
pub struct Cfg {
    shape: HitFootprint,
    env: ConeEnv,
    max_probes: i64,
    r_frac: i64,
    inv_across: Register,
    tangent: Register,
    tangent_crossed: Register,
    tangent_moved: Register,
    moved_lift: [i64; 2],
    inv_normal: Register,
    normal: Register,
    cosine: Register,
    inv_cosine: Register,
    along: Register,
    slope: Register,
    rotation: Option<[[i64; 3]; 3]>,
    dv: Register,
    dv_rotated: Register,
    numerator: Register,
    uv_lift: [i64; 2],
    one: i64,
    d: Register,
}

/// A ray at its hit.
#[derive(Clone, Copy, Debug)]
pub struct In {
    /// Codes of R.
    pub r: [i64; 3],
    /// Mantissas of the direction to the hit.
    pub to: [i64; 3],
    /// The cone's width there: significand and power of two; its angle where the ray escaped.
    pub width: (i64, i64),
    /// Power of two of the lengths: the map's, 0 where the ray escaped.
    pub scale: i64,
    /// Whether the ray escaped: there is no wall.
    pub escaped: bool,
    /// Face, u, v of the direction.
    pub face: (usize, i64, i64),
    /// 1/|ma|: mantissa and fraction bits.
    pub inv_ma: (i64, i64),
}

impl Cfg {
    /// Compiles and checks the stage.
    pub fn new(config: &Config) -> Result<Self, ConfigError> {
        let f = |reg| frac(config, reg);
        let q = |reg, frac_in| config.register(reg, frac_in);
        let b = |reg| bits(config, reg);
        let r = b(Reg::HitR);
        fits(Reg::HitInvAcross, 2 * r + 2)?;
        fits(Reg::HitTangent, r + b(Reg::HitTangent).max(b(Reg::HitInvAcross)) + 2)?;
        fits(Reg::HitNormal, 30 + b(Reg::HitInvNormal))?;
        fits(Reg::HitCosine, r + b(Reg::HitNormal) + 2)?;
        fits(Reg::HitAlong, b(Reg::HitTangent) + b(Reg::HitNormal) + 2)?;
        fits(Reg::HitSlope, b(Reg::HitAlong) + b(Reg::HitInvCosine))?;
        let terms = [f(Reg::HitTangent), f(Reg::HitR) + f(Reg::HitSlope)];
        let common = terms[0].max(terms[1]);
        let top = config
            .format(Reg::HitTangent)
            .int
            .max(config.format(Reg::HitR).int + config.format(Reg::HitSlope).int);
        fits(Reg::HitTangent, u32::try_from(common).unwrap_or(u32::MAX) + top + 1)?;
        // A cone's significand has at most 24 bits.
        fits(Reg::JacDvr, b(Reg::HitTangent) + 24)?;
        let uv = [f(Reg::FaceU), f(Reg::FaceV)];
        let face = uv[0].max(uv[1]);
        Ok(Self {
            shape: config.policy.hit.footprint,
            env: config.policy.cone.env,
            max_probes: i64::from(config.policy.footprint.max_probes.max(1)),
            r_frac: f(Reg::HitR),
            inv_across: q(Reg::HitInvAcross, 0),
            tangent: q(Reg::HitTangent, 0),
            tangent_crossed: q(Reg::HitTangent, f(Reg::HitR) + f(Reg::HitTangent)),
            tangent_moved: q(Reg::HitTangent, common),
            moved_lift: terms.map(|t| common - t),
            inv_normal: q(Reg::HitInvNormal, 0),
            normal: q(Reg::HitNormal, 0),
            cosine: q(Reg::HitCosine, f(Reg::HitR) + f(Reg::HitNormal)),
            inv_cosine: q(Reg::HitInvCosine, 0),
            along: q(Reg::HitAlong, f(Reg::HitTangent) + f(Reg::HitNormal)),
            slope: q(Reg::HitSlope, 0),
            rotation: config.rotation,
            dv: q(Reg::JacDvr, 0),
            dv_rotated: q(Reg::JacDvr, f(Reg::JacDvr) + i64::from(ROTATION_FRAC)),
            numerator: q(Reg::JacNumerator, f(Reg::JacDvr) + face),
            uv_lift: uv.map(|f| face - f),
            one: 1 << face,
            d: q(Reg::JacD, 0),
        })
    }
}

/// D row by row.
#[inline(always)]
pub fn footprint<T: Tap>(
    cfg: &Cfg,
    hit: &super::Cfg,
    roms: &Roms,
    memory: &DistanceMemory,
    input: &In,
    sink: &mut Sink<'_, T>,
) -> [i64; 4] {
    if input.escaped && cfg.env == ConeEnv::Otk {
        // OptiX Toolkit's constant 2α/π per [0, 1] of a face, the same everywhere.
        let shift = CONSTANT_FRAC - input.width.1 - cfg.d.frac();
        let mut d = [0; 4];
        for (c, d) in d.iter_mut().enumerate() {
            let product = if c % 3 == 0 { input.width.0 * FOUR_OVER_PI } else { 0 };
            *d = sink.shift(&cfg.d, c, product, shift, 0);
        }
        return d;
    }
    let mut t = basis(cfg, roms, input.r, sink);
    if cfg.shape == HitFootprint::Plane && !input.escaped {
        match normal(&hit.look_up, roms, memory, input.to) {
            Some(n) => t = onto_plane(cfg, roms, input.r, t, n, sink),
            None => sink.flags.event(Event::HitNoPlane, true),
        }
    }
    let mut d = [0; 4];
    let (face, u, v) = input.face;
    let (inv_ma, inv_frac) = input.inv_ma;
    for (col, t) in t.into_iter().enumerate() {
        let shift = cfg.tangent.frac() - input.width.1 + input.scale - cfg.dv.frac();
        let mut dv = [0; 3];
        for (i, dv) in dv.iter_mut().enumerate() {
            let product = t[i] * input.width.0;
            *dv = sink.shift(&cfg.dv, 3 * col + i, product, shift, input.scale);
        }
        if let Some(a) = &cfg.rotation {
            let turned = a.map(|row| dot(row, dv));
            for (i, dv) in dv.iter_mut().enumerate() {
                let c = 3 * col + i;
                *dv = sink.write(&cfg.dv_rotated, c, turned[i], input.scale);
            }
        }
        let [sc, tc, ma] = components(face, dv);
        let rows = [
            sc * cfg.one - ((u * ma) << cfg.uv_lift[0]),
            tc * cfg.one - ((v * ma) << cfg.uv_lift[1]),
        ];
        let shift = cfg.numerator.frac() + inv_frac - cfg.d.frac();
        for (row, sum) in rows.into_iter().enumerate() {
            let c = 2 * row + col;
            let numerator = sink.write(&cfg.numerator, c, sum, input.scale);
            d[c] = sink.shift(&cfg.d, c, numerator * inv_ma, shift, 0);
        }
    }
    d
}

/// t1 = unit(e_k × R), k the smallest |R_k| (ties z, y, x), and t2 = R × t1.
#[inline(always)]
fn basis<T: Tap>(cfg: &Cfg, roms: &Roms, r: [i64; 3], sink: &mut Sink<'_, T>) -> [[i64; 3]; 2] {
    let across = beside(r);
    let (m, e) = mantissa4(dot(across, across).max(1));
    let inv = sink.block(&cfg.inv_across, &[roms.rsqrt.rsqrt(m)], P + e - cfg.r_frac, 0);
    let shift = cfg.r_frac + inv.frac - cfg.tangent.frac();
    let mut t1 = [0; 3];
    for (i, t) in t1.iter_mut().enumerate() {
        *t = sink.shift(&cfg.tangent, i, across[i] * inv.m[0], shift, 0);
    }
    let crossed = cross(r, t1);
    let mut t2 = [0; 3];
    for (i, t) in t2.iter_mut().enumerate() {
        *t = sink.write(&cfg.tangent_crossed, 3 + i, crossed[i], 0);
    }
    [t1, t2]
}

/// A vector of at most 62 bits, shifted down to 30.
#[inline(always)]
fn short(v: [i64; 3]) -> [i64; 3] {
    let shift = (block::top_bit(&v) + 1 - P).max(0);
    v.map(|c| c >> shift)
}

/// The wall's normal, of any length, at most 30 bits: from the memory's own geometry, or for a cube from the four
/// texels about the hit, inside of its face. `None` where one of them is infinite or they have no plane.
fn normal(
    cfg: &look_up::Cfg,
    roms: &Roms,
    memory: &DistanceMemory,
    to: [i64; 3],
) -> Option<[i64; 3]> {
    let q = match &cfg.rotation {
        None => to,
        Some(a) => short(a.map(|row| dot(row, to))),
    };
    let n = match &memory.kind {
        Kind::Sphere(_) => q,
        Kind::Box(half_edges) => {
            let mut best: Option<usize> = None;
            for i in 0..3 {
                let nearer = |b: usize| half_edges[i] * q[b].abs() < half_edges[b] * q[i].abs();
                if q[i] != 0 && best.is_none_or(nearer) {
                    best = Some(i);
                }
            }
            let i = best?;
            let mut n = [0; 3];
            n[i] = q[i].signum() << 24;
            n
        }
        Kind::Cube { size, .. } if *size < 2 => q,
        Kind::Cube { size, codes } => quad(cfg, roms, codes, *size, q)?,
    };
    let n = match &cfg.rotation {
        None => short(n),
        // Back from the map's axes: the transposed matrix.
        Some(a) => {
            let n = short(n);
            short([0, 1, 2].map(|i| dot([a[0][i], a[1][i], a[2][i]], n)))
        }
    };
    (n != [0; 3]).then_some(n)
}

/// The cross product of the diagonals of the four points about a direction.
fn quad(
    cfg: &look_up::Cfg,
    roms: &Roms,
    codes: &[u32],
    size: usize,
    q: [i64; 3],
) -> Option<[i64; 3]> {
    let mut flags = crate::fx::Flags::default();
    let mut nobody = crate::tap::NoTap;
    let mut sink = Sink { lane: 0, flags: &mut flags, tap: &mut nobody };
    let place = cfg.place(roms, q, size, 0, &mut sink);
    let corner = place.corner.map(|c| c.clamp(1, size - 1));
    let stride = size + 2;
    let n = i64::try_from(size).ok()?;
    let least = mantissa4(n * n).1;
    let point = |dx: usize, dy: usize| {
        let [x, y] = [corner[0] + dx, corner[1] + dy];
        let code = *codes.get((place.face * stride + y) * stride + x)?;
        if code >= BEYOND {
            return None;
        }
        // Twice the texel's centre in texels, from the face's middle.
        let centre = |c: usize| i64::try_from(2 * c).ok().map(|c| c - 1 - n);
        let v = direction(place.face, [centre(x)?, centre(y)?, n]);
        let (m, e) = mantissa4(dot(v, v));
        let along = (i64::from(code) * roms.rsqrt.rsqrt(m)) >> (14 + e - least);
        Some(v.map(|c| c * along))
    };
    let [a, b, c, d] = [point(0, 0)?, point(1, 0)?, point(0, 1)?, point(1, 1)?];
    let difference = |a: [i64; 3], b: [i64; 3]| short([a[0] - b[0], a[1] - b[1], a[2] - b[2]]);
    let n = cross(difference(d, a), difference(c, b));
    (n != [0; 3]).then_some(n)
}

/// t − R·⟨n,t⟩/⟨n,R⟩ with |⟨n,R⟩| ≥ 1/max_probes.
#[inline(always)]
fn onto_plane<T: Tap>(
    cfg: &Cfg,
    roms: &Roms,
    r: [i64; 3],
    t: [[i64; 3]; 2],
    n: [i64; 3],
    sink: &mut Sink<'_, T>,
) -> [[i64; 3]; 2] {
    let (m, e) = mantissa4(dot(n, n).max(1));
    let inv = sink.block(&cfg.inv_normal, &[roms.rsqrt.rsqrt(m)], P + e, 0);
    let shift = inv.frac - cfg.normal.frac();
    let mut unit = [0; 3];
    for (i, u) in unit.iter_mut().enumerate() {
        *u = sink.shift(&cfg.normal, i, n[i] * inv.m[0], shift, 0);
    }
    let one = 1i64 << cfg.cosine.format.frac;
    let least = (one / cfg.max_probes).max(1);
    let cosine = sink.write(&cfg.cosine, 0, dot(unit, r), 0);
    let sign = if cosine < 0 { -1 } else { 1 };
    let (m, e) = mantissa(cosine.abs().max(least));
    let inv =
        sink.block(&cfg.inv_cosine, &[sign * roms.recip.recip(m)], P + e - cfg.cosine.frac(), 0);
    let shift = cfg.along.frac() + inv.frac - cfg.slope.frac();
    let mut out = [[0; 3]; 2];
    for (j, (out, t)) in out.iter_mut().zip(t).enumerate() {
        let along = sink.write(&cfg.along, j, dot(unit, t), 0);
        let slope = sink.shift(&cfg.slope, j, along * inv.m[0], shift, 0);
        for (i, o) in out.iter_mut().enumerate() {
            let sum = (t[i] << cfg.moved_lift[0]) - ((r[i] * slope) << cfg.moved_lift[1]);
            *o = sink.write(&cfg.tangent_moved, 3 * j + i, sum, 0);
        }
    }
    out
}
