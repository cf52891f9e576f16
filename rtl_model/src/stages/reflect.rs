//! `reflect`: v_r = 2n⟨n,v⟩ − v⟨n,n⟩ (Schilling, eq. 4). Nothing is normalised to unit length.

use lanes::Vector;

use super::{bits, block_frac, dot, fits, frac, int};
use crate::config::{Config, ConfigError};
use crate::lanes::{Writes, in_lanes};
use crate::regs::{Reg, Register};
use crate::unit::Inputs;

/// The stage. `n` is normalised where it comes as codes with `n_frac` fraction bits.
#[inline(always)]
pub fn reflect<V: Vector>(
    cfg: &Cfg,
    port: &Inputs<V>,
    n: [V; 3],
    n_frac: Option<i64>,
    sink: &mut impl Writes<V>,
) -> Out<V> {
    let (v, v_exp) = (port.v, port.v_exp);
    let (mut n, mut n_lift) = (n, v_exp.like(0));
    if let Some(n_frac) = n_frac {
        let (m, frac) = sink.normal(&cfg.n, &n, v_exp.like(n_frac), port.n_exp);
        (n, n_lift) = (m, v_exp.like(cfg.n_frac) - frac);
    }
    let n_exp = port.n_exp + n_lift;
    let n_dot_v = sink.put(&cfg.n_dot_v, 0, dot(n, v), n_exp + v_exp);
    let n_dot_n = sink.put(&cfg.n_dot_n, 0, dot(n, n), n_exp.up(1));
    let mut sum = n;
    for c in 0..3 {
        sum[c] = n[c].up(1).mul(n_dot_v).up(cfg.lift[0]) - v[c].mul(n_dot_n).up(cfg.lift[1]);
    }
    let exact_frac = v_exp.like(cfg.exact_frac);
    let (v_r, v_r_frac) = sink.normal(&cfg.v_r, &sum, exact_frac, n_exp.up(1) + v_exp);
    Out { n, n_lift, n_dot_v, n_dot_n, v_r, v_r_frac }
}

in_lanes! {
    /// The reflected direction and what later stages need again.
    pub struct Out<V> {
        /// Mantissas of the normal that reflects, its largest component in [1, 2).
        pub n: [V; 3],
        /// n_mod = nominal · 2^(n_exp + n_lift).
        pub n_lift: V,
        /// ⟨n, v⟩ in nominal scale.
        pub n_dot_v: V,
        /// ⟨n, n⟩ in nominal scale.
        pub n_dot_n: V,
        /// Mantissas of v_r.
        pub v_r: [V; 3],
        /// Fraction bits of v_r in nominal scale.
        pub v_r_frac: V,
    }
}

/// Compiled configuration.
#[derive(Clone, Debug, Hash)]
pub struct Cfg {
    /// Port of v.
    pub v: Register,
    /// Port of n, or the register that n_mod is normalised into.
    pub n: Register,
    n_dot_v: Register,
    n_dot_n: Register,
    v_r: Register,
    n_frac: i64,
    lift: [i64; 2],
    exact_frac: i64,
}

impl Cfg {
    /// Compiles and checks the stage.
    pub fn new(config: &Config) -> Result<Self, ConfigError> {
        let (n, v) = (bits(config, Reg::ReflectN), bits(config, Reg::ReflectV));
        fits(Reg::ReflectNdotV, n + v + 2)?;
        fits(Reg::ReflectNdotN, 2 * n + 2)?;
        let n_frac = block_frac(config, Reg::ReflectN);
        let v_frac = block_frac(config, Reg::ReflectV);
        let terms =
            [n_frac + frac(config, Reg::ReflectNdotV), v_frac + frac(config, Reg::ReflectNdotN)];
        let common = terms[0].max(terms[1]);
        let whole =
            (2 + int(config, Reg::ReflectNdotV)).max(1 + int(config, Reg::ReflectNdotN)) + 1;
        fits(Reg::ReflectVr, u32::try_from(common).unwrap_or(u32::MAX) + whole)?;
        Ok(Self {
            v: config.register(Reg::ReflectV, 0),
            n: config.register(Reg::ReflectN, 0),
            n_dot_v: config.register(Reg::ReflectNdotV, n_frac + v_frac),
            n_dot_n: config.register(Reg::ReflectNdotN, 2 * n_frac),
            v_r: config.register(Reg::ReflectVr, 0),
            n_frac,
            lift: terms.map(|t| common - t),
            exact_frac: common,
        })
    }
}
