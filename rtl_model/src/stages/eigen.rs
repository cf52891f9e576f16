//! `eigen`: λ1, λ2 and the unit vector of the major axis (Schilling, eq. 15–20).
//!
//! λ² = ½(a + c ± √((c−a)² + 4b²)); tan 2α = 2b/(c−a); r1 = (cos α, −sin α) is the major axis where
//! c − a < 0, r2 = (sin α, cos α) elsewhere. K isotropic: axis (1, 0).

use lanes::{Mask as _, Vector};

use super::{Roms, bits, covariance, fits, frac, int};
use crate::config::{Config, ConfigError};
use crate::lanes::{Writes, in_lanes};
use crate::policy::{Axis, Minor};
use crate::regs::{Reg, Register};
use crate::tables::angle::{BOUNDARY_FRAC, pair};
use crate::tables::rom::{mantissa, mantissa4};

const P: i64 = 30;

/// The stage: K to the axes of its ellipse.
#[inline(always)]
pub fn eigen<V: Vector>(
    cfg: &Cfg,
    roms: &Roms,
    k: &covariance::Out<V>,
    sink: &mut impl Writes<V>,
) -> Out<V> {
    let [a, b, c] = k.k;
    let none = a.like(0);
    // K = mantissa·2^−k_frac·4^exp, λ = nominal·2^exp.
    let exp = (none.like(cfg.k_frac) - k.frac).down(1);
    let (diff, two_b, twice) = (c - a, b.up(1), exp.up(1));
    let square = diff.mul(diff) + two_b.mul(two_b);
    let (y, down) = Cfg::sqrt(roms, square, 2 * cfg.k_frac);
    let root = sink.shifted(&cfg.root, 0, y, down.plus(-cfg.root.frac()), twice);
    let spread = root.up(cfg.lift[1]);
    let longer = cfg.policy == Axis::LongerDerivative;
    let (q, exact) = if longer {
        (&cfg.sq_from_k, [k.longest_sq, (a + c - k.longest_sq).larger(none)])
    } else {
        let sum = (a + c).up(cfg.lift[0]);
        (&cfg.sq, [sum + spread, (sum - spread).larger(none)])
    };
    let mut lambda = exact;
    for i in 0..2 {
        let sq = sink.put(q, i, exact[i], twice);
        let (y, down) = if i == 1 && cfg.minor == Minor::Det && !longer {
            cfg.minor_by_det(roms, k.k, lambda[0])
        } else {
            Cfg::sqrt(roms, sq, q.frac())
        };
        lambda[i] = sink.shifted(&cfg.lambda, i, y, down.plus(-cfg.lambda.frac()), exp);
    }
    let mut axis = [none; 2];
    if cfg.policy == Axis::EigenTable {
        let exact = Cfg::table_axis(roms, two_b, diff);
        for i in 0..2 {
            axis[i] = sink.put(&cfg.axis, i, exact[i], none);
        }
        return Out { lambda, exp, axis };
    }
    let mut direction = k.longest;
    if !longer {
        // 2(λ1² − smaller of a, c) = |c − a| + root; the other component is 2b.
        let (p, q) = (diff.abs().up(cfg.lift[0]) + spread, two_b.up(cfg.lift[0]));
        let (falls, isotropic) = (diff.negative(), two_b.zero() & diff.zero());
        direction = [
            isotropic.select(none, falls.select(p, q)),
            isotropic.select(none, falls.select(q, p)),
        ];
    }
    let (exact, down) = cfg.unit(roms, direction);
    for i in 0..2 {
        axis[i] = sink.shift_either(&cfg.axis_exact, i, exact[i], down, none);
    }
    Out { lambda, exp, axis }
}

in_lanes! {
    /// The ellipse's axes.
    pub struct Out<V> {
        /// λ1, λ2 in nominal scale.
        pub lambda: [V; 2],
        /// λ = nominal · 2^exp.
        pub exp: V,
        /// Unit vector of the major axis.
        pub axis: [V; 2],
    }
}

/// Compiled configuration.
#[derive(Clone, Debug, Hash)]
pub struct Cfg {
    policy: Axis,
    minor: Minor,
    k_frac: i64,
    root: Register,
    /// Lifts of K's mantissas and of the root to a common scale.
    lift: [i64; 2],
    sq: Register,
    sq_from_k: Register,
    lambda: Register,
    axis: Register,
    axis_exact: Register,
}

impl Cfg {
    /// Compiles and checks the stage.
    pub fn new(config: &Config) -> Result<Self, ConfigError> {
        let f = |reg| frac(config, reg);
        let q = |reg, frac_in| config.register(reg, frac_in);
        let common = f(Reg::CovK).max(f(Reg::EigenRoot));
        let whole = (int(config, Reg::CovK) + 1).max(int(config, Reg::EigenRoot)) + 1;
        fits(Reg::EigenSq, u32::try_from(common).unwrap_or(u32::MAX) + whole)?;
        for (reg, most) in [(Reg::EigenSq, 60), (Reg::EigenLambda, 40), (Reg::EigenAxis, 30)] {
            if bits(config, reg) > most {
                fits(reg, 63)?;
            }
        }
        let table = i64::from(config.tables.eigen.frac);
        Ok(Self {
            policy: config.policy.footprint.axis,
            minor: config.policy.eigen.minor,
            k_frac: f(Reg::CovK),
            root: q(Reg::EigenRoot, 0),
            lift: [common - f(Reg::CovK), common - f(Reg::EigenRoot)],
            sq: q(Reg::EigenSq, common + 1),
            sq_from_k: q(Reg::EigenSq, f(Reg::CovK)),
            lambda: q(Reg::EigenLambda, 0),
            axis: q(Reg::EigenAxis, if config.tables.eigen.order == 0 { table } else { table + P }),
            axis_exact: q(Reg::EigenAxis, 0),
        })
    }

