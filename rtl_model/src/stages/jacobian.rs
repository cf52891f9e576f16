//! `jacobian`: D = G A [J_v ∂v + J_n ∂n_mod] (Schilling, eq. 1 and 5–9).
//!
//! J_v = 2nnᵀ − ⟨n,n⟩I and J_n = 2⟨n,v⟩I + 2nvᵀ − 2vnᵀ are applied to the derivatives as vectors, so
//! that no matrix is ever stored; G has ±1/|ma| and −u/|ma| as its non-zero entries.

pub mod normal_derivative;

use lanes::Vector;

use super::cube_face::{self, components_of};
use super::{bits, block_frac, column, dot, fits, frac, int, reflect};
use crate::config::{Config, ConfigError, ROTATION_FRAC};
use crate::lanes::{Writes, in_lanes};
use crate::regs::{Reg, Register};
use crate::unit::Inputs;

/// The stage, from the derivative of the modified normal on.
#[inline(always)]
pub fn jacobian<V: Vector>(
    cfg: &Cfg,
    port: &Inputs<V>,
    dn_mod: &[V; 6],
    r: &reflect::Out<V>,
    face: &cube_face::Out<V>,
    sink: &mut impl Writes<V>,
) -> Out<V> {
    let (v, n) = (port.v, r.n);
    let n_exp = port.n_exp + r.n_lift;
    let (once, exp) = (n_exp + port.v_exp, n_exp.up(1) + port.v_exp);
    let shift = face.inv_ma_frac.plus(cfg.numerator.frac() - cfg.d.frac());
    let mut d = [exp; 4];
    for col in 0..2 {
        let (dv, dn) = (column(&port.dv, col), column(dn_mod, col));
        let n_dv = sink.put(&cfg.n_dot_dv[col], col, dot(n, dv), once);
        let v_dn = sink.put(&cfg.v_dot_dn, col, dot(v, dn), once);
        let n_dn = sink.put(&cfg.n_dot_dn, col, dot(n, dn), n_exp.up(1));
        let lift = cfg.lift[col];
        let mut dv_r = n;
        for c in 0..3 {
            let sum = n[c].up(1).mul(n_dv).up(lift[0]) - r.n_dot_n.mul(dv[c]).up(lift[1])
                + r.n_dot_v.up(1).mul(dn[c]).up(lift[2])
                + v_dn.mul_wide(n[c].up(1)).up(lift[3])
                - n_dn.mul_wide(v[c].up(1)).up(lift[4]);
            dv_r[c] = sink.put(&cfg.dv_r[col], 3 * col + c, sum, exp);
        }
        let rows = cfg.project.numerators(sink, col, face, dv_r, exp);
        for (row, sum) in rows.into_iter().enumerate() {
            let c = 2 * row + col;
            let numerator = sink.put(&cfg.numerator, c, sum, exp);
            d[c] = sink.shifted(&cfg.d, c, numerator.mul(face.inv_ma), shift, exp.like(0));
        }
    }
    Out { d }
}

in_lanes! {
    /// D row by row.
    pub struct Out<V> {
        /// ∂u/∂x, ∂u/∂y, ∂v/∂x, ∂v/∂y.
        pub d: [V; 4],
    }
}

/// Compiled configuration.
#[derive(Clone, Debug, Hash)]
pub struct Cfg {
    /// Ports of ∂v/∂x and ∂v/∂y.
    pub dv: [Register; 2],
    n_dot_dv: [Register; 2],
    v_dot_dn: Register,
    n_dot_dn: Register,
    lift: [[i64; 5]; 2],
    dv_r: [Register; 2],
    /// How a derivative of v_r becomes derivatives of (u, v).
    pub project: Project,
    numerator: Register,
    d: Register,
}

/// G (and A), shared with `roughness`: a derivative of v_r to |ma|·(∂u, ∂v).
#[derive(Clone, Debug, Hash)]
pub struct Project {
    rotation: Option<[[i64; 3]; 3]>,
    rotated: Register,
    uv_lift: [i64; 2],
    one_bits: i64,
}

impl Project {
    /// Compiles the projection for derivatives written with `reg`'s format; the numerators have
    /// [`Project::frac`] fraction bits.
    pub(crate) fn new(config: &Config, reg: Reg, numerator: Reg) -> Result<Self, ConfigError> {
        let dv_r = bits(config, reg);
        let uv = cube_face::Cfg::uv_frac(config);
        let common = uv[0].max(uv[1]);
        fits(numerator, dv_r + u32::try_from(common).unwrap_or(u32::MAX) + 2)?;
        if config.rotation.is_some() {
            fits(reg, dv_r + ROTATION_FRAC + 3)?;
        }
        Ok(Self {
            rotation: config.rotation,
            rotated: config.register(reg, frac(config, reg) + i64::from(ROTATION_FRAC)),
            uv_lift: uv.map(|f| common - f),
            one_bits: common,
        })
    }

