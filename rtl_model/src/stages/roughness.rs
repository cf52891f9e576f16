//! `roughness`: s·B' = G A J_n [e1 e2] · s·B (Schilling, eq. 10–12).
//!
//! B = [d1 d2; 0 d3] comes from the roughness pyramid in units of |n|. s is `roughness.scale`.

use super::jacobian::Project;
use super::{Lanes, Sink, bits, block_frac, dot, fits, frac, int, store, take};
use crate::config::{Config, ConfigError, SCALE_FRAC};
use crate::fx::{Flags, Quantizer};
use crate::regs::Reg;
use crate::tap::Tap;

/// Compiled configuration.
#[derive(Clone, Debug)]
pub struct Cfg {
    /// Port of d1, d2, d3.
    pub d: Quantizer,
    scale: i64,
    d_scaled: Quantizer,
    v_dot_e: [Quantizer; 2],
    n_dot_e: [Quantizer; 2],
    lift: [[i64; 3]; 2],
    dv_r: [Quantizer; 2],
    project: Project,
    numerator: Quantizer,
    e: Quantizer,
    b: Quantizer,
}

/// What the stage reads.
#[derive(Clone, Copy, Debug)]
pub struct In<'a, const N: usize> {
    /// Mantissas of v.
    pub v: &'a Lanes<N, 3>,
    /// Power of two of v.
    pub v_exp: &'a [i64; N],
    /// Power of two of the interpolated normal.
    pub n_exp: &'a [i64; N],
    /// First tangent vector.
    pub e1: &'a Lanes<N, 3>,
    /// Second tangent vector.
    pub e2: &'a Lanes<N, 3>,
    /// d1, d2, d3.
    pub d: &'a Lanes<N, 3>,
    /// Output of `reflect`.
    pub reflect: &'a super::reflect::Out<N>,
    /// Output of `cube_face`.
    pub face: &'a super::cube_face::Out<N>,
}

/// s·B' row by row.
#[derive(Clone, Debug)]
pub struct Out<const N: usize> {
    /// b11, b12, b21, b22.
    pub b: Lanes<N, 4>,
}

impl<const N: usize> Default for Out<N> {
    fn default() -> Self {
        Self { b: [[0; N]; 4] }
    }
}

impl Cfg {
    /// Compiles and checks the stage.
    pub fn new(config: &Config) -> Result<Self, ConfigError> {
        let f = |reg| frac(config, reg);
        let w = |reg| bits(config, reg);
        let q = |reg, frac_in| Quantizer::new(config.format(reg), frac_in);
        let (n_frac, v_frac) = (
            block_frac(config, Reg::ReflectN),
            block_frac(config, Reg::ReflectV),
        );
        fits(Reg::RoughScaled, w(Reg::RoughD) + SCALE_FRAC + 4)?;
        let mut lift = [[0; 3]; 2];
        let mut exact = [0; 2];
        for (k, reg) in [Reg::FrameE1, Reg::FrameE2].into_iter().enumerate() {
            fits(Reg::RoughVdotE, w(Reg::ReflectV) + w(reg) + 2)?;
            fits(Reg::RoughNdotE, w(Reg::ReflectN) + w(reg) + 2)?;
            let terms = [
                f(Reg::ReflectNdotV) + f(reg),
                n_frac + f(Reg::RoughVdotE),
                v_frac + f(Reg::RoughNdotE),
            ];
            let common = terms.into_iter().max().unwrap_or(0);
            let whole = (int(config, Reg::ReflectNdotV) + int(config, reg))
                .max(1 + int(config, Reg::RoughVdotE))
                .max(1 + int(config, Reg::RoughNdotE));
            fits(
                Reg::RoughDvr,
                u32::try_from(common).unwrap_or(u32::MAX) + whole + 3,
            )?;
            lift[k] = terms.map(|t| common - t);
            exact[k] = common;
        }
        fits(Reg::RoughE, w(Reg::RoughNumerator) + w(Reg::FaceInvMa))?;
        fits(Reg::RoughB, w(Reg::RoughE) + w(Reg::RoughScaled) + 1)?;
        Ok(Self {
            d: q(Reg::RoughD, 0),
            scale: config.roughness_scale,
            d_scaled: q(Reg::RoughScaled, f(Reg::RoughD) + i64::from(SCALE_FRAC)),
            v_dot_e: [Reg::FrameE1, Reg::FrameE2].map(|e| q(Reg::RoughVdotE, v_frac + f(e))),
            n_dot_e: [Reg::FrameE1, Reg::FrameE2].map(|e| q(Reg::RoughNdotE, n_frac + f(e))),
            lift,
            dv_r: exact.map(|frac_in| q(Reg::RoughDvr, frac_in)),
            project: Project::new(config, Reg::RoughDvr, Reg::RoughNumerator)?,
            numerator: q(Reg::RoughNumerator, Project::frac(config, f(Reg::RoughDvr))),
            e: q(Reg::RoughE, 0),
            b: q(Reg::RoughB, f(Reg::RoughE) + f(Reg::RoughScaled)),
        })
    }
}

