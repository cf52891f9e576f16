//! Probe count, width, level and step against exact rational arithmetic.

use std::sync::OnceLock;

use crate::common::{Record, Rng, limit, round_ratio};
use rtl_model::fx::{Flags, Rounding};
use rtl_model::policy::Count;
use rtl_model::stages::{Roms, Sink, eigen, footprint};
use rtl_model::{Config, Reg};

/// What `footprint` wrote: M's code, m's code, count, LOD, both steps.
struct Line {
    length: i64,
    width: i64,
    count: i64,
    lod: i64,
    step: [i64; 2],
    flags: Flags,
}

/// Every unit here keeps the default tables.
static ROMS: OnceLock<Roms> = OnceLock::new();

/// λ = code·2^(exp − 28) with the default registers; the axis has 20 fraction bits.
fn line(config: &Config, size: u32, lambda: [i64; 2], exp: i64, axis: [i64; 2]) -> Line {
    let cfg = footprint::Cfg::new(config, size).expect("a legal footprint");
    let roms = ROMS.get_or_init(|| Roms::new(&Config::default()).expect("the default tables"));
    let (mut record, mut flags) = (Record::default(), Flags::default());
    let mut sink = Sink { lane: 0, flags: &mut flags, tap: &mut record };
    let out = footprint::footprint(&cfg, roms, &eigen::Out { lambda, exp, axis }, &mut sink);
    let code = |reg| record.0.iter().find(|r| r.1 == reg).expect("written").3;
    Line {
        length: code(Reg::FootLength),
        width: code(Reg::FootWidth),
        count: out.count,
        lod: out.lod,
        step: out.step,
        flags,
    }
}

/// The count of a line M and a width m (as p/q with one q), by the rules of the specification.
fn defined(rule: Count, length: i64, width: i64, max: u32) -> i128 {
    let (m1, m2) = (i128::from(length), i128::from(width));
    let ceil = |p: i128, q: i128| -((-p).div_euclid(q));
    let max = i128::from(max);
    // ⌈M/m − 2⁻⁸⌉
    let plain = ceil(256 * m1 - m2, 256 * m2).max(1);
    match rule {
        Count::Ceil => plain.min(max),
        // ⌊M/m + ½⌋
        Count::Round => (2 * m1 + m2).div_euclid(2 * m2).clamp(1, max),
        Count::Pow2 => {
            let mut power = 1;
            while power < plain {
                power *= 2;
            }
            while power > max {
                power /= 2;
            }
            power
        }
        // ⌊2M/m − ½⌋
        Count::Feline => (4 * m1 - m2).div_euclid(2 * m2).clamp(1, max),
    }
}

#[test]
fn counts_turn_over_exactly_at_their_boundaries() {
    let mut turned = 0;
    for &count in Count::ALL {
        for max_probes in [1, 2, 3, 8, 12, 16, 33, 63, 64] {
            let config = Config::default().with(|p| {
                p.footprint.count = count;
                p.footprint.max_probes = max_probes;
            });
            // With N = 2 and exponent 16 λ's codes are the codes of M and m.
            for width in [4096i64, 4097, 5000, 8191, 65536, 100_003] {
                let mut lengths = vec![0, 1, width - 1, width, width + 1];
                for n in 0..=i64::from(max_probes) + 1 {
                    for (p, q) in [(256 * n + 1, 256), (2 * n + 1, 2), (2 * n + 3, 4), (n, 1)] {
                        let at = (p * width).div_euclid(q);
                        lengths.extend([at - 1, at, at + 1, at + 2]);
                    }
                }
                lengths.retain(|&l| l >= 0);
                lengths.sort_unstable();
                lengths.dedup();
                let mut before = 1;
                for length in lengths {
                    let got = line(&config, 2, [length, width], 16, [1 << 20, 0]);
                    assert_eq!(got.length, length);
                    assert!(got.width >= width);
                    let want = defined(count, got.length, got.width, max_probes);
                    assert_eq!(
                        i128::from(got.count),
                        want,
                        "{count:?} {length}/{width}, at most {max_probes}"
                    );
                    turned += usize::from(got.count != before);
                    before = got.count;
                }
            }
        }
    }
    assert!(turned > 2000, "{turned}");
}

#[test]
fn the_width_is_the_widest_of_minor_texel_and_cap_each_rounded_once() {
    let mut rng = Rng(31);
    let mut capped = 0;
    for case in 0..20_000 {
        let mut config = Config::default().with(|p| {
            p.footprint.count = rng.pick(Count::ALL);
            p.footprint.max_probes = rng.bits(1, 64);
        });
        let width = &mut config.formats[Reg::FootWidth.index()];
        width.rounding = rng.pick(Rounding::ALL);
        let format = *width;
        let size = rng.bits(1, 16384);
        let minor = rng.range(0, (1 << 30) - 1) >> rng.range(0, 29);
        let major = minor.max(rng.range(0, (1 << 30) - 1) >> rng.range(0, 29));
        let exp = rng.range(-12, 8);
        let got = line(&config, size, [major, minor], exp, [1 << 20, 0]);
        // λ2·N/2 = minor·N·2^(exp − 29).
        let scaled = (i128::from(minor) * i128::from(size)) << (12 + exp + 12);
        let own = limit(round_ratio(scaled, 1 << (29 + 12), format.rounding), format).0;
        let max = i128::from(config.policy.footprint.max_probes);
        let (p, q) = match config.policy.footprint.count {
            Count::Ceil | Count::Round => (1, max),
            Count::Pow2 => (1, 1 << config.policy.footprint.max_probes.ilog2()),
            Count::Feline => (2, max + 1),
        };
        let cap = limit(round_ratio(i128::from(got.length) * p, q, format.rounding), format).0;
        assert_eq!(i128::from(got.width), own.max(cap).max(4096), "case {case}");
        assert!(got.count >= 1 && i128::from(got.count) <= max);
        capped += usize::from(cap > own.max(4096));
    }
    assert!(capped > 2000, "{capped}");
}

