//! Products and sums on a grid of exponent classes × significand patterns, in the manner of TestFloat.
//!
//! The oracle is arbitrary-precision: num-bigint fractions rounded by comparing with both neighbours.

use num_bigint::BigInt;
use rayon::prelude::*;
use rtl_model::cone::{Angle, Cone, Dither, Dyadic, SmallFloat, StoreRounding, Width, fast};
use rtl_model::fx::Flags;
use rtl_model::stages::ray_cone::{self, Cfg};
use rtl_model::{Config, cone::ConeFormat};

fn big(x: Dyadic, unit: i64) -> BigInt {
    let m = BigInt::from(x.m) << u64::try_from(x.e - unit).unwrap();
    if x.negative { -m } else { m }
}

/// The code nearest to numerator · 2^unit, ties to even, by bisection over all codes.
pub(crate) fn nearest(format: SmallFloat, x: &BigInt, unit: i64) -> u32 {
    let negative = *x < BigInt::ZERO;
    let x: BigInt = x.magnitude().clone().into();
    let at = |code: u32| big(format.unpack(code).0, unit);
    let (mut low, mut high) = (0, format.largest());
    if x >= at(high) {
        low = high;
    }
    while low + 1 < high {
        let middle = low.midpoint(high);
        if at(middle) <= x {
            low = middle;
        } else {
            high = middle;
        }
    }
    let code = if low == format.largest() {
        low
    } else {
        let twice = &x * 2u32;
        let between = at(low) + at(low + 1);
        if twice > between || (twice == between && low & 1 == 1) { low + 1 } else { low }
    };
    if negative && code != 0 { code | format.sign() } else { code }
}

/// Codes of a format: exponents at the ends, around 1 and a stride between; patterns of a single bit, a run
/// of ones, its neighbours; both signs.
fn grid(format: SmallFloat, exponents: u32, patterns: u32) -> Vec<u32> {
    let last = (1u32 << format.exponent_bits) - 2;
    let middle = last / 2;
    let mut classes: Vec<u32> = [0, 1, 2, middle - 1, middle, middle + 1, last - 1, last].into();
    classes.extend((0..exponents).map(|i| i * last / exponents.max(1)));
    let bits = format.mantissa_bits;
    let full = (1u32 << bits) - 1;
    let mut fractions = vec![0, 1, full, full - 1, 1 << (bits - 1), (1 << (bits - 1)) | 1];
    for i in 0..patterns.min(bits) {
        fractions.extend([1 << i, full >> i, full ^ (1 << i)]);
    }
    let mut out = Vec::new();
    for class in classes {
        for fraction in &fractions {
            let code = class << bits | fraction;
            out.extend([code, code | format.sign()]);
        }
    }
    out.sort_unstable();
    out.dedup();
    out
}

/// α·d + w for all of the grid's triples whose index passes, by three ways; returns how many.
fn check(
    format: SmallFloat,
    config: &Config,
    codes: &[u32],
    distances: &[u32],
    stride: usize,
) -> u64 {
    let cfg = Cfg::new(config);
    let lowest = 2 * SmallFloat::F32.lowest_exponent() - 64;
    codes
        .par_iter()
        .enumerate()
        .map(|(i, &a)| {
            let mut cases = 0;
            for (j, &d) in distances.iter().enumerate() {
                let product = (format.unpack(a).0, SmallFloat::F32.unpack(d).0);
                let exact = big(product.0, lowest / 2) * big(product.1, lowest / 2);
                let unit = 2 * (lowest / 2);
                for (k, &w) in codes.iter().enumerate() {
                    if !(i + 7 * j + 31 * k).is_multiple_of(stride) {
                        continue;
                    }
                    cases += 1;
                    let total = &exact + big(format.unpack(w).0, unit);
                    let cone = Cone { angle: Angle(a), width: Width(w) };
                    let mut flags = Flags::default();
                    let ours =
                        ray_cone::propagate(&cfg, cone, product.1, &mut cfg.dither(0), &mut flags);
                    let passed = product.0.negative && total < BigInt::ZERO;
                    let total = if passed { -total } else { total };
                    let expected = nearest(format, &total, unit);
                    assert_eq!(ours.width.0, expected, "α {a:#x} d {d:#x} w {w:#x}");
                    let angle = if product.0.is_zero() {
                        0
                    } else if passed {
                        format.abs(a)
                    } else {
                        a
                    };
                    assert_eq!(ours.angle.0, angle, "α {a:#x} d {d:#x} w {w:#x}");
                    if format.width() <= 16 {
                        let (quick, over) = fast::propagate(format, StoreRounding::Rne, 0, cone, d);
                        assert_eq!(quick, ours, "α {a:#x} d {d:#x} w {w:#x}");
                        assert_eq!(over, !flags.is_empty());
                    }
                }
            }
            cases
        })
        .sum()
}

fn config(format: ConeFormat, rounding: StoreRounding) -> Config {
    let mut config = Config::default();
    config.policy.cone.format = format;
    config.policy.cone.rounding = rounding;
    config
}

fn level(exponents: u32, patterns: u32, at_least: u64, stride: usize) {
    for name in ConeFormat::ALL {
        let format = name.float();
        let codes = grid(format, exponents, patterns);
        let distances = grid(SmallFloat::F32, exponents, patterns);
        let cases = check(format, &config(*name, StoreRounding::Rne), &codes, &distances, stride);
        assert!(cases >= at_least, "{name:?}: {cases} cases");
    }
}

#[test]
fn level_1_products_and_sums_are_rounded_once() {
    level(0, 1, 46_464, 13);
}

/// `cargo test --release --test rtl level_2 -- --ignored`
#[test]
#[ignore = "22 million cases and more, a minute or two"]
fn level_2_products_and_sums_are_rounded_once() {
    level(3, 4, 7_496_192, 5);
}

#[test]
fn the_word_parallel_path_has_the_general_ones_bits_in_every_rounding() {
    let mut dither = Dither::new(3, 0);
    for name in [ConeFormat::Bf16, ConeFormat::F16] {
        for rounding in StoreRounding::ALL {
            let cfg = Cfg::new(&config(name, *rounding));
            let mut saturated = 0;
            for ray in 0..200_000 {
                let mut bits = || dither.next_bits();
                let (a, w) = (bits() & 0xffff, bits() & 0xffff);
                // Distances near enough that both terms matter in most cases.
                let d = bits() & 0x80ff_ffff
                    | (if ray % 2 == 0 { bits() } else { 0x3e00_0000 }) & 0x7f00_0000;
                let cone = Cone { angle: Angle(a), width: Width(w) };
                let mut flags = Flags::default();
                let d_value = SmallFloat::F32.unpack(d).0;
                let slow =
                    ray_cone::propagate(&cfg, cone, d_value, &mut cfg.dither(ray), &mut flags);
                let random = cfg.dither(ray).next_bits();
                let (quick, over) = fast::propagate(name.float(), *rounding, random, cone, d);
                assert_eq!(quick, slow, "{name:?} {rounding:?} α {a:#x} w {w:#x} d {d:#x}");
                let width = rtl_model::Event::ConeWidthSaturated;
                assert_eq!(over, flags.has_event(width));
                saturated += u32::from(over);
                let mut batch = [cone];
                ray_cone::propagate_batch(&cfg, &mut batch, &[d], ray);
                assert_eq!(batch[0], slow);
            }
            assert!(saturated > 100, "{saturated}");
        }
    }
}
