//! `eigen`: λ1, λ2 and the unit vector of the major axis (Schilling, eq. 15–20).
//!
//! λ² = ½(a + c ± √((c−a)² + 4b²)); tan 2α = 2b/(c−a); r1 = (cos α, −sin α) is the major axis where
//! c − a < 0, r2 = (sin α, cos α) elsewhere. K isotropic: axis (1, 0).

use super::{Lanes, Roms, bits, fits, frac, int, store, take};
use crate::config::{Config, ConfigError};
use crate::fx::{Flags, block};
use crate::lanes::{LaneSink, Shift, each, mantissa, mantissa4, mul, mul_unsigned};
use crate::policy::{Axis, Minor};
use crate::regs::{Reg, Register};
use crate::tables::angle::BOUNDARY_FRAC;
use crate::tables::rom;
use crate::tap::Tap;

const P: i64 = 30;

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

/// The result of `covariance`: K, and under the policy `longer-derivative` the longest column.
#[derive(Clone, Copy, Debug)]
pub struct In<'a, const N: usize> {
    /// Output of `covariance`.
    pub covariance: &'a super::covariance::Out<N>,
}

/// The ellipse's axes.
#[derive(Clone, Debug)]
pub struct Out<const N: usize> {
    /// λ1, λ2 in nominal scale.
    pub lambda: Lanes<N, 2>,
    /// λ = nominal · 2^exp.
    pub exp: [i64; N],
    /// Unit vector of the major axis.
    pub axis: Lanes<N, 2>,
}

impl<const N: usize> Default for Out<N> {
    fn default() -> Self {
        Self { lambda: [[0; N]; 2], exp: [0; N], axis: [[0; N]; 2] }
    }
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
    fn sqrt<const N: usize, T: Tap>(
        lanes: usize,
        roms: &Roms,
        x: &[i64; N],
        x_frac: i64,
        y: &mut [i64; N],
        down: &mut [i64; N],
    ) {
        let odd = x_frac & 1;
        let mut m = [0; N];
        mantissa4(lanes, |i| (x[i] << odd).max(1), &mut m, down);
        roms.sqrt.sqrt_lanes::<N, T>(lanes, &m, &roms.rsqrt, y);
        for i in 0..lanes.min(N) {
            y[i] = if x[i] <= 0 { 0 } else { y[i] };
            down[i] = P - down[i] + ((x_frac + odd) >> 1);
        }
    }

    /// cos and sin of |α| between two entries of the table, with 30 fraction bits more than an entry.
    #[cold]
    #[inline(never)]
    fn interpolated(roms: &Roms, t: i64, d: i64, k: usize) -> (i64, i64) {
        let rom = &roms.angle;
        let (cos, sin) = rom.angles.get(k).copied().unwrap_or((1, 0));
        let (cos, sin) = (cos << P, sin << P);
        let Some(&(next_cos, next_sin)) = rom.angles.get(k + 1) else {
            return (cos, sin);
        };
        // tan(2α − θk) over the tangent of the step: the fraction of the way to the next entry.
        let theta = rom.doubled.get(k).copied().unwrap_or((1, 0));
        let num = (t * theta.0 - d * theta.1).max(0);
        let den = t * theta.1 + d * theta.0;
        let (m, e) = rom::mantissa(den.max(1));
        let (n, n_e) = rom::mantissa(num.max(1));
        let n = if num == 0 { 0 } else { n };
        // n·2^(n_e − 30) · y·2^(−30 − e) · cot·2^−(B − 8), as a fraction of 30 bits.
        let ratio = (n * roms.recip.recip(m)) >> P;
        let ratio = ratio >> (e - n_e).clamp(0, 62);
        let t = ((ratio * rom.cot_step) >> (BOUNDARY_FRAC - 8)).clamp(0, 1 << P);
        (cos + (((next_cos << P) - cos) >> P) * t, sin + (((next_sin << P) - sin) >> P) * t)
    }

