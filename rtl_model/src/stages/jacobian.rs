//! `jacobian`: D = G A [J_v ∂v + J_n ∂n_mod] (Schilling, eq. 1 and 5–9).
//!
//! J_v = 2nnᵀ − ⟨n,n⟩I and J_n = 2⟨n,v⟩I + 2nvᵀ − 2vnᵀ are applied to the derivatives as vectors, so
//! that no matrix is ever stored; G has ±1/|ma| and −u/|ma| as its non-zero entries.

pub mod normal_derivative;

use super::cube_face::components_lanes;
use super::{Lanes, bits, block_frac, column, fits, frac, int, take};
use crate::config::{Config, ConfigError, ROTATION_FRAC};
use crate::fx::Flags;
use crate::lanes::{LaneSink, Shift, dot, each, mul, mul_wide};
use crate::regs::{Reg, Register};
use crate::tap::Tap;

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
        let uv = super::cube_face::Cfg::uv_frac(config);
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
        let uv = super::cube_face::Cfg::uv_frac(config);
        dv_r_frac + uv[0].max(uv[1])
    }

    /// A·t, written to the register of t again; t as it is without a rotation.
    #[inline(always)]
    pub(crate) fn rotate<const N: usize, T: Tap>(
        &self,
        sink: &mut LaneSink<'_, N, T>,
        first: usize,
        t: Lanes<N, 3>,
        exponent: impl Fn(usize) -> i64 + Copy,
    ) -> Lanes<N, 3> {
        let Some(a) = &self.rotation else { return t };
        let mut out = [[0; N]; 3];
        for c in 0..3 {
            let sum = |i: usize| dot::<T>(a[c], take(&t, i));
            sink.write(&self.rotated, first + c, sum, exponent, &mut out[c]);
        }
        out
    }

    /// (∂sc − u·∂|ma|, ∂tc − v·∂|ma|); 0 where v_r is zero.
    #[inline(always)]
    pub(crate) fn numerators<const N: usize, T: Tap>(
        &self,
        lanes: usize,
        face: &super::cube_face::Out<N>,
        t: &Lanes<N, 3>,
    ) -> Lanes<N, 2> {
        let [sc, tc, ma] = components_lanes(lanes, &face.face, t);
        let one_bits = self.one_bits;
        let mut out = [[0; N]; 2];
        for (out, (side, at, lift)) in
            out.iter_mut().zip([(sc, &face.u, self.uv_lift[0]), (tc, &face.v, self.uv_lift[1])])
        {
            *out = each(lanes, |i| {
                let keep = i64::from(face.zero[i]) - 1;
                // The negative of the most negative code has a bit more.
                ((side[i] << one_bits) - (mul_wide::<T>(ma[i], at[i]) << lift)) & keep
            });
        }
        out
    }
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
    /// ∂v/∂x then ∂v/∂y, shifted with v.
    pub dv: &'a Lanes<N, 6>,
    /// ∂n_mod/∂x then ∂n_mod/∂y, shifted with n_mod.
    pub dn_mod: &'a Lanes<N, 6>,
    /// Output of `reflect`.
    pub reflect: &'a super::reflect::Out<N>,
    /// Output of `cube_face`.
    pub face: &'a super::cube_face::Out<N>,
}

/// D row by row.
#[derive(Clone, Debug)]
pub struct Out<const N: usize> {
    /// ∂u/∂x, ∂u/∂y, ∂v/∂x, ∂v/∂y.
    pub d: Lanes<N, 4>,
}

impl<const N: usize> Default for Out<N> {
    fn default() -> Self {
        Self { d: [[0; N]; 4] }
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

/// The stage.
#[inline(always)]
pub fn jacobian<const N: usize, T: Tap>(
    cfg: &Cfg,
    input: In<'_, N>,
    out: &mut Out<N>,
    flags: &mut [Flags],
    tap: &mut T,
) {
    let fixed = cfg.numerator.frac() - cfg.d.frac();
    let mut sink = LaneSink::<N, T>::new(flags, tap);
    let lanes = sink.n;
    let shift = Shift::new(lanes, &cfg.d, |i| fixed + input.face.inv_ma_frac[i]);
    let (r, face) = (input.reflect, input.face);
    let (v, n) = (input.v, &r.n);
    let v_exp = input.v_exp;
    let n_exp = |i: usize| input.n_exp[i] + r.n_lift[i];
    let exp = |i: usize| 2 * n_exp(i) + v_exp[i];
    for col in 0..2 {
        let (dv, dn) = (column(input.dv, col), column(input.dn_mod, col));
        let mut n_dv = [0; N];
        sink.write(
            &cfg.n_dot_dv[col],
            col,
            |i| dot::<T>(take(n, i), take(dv, i)),
            |i| n_exp(i) + v_exp[i],
            &mut n_dv,
        );
        let mut v_dn = [0; N];
        sink.write(
            &cfg.v_dot_dn,
            col,
            |i| dot::<T>(take(v, i), take(dn, i)),
            |i| n_exp(i) + v_exp[i],
            &mut v_dn,
        );
        let mut n_dn = [0; N];
        sink.write(
            &cfg.n_dot_dn,
            col,
            |i| dot::<T>(take(n, i), take(dn, i)),
            |i| 2 * n_exp(i),
            &mut n_dn,
        );
        let lift = cfg.lift[col];
        let mut dv_r = [[0; N]; 3];
        for c in 0..3 {
            let sum = |i: usize| {
                (mul::<T>(2 * n[c][i], n_dv[i]) << lift[0])
                    - (mul::<T>(r.n_dot_n[i], dv[c][i]) << lift[1])
                    + (mul::<T>(2 * r.n_dot_v[i], dn[c][i]) << lift[2])
                    + (mul_wide::<T>(v_dn[i], 2 * n[c][i]) << lift[3])
                    - (mul_wide::<T>(n_dn[i], 2 * v[c][i]) << lift[4])
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
            sink.shift(&cfg.d, c, &shift, quotient, |_| 0, &mut out.d[c]);
        }
    }
}
