//! The eigen stage against an independent solver in doubles: λ1, λ2 and the axis of random ellipses.

#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    reason = "the oracle is in doubles: integers here stay below 2^53"
)]

use rtl_model::fx::Flags;
use rtl_model::policy::{Axis, Minor, Placement};
use rtl_model::stages::{Roms, Sink, covariance, eigen};
use rtl_model::{Config, NoTap};
use support::model::Rng;

struct Got {
    lambda: [f64; 2],
    axis: [f64; 2],
    flags: Flags,
}

/// The stage on K's mantissas with 28 fraction bits.
fn run(config: &Config, roms: &Roms, k: [i64; 3]) -> Got {
    let cfg = eigen::Cfg::new(config).expect("legal");
    let covariance = covariance::Out { k, frac: 28, longest: [0; 2], longest_sq: 0 };
    let mut flags = Flags::default();
    let mut sink = Sink { lane: 0, flags: &mut flags, tap: &mut NoTap };
    let out = eigen::eigen(&cfg, roms, &covariance, &mut sink);
    let exp = i32::try_from(out.exp).expect("small");
    Got {
        lambda: out.lambda.map(|l| libm::ldexp(l as f64, exp - 28)),
        axis: out.axis.map(|a| a as f64 / f64::from(1u32 << 20)),
        flags,
    }
}

/// a, b, c of an ellipse with λ1² = `major`, λ2² = `minor` whose major axis lies at `angle`.
fn ellipse(major: f64, minor: f64, angle: f64) -> [i64; 3] {
    let (c, s) = (libm::cos(angle), libm::sin(angle));
    let one = f64::from(1u32 << 28);
    [
        (major * c * c + minor * s * s) * one,
        (major - minor) * c * s * one,
        (major * s * s + minor * c * c) * one,
    ]
    .map(|x| libm::rint(x) as i64)
}

/// λ1², λ2² and the angle of the major axis of rounded mantissas.
fn solve([a, b, c]: [i64; 3]) -> ([f64; 2], f64) {
    let [a, b, c] = [a, b, c].map(|x| x as f64 / f64::from(1u32 << 28));
    let root = libm::hypot(a - c, 2.0 * b);
    // The smaller one through the determinant: no cancellation.
    let major = (a + c + root) / 2.0;
    ([major, (a * c - b * b) / major], libm::atan2(2.0 * b, a - c) / 2.0)
}

/// The angle between two undirected axes.
fn between(axis: [f64; 2], angle: f64) -> f64 {
    let turned = libm::atan2(axis[1], axis[0]) - angle;
    libm::fabs(libm::remainder(turned, std::f64::consts::PI))
}

fn check(config: &Config, angle_bound: f64, degrees: std::ops::Range<i64>) -> f64 {
    let roms = Roms::new(config).expect("legal tables");
    let mut rng = Rng(51);
    let mut worst = 0.0f64;
    for step in degrees.start * 8..degrees.end * 8 {
        for _ in 0..4 {
            let angle = step as f64 / 8.0 / 180.0 * std::f64::consts::PI;
            let major = 1.0 + rng.range(0, 1 << 20) as f64 / f64::from(1u32 << 20);
            let minor = major * (rng.range(0, 900) as f64 / 1000.0);
            let k = ellipse(major, minor, angle);
            let ([major_sq, minor_sq], exact) = solve(k);
            let got = run(config, &roms, k);
            assert_eq!(got.flags, Flags::default(), "{k:?}");
            let [x, y] = got.axis;
            assert!(x > 0.0 || (x == 0.0 && y > 0.0), "{k:?}: ({x}, {y})");
            let error = between(got.axis, exact);
            assert!(error <= angle_bound, "{k:?} at {angle}: {error} > {angle_bound}");
            worst = worst.max(error);
            // √ twice by a table of 64 intervals with a Newton step: relative error below 2^−20 each,
            // and λ1 ≥ 1. λ2² loses what λ1² has in absolute error: 2^−19 under the root.
            let off = libm::fabs(got.lambda[0] - libm::sqrt(major_sq));
            assert!(off < 0.5f64.powi(19), "{k:?}: λ1 off by {off}");
            let lambda2 = libm::sqrt(minor_sq.max(0.0));
            let off = libm::fabs(got.lambda[1] * got.lambda[1] - lambda2 * lambda2);
            assert!(off < 0.5f64.powi(18), "{k:?}: λ2² off by {off}");
        }
    }
    worst
}

