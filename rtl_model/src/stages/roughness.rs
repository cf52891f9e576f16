//! `roughness`: s·B' = G A J_n [e1 e2] · s·B (Schilling, eq. 10–12).
//!
//! B = [d1 d2; 0 d3] comes from the roughness pyramid in units of |n|. s is `roughness.scale`.

use lanes::Vector;

use super::jacobian::Project;
use super::{bits, block_frac, cube_face, dot, fits, frac, int, local_frame, reflect};
use crate::config::{Config, ConfigError, SCALE_FRAC};
use crate::lanes::{Writes, in_lanes};
use crate::regs::{Reg, Register};
use crate::unit::Inputs;

/// The stage.
#[inline(always)]
pub fn roughness<V: Vector>(
    cfg: &Cfg,
    port: &Inputs<V>,
    frame: &local_frame::Out<V>,
    r: &reflect::Out<V>,
    face: &cube_face::Out<V>,
    sink: &mut impl Writes<V>,
) -> Out<V> {
    let (v, n) = (port.v, r.n);
    let (v_exp, e_exp) = (port.v_exp, port.n_exp);
    let n_exp = e_exp + r.n_lift;
    let (exp, none) = (n_exp + v_exp + e_exp, n_exp.like(0));
    let mut scaled = port.d;
    for (c, d) in scaled.iter_mut().enumerate() {
        *d = sink.put(&cfg.d_scaled, c, d.times(cfg.scale), none);
    }
    // G holds 1/|n_mod|², J_n one |n_mod|, e one |n|: one factor 2^−n_lift is left.
    let shift = (face.inv_ma_frac + r.n_lift).plus(cfg.numerator.frac() - cfg.e.frac());
    let mut e_uv = [none; 4];
    for (col, e) in [frame.e1, frame.e2].into_iter().enumerate() {
        let v_e = sink.put(&cfg.v_dot_e[col], col, dot(v, e), v_exp + e_exp);
        let n_e = sink.put(&cfg.n_dot_e[col], col, dot(n, e), n_exp + e_exp);
        let lift = cfg.lift[col];
        let mut dv_r = e;
        for c in 0..3 {
            let sum = r.n_dot_v.up(1).mul(e[c]).up(lift[0]) + n[c].up(1).mul(v_e).up(lift[1])
                - v[c].up(1).mul(n_e).up(lift[2]);
            dv_r[c] = sink.put(&cfg.dv_r[col], 3 * col + c, sum, exp);
        }
        let rows = cfg.project.numerators(sink, col, face, dv_r, exp);
        for (row, sum) in rows.into_iter().enumerate() {
            let c = 2 * row + col;
            let numerator = sink.put(&cfg.numerator, c, sum, exp);
            e_uv[c] = sink.shifted(&cfg.e, c, numerator.mul(face.inv_ma), shift, none);
        }
    }
    let [e11, e12, e21, e22] = e_uv;
    let [d1, d2, d3] = scaled;
    let mut b = [e11.mul(d1), e11.mul(d2) + e12.mul(d3), e21.mul(d1), e21.mul(d2) + e22.mul(d3)];
    for (c, b) in b.iter_mut().enumerate() {
        *b = sink.put(&cfg.b, c, *b, none);
    }
    Out { b }
}

in_lanes! {
    /// s·B' row by row.
    pub struct Out<V> {
        /// b11, b12, b21, b22.
        pub b: [V; 4],
    }
}

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
