//! `filter`: trilinear probes summed with integer weights, one rounding at the output register.
//!
//! The LOD weight is common to all probes, so each level's bilinear sums are added up separately
//! (41 + 16 bits and log2 max_probes more: exact in 64), the two levels are combined and the sum is
//! divided by the count once. A constant texture stays constant.

pub(crate) mod block;
pub mod rows;
pub mod weights;

use alloc::vec::Vec;

use super::address;
use super::address::lanes::Walk;
use super::{Roms, Sink, bits, fits, frac, int};
use crate::config::{Config, ConfigError};
use crate::fx::Flags;
use crate::policy::{Policy, Weights};
use crate::regs::{Reg, Register};
use crate::tap::Tap;
use crate::texture::{Texels, Texture};

/// Compiled configuration.
#[derive(Clone, Debug, Hash)]
pub struct Cfg {
    lod_shift: i64,
    lod_frac: i64,
    lod_bits: i64,
    /// `None` where the register holds every bilinear sum as it is.
    bilinear: Option<Register>,
    sum_frac: i64,
    color: Register,
    color_shift: i64,
    /// Integer probe weights by count; empty for box weights.
    weights: Vec<Vec<i64>>,
    probe_weight_bits: i64,
    /// ⌈2^64/count⌉ by count: exact quotients for dividends below 2^56.
    inv_count: Vec<u64>,
}

/// The texture request of one fragment.
#[derive(Clone, Copy, Debug)]
pub struct In {
    /// The probe line.
    pub line: address::In,
    /// Level of detail with the register's fraction bits.
    pub lod: i64,
}

/// Filtered colour and the number of texels read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Out {
    /// RGB with the register's fraction bits.
    pub color: [i64; 3],
    /// Texels read.
    pub texels: u64,
}

/// Footprints that are addressed and filtered at a time: a vector of 64-bit lanes under AVX2.
pub const FOOTPRINTS: usize = 4;

/// Sums of one level.
type Sums = [i64; 3];

impl Cfg {
    /// Compiles and checks the stage.
    pub fn new(config: &Config) -> Result<Self, ConfigError> {
        config.check()?;
        let Policy { footprint, filter, texel, .. } = &config.policy;
        let exact_frac = i64::from(texel.frac) + 2 * i64::from(filter.weight_bits);
        let register = config.format(Reg::FilterBilinear);
        let narrowed = i64::from(register.frac) < exact_frac || register.int < texel.int;
        let sum_frac = if narrowed { i64::from(register.frac) } else { exact_frac };
        let whole = if narrowed { register.int } else { texel.int };
        let sum_bits = whole + u32::try_from(sum_frac).unwrap_or(u32::MAX);
        let most = footprint.max_probes.next_power_of_two().ilog2();
        if footprint.weights == Weights::Box {
            // No rounding constant is added to the sums: they may use 63 bits.
            fits(Reg::FilterBilinear, sum_bits + most - 1)?;
        } else {
            fits(Reg::FilterBilinear, sum_bits)?;
        }
        let color = config.format(Reg::FilterColor);
        if bits(config, Reg::FilterColor) > 48 || int(config, Reg::FootLod) > 16 {
            fits(Reg::FilterColor, 63)?;
        }
        // The quotient's exact reciprocal holds for dividends below 2^56.
        fits(Reg::FilterColor, color.frac + whole + most + 1 + 6)?;
        let weights = match footprint.weights {
            Weights::Box => Vec::new(),
            Weights::Gaussian | Weights::Bell => weights::rom(footprint),
        };
        let lod_frac = frac(config, Reg::FootLod);
        let lod_bits = i64::from(filter.lod_bits);
        let scale =
            if footprint.weights == Weights::Box { 0 } else { i64::from(footprint.weight_bits) };
        Ok(Self {
            lod_shift: lod_frac - lod_bits,
            lod_frac,
            lod_bits,
            bilinear: narrowed.then(|| config.register(Reg::FilterBilinear, exact_frac)),
            sum_frac,
            color: config.register(Reg::FilterColor, 0),
            color_shift: sum_frac + lod_bits + scale - i64::from(color.frac),
            weights,
            probe_weight_bits: scale,
            inv_count: (0..=u64::from(footprint.max_probes))
                .map(|c| if c <= 1 { u64::MAX } else { u64::MAX / c + 1 })
                .collect(),
        })
    }

    /// Level and weight of the next level (0…2^lod_bits) of a LOD code.
    #[inline(always)]
    #[must_use]
    pub fn level(&self, lod: i64, last: usize) -> (usize, i64) {
        let whole = lod >> self.lod_frac;
        let part = lod - (whole << self.lod_frac);
        let weight = if self.lod_shift > 0 {
            (part + (1 << (self.lod_shift - 1))) >> self.lod_shift
        } else {
            part << -self.lod_shift
        };
        let level = usize::try_from(whole).unwrap_or(0);
        if level >= last { (last, 0) } else { (level, weight) }
    }

