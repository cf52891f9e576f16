//! `eigen`: λ1, λ2 and the unit vector of the major axis (Schilling, eq. 15–20).
//!
//! λ² = ½(a + c ± √((c−a)² + 4b²)); tan 2α = 2b/(c−a); r1 = (cos α, −sin α) is the major axis where
//! c − a < 0, r2 = (sin α, cos α) elsewhere. K isotropic: axis (1, 0).

use super::{Lanes, Roms, Sink, bits, fits, frac, int, store, take};
use crate::config::{Config, ConfigError};
use crate::fx::{Flags, Quantizer, block};
use crate::policy::{Axis, Minor};
use crate::regs::Reg;
use crate::tables::angle::BOUNDARY_FRAC;
use crate::tables::rom::{mantissa, mantissa4};
use crate::tap::Tap;

const P: i64 = 30;

/// Compiled configuration.
#[derive(Clone, Debug)]
pub struct Cfg {
    policy: Axis,
    minor: Minor,
    k_frac: i64,
    root: Quantizer,
    /// Lifts of K's mantissas and of the root to a common scale.
    lift: [i64; 2],
    sq: Quantizer,
    sq_from_k: Quantizer,
    lambda: Quantizer,
    axis: Quantizer,
    axis_exact: Quantizer,
}

/// K, and the longest column where that is the axis.
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
        Self {
            lambda: [[0; N]; 2],
            exp: [0; N],
            axis: [[0; N]; 2],
        }
    }
}

impl Cfg {
    /// Compiles and checks the stage.
    pub fn new(config: &Config) -> Result<Self, ConfigError> {
        let f = |reg| frac(config, reg);
        let q = |reg, frac_in| Quantizer::new(config.format(reg), frac_in);
        let common = f(Reg::CovK).max(f(Reg::EigenRoot));
        let whole = (int(config, Reg::CovK) + 1).max(int(config, Reg::EigenRoot)) + 1;
        fits(
            Reg::EigenSq,
            u32::try_from(common).unwrap_or(u32::MAX) + whole,
        )?;
        for (reg, most) in [
            (Reg::EigenSq, 60),
            (Reg::EigenLambda, 40),
            (Reg::EigenAxis, 30),
        ] {
            if bits(config, reg) > most {
                fits(reg, 63)?;
            }
        }
        let table = i64::from(config.tables.eigen.frac);
        Ok(Self {
            policy: config.axis,
            minor: config.minor,
            k_frac: f(Reg::CovK),
            root: q(Reg::EigenRoot, 0),
            lift: [common - f(Reg::CovK), common - f(Reg::EigenRoot)],
            sq: q(Reg::EigenSq, common + 1),
            sq_from_k: q(Reg::EigenSq, f(Reg::CovK)),
            lambda: q(Reg::EigenLambda, 0),
            axis: q(
                Reg::EigenAxis,
                if config.tables.eigen.order == 0 {
                    table
                } else {
                    table + P
                },
            ),
            axis_exact: q(Reg::EigenAxis, 0),
        })
    }

    /// √x of a code with `x_frac` fraction bits, times 2^−30: (mantissa, right shift to an integer
    /// with 0 fraction bits).
    #[inline(always)]
    fn sqrt(roms: &Roms, x: i64, x_frac: i64) -> (i64, i64) {
        let odd = x_frac & 1;
        let (m, q) = mantissa4((x << odd).max(1));
        let y = if x <= 0 {
            0
        } else {
            roms.sqrt.sqrt(m, &roms.rsqrt)
        };
        (y, P - q + ((x_frac + odd) >> 1))
    }

    /// cos and sin (sign applied) of α from the table, with the fraction bits of `self.axis`.
    #[inline(always)]
    fn table(roms: &Roms, two_b: i64, diff: i64) -> (i64, i64) {
        let rom = &roms.angle;
        let (t, d) = (two_b.abs(), diff.abs());
        let k = rom.index(t, d);
        let (cos, sin) = rom.angles.get(k).copied().unwrap_or((1, 0));
        if rom.spec.order == 0 {
            return (cos, sin);
        }
        let (cos, sin) = (cos << P, sin << P);
        let Some(&(next_cos, next_sin)) = rom.angles.get(k + 1) else {
            return (cos, sin);
        };
        // tan(2α − θk) over the tangent of the step: the fraction of the way to the next entry.
        let theta = rom.doubled.get(k).copied().unwrap_or((1, 0));
        let num = (t * theta.0 - d * theta.1).max(0);
        let den = t * theta.1 + d * theta.0;
        let (m, e) = mantissa(den.max(1));
        let (n, n_e) = mantissa(num.max(1));
        let n = if num == 0 { 0 } else { n };
        // n·2^(n_e − 30) · y·2^(−30 − e) · cot·2^−(B − 8), as a fraction of 30 bits.
        let ratio = (n * roms.recip.recip(m)) >> P;
        let ratio = ratio >> (e - n_e).clamp(0, 62);
        let t = ((ratio * rom.cot_step) >> (BOUNDARY_FRAC - 8)).clamp(0, 1 << P);
        (
            cos + (((next_cos << P) - cos) >> P) * t,
            sin + (((next_sin << P) - sin) >> P) * t,
        )
    }

