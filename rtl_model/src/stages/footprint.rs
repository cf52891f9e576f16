//! `footprint`: probe count, probe width, level of detail and step.
//!
//! M = λ1·N/2, m = max(λ2·N/2, 1, M/max_probes); count = clamp(⌈M/m − 2⁻⁸⌉, 1, max_probes); LOD = log2 m
//! clamped to the mip chain. The count is found by comparing M with multiples of m: no division.

use alloc::vec::Vec;

use lanes::{Mask as _, Vector};

use super::{Roms, bits, eigen, fits, frac, int};
use crate::config::{Config, ConfigError};
use crate::lanes::{Writes, in_lanes};
use crate::policy::{Count, FootprintPolicy, FootprintRule};
use crate::regs::{Reg, Register};
use crate::tables::rom::{PORT_FRAC, mantissa};

/// The stage: the ellipse's axes to its probe line.
#[inline(always)]
pub fn footprint<V: Vector>(
    cfg: &Cfg,
    roms: &Roms,
    eigen: &eigen::Out<V>,
    sink: &mut impl Writes<V>,
) -> Out<V> {
    let (length_frac, width_frac) = (cfg.length.frac(), cfg.width.frac());
    let ([major, minor], none) = (eigen.lambda, eigen.exp.like(0));
    // λ = code · 2^−scale.
    let scale = none.like(cfg.lambda_frac) - eigen.exp;
    let shift = scale.plus(1 - length_frac);
    let length = sink.shifted(&cfg.length, 0, major.times(cfg.size), shift, none);
    let shift = scale.plus(1 - width_frac);
    let minor = sink.shift_code(&cfg.width, minor.times(cfg.size), shift, i64::MAX);
    let cap = sink.code(&cfg.width, cfg.cap(length));
    let width = minor.larger(cap).larger(none.like(1 << width_frac));
    sink.tell(&cfg.width, 0, width, none.like(width_frac));

    let common = length_frac.max(width_frac);
    let count = cfg.count(length.up(common - length_frac), width.up(common - width_frac));

    let (m, e) = mantissa(width.larger(none.like(1)));
    let log = e.plus(-width_frac).up(PORT_FRAC.into()) + roms.log2.log2(m);
    let lod = sink.put(&cfg.lod, 0, log.limit(0, cfg.last_level << PORT_FRAC), none);

    let mut step = [none; 2];
    for c in 0..2 {
        let line = if cfg.rule.has_end_points() {
            let exact = cfg.body(major, scale, width).mul_wide(eigen.axis[c]);
            sink.put(&cfg.line_feline, c, exact, none)
        } else {
            let shift = scale.plus(cfg.axis_frac - cfg.line.frac());
            sink.shifted(&cfg.line, c, major.mul(eigen.axis[c]), shift, none)
        };
        let product = line.mul(count.look_up(&cfg.inv_count[c]));
        step[c] = sink.put(&cfg.step[c], c, product, none);
    }
    Out { count, lod, step }
}

in_lanes! {
    /// The probe line.
    pub struct Out<V> {
        /// Probes.
        pub count: V,
        /// Level of detail with the register's fraction bits.
        pub lod: V,
        /// Half the spacing of the probes in (u, v).
        pub step: [V; 2],
    }
}

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
        let FootprintPolicy { max_probes: max, count: rule, policy, .. } = config.policy.footprint;
        if policy != FootprintRule::Paper {
            return Err(ConfigError {
                path: "footprint.policy".into(),
                expected: "paper: the integer model has no other one yet, f64 has".into(),
                found: policy.name().into(),
            });
        }
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
    fn cap<V: Vector>(&self, length: V) -> V {
        let cap = length.mul_wide(length.like(self.cap_numerator)).up(8);
        let denominator = self.cap_denominator;
        // Only a register that wraps has a negative length.
        let (quotient, rest) = if V::LEN > 1 && denominator.count_ones() == 1 {
            (cap.down(denominator.ilog2().into()), cap.and(denominator - 1))
        } else {
            cap.div_rem(denominator)
        };
        quotient | rest.zero().select(cap.like(0), cap.like(1))
    }

    /// How often M exceeds the rule's multiples of m, plus one: the count before `pow2` rounds it.
    ///
    /// The condition for "more than n probes" is A·M > (B·n + C)·m, or ≥ where the rule has it; A and B
    /// are powers of two, so that the multiples are sums of shifted m.
    #[inline(always)]
    fn count<V: Vector>(&self, length: V, m: V) -> V {
        let (scale, per, offset, or_equal) = match self.rule {
            // M/m − 2⁻⁸ > n
            Count::Ceil | Count::Pow2 => (8, 8, 1, 0),
            // M/m + ½ ≥ n + 1
            Count::Round => (1, 1, 1, 1),
            // 2M/m − ½ ≥ n + 1
            Count::Feline => (2, 1, 3, 1),
        };
        let left = length.up(scale).plus(or_equal);
        let (mut n, mut multiple) = (m.like(0), if offset == 3 { m + m.up(1) } else { m });
        for k in (0..6).rev() {
            let (more, larger) = (n.plus(1 << k), multiple + m.up(per + k));
            let passed = m.like(self.max).gt(more) & left.gt(larger);
            n = passed.select(more, n);
            multiple = passed.select(larger, multiple);
        }
        if self.rule == Count::Pow2 {
            let power = m.like(1).shl(m.like(64) - n.leading_zeros());
            return power.smaller(m.like(self.cap_denominator));
        }
        n.plus(1)
    }

    /// 2(λ1 − m·2/N) in u, v with 28 fraction bits, end points included; λ1 at most 2^9.
    #[inline(always)]
    fn body<V: Vector>(&self, lambda: V, scale: V, width: V) -> V {
        let (down, zero, most) = (scale.plus(-INV_FRAC), lambda.like(0), 1 << (INV_FRAC + 9));
        // Only a register that wraps makes λ1 negative.
        let lambda = lambda.larger(zero);
        let (right, left) = (down.limit(0, 62), (-down).larger(zero));
        let room = lambda.larger(zero.like(1)).leading_zeros().plus(-1).gt(left);
        let code = lambda.sra(right).shl(room.select(left, zero)).smaller(zero.like(most));
        let code = (room | !left.gt(zero)).select(code, zero.like(most));
        let width = width.times(self.two_over_n).down(self.width.frac());
        (code - width).larger(zero).up(1)
    }
}