    /// Fraction bits of the numerators of derivatives with `dv_r_frac` fraction bits.
    pub(crate) fn frac(config: &Config, dv_r_frac: i64) -> i64 {
        let uv = cube_face::Cfg::uv_frac(config);
        dv_r_frac + uv[0].max(uv[1])
    }

    /// A·t, written to the register of t again; t as it is without a rotation.
    #[inline(always)]
    fn rotate<V: Vector>(
        &self,
        sink: &mut impl Writes<V>,
        first: usize,
        t: [V; 3],
        exponent: V,
    ) -> [V; 3] {
        let Some(a) = &self.rotation else { return t };
        let mut out = t;
        for c in 0..3 {
            let sum = t[0].times(a[c][0]) + t[1].times(a[c][1]) + t[2].times(a[c][2]);
            out[c] = sink.put(&self.rotated, first + c, sum, exponent);
        }
        out
    }

    /// (∂sc − u·∂|ma|, ∂tc − v·∂|ma|) of column `col`; 0 where v_r is zero.
    #[inline(always)]
    pub(crate) fn numerators<V: Vector>(
        &self,
        sink: &mut impl Writes<V>,
        col: usize,
        face: &cube_face::Out<V>,
        dv_r: [V; 3],
        exponent: V,
    ) -> [V; 2] {
        let t = self.rotate(sink, 3 * col, dv_r, exponent);
        let [sc, tc, ma] = components_of(face.face, t);
        let keep = face.zero.plus(-1);
        // The negative of the most negative code has a bit more.
        [
            (sc.up(self.one_bits) - ma.mul_wide(face.u).up(self.uv_lift[0])) & keep,
            (tc.up(self.one_bits) - ma.mul_wide(face.v).up(self.uv_lift[1])) & keep,
        ]
    }
}

impl Cfg {
    /// Compiles and checks the stage.
    pub fn new(config: &Config) -> Result<Self, ConfigError> {
        let q = |reg, frac_in| config.register(reg, frac_in);
        let f = |reg| frac(config, reg);
        let (n_frac, v_frac) =
            (block_frac(config, Reg::ReflectN), block_frac(config, Reg::ReflectV));
        let (n_bits, v_bits) = (bits(config, Reg::ReflectN), bits(config, Reg::ReflectV));
        let dn = bits(config, Reg::JacDnMod);
        fits(Reg::JacVdotDn, v_bits + dn + 2)?;
        fits(Reg::JacNdotDn, n_bits + dn + 2)?;
        let mut lift = [[0; 5]; 2];
        let mut exact = [0; 2];
        for (i, reg) in [Reg::JacDvDx, Reg::JacDvDy].into_iter().enumerate() {
            fits(Reg::JacNdotDv, n_bits + bits(config, reg) + 2)?;
            let terms = [
                n_frac + f(Reg::JacNdotDv),
                f(Reg::ReflectNdotN) + f(reg),
                f(Reg::ReflectNdotV) + f(Reg::JacDnMod),
                n_frac + f(Reg::JacVdotDn),
                v_frac + f(Reg::JacNdotDn),
            ];
            let whole = [
                2 + int(config, Reg::JacNdotDv),
                int(config, Reg::ReflectNdotN) + int(config, reg),
                1 + int(config, Reg::ReflectNdotV) + int(config, Reg::JacDnMod),
                2 + int(config, Reg::JacVdotDn),
                2 + int(config, Reg::JacNdotDn),
            ];
            let common = terms.into_iter().max().unwrap_or(0);
            let top = whole.into_iter().max().unwrap_or(0);
            fits(Reg::JacDvr, u32::try_from(common).unwrap_or(u32::MAX) + top + 3)?;
            lift[i] = terms.map(|t| common - t);
            exact[i] = common;
        }
        let project = Project::new(config, Reg::JacDvr, Reg::JacNumerator)?;
        fits(Reg::JacD, bits(config, Reg::JacNumerator) + bits(config, Reg::FaceInvMa))?;
        Ok(Self {
            dv: [q(Reg::JacDvDx, 0), q(Reg::JacDvDy, 0)],
            n_dot_dv: [Reg::JacDvDx, Reg::JacDvDy].map(|reg| q(Reg::JacNdotDv, n_frac + f(reg))),
            v_dot_dn: q(Reg::JacVdotDn, v_frac + f(Reg::JacDnMod)),
            n_dot_dn: q(Reg::JacNdotDn, n_frac + f(Reg::JacDnMod)),
            lift,
            dv_r: exact.map(|frac_in| q(Reg::JacDvr, frac_in)),
            project,
            numerator: q(Reg::JacNumerator, Project::frac(config, f(Reg::JacDvr))),
            d: q(Reg::JacD, 0),
        })
    }
}
