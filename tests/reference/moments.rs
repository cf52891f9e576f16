//! `footprint.policy` = `moments`: the variance of the line and what bounds its probes.

use support::reference::{map, plain};
use tapline::policy::{FootprintPolicy, FootprintRule, Weights};
use tapline::reference::footprint::{Chain, Footprint, footprint};
use tapline::reference::weights::spreads;
use tapline::reference::{Flags, NoTap, Prepared, Texture, env};
use tapline::settings::Settings;

/// λ counts in texels.
const CHAIN: Chain = Chain { size: 2, levels: 16 };

fn policy(weights: Weights, max_probes: u32, kappa: u32) -> FootprintPolicy {
    let plain = FootprintPolicy::default();
    FootprintPolicy { policy: FootprintRule::Moments, weights, max_probes, kappa, ..plain }
}

fn line(lambda: [f64; 2], policy: &FootprintPolicy) -> Footprint<f64> {
    let spreads = spreads(policy);
    let flags = &mut Flags::default();
    footprint(lambda, [1.0, 0.0], CHAIN, (policy, &spreads), flags, &mut NoTap)
}

/// Twelve times the variance of the probes and of their places along the line, less that of level 0's tent.
fn variance(line: &Footprint<f64>, policy: &FootprintPolicy) -> [f64; 2] {
    let kappa = f64::from(policy.kappa);
    let probe = kappa * libm::exp2(2.0 * line.lod) - kappa;
    let spread = spreads(policy)[line.probes as usize - 1];
    [probe + spread * 4.0 * line.step[0] * line.step[0], probe]
}

#[test]
fn a_line_has_the_variance_of_its_ellipse() {
    let mut clamped = 0;
    for weights in Weights::ALL {
        for (max_probes, kappa) in [(1, 3), (2, 4), (7, 5), (8, 4), (16, 3)] {
            let policy = policy(*weights, max_probes, kappa);
            for minor in [0.0f64, 0.3, 1.0, 2.5, 40.0] {
                for ratio in [1.0, 1.2, 2.0, 3.7, 9.0, 30.0, 900.0] {
                    let lambda: [f64; 2] = [minor.max(0.1) * ratio, minor];
                    let line = line(lambda, &policy);
                    let [along, across] = variance(&line, &policy);
                    let square = lambda.map(|x| x * x);
                    // One probe shares what is left: κ/8 of R more on both sides, where R ≤ m².
                    let slack = if line.probes == 1 { square[0] - square[1] } else { 0.0 };
                    let fuzz = 1e-9 * (1.0 + square[0]) + slack;
                    assert!((along - square[0]).abs() <= fuzz, "{lambda:?} {policy:?} {line:?}");
                    assert!(across >= square[1] - fuzz, "{lambda:?} {policy:?} {line:?}");
                    clamped += usize::from(across > square[1] + fuzz);
                }
            }
        }
    }
    assert!(clamped > 100, "{clamped}");
}

#[test]
fn a_longer_ellipse_never_has_fewer_probes_and_a_round_one_has_one() {
    for weights in Weights::ALL {
        for max_probes in [1, 2, 5, 8, 64] {
            let policy = policy(*weights, max_probes, 4);
            for minor in [0.0, 0.7, 1.0, 3.0, 100.0] {
                let round = line([minor; 2], &policy);
                assert_eq!((round.probes, round.step), (1, [0.0; 2]));
                let mut last = (1, 0.0);
                for i in 0..2000 {
                    let line = line([minor + f64::from(i) * 0.05, minor], &policy);
                    assert!(line.probes >= last.0, "{minor} {i} {weights:?}");
                    let whole =
                        line.step[0] * libm::sqrt(spreads(&policy)[line.probes as usize - 1]);
                    // √R has no step: from one probe to two it begins at m, and elsewhere it follows λ1.
                    assert!(last.0 == 1 || whole - last.1 < 0.2, "{minor} {i} {weights:?}");
                    last = (line.probes, whole);
                }
            }
        }
    }
}

#[test]
fn moments_keep_a_constant_texture_constant() {
    let cube = map(32, |_, _, _| [0.3, 1.7, 1e4]);
    let texture = Texture::new(&cube);
    for weights in Weights::ALL {
        let mut settings = Settings::default();
        settings.policy.footprint = policy(*weights, 8, 4);
        let prepared = Prepared::new(&settings);
        let mut fragment = plain([0.2, 0.3, 1.0]);
        fragment.dn_dx = [0.4, 0.1, 0.2];
        let out = env(&prepared, &fragment, 32, Some(&texture), &mut NoTap);
        assert!(out.probes > 1);
        for (got, held) in out.color.into_iter().zip([0.3f32, 1.7, 1e4]) {
            assert!((got - f64::from(held)).abs() <= 1e-15 * got, "{got} {held}");
        }
    }
}
