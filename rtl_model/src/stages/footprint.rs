//! `footprint`: probe count, probe width, level of detail and step.
//!
//! M = λ1·N/2, m = max(λ2·N/2, 1, M/max_probes); count = clamp(⌈M/m − 2⁻⁸⌉, 1, max_probes); LOD = log2 m
//! clamped to the mip chain. The count is found by comparing M with multiples of m: no division.

use alloc::vec::Vec;

use super::{Lanes, Roms, bits, fits, frac, int};
use crate::config::{Config, ConfigError};
use crate::fx::Flags;
use crate::lanes::{LaneSink, Shift, each, mantissa, mul};
use crate::policy::{Count, FootprintPolicy};
use crate::regs::{Reg, Register};
use crate::tables::rom::PORT_FRAC;
use crate::tap::Tap;

/// Largest face that the address registers are made for.
pub const MAX_FACE: u32 = 1 << 15;
const INV_FRAC: i64 = 28;

/// The power of two that is at least the longer side of a 2-D texture: its D, K and λ count in half of that many
/// texels, so that they fill the same registers as a cube's.
#[must_use]
pub fn planar_unit(size: [u32; 2]) -> u32 {
    size[0].max(size[1]).clamp(1, MAX_FACE).next_power_of_two()
}

/// Compiled configuration.
#[derive(Clone, Debug, Hash)]
pub struct Cfg {
    rule: Count,
    max: i64,
    size: i64,
    last_level: i64,
    length: Register,
    width: Register,
    cap_numerator: i64,
    cap_denominator: i64,
    lod: Register,
    line: Register,
    line_feline: Register,
    step: [Register; 2],
    /// r / (2·count) by count with b fraction bits, for u and v; for `feline` r / (2·(count − 1)).
    /// r is the power of two that holds a texture's longer side, over the side in question; on a cube it is 1.
    /// b is `INV_FRAC` − ⌈log2 r⌉.
    inv_count: [Vec<i64>; 2],
    two_over_n: i64,
    axis_frac: i64,
    lambda_frac: i64,
}

/// The ellipse's axes.
#[derive(Clone, Copy, Debug)]
pub struct In<'a, const N: usize> {
    /// Output of `eigen`.
    pub eigen: &'a super::eigen::Out<N>,
}

/// The probe line.
#[derive(Clone, Debug)]
pub struct Out<const N: usize> {
    /// Probes.
    pub count: [i64; N],
    /// Level of detail with the register's fraction bits.
    pub lod: [i64; N],
    /// Half the spacing of the probes in (u, v).
    pub step: Lanes<N, 2>,
}

impl<const N: usize> Default for Out<N> {
    fn default() -> Self {
        Self { count: [1; N], lod: [0; N], step: [[0; N]; 2] }
    }
}

impl Cfg {
    /// Compiles and checks the stage for faces of `size` texels.
    pub fn new(config: &Config, size: u32) -> Result<Self, ConfigError> {
        Self::compile(config, size, [size; 2])
    }

    /// Compiles and checks the stage for a 2-D texture: λ in units of half of [`planar_unit`] texels, steps in
    /// units of half a period of u and v.
    pub fn planar(config: &Config, size: [u32; 2]) -> Result<Self, ConfigError> {
        Self::compile(config, planar_unit(size), size)
    }

