//! `reflect`: v_r = 2n⟨n,v⟩ − v⟨n,n⟩ (Schilling, eq. 4). Nothing is normalised to unit length.

use super::{Lanes, Sink, bits, block_frac, dot, fits, frac, int, store, take};
use crate::config::{Config, ConfigError};
use crate::fx::{Flags, Quantizer};
use crate::regs::Reg;
use crate::tap::Tap;

/// Compiled configuration.
#[derive(Clone, Debug)]
pub struct Cfg {
    /// Port of v.
    pub v: Quantizer,
    /// Port of n, or the register that n_mod is normalised into.
    pub n: Quantizer,
    n_dot_v: Quantizer,
    n_dot_n: Quantizer,
    v_r: Quantizer,
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
        let terms = [
            n_frac + frac(config, Reg::ReflectNdotV),
            v_frac + frac(config, Reg::ReflectNdotN),
        ];
        let common = terms[0].max(terms[1]);
        let whole =
            (2 + int(config, Reg::ReflectNdotV)).max(1 + int(config, Reg::ReflectNdotN)) + 1;
        fits(
            Reg::ReflectVr,
            u32::try_from(common).unwrap_or(u32::MAX) + whole,
        )?;
        Ok(Self {
            v: Quantizer::new(config.format(Reg::ReflectV), 0),
            n: Quantizer::new(config.format(Reg::ReflectN), 0),
            n_dot_v: Quantizer::new(config.format(Reg::ReflectNdotV), n_frac + v_frac),
            n_dot_n: Quantizer::new(config.format(Reg::ReflectNdotN), 2 * n_frac),
            v_r: Quantizer::new(config.format(Reg::ReflectVr), 0),
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
    for lane in 0..flags.len().min(N) {
        let flags = &mut flags[lane];
        let mut sink = Sink { lane, flags, tap };
        let v = take(input.v, lane);
        let v_exp = input.v_exp[lane];
        let mut n = take(input.n, lane);
        let mut n_exp = input.n_exp[lane];
        let mut n_lift = 0;
        if let Some(n_frac) = input.n_mod_frac {
            let block = sink.block(&cfg.n, Reg::ReflectN, &n, n_frac, n_exp);
            n = block.m;
            n_lift = cfg.n_frac - block.frac;
            n_exp += n_lift;
        }
        let n_dot_v = sink.write(&cfg.n_dot_v, Reg::ReflectNdotV, 0, dot(n, v), n_exp + v_exp);
        let n_dot_n = sink.write(&cfg.n_dot_n, Reg::ReflectNdotN, 0, dot(n, n), 2 * n_exp);
        let mut sum = [0; 3];
        for (i, s) in sum.iter_mut().enumerate() {
            *s = ((2 * n[i] * n_dot_v) << cfg.lift[0]) - ((v[i] * n_dot_n) << cfg.lift[1]);
        }
        let v_r = sink.block(
            &cfg.v_r,
            Reg::ReflectVr,
            &sum,
            cfg.exact_frac,
            2 * n_exp + v_exp,
        );
        store(&mut out.n, lane, n);
        out.n_lift[lane] = n_lift;
        out.n_dot_v[lane] = n_dot_v;
        out.n_dot_n[lane] = n_dot_n;
        store(&mut out.v_r, lane, v_r.m);
        out.v_r_frac[lane] = v_r.frac;
    }
}
