//! `reflect`: v_r = 2n⟨n,v⟩ − v⟨n,n⟩ (Schilling, eq. 4). Nothing is normalised to unit length.

use super::{Lanes, bits, block_frac, fits, frac, int, take};
use crate::config::{Config, ConfigError};
use crate::fx::Flags;
use crate::lanes::{LaneSink, dot, fill, mul};
use crate::regs::{Reg, Register};
use crate::tap::Tap;

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

/// v and n as mantissas, each with its power of two.
#[derive(Clone, Copy, Debug)]
pub struct In<'a, const N: usize> {
    /// Mantissas of v.
    pub v: &'a Lanes<N, 3>,
    /// Power of two of v.
    pub v_exp: &'a [i64; N],
    /// Mantissas of n, or codes of n_mod.
    pub n: &'a Lanes<N, 3>,
    /// Power of two of the interpolated normal.
    pub n_exp: &'a [i64; N],
    /// Fraction bits of n_mod's codes; `None` where n comes normalised from its port.
    pub n_mod_frac: Option<i64>,
}

/// The reflected direction and what later stages need again.
#[derive(Clone, Debug)]
pub struct Out<const N: usize> {
    /// Mantissas of the normal that reflects, its largest component in [1, 2).
    pub n: Lanes<N, 3>,
    /// n_mod = nominal · 2^(n_exp + n_lift).
    pub n_lift: [i64; N],
    /// ⟨n, v⟩ in nominal scale.
    pub n_dot_v: [i64; N],
    /// ⟨n, n⟩ in nominal scale.
    pub n_dot_n: [i64; N],
    /// Mantissas of v_r.
    pub v_r: Lanes<N, 3>,
    /// Fraction bits of v_r in nominal scale.
    pub v_r_frac: [i64; N],
}

impl<const N: usize> Default for Out<N> {
    fn default() -> Self {
        Self {
            n: [[0; N]; 3],
            n_lift: [0; N],
            n_dot_v: [0; N],
            n_dot_n: [0; N],
            v_r: [[0; N]; 3],
            v_r_frac: [0; N],
        }
    }
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

/// The stage.
#[inline(always)]
pub fn reflect<const N: usize, T: Tap>(
    cfg: &Cfg,
    input: In<'_, N>,
    out: &mut Out<N>,
    flags: &mut [Flags],
    tap: &mut T,
) {
    let mut sink = LaneSink::<N, T>::new(flags, tap);
    let lanes = sink.n;
    let (v, v_exp) = (input.v, input.v_exp);
    if let Some(n_frac) = input.n_mod_frac {
        let n_exp = |i: usize| input.n_exp[i];
        let mut frac = [0; N];
        let block = (&mut out.n, &mut frac);
        sink.block(&cfg.n, input.n, |_| n_frac, n_exp, block);
        fill(lanes, &mut out.n_lift, |i| cfg.n_frac - frac[i]);
    } else {
        out.n = *input.n;
        out.n_lift = [0; N];
    }
    let (n, n_lift) = (&out.n, &out.n_lift);
    let n_exp = |i: usize| input.n_exp[i] + n_lift[i];
    sink.write(
        &cfg.n_dot_v,
        0,
        |i| dot::<T>(take(n, i), take(v, i)),
        |i| n_exp(i) + v_exp[i],
        &mut out.n_dot_v,
    );
    sink.write(
        &cfg.n_dot_n,
        0,
        |i| dot::<T>(take(n, i), take(n, i)),
        |i| 2 * n_exp(i),
        &mut out.n_dot_n,
    );
    let (n_dot_v, n_dot_n) = (&out.n_dot_v, &out.n_dot_n);
    let lift = cfg.lift;
    let mut sum = [[0; N]; 3];
    for (sum, (n, v)) in sum.iter_mut().zip(n.iter().zip(v)) {
        fill(lanes, sum, |i| {
            (mul::<T>(2 * n[i], n_dot_v[i]) << lift[0]) - (mul::<T>(v[i], n_dot_n[i]) << lift[1])
        });
    }
    let exp = |i: usize| 2 * n_exp(i) + v_exp[i];
    let block = (&mut out.v_r, &mut out.v_r_frac);
    sink.block(&cfg.v_r, &sum, |_| cfg.exact_frac, exp, block);
}
