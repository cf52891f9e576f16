//! Extremes of the specification on rtl and f64; what no input may make.

use rtl_model::Config;
use rtl_model::cone::{Angle, Cone, ConeFormat, Dither, StoreRounding, Width};
use rtl_model::fx::Flags;
use rtl_model::policy::{ConeRules, SetDiffuse};
use rtl_model::regs::Event;
use rtl_model::stages::ray_cone::{self as rtl, Cfg};
use tapline::reference::ray_cone::Step;

use super::formats::{rne, value, word};
use super::operations::{both, cfg, check, operands, random};

/// Extremes of the specification, each on rtl (all formats) and f64.
fn extreme(angle: f64, width: f64, step: Step) {
    for format in ConeFormat::ALL {
        check(&cfg(*format), angle, width, step);
    }
}

#[test]
fn extreme_zeros_have_no_sign() {
    for (angle, width) in [(0.0, 0.0), (-0.0, -0.0), (-0.0, 1.0), (1.0, -0.0)] {
        extreme(angle, width, Step::Propagate(-0.0));
        extreme(angle, width, Step::Reflect(-0.0));
        for format in ConeFormat::ALL {
            let cfg = cfg(*format);
            let cone = Cone { angle: Angle(cfg.format.sign()), width: Width(cfg.format.sign()) };
            let mut flags = Flags::default();
            let out = rtl::propagate(&cfg, cone, word(1.0), &mut cfg.dither(0), &mut flags);
            assert_eq!(out, Cone::default());
        }
    }
}

#[test]
fn extreme_subnormals_are_kept() {
    extreme(0.0, f64::from_bits(0x37a0_0000_0000_0000), Step::Propagate(1.0));
    extreme(1e-40, 1e-40, Step::Propagate(0.5));
    let cfg = cfg(ConeFormat::Bf16);
    let (ours, _, _) = both(&cfg, 0.0, 1e-40, Step::Propagate(1.0));
    assert!(ours[1] > 0.0 && ours[1] < 1.2e-38);
}

#[test]
fn extreme_largest_numbers_saturate_and_flag() {
    for format in ConeFormat::ALL {
        let cfg = cfg(*format);
        let most = value(cfg.format, cfg.format.largest());
        for sign in [1.0, -1.0] {
            let (ours, theirs, flags) = both(&cfg, sign, sign * most, Step::Propagate(most));
            // Both negative: both turn.
            assert!(ours == [1.0, most] && theirs == [1.0, 2.0 * most]);
            assert!(flags.has_event(Event::ConeWidthSaturated));
            let (ours, _, flags) = both(&cfg, sign, most, Step::Reflect(sign * f64::MAX));
            assert!(ours[0] == sign * most && flags.has_event(Event::ConeAngleSaturated));
        }
    }
}

#[test]
fn extreme_both_negative_turn_and_one_negative_does_not() {
    extreme(-0.5, -1.0, Step::Propagate(2.0));
    extreme(0.5, -1.0, Step::Propagate(1.0));
    let cfg = cfg(ConeFormat::Bf16);
    assert_eq!(both(&cfg, -0.5, -1.0, Step::Propagate(2.0)).0, [0.5, 2.0]);
    assert_eq!(both(&cfg, 0.5, -1.0, Step::Propagate(1.0)).0, [0.5, -0.5]);
}

#[test]
fn extreme_a_width_that_crosses_zero() {
    for d in [1.999, 2.0, 2.001] {
        extreme(-0.5, 1.0, Step::Propagate(d));
    }
    // Below zero by less than the format holds: the exact sign turns the cone.
    let cfg = cfg(ConeFormat::F16);
    let d = 2.0 + 1e-12;
    assert_eq!(both(&cfg, -0.5, 1.0, Step::Propagate(d)).0, [0.5, 0.0]);
}

#[test]
fn extreme_sixty_four_bounces_stay_finite_and_agree_at_every_step() {
    for format in ConeFormat::ALL {
        let cfg = cfg(*format);
        let mut dither = Dither::new(64, 0);
        let mut cone = [0.01, 0.0];
        for i in 0..64 {
            let k = random(&mut dither) / 64.0;
            for step in [Step::Propagate(random(&mut dither).abs()), Step::Reflect(k)] {
                check(&cfg, cone[0], cone[1], step);
                cone = both(&cfg, cone[0], cone[1], step).0;
            }
            if i % 8 == 7 {
                cone[0] = 0.01;
            }
        }
        assert!(cone[1] != 0.0);
    }
}