    /// The direction (x, y), normalised through the reciprocal root: (x, y) and the right shift to the
    /// register; (1, 0) for no direction.
    #[cold]
    #[inline(never)]
    fn unit(&self, roms: &Roms, xy: [i64; 2]) -> ([i64; 2], i64) {
        let frac = self.axis_exact.frac();
        if xy == [0, 0] {
            return ([1, 0], -frac);
        }
        let shift = (block::top_bit(&xy) + 1 - P).max(0);
        let (x, y) = (xy[0] >> shift, xy[1] >> shift);
        let (m, q) = rom::mantissa4((x * x + y * y).max(1));
        let r = roms.rsqrt.rsqrt(m);
        let (x, y) = if x < 0 || (x == 0 && y < 0) { (-x, -y) } else { (x, y) };
        ([x * r, y * r], P + q - frac)
    }
}

/// The stage.
#[inline(always)]
pub fn eigen<const N: usize, T: Tap>(
    cfg: &Cfg,
    roms: &Roms,
    input: In<'_, N>,
    out: &mut Out<N>,
    flags: &mut [Flags],
    tap: &mut T,
) {
    let mut sink = LaneSink::<N, T>::new(flags, tap);
    let lanes = sink.n;
    let [a, b, c] = &input.covariance.k;
    // K = mantissa·2^−k_frac·4^exp, λ = nominal·2^exp.
    out.exp = each(lanes, |i| (cfg.k_frac - input.covariance.frac[i]) >> 1);
    let exp = &out.exp;
    let diff: [i64; N] = each(lanes, |i| c[i] - a[i]);
    let two_b: [i64; N] = each(lanes, |i| 2 * b[i]);

    let square = each(lanes, |i| mul::<T>(diff[i], diff[i]) + mul::<T>(two_b[i], two_b[i]));
    let [mut y, mut down] = [[0; N]; 2];
    Cfg::sqrt::<N, T>(lanes, roms, &square, 2 * cfg.k_frac, &mut y, &mut down);
    let root_frac = cfg.root.frac();
    let shift = Shift::new(lanes, &cfg.root, |i| down[i] - root_frac);
    let twice = |i: usize| 2 * exp[i];
    let mut root = [0; N];
    sink.shift(&cfg.root, 0, &shift, |i| y[i], twice, &mut root);
    let spread: [i64; N] = each(lanes, |i| root[i] << cfg.lift[1]);
    let longer = cfg.policy == Axis::LongerDerivative;
    let (q, sq) = if longer {
        let major = &input.covariance.longest_sq;
        let minor = each(lanes, |i| (a[i] + c[i] - major[i]).max(0));
        (&cfg.sq_from_k, [*major, minor])
    } else {
        let sum = |i: usize| (a[i] + c[i]) << cfg.lift[0];
        let major = each(lanes, |i| sum(i) + spread[i]);
        (&cfg.sq, [major, each(lanes, |i| (sum(i) - spread[i]).max(0))])
    };
    let lambda_frac = cfg.lambda.frac();
    for (k, exact) in sq.iter().enumerate() {
        let mut sq = [0; N];
        sink.write(q, k, |i| exact[i], twice, &mut sq);
        if k == 1 && cfg.minor == Minor::Det && !longer {
            let major = &out.lambda[0];
            minor_by_det::<N, T>(lanes, cfg, roms, [a, b, c], major, &mut y, &mut down);
        } else {
            let sq_frac = q.frac();
            Cfg::sqrt::<N, T>(lanes, roms, &sq, sq_frac, &mut y, &mut down);
        }
        let shift = Shift::new(lanes, &cfg.lambda, |i| down[i] - lambda_frac);
        let exp = |i: usize| exp[i];
        sink.shift(&cfg.lambda, k, &shift, |i| y[i], exp, &mut out.lambda[k]);
    }

    if cfg.policy == Axis::EigenTable {
        let axis = table_axis::<N, T>(lanes, roms, &two_b, &diff);
        for (c, axis) in axis.iter().enumerate() {
            sink.write(&cfg.axis, c, |i| axis[i], |_| 0, &mut out.axis[c]);
        }
        return;
    }
    let (mut axis, mut down) = ([[0; N]; 2], [0; N]);
    for i in 0..lanes.min(N) {
        let direction = if longer {
            take(&input.covariance.longest, i)
        } else if two_b[i] == 0 && diff[i] == 0 {
            [0, 0]
        } else {
            // 2(λ1² − smaller of a, c) = |c − a| + root; the other component is 2b.
            let p = (diff[i].abs() << cfg.lift[0]) + spread[i];
            let q = two_b[i] << cfg.lift[0];
            if diff[i] < 0 { [p, q] } else { [q, p] }
        };
        let (unit, shift) = cfg.unit(roms, direction);
        store(&mut axis, i, unit);
        down[i] = shift;
    }
    let shift = Shift::new(lanes, &cfg.axis_exact, |i| down[i]);
    for (c, axis) in axis.iter().enumerate() {
        sink.shift(&cfg.axis_exact, c, &shift, |i| axis[i], |_| 0, &mut out.axis[c]);
    }
}