    /// The direction (x, y), normalised through the reciprocal root.
    #[inline(always)]
    fn unit<T: Tap>(&self, sink: &mut Sink<'_, T>, roms: &Roms, xy: [i64; 2]) -> [i64; 2] {
        let shift = (block::top_bit(&xy) + 1 - P).max(0);
        let [x, y] = xy.map(|c| c >> shift);
        let (m, q) = mantissa4((x * x + y * y).max(1));
        let r = roms.rsqrt.rsqrt(m);
        let down = P + q - i64::from(self.axis_exact.format.frac);
        let [x, y] = if x < 0 || (x == 0 && y < 0) {
            [-x, -y]
        } else {
            [x, y]
        };
        [
            sink.shift(&self.axis_exact, Reg::EigenAxis, 0, x * r, down, 0),
            sink.shift(&self.axis_exact, Reg::EigenAxis, 1, y * r, down, 0),
        ]
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
    let root_frac = i64::from(cfg.root.format.frac);
    let lambda_frac = i64::from(cfg.lambda.format.frac);
    for lane in 0..flags.len().min(N) {
        let flags = &mut flags[lane];
        let mut sink = Sink { lane, flags, tap };
        let [a, b, c] = take(&input.covariance.k, lane);
        // K = mantissa·2^−k_frac·4^exp, λ = nominal·2^exp.
        let exp = (cfg.k_frac - input.covariance.frac[lane]) >> 1;
        let diff = c - a;
        let two_b = 2 * b;

        let square = diff * diff + two_b * two_b;
        let (y, down) = Cfg::sqrt(roms, square, 2 * cfg.k_frac);
        let root = sink.shift(&cfg.root, Reg::EigenRoot, 0, y, down - root_frac, 2 * exp);
        let sum = (a + c) << cfg.lift[0];
        let spread = root << cfg.lift[1];
        let longer = cfg.policy == Axis::LongerDerivative;
        let sq = if longer {
            let major = input.covariance.longest_sq[lane];
            [major, (a + c - major).max(0)].map(|x| (x, &cfg.sq_from_k))
        } else {
            [(sum + spread, &cfg.sq), ((sum - spread).max(0), &cfg.sq)]
        };
        let mut lambda = [0; 2];
        for (i, (x, q)) in sq.into_iter().enumerate() {
            let sq = sink.write(q, Reg::EigenSq, i, x, 2 * exp);
            let (mut y, mut down) = Cfg::sqrt(roms, sq, i64::from(q.format.frac));
            if i == 1 && cfg.minor == Minor::Det && !longer {
                (y, down) = minor_by_det(cfg, roms, [a, b, c], lambda[0]);
            }
            lambda[i] = sink.shift(&cfg.lambda, Reg::EigenLambda, i, y, down - lambda_frac, exp);
        }

        let axis = match cfg.policy {
            Axis::EigenTable if two_b == 0 && diff == 0 => unit_x(cfg, &mut sink),
            Axis::EigenTable => {
                let (cos, sin) = Cfg::table(roms, two_b, diff);
                let sin = if (two_b < 0) == (diff < 0) { sin } else { -sin };
                // A zero 2b counts as positive on both sides.
                let sin = if two_b == 0 { sin.abs() } else { sin };
                let [x, y] = if diff < 0 { [cos, -sin] } else { [sin, cos] };
                let [x, y] = if x < 0 || (x == 0 && y < 0) {
                    [-x, -y]
                } else {
                    [x, y]
                };
                [
                    sink.write(&cfg.axis, Reg::EigenAxis, 0, x, 0),
                    sink.write(&cfg.axis, Reg::EigenAxis, 1, y, 0),
                ]
            }
            Axis::EigenExact if two_b == 0 && diff == 0 => unit_x(cfg, &mut sink),
            Axis::EigenExact => {
                // 2(λ1² − smaller of a, c) = |c − a| + root; the other component is 2b.
                let p = (diff.abs() << cfg.lift[0]) + spread;
                let q = two_b << cfg.lift[0];
                cfg.unit(&mut sink, roms, if diff < 0 { [p, q] } else { [q, p] })
            }
            Axis::LongerDerivative => match take(&input.covariance.longest, lane) {
                [0, 0] => unit_x(cfg, &mut sink),
                column => cfg.unit(&mut sink, roms, column),
            },
        };
        store(&mut out.lambda, lane, lambda);
        out.exp[lane] = exp;
        store(&mut out.axis, lane, axis);
    }
}

/// (1, 0).
#[inline(always)]
fn unit_x<T: Tap>(cfg: &Cfg, sink: &mut Sink<'_, T>) -> [i64; 2] {
    let one = -i64::from(cfg.axis_exact.format.frac);
    [
        sink.shift(&cfg.axis_exact, Reg::EigenAxis, 0, 1, one, 0),
        sink.shift(&cfg.axis_exact, Reg::EigenAxis, 1, 0, 0, 0),
    ]
}

/// λ2 = √(ac − b²)/λ1 as (mantissa, right shift to an integer without fraction bits).
#[inline(always)]
fn minor_by_det(cfg: &Cfg, roms: &Roms, [a, b, c]: [i64; 3], lambda1: i64) -> (i64, i64) {
    let det = (a * c - b * b).max(0);
    let (root, down) = Cfg::sqrt(roms, det, 2 * cfg.k_frac);
    let (m, e) = mantissa(lambda1.max(1));
    let y = roms.recip.recip(m);
    // root·2^−down · y·2^−30 · 2^(λ_frac − e)
    (root * y, down + P + e - i64::from(cfg.lambda.format.frac))
}