    /// √x of codes with `x_frac` fraction bits, times 2^−30: mantissas, and right shifts to integers
    /// with 0 fraction bits.
    #[inline(always)]
    fn sqrt<V: Vector>(roms: &Roms, x: V, x_frac: i64) -> (V, V) {
        let odd = x_frac & 1;
        let (m, q) = mantissa4(x.up(odd).larger(x.like(1)));
        let y = x.gt(x.like(0)).select(roms.sqrt.sqrt(m, &roms.rsqrt), x.like(0));
        (y, x.like(P + ((x_frac + odd) >> 1)) - q)
    }

    /// λ2 = √(ac − b²)/λ1 as mantissas and right shifts to integers without fraction bits.
    #[inline(always)]
    fn minor_by_det<V: Vector>(&self, roms: &Roms, [a, b, c]: [V; 3], lambda1: V) -> (V, V) {
        let det = (a.mul(c) - b.mul(b)).larger(a.like(0));
        let (root, down) = Self::sqrt(roms, det, 2 * self.k_frac);
        let (m, e) = mantissa(lambda1.larger(a.like(1)));
        // root·2^−down · y·2^−30 · 2^(λ_frac − e)
        (root.mul_unsigned(roms.recip.recip(m)), (down + e).plus(P - self.lambda.frac()))
    }

    /// The axis from the table, with its fraction bits; (1, 0) where K is isotropic.
    #[inline(always)]
    fn table_axis<V: Vector>(roms: &Roms, two_b: V, diff: V) -> [V; 2] {
        let (t, d, none) = (two_b.abs(), diff.abs(), diff.like(0));
        let bin = roms.angle.index(t, d);
        let [mut cos, mut sin] = pair(&roms.angle.angles, bin);
        if roms.angle.spec.order != 0 {
            (cos, sin) = Self::interpolated(roms, t, d, bin);
        }
        // A zero 2b counts as positive on both sides.
        let differ = (two_b ^ diff).negative() & !two_b.zero();
        let sin = two_b.zero().select(sin.abs(), differ.select(-sin, sin));
        let falls = diff.negative();
        let (x, y) = (falls.select(cos, sin), falls.select(-sin, cos));
        let flip = x.negative() | (x.zero() & y.negative());
        let isotropic = two_b.zero() & diff.zero();
        let one = none.like(1 << roms.angle.value_frac());
        [isotropic.select(one, flip.select(-x, x)), isotropic.select(none, flip.select(-y, y))]
    }

    /// cos and sin of |α| between two entries of the table, with 30 fraction bits more than an entry.
    #[inline(always)]
    fn interpolated<V: Vector>(roms: &Roms, t: V, d: V, k: V) -> (V, V) {
        let rom = &roms.angle;
        let ([cos, sin], next) = (pair(&rom.angles, k), pair(&rom.angles, k.plus(1)));
        // tan(2α − θk) over the tangent of the step: the fraction of the way to the next entry.
        let [c, s] = pair(&rom.doubled, k);
        let num = (t.mul_wide(c) - d.mul_wide(s)).larger(t.like(0));
        let den = t.mul_wide(s) + d.mul_wide(c);
        let (m, e) = mantissa(den.larger(t.like(1)));
        let (n, n_e) = mantissa(num.larger(t.like(1)));
        let n = num.zero().select(num, n);
        // n·2^(n_e − 30) · y·2^(−30 − e) · cot·2^−(B − 8), as a fraction of 30 bits.
        let ratio = n.mul_unsigned(roms.recip.recip(m)).down(P);
        let ratio = ratio.sra((e - n_e).limit(0, 62));
        let t = ratio.mul_wide(t.like(rom.cot_step)).down(i64::from(BOUNDARY_FRAC) - 8);
        let t = t.limit(0, 1 << P);
        (cos.up(P) + (next[0] - cos).mul(t), sin.up(P) + (next[1] - sin).mul(t))
    }

    /// The direction (x, y), normalised through the reciprocal root: (x, y) and the right shift to the
    /// register; (1, 0) for no direction.
    #[inline(always)]
    fn unit<V: Vector>(&self, roms: &Roms, [x, y]: [V; 2]) -> ([V; 2], V) {
        let frac = self.axis_exact.frac();
        let (zero, one) = (x.like(0), x.like(1));
        let none = x.zero() & y.zero();
        let top = x.like(64 - P) - (x.abs() | y.abs()).leading_zeros();
        let shift = top.larger(zero);
        let (x, y) = (x.sra(shift), y.sra(shift));
        let (m, q) = mantissa4((x.mul(x) + y.mul(y)).larger(one));
        let r = roms.rsqrt.rsqrt(m);
        let flip = x.negative() | (x.zero() & y.negative());
        let (x, y) = (flip.select(-x, x), flip.select(-y, y));
        let (x, y) = (none.select(one, x.mul(r)), none.select(zero, y.mul(r)));
        ([x, y], none.select(x.like(-frac), q.plus(P - frac)))
    }
}
