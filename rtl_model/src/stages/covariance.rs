//! `covariance`: K = D Dᵀ + (sB')(sB')ᵀ = (a, b; b, c) with one shared, even exponent.
//!
//! (Schilling, eq. 3 with the order corrected, 12 and 13.) The shift is common to a, b and c, never a
//! saturation of one of them: that would turn the axis.

use super::{Lanes, bits, block_frac, fits, frac, int, store, take};
use crate::config::{Config, ConfigError};
use crate::fx::Flags;
use crate::lanes::{LaneSink, each, fill, leading_zeros, mantissas, mul};
use crate::policy::Axis;
use crate::regs::{Kind, Reg, Register};
use crate::tap::Tap;

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

/// D and, with roughness, s·B'.
#[derive(Clone, Copy, Debug)]
pub struct In<'a, const N: usize> {
    /// D row by row.
    pub d: &'a Lanes<N, 4>,
    /// s·B' row by row; `None` without roughness.
    pub b: Option<&'a Lanes<N, 4>>,
    /// Powers of two of D, where its register is a block.
    pub exp: Option<&'a [i64; N]>,
}

/// K.
#[derive(Clone, Debug)]
pub struct Out<const N: usize> {
    /// Mantissas of a, b, c.
    pub k: Lanes<N, 3>,
    /// Their fraction bits.
    pub frac: [i64; N],
    /// The longest column of [D s·B'], for `footprint.axis = "longer-derivative"`.
    pub longest: Lanes<N, 2>,
    /// Its squared length at K's exponent.
    pub longest_sq: [i64; N],
}

impl<const N: usize> Default for Out<N> {
    fn default() -> Self {
        Self { k: [[0; N]; 3], frac: [0; N], longest: [[0; N]; 2], longest_sq: [0; N] }
    }
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

/// The stage.
#[inline(always)]
pub fn covariance<const N: usize, T: Tap>(
    cfg: &Cfg,
    input: In<'_, N>,
    out: &mut Out<N>,
    flags: &mut [Flags],
    tap: &mut T,
) {
    let mut sink = LaneSink::<N, T>::new(flags, tap);
    let lanes = sink.n;
    let mut sum = squares::<N, T>(lanes, input.d, cfg.lift[0]);
    if let Some(rough) = input.b {
        let more = squares::<N, T>(lanes, rough, cfg.lift[1]);
        for (sum, more) in sum.iter_mut().zip(&more) {
            *sum = each(lanes, |i| sum[i] + more[i]);
        }
    }
    // Where all words of a row stand at −2^w the sum is 2^62, and an even shift takes one place more.
    let width = cfg.k.bits();
    let zeros = leading_zeros(lanes, &[sum[0], sum[2]]);
    let shift: [i64; N] = each(lanes, |i| {
        let shift = if zeros[i] == 64 { 0 } else { 64 - zeros[i] - width };
        // An even exponent against the nominal scale: K's root has a whole one.
        shift + ((cfg.exact_frac - shift + cfg.parity) & 1)
    });
    mantissas(lanes, &cfg.k, &sum, |i| 63 - width - shift[i], &mut out.k);
    fill(lanes, &mut out.frac, |i| cfg.exact_frac - shift[i]);
    if let Some(exp) = input.exp {
        for (frac, exp) in out.frac.iter_mut().zip(exp) {
            *frac -= 2 * exp;
        }
    }
    for (c, k) in out.k.iter().enumerate() {
        sink.put(&cfg.k, c, k, |i| out.frac[i]);
    }
    if cfg.longest {
        for lane in 0..lanes {
            let (column, sq) = longest(cfg, input, lane);
            store(&mut out.longest, lane, column);
            out.longest_sq[lane] = cfg.k.round(sq, shift[lane]).clamp(0, cfg.k.format.max_raw());
        }
    }
}

/// The products of a matrix's rows: a, b, c of X Xᵀ.
#[inline(always)]
fn squares<const N: usize, T: Tap>(
    lanes: usize,
    [ux, uy, vx, vy]: &Lanes<N, 4>,
    lift: i64,
) -> Lanes<N, 3> {
    [
        each(lanes, |i| (mul::<T>(ux[i], ux[i]) + mul::<T>(uy[i], uy[i])) << lift),
        each(lanes, |i| (mul::<T>(ux[i], vx[i]) + mul::<T>(uy[i], vy[i])) << lift),
        each(lanes, |i| (mul::<T>(vx[i], vx[i]) + mul::<T>(vy[i], vy[i])) << lift),
    ]
}

/// The longest column of [D s·B'] and its squared length; the first on ties.
#[inline(always)]
fn longest<const N: usize>(cfg: &Cfg, input: In<'_, N>, lane: usize) -> ([i64; 2], i64) {
    let [ux, uy, vx, vy] = take(input.d, lane);
    let [b11, b12, b21, b22] = input.b.map_or([0; 4], |b| take(b, lane));
    let mut best = ([0; 2], -1);
    for (column, lift) in [
        ([ux, vx], cfg.lift[0]),
        ([uy, vy], cfg.lift[0]),
        ([b11, b21], cfg.lift[1]),
        ([b12, b22], cfg.lift[1]),
    ] {
        let sq = (column[0] * column[0] + column[1] * column[1]) << lift;
        if sq > best.1 {
            best = (column, sq);
        }
    }
    best
}