    /// Combines two levels, divides by the number of probes (or 2^bits) and writes the output.
    #[inline(always)]
    fn finish(
        &self,
        standard: bool,
        total: impl Fn(usize, usize) -> i128,
        lod_weight: i64,
        count: i64,
        flags: &mut Flags,
    ) -> [i64; 3] {
        let box_weights = self.weights.is_empty();
        let divisor = if box_weights { count } else { 1 };
        let inv =
            self.inv_count.get(usize::try_from(divisor).unwrap_or(0)).copied().unwrap_or(u64::MAX);
        let mut out = [0; 3];
        let mut over_any = false;
        for (c, o) in out.iter_mut().enumerate() {
            let sum = total(0, c) * i128::from((1 << self.lod_bits) - lod_weight)
                + total(1, c) * i128::from(lod_weight);
            // One guard bit below the register's LSB, then a sticky one.
            let (quotient, sticky) = self.divide(sum, divisor, inv);
            let (code, over) =
                self.color.write_as(standard, (quotient << 1) | i64::from(sticky), 2);
            over_any |= over;
            *o = code;
        }
        flags.register(Reg::FilterColor, over_any);
        out
    }

    /// ⌊2·sum/(divisor·2^color_shift)⌋ and whether a remainder is left. |sum| < 2^80; only a signed
    /// `filter.bilinear` that wraps or a negative probe weight makes it negative.
    #[inline(always)]
    fn divide(&self, sum: i128, divisor: i64, inv: u64) -> (i64, bool) {
        let down = self.color_shift - 1;
        if down < 0 {
            // The register is finer than the sums: the quotient takes the missing bits.
            let wide = sum << -down;
            let d = i128::from(divisor);
            return (narrow(wide.div_euclid(d)), wide % d != 0);
        }
        let head = sum >> down;
        let tail = sum - (head << down) != 0;
        if divisor == 1 {
            return (narrow(head), tail);
        }
        if head < 0 {
            let d = i128::from(divisor);
            return (narrow(head.div_euclid(d)), tail || head % d != 0);
        }
        let head = narrow(head).cast_unsigned();
        let quotient = narrow(((u128::from(head) * u128::from(inv)) >> 64).cast_signed());
        let rest = head.cast_signed() - quotient * divisor;
        (quotient, tail || rest != 0)
    }
}

#[inline(always)]
fn narrow(x: i128) -> i64 {
    i64::try_from(x).unwrap_or(i64::MAX)
}

/// Sums over the probes of one level, with 32 low bits apart where weights make them too wide.
#[derive(Clone, Copy, Debug, Default)]
struct Accumulator {
    low: Sums,
    high: Sums,
}

impl Accumulator {
    #[inline(always)]
    fn total(&self, c: usize) -> i128 {
        i128::from(self.low[c]) + (i128::from(self.high[c]) << 32)
    }
}

/// The stage for one fragment, its addresses included.
#[inline(always)]
pub fn filter<T: Tap>(
    cfg: &Cfg,
    address_cfg: &address::Cfg,
    roms: &Roms,
    texture: &Texture,
    input: &In,
    sink: &mut Sink<'_, T>,
) -> Out {
    match &texture.texels {
        Texels::Half(t) => probes(cfg, address_cfg, roms, (texture, rows::Half(t)), input, sink),
        Texels::Wide(t) => probes(cfg, address_cfg, roms, (texture, rows::Wide(t)), input, sink),
    }
}