/// Axes from the table, with its fraction bits; (1, 0) where K is isotropic.
#[inline(always)]
fn table_axis<const N: usize, T: Tap>(
    lanes: usize,
    roms: &Roms,
    two_b: &[i64; N],
    diff: &[i64; N],
) -> Lanes<N, 2> {
    let (t, d) = (each(lanes, |i| two_b[i].abs()), each(lanes, |i| diff[i].abs()));
    let bin = roms.angle.indices::<N, T>(lanes, &t, &d);
    let (mut cos, mut sin) = ([0; N], [0; N]);
    for i in 0..lanes.min(N) {
        (cos[i], sin[i]) = roms.angle.angles.get(bin[i]).copied().unwrap_or((1, 0));
    }
    if roms.angle.spec.order != 0 {
        for i in 0..lanes.min(N) {
            (cos[i], sin[i]) = Cfg::interpolated(roms, t[i], d[i], bin[i]);
        }
    }
    let one = 1i64 << roms.angle.value_frac();
    let mut out = [[0; N]; 2];
    for i in 0..lanes.min(N) {
        let isotropic = two_b[i] == 0 && diff[i] == 0;
        // A zero 2b counts as positive on both sides.
        let same = (two_b[i] < 0) == (diff[i] < 0);
        let signed = if same { sin[i] } else { -sin[i] };
        let sin = if two_b[i] == 0 { sin[i].abs() } else { signed };
        let (x, y) = if diff[i] < 0 { (cos[i], -sin) } else { (sin, cos[i]) };
        let flip = x < 0 || (x == 0 && y < 0);
        let (x, y) = if flip { (-x, -y) } else { (x, y) };
        out[0][i] = if isotropic { one } else { x };
        out[1][i] = if isotropic { 0 } else { y };
    }
    out
}

/// λ2 = √(ac − b²)/λ1 as mantissas and right shifts to integers without fraction bits.
#[inline(always)]
fn minor_by_det<const N: usize, T: Tap>(
    lanes: usize,
    cfg: &Cfg,
    roms: &Roms,
    [a, b, c]: [&[i64; N]; 3],
    lambda1: &[i64; N],
    y: &mut [i64; N],
    down: &mut [i64; N],
) {
    let det = each(lanes, |i| (mul::<T>(a[i], c[i]) - mul::<T>(b[i], b[i])).max(0));
    let [mut root, mut m, mut e] = [[0; N]; 3];
    Cfg::sqrt::<N, T>(lanes, roms, &det, 2 * cfg.k_frac, &mut root, down);
    mantissa(lanes, |i| lambda1[i].max(1), &mut m, &mut e);
    roms.recip.recip_lanes::<N, T>(lanes, &m, y);
    // root·2^−down · y·2^−30 · 2^(λ_frac − e)
    let fixed = P - cfg.lambda.frac();
    for i in 0..lanes.min(N) {
        y[i] = mul_unsigned::<T>(root[i], y[i]);
        down[i] += fixed + e[i];
    }
}