    /// `unit` texels are 2 in λ's units; `size` is that of level 0.
    fn compile(config: &Config, unit: u32, size: [u32; 2]) -> Result<Self, ConfigError> {
        config.check()?;
        let FootprintPolicy { max_probes: max, count: rule, .. } = config.policy.footprint;
        let last_level = i64::from(size[0].max(size[1]).max(1).ilog2());
        let unit = i64::from(unit.clamp(1, MAX_FACE));
        let size = size.map(|n| i64::from(n.clamp(1, MAX_FACE)));
        let f = |reg| frac(config, reg);
        let q = |reg, frac_in| config.register(reg, frac_in);
        let lambda = bits(config, Reg::EigenLambda);
        fits(Reg::FootLength, lambda + 16)?;
        fits(Reg::FootWidth, bits(config, Reg::FootLength) + 16)?;
        fits(Reg::FootLod, bits(config, Reg::FootWidth) + 30)?;
        if int(config, Reg::FootWidth) == 0 {
            return Err(ConfigError {
                path: "registers.footprint.width".into(),
                expected: "at least 1 integer bit: no probe is narrower than a texel".into(),
                found: "0 integer bits".into(),
            });
        }
        // The count compares 256·M with (256·63 + 1)·m at their common fraction.
        let common = config.format(Reg::FootLength).frac.max(config.format(Reg::FootWidth).frac);
        fits(Reg::FootLength, int(config, Reg::FootLength) + common + 9)?;
        fits(Reg::FootWidth, int(config, Reg::FootWidth) + common + 14)?;
        fits(Reg::FootLine, lambda.max(39) + bits(config, Reg::EigenAxis) + 1)?;
        fits(Reg::FootStep, bits(config, Reg::FootLine) + 28)?;
        // Widest m whose count stays within the limit.
        let [cap_denominator, cap_numerator] = rule.most(max).map(i64::from);
        // A narrow texture has long steps: r = unit/size takes bits from its table's fraction.
        let inv_frac = size.map(|n| {
            INV_FRAC - i64::from(u64::BITS - ((unit - 1) / n).cast_unsigned().leading_zeros())
        });
        let inv_count = [0, 1].map(|i: usize| {
            let (over, under) = (unit << inv_frac[i], size[i]);
            let entry = |count: i64| {
                let parts = if rule.has_end_points() { 2 * (count - 1) } else { 2 * count };
                let under = under * parts;
                if parts <= 0 { 0 } else { (2 * over + under) / (2 * under) }
            };
            (0..=i64::from(max)).map(entry).collect()
        });
        let one = 1i64 << INV_FRAC;
        Ok(Self {
            rule,
            max: i64::from(max),
            size: unit,
            last_level,
            length: q(Reg::FootLength, 0),
            width: q(Reg::FootWidth, f(Reg::FootLength) + 8),
            cap_numerator,
            cap_denominator,
            lod: q(Reg::FootLod, i64::from(PORT_FRAC)),
            line: q(Reg::FootLine, 0),
            line_feline: q(Reg::FootLine, INV_FRAC + f(Reg::EigenAxis)),
            step: inv_frac.map(|inv| q(Reg::FootStep, f(Reg::FootLine) + inv)),
            inv_count,
            two_over_n: ((4 * one) / unit + 1) / 2,
            axis_frac: f(Reg::EigenAxis),
            lambda_frac: f(Reg::EigenLambda),
        })
    }

    /// M/max with eight guard bits and a sticky one, to be rounded by the register.
    #[inline(always)]
    fn caps<const N: usize, T: Tap>(&self, lanes: usize, length: &[i64; N]) -> [i64; N] {
        let (numerator, denominator) = (self.cap_numerator, self.cap_denominator);
        if T::STANDARD && denominator.count_ones() == 1 {
            // No register of such a unit wraps to a negative length.
            let bits = denominator.ilog2();
            return each(lanes, |i| {
                let cap = (length[i] * numerator) << 8;
                (cap >> bits) | i64::from(cap & (denominator - 1) != 0)
            });
        }
        each(lanes, |i| {
            let cap = (length[i] * numerator) << 8;
            (cap / denominator) | i64::from(cap % denominator != 0)
        })
    }

    /// How often M exceeds the rule's multiples of m, plus one: the count before `pow2` rounds it.
    ///
    /// The condition for "more than n probes" is A·M > (B·n + C)·m, or ≥ where the rule has it; A and B
    /// are powers of two, so that the multiples are sums of shifted m.
    #[inline(always)]
    fn counts<const N: usize>(
        &self,
        lanes: usize,
        length: &[i64; N],
        width: &[i64; N],
    ) -> [i64; N] {
        let (scale, per, offset, or_equal) = match self.rule {
            // M/m − 2⁻⁸ > n
            Count::Ceil | Count::Pow2 => (8, 8, 1, 0),
            // M/m + ½ ≥ n + 1
            Count::Round => (1, 1, 1, 1),
            // 2M/m − ½ ≥ n + 1
            Count::Feline => (2, 1, 3, 1),
        };
        let mut out = [0; N];
        for i in 0..lanes.min(N) {
            let left = (length[i] << scale) + or_equal;
            let m = width[i];
            let (mut n, mut multiple) = (0, m + if offset == 3 { 2 * m } else { 0 });
            for k in (0..6).rev() {
                let (more, larger) = (n + (1 << k), multiple + (m << (per + k)));
                let passed = more < self.max && left > larger;
                n = if passed { more } else { n };
                multiple = if passed { larger } else { multiple };
            }
            out[i] = n + 1;
        }
        if self.rule == Count::Pow2 {
            for count in &mut out[..lanes] {
                *count = count
                    .cast_unsigned()
                    .next_power_of_two()
                    .cast_signed()
                    .min(self.cap_denominator);
            }
        }
        out
    }
}