#[test]
fn one_probe_at_most_means_one_probe_of_the_full_length() {
    for &count in Count::ALL {
        let config = Config::default().with(|p| {
            p.footprint.count = count;
            p.footprint.max_probes = 1;
        });
        for length in [0, 1, 4096, 1 << 20, (1 << 30) - 1] {
            let got = line(&config, 2, [length, 0], 16, [1 << 20, 0]);
            assert_eq!(got.count, 1);
            assert_eq!(got.width, length.max(4096), "{count:?}: the width covers the line");
        }
    }
}

#[test]
fn a_limit_that_is_no_power_of_two_leaves_the_next_lower_power() {
    let config = Config::default().with(|p| {
        p.footprint.count = Count::Pow2;
        p.footprint.max_probes = 12;
    });
    let counts: Vec<i64> =
        (0..20).map(|k| line(&config, 2, [k << 12, 4096], 16, [1 << 20, 0]).count).collect();
    assert_eq!(counts[..9], [1, 1, 2, 4, 4, 8, 8, 8, 8]);
    assert!(counts[9..].iter().all(|&c| c == 8));
}

#[test]
fn the_level_is_the_logarithm_of_the_width_clamped_to_the_chain() {
    let config = Config::default();
    let mut exact = 0;
    for size in [1u32, 2, 3, 64, 100, 16384] {
        let last = i64::from(size.ilog2());
        let narrow = line(&config, size, [1 << 12, 1], 0, [1 << 20, 0]);
        assert_eq!(narrow.lod, 0, "narrower than a texel");
        // m = λ2·N/2; powers of two are exact: log2 1 = 0 is an entry of the order-1 table.
        for power in 12..30 {
            let lambda = 1i64 << power;
            let got = line(&config, size, [lambda, lambda], 16, [1 << 20, 0]);
            assert!((0..=last << 8).contains(&got.lod));
            let m = (lambda * i64::from(size)) >> 1;
            if m.count_ones() == 1 && (1 << 12..1 << 31).contains(&m) {
                let log = i64::from(m.ilog2()) - 12;
                assert_eq!(got.lod, log.min(last) << 8, "face {size}, width 2^{log}");
                exact += 1;
            }
        }
    }
    assert!(exact > 40, "{exact}");
}

#[test]
fn steps_lie_within_their_rounding_of_the_exact_spacing() {
    let mut rng = Rng(33);
    let mut moving = 0;
    for case in 0..20_000 {
        let config = Config::default().with(|p| {
            p.footprint.count = rng.pick(Count::ALL);
            p.footprint.max_probes = rng.bits(1, 64);
        });
        let size = 1u32 << rng.bits(0, 14);
        let major = rng.range(0, (1 << 30) - 1) >> rng.range(0, 20);
        let minor = major >> rng.range(0, 8);
        let exp = rng.range(-12, 4);
        let axis = [rng.range(0, 1 << 20), rng.range(-(1 << 20), 1 << 20)];
        let got = line(&config, size, [major, minor], exp, axis);
        if got.flags != Flags::default() {
            continue;
        }
        // Everything in units of 2^−60: λ1 = major·2^(exp + 32).
        let lambda = i128::from(major) << (exp + 32);
        let (length, parts) = if config.policy.footprint.count == Count::Feline {
            // 2(λ1 − m·2/N), m with 12 bits; between count − 1 gaps.
            let body = (i128::from(got.width) << 49) / i128::from(size);
            (2 * (lambda - body).max(0), 2 * (i128::from(got.count) - 1))
        } else {
            (lambda, 2 * i128::from(got.count))
        };
        for (&step, &axis) in got.step.iter().zip(&axis) {
            let got_step = i128::from(step) << 36;
            if parts == 0 {
                assert_eq!(got_step, 0);
                continue;
            }
            let exact = ((length >> 20) * i128::from(axis)) / parts;
            // line: ½·2^−22 over `parts`; 1/parts: ½·2^−28 of the line; step: ½·2^−24; feline also cuts
            // λ1, 2/N (times m) and m·2/N to 28 bits: < 2·(2^−28 + 2^−29·m + 2^−28).
            let rounding = (1i128 << 37) / parts + (length >> 29) + (1 << 35);
            let feline = if config.policy.footprint.count == Count::Feline {
                ((4i128 << 32) + (i128::from(got.width) << 20)) / parts
            } else {
                0
            };
            let error = (got_step - exact).abs();
            assert!(
                error <= rounding + feline + (1 << 20),
                "case {case}: {error} > {rounding} + {feline}"
            );
            moving += usize::from(step != 0);
        }
    }
    assert!(moving > 10_000, "{moving}");
}