/// An axis register of 20 bits turns by at most √2·½·2^−20, an entry of 20 bits likewise.
const WORDS: f64 = 1.5 / 1_048_576.0;

#[test]
fn the_nearest_entry_is_within_half_a_step_all_around() {
    for minor in [Minor::Paper, Minor::Det] {
        for &placement in Placement::ALL {
            for entries in [4, 10, 32, 128] {
                let mut config = Config::default().with(|p| {
                    p.eigen.placement = placement;
                    p.eigen.minor = minor;
                });
                config.tables.eigen.entries = entries;
                let half = std::f64::consts::FRAC_PI_2 / f64::from(entries) / 2.0;
                let worst = check(&config, half + WORDS, -90..90);
                assert!(worst > half * 0.8, "{worst} of {half}");
            }
        }
    }
}

#[test]
fn interpolated_angles_are_far_better_than_half_a_step() {
    // Between entries the chord's direction errs by ~ step³, and tan is used for the angle itself: the
    // fraction f of the way is tan(fθ)/tan θ, off by at most ~0.13·θ² of a step for small θ = 2·step.
    for entries in [10, 32, 128] {
        let mut config = Config::default();
        config.tables.eigen.order = 1;
        config.tables.eigen.entries = entries;
        let step = std::f64::consts::FRAC_PI_2 / f64::from(entries);
        let theta = 2.0 * step;
        let bound = step * 0.16 * theta * theta + 4.0 * WORDS;
        let worst = check(&config, bound, -90..90);
        assert!(worst < step / 2.0);
    }
}

#[test]
fn the_exact_axis_is_limited_by_its_register_alone() {
    let config = Config::default().with(|p| p.footprint.axis = Axis::EigenExact);
    // The root is rounded to 2^−28 and off by the table's 2^−20; it enters one component of a vector of
    // length ≥ √2·(λ1² − λ2²) ≥ 0.14: 2^−20/0.14 < 7.5·2^−20 at most.
    check(&config, 8.0 * WORDS, -90..90);
}

#[test]
fn isotropic_and_axis_aligned_ellipses_are_exact() {
    for axis in [Axis::EigenTable, Axis::EigenExact] {
        for order in [0, 1] {
            let mut config = Config::default().with(|p| p.footprint.axis = axis);
            config.tables.eigen.order = order;
            let roms = Roms::new(&config).expect("legal tables");
            let one = 1i64 << 28;
            for (k, want) in [
                ([0, 0, 0], [1.0, 0.0]),
                ([one, 0, one], [1.0, 0.0]),
                ([one, 0, one / 2], [1.0, 0.0]),
                ([one, 0, 0], [1.0, 0.0]),
                ([one / 2, 0, one], [0.0, 1.0]),
                ([0, 0, one], [0.0, 1.0]),
                ([one, 0, one - 1], [1.0, 0.0]),
            ] {
                let got = run(&config, &roms, k);
                assert!(
                    got.axis.iter().zip(want).all(|(g, w)| (g - w).abs() < 1e-6),
                    "{axis:?} order {order} {k:?}: {:?}",
                    got.axis
                );
            }
            // a = c, b ≠ 0: ±45°.
            for sign in [1i64, -1] {
                let got = run(&config, &roms, [one, sign * one / 3, one]);
                let want = sign as f64 * std::f64::consts::FRAC_PI_4;
                assert!(
                    between(got.axis, want) < 4.0 * WORDS,
                    "{axis:?} order {order}: {:?}",
                    got.axis
                );
            }
        }
    }
}