/// The stage.
#[inline(always)]
pub fn roughness<const N: usize, T: Tap>(
    cfg: &Cfg,
    input: In<'_, N>,
    out: &mut Out<N>,
    flags: &mut [Flags],
    tap: &mut T,
) {
    let fixed = i64::from(cfg.numerator.format.frac) - i64::from(cfg.e.format.frac);
    for lane in 0..flags.len().min(N) {
        let flags = &mut flags[lane];
        let mut sink = Sink { lane, flags, tap };
        let (r, face) = (input.reflect, input.face);
        let v = take(input.v, lane);
        let n = take(&r.n, lane);
        let nv = r.n_dot_v[lane];
        let (v_exp, e_exp) = (input.v_exp[lane], input.n_exp[lane]);
        let n_exp = e_exp + r.n_lift[lane];
        let exp = n_exp + v_exp + e_exp;

        let d = take(input.d, lane);
        let mut scaled = [0; 3];
        for (i, s) in scaled.iter_mut().enumerate() {
            *s = sink.write(&cfg.d_scaled, Reg::RoughScaled, i, d[i] * cfg.scale, 0);
        }
        let mut e_uv = [0; 4];
        for (col, e) in [take(input.e1, lane), take(input.e2, lane)]
            .into_iter()
            .enumerate()
        {
            let v_e = sink.write(
                &cfg.v_dot_e[col],
                Reg::RoughVdotE,
                col,
                dot(v, e),
                v_exp + e_exp,
            );
            let n_e = sink.write(
                &cfg.n_dot_e[col],
                Reg::RoughNdotE,
                col,
                dot(n, e),
                n_exp + e_exp,
            );
            let lift = &cfg.lift[col];
            let mut t = [0; 3];
            for i in 0..3 {
                let sum = ((2 * nv * e[i]) << lift[0]) + ((2 * n[i] * v_e) << lift[1])
                    - ((2 * v[i] * n_e) << lift[2]);
                t[i] = sink.write(&cfg.dv_r[col], Reg::RoughDvr, 3 * col + i, sum, exp);
            }
            let t = cfg
                .project
                .rotate(&mut sink, Reg::RoughDvr, 3 * col, t, exp);
            let rows = cfg
                .project
                .numerators(face.face[lane], face.u[lane], face.v[lane], t);
            // G holds 1/|n_mod|², J_n one |n_mod|, e one |n|: one factor 2^−n_lift is left.
            let shift = fixed + face.inv_ma_frac[lane] + r.n_lift[lane];
            for (row, sum) in rows.into_iter().enumerate() {
                let c = 2 * row + col;
                let sum = if face.zero[lane] { 0 } else { sum };
                let numerator = sink.write(&cfg.numerator, Reg::RoughNumerator, c, sum, exp);
                e_uv[c] = sink.shift(
                    &cfg.e,
                    Reg::RoughE,
                    c,
                    numerator * face.inv_ma[lane],
                    shift,
                    0,
                );
            }
        }
        let [e11, e12, e21, e22] = e_uv;
        let [d1, d2, d3] = scaled;
        let sums = [e11 * d1, e11 * d2 + e12 * d3, e21 * d1, e21 * d2 + e22 * d3];
        let mut b = [0; 4];
        for (i, o) in b.iter_mut().enumerate() {
            *o = sink.write(&cfg.b, Reg::RoughB, i, sums[i], 0);
        }
        store(&mut out.b, lane, b);
    }
}