/// The stage.
#[inline(always)]
pub fn footprint<const N: usize, T: Tap>(
    cfg: &Cfg,
    roms: &Roms,
    input: In<'_, N>,
    out: &mut Out<N>,
    flags: &mut [Flags],
    tap: &mut T,
) {
    let length_frac = cfg.length.frac();
    let width_frac = cfg.width.frac();
    let mut sink = LaneSink::<N, T>::new(flags, tap);
    let lanes = sink.n;
    let ([major, minor], axis) = (&input.eigen.lambda, &input.eigen.axis);
    // λ = code · 2^−scale.
    let scale = |i: usize| cfg.lambda_frac - input.eigen.exp[i];
    let shift = Shift::new(lanes, &cfg.length, |i| scale(i) + 1 - length_frac);
    let product = |i: usize| mul::<T>(major[i], cfg.size);
    let mut length = [0; N];
    sink.shift(&cfg.length, 0, &shift, product, |_| 0, &mut length);
    let shift = Shift::new(lanes, &cfg.width, |i| scale(i) + 1 - width_frac);
    let product = |i: usize| mul::<T>(minor[i], cfg.size);
    let mut minor = [0; N];
    sink.shift_code(&cfg.width, &shift, i64::MAX, product, &mut minor);
    let exact = cfg.caps::<N, T>(lanes, &length);
    let mut caps = [0; N];
    sink.code(&cfg.width, |i| exact[i], &mut caps);
    let width = each(lanes, |i| minor[i].max(caps[i]).max(1 << width_frac));
    sink.put(&cfg.width, 0, &width, |_| width_frac);

    let common = length_frac.max(width_frac);
    out.count = cfg.counts(
        lanes,
        &each(lanes, |i| length[i] << (common - length_frac)),
        &each(lanes, |i| width[i] << (common - width_frac)),
    );

    let [mut m, mut e, mut log] = [[0; N]; 3];
    mantissa(lanes, |i| width[i].max(1), &mut m, &mut e);
    roms.log2.log2_lanes::<N, T>(lanes, &m, &mut log);
    let most = cfg.last_level << PORT_FRAC;
    let log = |i: usize| (((e[i] - width_frac) << PORT_FRAC) + log[i]).clamp(0, most);
    sink.write(&cfg.lod, 0, log, |_| 0, &mut out.lod);

    let lines = if cfg.rule.has_end_points() {
        // 2(λ1 − m·2/N) in u, v; end points included.
        let mut body = [0; N];
        for i in 0..lanes.min(N) {
            let width = (width[i] * cfg.two_over_n) >> width_frac;
            body[i] = 2 * (line_code(major[i], scale(i)) - width).max(0);
        }
        let q = &cfg.line_feline;
        let mut lines = [[0; N]; 2];
        for (c, (line, axis)) in lines.iter_mut().zip(axis).enumerate() {
            sink.write(q, c, |i| body[i] * axis[i], |_| 0, line);
        }
        lines
    } else {
        let fixed = cfg.axis_frac - cfg.line.frac();
        let shift = Shift::new(lanes, &cfg.line, |i| scale(i) + fixed);
        let mut lines = [[0; N]; 2];
        for (c, (line, axis)) in lines.iter_mut().zip(axis).enumerate() {
            let product = |i: usize| mul::<T>(major[i], axis[i]);
            sink.shift(&cfg.line, c, &shift, product, |_| 0, line);
        }
        lines
    };
    for (c, line) in lines.iter().enumerate() {
        let mut inv = [0; N];
        for (inv, count) in inv.iter_mut().zip(&out.count).take(lanes) {
            let at = usize::try_from(*count).unwrap_or(0);
            *inv = cfg.inv_count[c].get(at).copied().unwrap_or(0);
        }
        let product = |i: usize| mul::<T>(line[i], inv[i]);
        sink.write(&cfg.step[c], c, product, |_| 0, &mut out.step[c]);
    }
}

/// λ1 with 28 fraction bits, at most 2^9.
#[inline(always)]
fn line_code(lambda: i64, scale: i64) -> i64 {
    let down = scale - INV_FRAC;
    // Only a register that wraps makes λ1 negative.
    let lambda = lambda.max(0);
    let code = if down >= 0 {
        lambda >> down.min(62)
    } else if i64::from(lambda.max(1).leading_zeros()) - 1 > -down {
        lambda << -down
    } else {
        i64::MAX
    };
    code.min(1 << (INV_FRAC + 9))
}