#[inline(always)]
fn probes<R: rows::Rows, T: Tap>(
    cfg: &Cfg,
    address_cfg: &address::Cfg,
    roms: &Roms,
    (texture, rows): (&Texture, R),
    input: &In,
    sink: &mut Sink<'_, T>,
) -> Out {
    let (mut walk, lod_weight) = walk(cfg, address_cfg, texture, input);
    let two = usize::from(lod_weight != 0);
    let exact = cfg.bilinear.is_none() && cfg.weights.is_empty();
    let mut lanes = [[0u64; FOOTPRINTS]; 3];
    let mut sums = [Accumulator::default(); 2];
    let mut k = 0;
    while k < input.line.count {
        let at = walk.next(roms, k, sink);
        let bilinear = rows.sums(&at);
        if exact {
            // Box weights: every lane adds up its own probes.
            for (total, sum) in lanes.iter_mut().zip(&bilinear) {
                for (total, sum) in total.iter_mut().zip(sum) {
                    *total += sum;
                }
            }
        }
        for lane in 0..at.len.min(FOOTPRINTS) {
            let (probe, level) = (lane >> two, lane & two);
            let index = usize::try_from(k).unwrap_or(0) + probe;
            let sum = [0, 1, 2].map(|c| bilinear[c][lane].cast_signed());
            let component = 6 * index + 3 * level;
            if exact {
                put(cfg, &sum, component, sink);
            } else {
                let k = k + i64::try_from(probe).unwrap_or(0);
                let place = (input.line.count, k);
                accumulate(cfg, place, &mut sums[level], sum, component, sink);
            }
        }
        k += walk.probes();
    }
    let (standard, count) = (T::STANDARD, input.line.count);
    let color = if exact {
        let mut totals = [[0; 3]; 2];
        for (c, lanes) in lanes.iter().enumerate() {
            let (mut even, mut odd) = (0, 0);
            for [first, second] in lanes.as_chunks().0 {
                even += first;
                odd += second;
            }
            let first = if two == 0 { even + odd } else { even };
            totals[0][c] = first.cast_signed();
            totals[1][c] = odd.cast_signed();
        }
        let total = |l: usize, c: usize| i128::from(totals[l][c]);
        cfg.finish(standard, total, lod_weight, count, sink.flags)
    } else {
        let total = |l: usize, c: usize| sums[l].total(c);
        cfg.finish(standard, total, lod_weight, count, sink.flags)
    };
    for (c, code) in color.iter().enumerate() {
        sink.tap.put(sink.lane, Reg::FilterColor, c, *code, cfg.color.frac());
    }
    Out { color, texels: count.unsigned_abs() << (2 + two) }
}

/// Set-up of a fragment: its footprints and the weight of its second level.
#[inline(always)]
fn walk<'a>(
    cfg: &Cfg,
    address_cfg: &'a address::Cfg,
    texture: &'a Texture,
    input: &'a In,
) -> (Walk<'a, FOOTPRINTS>, i64) {
    let last = texture.levels.len().saturating_sub(1);
    let (first, lod_weight) = cfg.level(input.lod, last);
    let both = lod_weight != 0;
    let levels = [first, first + usize::from(both)].map(|level| &texture.levels[level]);
    (Walk::new(address_cfg, &input.line, levels, both), lod_weight)
}

/// Where a bilinear footprint begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Corner {
    /// Face of the probe.
    pub face: usize,
    /// Level.
    pub level: usize,
    /// Column and row of the first texel in the bordered level: texel (0, 0) is (1, 1).
    pub texel: [usize; 2],
}

/// The first texel of every bilinear footprint.
#[inline(always)]
pub fn footprints<T: Tap>(
    cfg: &Cfg,
    address_cfg: &address::Cfg,
    roms: &Roms,
    texture: &Texture,
    input: &In,
    sink: &mut Sink<'_, T>,
    each: &mut dyn FnMut(Corner),
) {
    let last = texture.levels.len().saturating_sub(1);
    let (first, lod_weight) = cfg.level(input.lod, last);
    for k in 0..input.line.count {
        let probe = address::address(address_cfg, roms, &input.line, k, sink);
        for index in first..=first + usize::from(lod_weight != 0) {
            let Some(level) = texture.levels.get(index) else {
                continue;
            };
            let size = level.size.map(|n| i64::try_from(n).unwrap_or(1));
            let texel = address_cfg.taps(&probe, size, 0, sink).corner;
            each(Corner { face: probe.face, level: index, texel });
        }
    }
}

#[inline(always)]
fn put<T: Tap>(cfg: &Cfg, sum: &Sums, component: usize, sink: &mut Sink<'_, T>) {
    for (c, s) in sum.iter().enumerate() {
        let (reg, frac) = (Reg::FilterBilinear, cfg.sum_frac);
        sink.tap.put(sink.lane, reg, component + c, *s, frac);
    }
}

#[inline(always)]
fn accumulate<T: Tap>(
    cfg: &Cfg,
    (count, k): (i64, i64),
    into: &mut Accumulator,
    mut sum: Sums,
    component: usize,
    sink: &mut Sink<'_, T>,
) {
    if let Some(q) = &cfg.bilinear {
        for s in &mut sum {
            let (code, over) = q.write(*s);
            sink.flags.register(Reg::FilterBilinear, over);
            *s = code;
        }
    }
    put(cfg, &sum, component, sink);
    if cfg.weights.is_empty() {
        for (a, s) in into.low.iter_mut().zip(sum) {
            *a += s;
        }
    } else {
        let weight = weights::at(&cfg.weights, count, k);
        for (c, s) in sum.into_iter().enumerate() {
            into.low[c] += (s & 0xffff_ffff) * weight;
            into.high[c] += (s >> 32) * weight;
        }
    }
}

impl Cfg {
    /// Bits of the sum of a fragment's probe weights; 0 for box weights.
    #[must_use]
    pub fn probe_weight_bits(&self) -> i64 {
        self.probe_weight_bits
    }
}
