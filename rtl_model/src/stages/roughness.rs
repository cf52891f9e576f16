//! `roughness`: s·B' = G A J_n [e1 e2] · s·B (Schilling, eq. 10–12).
//!
//! B = [d1 d2; 0 d3] comes from the roughness pyramid in units of |n|. s is `roughness.scale`.

use super::jacobian::Project;
use super::{Lanes, bits, block_frac, fits, frac, int, take};
use crate::config::{Config, ConfigError, SCALE_FRAC};
use crate::fx::Flags;
use crate::lanes::{LaneSink, Shift, dot, mul};
use crate::regs::{Reg, Register};
use crate::tap::Tap;

/// Compiled configuration.
#[derive(Clone, Debug, Hash)]
pub struct Cfg {
    /// Port of d1, d2, d3.
    pub d: Register,
    scale: i64,
    d_scaled: Register,
    v_dot_e: [Register; 2],
    n_dot_e: [Register; 2],
    lift: [[i64; 3]; 2],
    dv_r: [Register; 2],
    project: Project,
    numerator: Register,
    e: Register,
    b: Register,
}

/// The inputs of the stage.
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
        let q = |reg, frac_in| config.register(reg, frac_in);
        let (n_frac, v_frac) =
            (block_frac(config, Reg::ReflectN), block_frac(config, Reg::ReflectV));
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
            fits(Reg::RoughDvr, u32::try_from(common).unwrap_or(u32::MAX) + whole + 3)?;
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
    let fixed = cfg.numerator.frac() - cfg.e.frac();
    let mut sink = LaneSink::<N, T>::new(flags, tap);
    let lanes = sink.n;
    let (r, face) = (input.reflect, input.face);
    let (v, n) = (input.v, &r.n);
    let (v_exp, e_exp) = (input.v_exp, input.n_exp);
    let n_exp = |i: usize| e_exp[i] + r.n_lift[i];
    let exp = |i: usize| n_exp(i) + v_exp[i] + e_exp[i];

    let mut scaled = [[0; N]; 3];
    for (c, (scaled, d)) in scaled.iter_mut().zip(input.d).enumerate() {
        let product = |i: usize| mul::<T>(d[i], cfg.scale);
        sink.write(&cfg.d_scaled, c, product, |_| 0, scaled);
    }
    // G holds 1/|n_mod|², J_n one |n_mod|, e one |n|: one factor 2^−n_lift is left.
    let shift = Shift::new(lanes, &cfg.e, |i| fixed + face.inv_ma_frac[i] + r.n_lift[i]);
    let mut e_uv = [[0; N]; 4];
    for (col, e) in [input.e1, input.e2].into_iter().enumerate() {
        let mut v_e = [0; N];
        sink.write(
            &cfg.v_dot_e[col],
            col,
            |i| dot::<T>(take(v, i), take(e, i)),
            |i| v_exp[i] + e_exp[i],
            &mut v_e,
        );
        let mut n_e = [0; N];
        sink.write(
            &cfg.n_dot_e[col],
            col,
            |i| dot::<T>(take(n, i), take(e, i)),
            |i| n_exp(i) + e_exp[i],
            &mut n_e,
        );
        let lift = cfg.lift[col];
        let mut dv_r = [[0; N]; 3];
        for c in 0..3 {
            let sum = |i: usize| {
                (mul::<T>(2 * r.n_dot_v[i], e[c][i]) << lift[0])
                    + (mul::<T>(2 * n[c][i], v_e[i]) << lift[1])
                    - (mul::<T>(2 * v[c][i], n_e[i]) << lift[2])
            };
            sink.write(&cfg.dv_r[col], 3 * col + c, sum, exp, &mut dv_r[c]);
        }
        let t = cfg.project.rotate(&mut sink, 3 * col, dv_r, exp);
        let rows = cfg.project.numerators::<N, T>(lanes, face, &t);
        for (row, sum) in rows.iter().enumerate() {
            let c = 2 * row + col;
            let mut numerator = [0; N];
            sink.write(&cfg.numerator, c, |i| sum[i], exp, &mut numerator);
            let quotient = |i: usize| mul::<T>(numerator[i], face.inv_ma[i]);
            sink.shift(&cfg.e, c, &shift, quotient, |_| 0, &mut e_uv[c]);
        }
    }
    let [e11, e12, e21, e22] = &e_uv;
    let [d1, d2, d3] = &scaled;
    let b = &cfg.b;
    sink.write(b, 0, |i| mul::<T>(e11[i], d1[i]), |_| 0, &mut out.b[0]);
    sink.write(b, 1, |i| mul::<T>(e11[i], d2[i]) + mul::<T>(e12[i], d3[i]), |_| 0, &mut out.b[1]);
    sink.write(b, 2, |i| mul::<T>(e21[i], d1[i]), |_| 0, &mut out.b[2]);
    sink.write(b, 3, |i| mul::<T>(e21[i], d2[i]) + mul::<T>(e22[i], d3[i]), |_| 0, &mut out.b[3]);
}
