//! `bump`: n_mod = n + b1 e1 + b2 e2 (Schilling, before eq. 4).

use super::{Lanes, block_frac, fits, frac, int};
use crate::config::{Config, ConfigError};
use crate::fx::Flags;
use crate::lanes::{LaneSink, mul};
use crate::regs::{Reg, Register};
use crate::tap::Tap;

/// Compiled configuration.
#[derive(Clone, Debug, Hash)]
pub struct Cfg {
    /// Port of b.
    pub b: Register,
    n_mod: Register,
    lift_n: i64,
    lift: [i64; 2],
}

/// n and its tangent vectors in one nominal scale, offsets in units of |n|.
#[derive(Clone, Copy, Debug)]
pub struct In<'a, const N: usize> {
    /// Mantissas of the interpolated normal.
    pub n: &'a Lanes<N, 3>,
    /// Its power of two.
    pub n_exp: &'a [i64; N],
    /// First tangent vector.
    pub e1: &'a Lanes<N, 3>,
    /// Second tangent vector.
    pub e2: &'a Lanes<N, 3>,
    /// Offsets b1, b2.
    pub b: &'a Lanes<N, 2>,
}

/// The modified normal in n's nominal scale.
#[derive(Clone, Debug)]
pub struct Out<const N: usize> {
    /// n_mod.
    pub n_mod: Lanes<N, 3>,
}

impl<const N: usize> Default for Out<N> {
    fn default() -> Self {
        Self { n_mod: [[0; N]; 3] }
    }
}

impl Cfg {
    /// Compiles and checks the stage.
    pub fn new(config: &Config) -> Result<Self, ConfigError> {
        let b = frac(config, Reg::BumpB);
        let n = block_frac(config, Reg::FrameN);
        let e = [Reg::FrameE1, Reg::FrameE2].map(|reg| frac(config, reg));
        let common = n.max(b + e[0]).max(b + e[1]);
        let whole =
            int(config, Reg::BumpB) + int(config, Reg::FrameE1).max(int(config, Reg::FrameE2));
        fits(Reg::BumpN, u32::try_from(common).unwrap_or(u32::MAX) + whole.max(1) + 2)?;
        Ok(Self {
            b: config.register(Reg::BumpB, 0),
            n_mod: config.register(Reg::BumpN, common),
            lift_n: common - n,
            lift: e.map(|e| common - b - e),
        })
    }
}

/// The stage.
#[inline(always)]
pub fn bump<const N: usize, T: Tap>(
    cfg: &Cfg,
    input: In<'_, N>,
    out: &mut Out<N>,
    flags: &mut [Flags],
    tap: &mut T,
) {
    let mut sink = LaneSink::<N, T>::new(flags, tap);
    let [b1, b2] = input.b;
    let (lift_n, lift) = (cfg.lift_n, cfg.lift);
    for c in 0..3 {
        let (n, e1, e2) = (&input.n[c], &input.e1[c], &input.e2[c]);
        let sum = |i: usize| {
            (n[i] << lift_n)
                + (mul::<T>(b1[i], e1[i]) << lift[0])
                + (mul::<T>(b2[i], e2[i]) << lift[1])
        };
        sink.write(&cfg.n_mod, c, sum, |i| input.n_exp[i], &mut out.n_mod[c]);
    }
}
