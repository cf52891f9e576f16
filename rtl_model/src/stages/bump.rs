//! `bump`: n_mod = n + b1 e1 + b2 e2 (Schilling, before eq. 4).

use lanes::Vector;

use super::{block_frac, fits, frac, int, local_frame};
use crate::config::{Config, ConfigError};
use crate::lanes::{Writes, in_lanes};
use crate::regs::{Reg, Register};
use crate::unit::Inputs;

/// The stage: n_mod in n's nominal scale.
#[inline(always)]
pub fn bump<V: Vector>(
    cfg: &Cfg,
    port: &Inputs<V>,
    frame: &local_frame::Out<V>,
    sink: &mut impl Writes<V>,
) -> Out<V> {
    let [b1, b2] = port.b;
    let mut n_mod = port.n;
    for c in 0..3 {
        let sum = port.n[c].up(cfg.lift_n)
            + b1.mul(frame.e1[c]).up(cfg.lift[0])
            + b2.mul(frame.e2[c]).up(cfg.lift[1]);
        n_mod[c] = sink.put(&cfg.n_mod, c, sum, port.n_exp);
    }
    Out { n_mod }
}

in_lanes! {
    /// The modified normal in n's nominal scale.
    pub struct Out<V> {
        /// n_mod.
        pub n_mod: [V; 3],
    }
}

/// Compiled configuration.
#[derive(Clone, Debug, Hash)]
pub struct Cfg {
    /// Port of b.
    pub b: Register,
    n_mod: Register,
    lift_n: i64,
    lift: [i64; 2],
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