#[test]
fn extreme_a_distance_of_a_billion() {
    extreme(0.001, 1.0, Step::Propagate(1e9));
    extreme(-0.001, 1.0, Step::Propagate(1e9));
}

#[test]
fn extreme_a_black_bsdf_spreads_by_s_max() {
    extreme(0.125, 1.0, Step::Scatter(0.0));
    extreme(0.125, 1.0, Step::Scatter(1e300));
    let cfg = cfg(ConeFormat::Bf16);
    assert_eq!(both(&cfg, 0.125, 1.0, Step::Scatter(0.0)).0, [0.375, 1.0]);
}

#[test]
fn extreme_a_flat_mirror_changes_nothing() {
    extreme(0.125, 3.0, Step::Reflect(0.0));
    let cfg = cfg(ConeFormat::Bf16);
    assert_eq!(both(&cfg, 0.125, 3.0, Step::Reflect(0.0)).0, [0.125, 3.0]);
}

#[test]
fn extreme_equal_indices_and_indices_of_a_third_and_three() {
    for (outside, inside) in [(1.3, 1.3), (1.0, 1.0 / 3.0), (1.0, 3.0), (3.0, 1.0)] {
        for curvature in [0.0, 0.7, -0.7, 1e300] {
            let step = Step::Refract { curvature, outside, inside };
            extreme(0.1, 0.3, step);
            if outside == inside {
                let (ours, theirs, _) = both(&cfg(ConeFormat::F32), 0.125, 0.3, step);
                assert!(ours[0] == 0.125 && theirs[0] == 0.125);
            }
        }
    }
}

#[test]
fn errata_scatter_spreads_by_s_max_where_f_is_one_over_pi() {
    // The largest double below 1/π gives ¼ exactly (the nearest one lies above it); π gives ¼/π².
    let cfg = cfg(ConeFormat::F32);
    let below = f64::from_bits(std::f64::consts::FRAC_1_PI.to_bits() - 1);
    let at = both(&cfg, 0.0, 1.0, Step::Scatter(below));
    assert!(at.0[0] == 0.25 && at.1[0] == 0.25);
    let smooth = both(&cfg, 0.0, 1.0, Step::Scatter(std::f64::consts::PI));
    let expected = 0.25 / (std::f64::consts::PI * std::f64::consts::PI);
    assert!((smooth.1[0] - expected).abs() < 1e-16);
    assert!((smooth.0[0] - expected).abs() < 2e-9);
}

#[test]
fn no_code_and_no_operand_makes_anything_but_a_finite_code() {
    let specials =
        [f64::INFINITY, f64::NEG_INFINITY, f64::NAN, f64::MAX, -f64::MAX, 5e-324, -0.0, 1.0];
    for rules in ConeRules::ALL {
        for set_diffuse in SetDiffuse::ALL {
            for format in ConeFormat::ALL {
                let mut config = Config::default();
                config.policy.cone.format = *format;
                config.policy.cone.rules = *rules;
                config.policy.cone.set_diffuse = *set_diffuse;
                config.policy.cone.rounding = StoreRounding::Stochastic;
                let cfg = Cfg::new(&config);
                let float = cfg.format;
                let codes = [
                    0,
                    float.sign(),
                    1,
                    float.largest(),
                    float.largest() + 1,
                    float.sign() - 1,
                    u32::MAX,
                    rne(float, -0.25),
                ];
                for a in codes {
                    for w in codes {
                        for x in specials {
                            for y in specials {
                                let refract = Step::Refract { curvature: x, outside: y, inside: x };
                                for step in [
                                    Step::Propagate(x),
                                    Step::Reflect(x),
                                    refract,
                                    Step::Scatter(x),
                                ] {
                                    let cone = Cone { angle: Angle(a), width: Width(w) };
                                    let mut flags = Flags::default();
                                    let out = rtl::ray_cone(
                                        &cfg,
                                        cone,
                                        operands(step),
                                        &mut cfg.dither(9),
                                        &mut flags,
                                    );
                                    for code in [out.angle.0, out.width.0] {
                                        assert!(
                                            float.abs(code) <= float.largest(),
                                            "{step:?} {a:#x} {w:#x}"
                                        );
                                        assert!(
                                            code <= float.sign() | float.largest()
                                                && code != float.sign()
                                        );
                                    }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}
