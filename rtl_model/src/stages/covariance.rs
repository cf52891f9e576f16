//! `covariance`: K = D Dᵀ + (sB')(sB')ᵀ = (a, b; b, c) with one shared, even exponent.
//!
//! (Schilling, eq. 3 with the order corrected, 12 and 13.) The shift is common to a, b and c, never a
//! saturation of one of them: that would turn the axis.

use lanes::{Mask as _, Vector};

use super::{bits, block_frac, fits, frac, int};
use crate::config::{Config, ConfigError};
use crate::lanes::{Writes, in_lanes};
use crate::policy::Axis;
use crate::regs::{Kind, Reg, Register};

/// The stage, from D, with roughness s·B', and D's powers of two where its register is a block.
#[inline(always)]
pub fn covariance<V: Vector>(
    cfg: &Cfg,
    d: &[V; 4],
    b: Option<&[V; 4]>,
    exp: Option<V>,
    sink: &mut impl Writes<V>,
) -> Out<V> {
    let mut sum = squares(d, cfg.lift[0]);
    if let Some(b) = b {
        let more = squares(b, cfg.lift[1]);
        for c in 0..3 {
            sum[c] = sum[c] + more[c];
        }
    }
    let any = sum[0].abs() | sum[2].abs();
    let shift = any.like(64 - cfg.k.bits()) - any.leading_zeros();
    let shift = any.zero().select(any.like(0), shift);
    // An even exponent against the nominal scale: K's root has a whole one.
    let shift = shift + (shift.like(cfg.exact_frac + cfg.parity) - shift).and(1);
    let exact_frac = shift.like(cfg.exact_frac);
    let (k, frac) = sink.normalize(&cfg.k, &sum, exact_frac, Some(shift));
    let frac = frac - exp.map_or(shift.like(0), |exp| exp.up(1));
    for (c, k) in k.iter().enumerate() {
        sink.tell(&cfg.k, c, *k, frac);
    }
    let mut out = Out { k, frac, longest: [frac; 2], longest_sq: frac };
    if cfg.longest {
        let (longest, sq) = longest(cfg, d, b);
        let ([sq], _) = sink.normalize(&cfg.k, &[sq], exact_frac, Some(shift));
        out.longest = longest;
        out.longest_sq = sq.larger(sq.like(0));
    }
    out
}

/// The products of a matrix's rows: a, b, c of X Xᵀ.
#[inline(always)]
fn squares<V: Vector>([ux, uy, vx, vy]: &[V; 4], lift: i64) -> [V; 3] {
    [
        (ux.mul(*ux) + uy.mul(*uy)).up(lift),
        (ux.mul(*vx) + uy.mul(*vy)).up(lift),
        (vx.mul(*vx) + vy.mul(*vy)).up(lift),
    ]
}

/// The longest column of [D s·B'] and its squared length; the first on ties.
#[inline(always)]
fn longest<V: Vector>(cfg: &Cfg, d: &[V; 4], b: Option<&[V; 4]>) -> ([V; 2], V) {
    let none = d[0].like(0);
    let (mut best, mut most) = ([none; 2], none.like(-1));
    for (m, lift) in [(d, cfg.lift[0]), (b.unwrap_or(&[none; 4]), cfg.lift[1])] {
        for (u, v) in [(m[0], m[2]), (m[1], m[3])] {
            let sq = (u.mul(u) + v.mul(v)).up(lift);
            let longer = sq.gt(most);
            best = [longer.select(u, best[0]), longer.select(v, best[1])];
            most = longer.select(sq, most);
        }
    }
    (best, most)
}

in_lanes! {
    /// K.
    pub struct Out<V> {
        /// Mantissas of a, b, c.
        pub k: [V; 3],
        /// Their fraction bits.
        pub frac: V,
        /// The longest column of [D s·B'], for `footprint.axis = "longer-derivative"`.
        pub longest: [V; 2],
        /// Its squared length at K's exponent.
        pub longest_sq: V,
    }
}

/// Compiled configuration.
#[derive(Clone, Debug, Hash)]
pub struct Cfg {
    k: Register,
    exact_frac: i64,
    lift: [i64; 2],
    /// Fraction bits of K's nominal scale; the shared exponent is even against it.
    parity: i64,
    longest: bool,
}

impl Cfg {
    /// Compiles and checks the stage behind the register `source` that holds D.
    pub fn new(config: &Config, source: Reg, rough: bool) -> Result<Self, ConfigError> {
        // A block's mantissas fill their bits, the largest in [1, 2).
        let (d, d_int) = match source.info().kind {
            Kind::Fixed => (frac(config, source), int(config, source)),
            Kind::Block => (block_frac(config, source), 1),
        };
        let b = if rough { frac(config, Reg::RoughB) } else { d };
        let common = d.max(b);
        let whole = if rough { d_int.max(int(config, Reg::RoughB)) } else { d_int };
        let sum = if rough { 2 } else { 1 };
        fits(Reg::CovK, u32::try_from(2 * common).unwrap_or(u32::MAX) + 2 * whole + sum)?;
        // (c − a)² + 4b² of mantissas < 2^w needs 2w + 3 bits at most.
        fits(Reg::EigenRoot, 2 * bits(config, Reg::CovK) + 2)?;
        if bits(config, Reg::CovK) < 4 {
            return Err(ConfigError {
                path: "registers.covariance.k".into(),
                expected: "a mantissa of at least 4 bits".into(),
                found: alloc::format!("{} bits", bits(config, Reg::CovK)),
            });
        }
        Ok(Self {
            k: config.register(Reg::CovK, 0),
            exact_frac: 2 * common,
            lift: [2 * (common - d), 2 * (common - b)],
            parity: frac(config, Reg::CovK) & 1,
            longest: config.policy.footprint.axis == Axis::LongerDerivative,
        })
    }
}
