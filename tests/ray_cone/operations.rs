//! Every operation against exact fractions, on rtl and f64; extremes; OptiX Toolkit's rules.

use num_bigint::BigInt;
use rtl_model::Config;
use rtl_model::cone::{Angle, Cone, ConeFormat, Dither, Dyadic, StoreRounding, Width};
use rtl_model::fx::Flags;
use rtl_model::policy::{ConeRules, SetDiffuse};
use rtl_model::regs::Event;
use rtl_model::stages::ray_cone::{self as rtl, Cfg, Larger, camera};
use tapline::reference::ray_cone::{self as float, Step};

use crate::formats::{rne, value, word};
use crate::grid::nearest;

/// x · 2^1100, exact for every double.
fn big(x: f64) -> BigInt {
    let x = word(x);
    let m = BigInt::from(x.m) << u64::try_from(x.e + 1100).unwrap();
    if x.negative { -m } else { m }
}

/// π · 2^600, to a few units (Machin).
fn pi() -> BigInt {
    let inverse_tangent = |x: u32| {
        let mut term = (BigInt::from(1) << 640u32) / x;
        let (mut total, mut n) = (term.clone(), 1u32);
        while term != BigInt::ZERO {
            term = -term / (x * x);
            n += 2;
            total += &term / n;
        }
        total
    };
    ((16 * inverse_tangent(5) - 4 * inverse_tangent(239)) * 1u32) >> 40u32
}

/// (numerator, denominator, unit): the exact α' (or w') is numerator/denominator · 2^unit.
fn exact(angle: f64, width: f64, step: Step) -> (BigInt, BigInt, i64) {
    let one = BigInt::from(1);
    let w = big(width.abs());
    match step {
        Step::Propagate(d) => ((big(width) << 1100u32) + big(angle) * big(d), one, -2200),
        Step::Reflect(k) => ((big(angle) << 1100u32) + 2 * big(k) * w, one, -2200),
        Step::Refract {
            curvature,
            outside,
            inside,
        } => {
            let bend = big(curvature) * w;
            let over = ((big(outside) * big(angle)) << 1100u32) + big(outside) * &bend
                - big(inside) * bend;
            (over, big(inside), -2200)
        }
        Step::Scatter(f) => {
            let f_pi = big(f) * pi();
            if f_pi <= BigInt::from(1) << 1700u32 {
                return (big(angle) + big(0.25), one, -1100);
            }
            let over = big(angle) * &f_pi + (BigInt::from(1) << (2800u32 - 2));
            (over, f_pi, -1100)
        }
    }
}

pub(crate) fn cfg(format: ConeFormat) -> Cfg {
    let mut config = Config::default();
    config.cone.format = format;
    Cfg::new(&config)
}

fn operands(step: Step) -> rtl::Step {
    match step {
        Step::Propagate(d) => rtl::Step::Propagate(word(d)),
        Step::Reflect(k) => rtl::Step::Reflect(word(k)),
        Step::Refract {
            curvature,
            outside,
            inside,
        } => rtl::Step::Refract {
            curvature: word(curvature),
            outside: word(outside),
            inside: word(inside),
        },
        Step::Scatter(f) => rtl::Step::Scatter(word(f)),
    }
}

/// One step by both engines from the same register values; the values and rtl's flags.
fn both(cfg: &Cfg, angle: f64, width: f64, step: Step) -> ([f64; 2], [f64; 2], Flags) {
    let mut flags = Flags::default();
    let cone = Cone {
        angle: Angle(rne(cfg.format, angle)),
        width: Width(rne(cfg.format, width)),
    };
    let (angle, width) = (
        value(cfg.format, cone.angle.0),
        value(cfg.format, cone.width.0),
    );
    let ours = rtl::ray_cone(cfg, cone, operands(step), &mut cfg.dither(0), &mut flags);
    let theirs = float::ray_cone(
        float::Cone {
            angle: float::Angle(angle),
            width: float::Width(width),
        },
        step,
        ConeRules::Note,
        SetDiffuse::Angle,
    );
    (
        [
            value(cfg.format, ours.angle.0),
            value(cfg.format, ours.width.0),
        ],
        [theirs.angle.0, theirs.width.0],
        flags,
    )
}

/// Checks one step of both engines: rtl is the nearest code, f64 within 2^−50 where nothing underflows.
fn check(cfg: &Cfg, angle: f64, width: f64, step: Step) {
    let angle = value(cfg.format, rne(cfg.format, angle));
    let width = value(cfg.format, rne(cfg.format, width));
    let (ours, theirs, _) = both(cfg, angle, width, step);
    let (mut over, under, unit) = exact(angle, width, step);
    let moved = matches!(step, Step::Propagate(_));
    let turned = moved && angle < 0.0 && over < BigInt::ZERO;
    if turned {
        over = -over;
    }
    let sign = if turned { -1.0 } else { 1.0 };
    let (changed, kept, kept_before) = if moved {
        (1, 0, angle * sign)
    } else {
        (0, 1, width)
    };
    let what = format!("α {angle:e} w {width:e} {step:?}");
    assert!(
        ours[kept] == kept_before && theirs[kept] == kept_before,
        "{what}"
    );
    // Two bits more than any format looks at, and one for the rest.
    let quotient = (&over << 600u32) / &under;
    let rest = &quotient * &under != (&over << 600u32);
    let quotient = 2 * quotient
        + if rest && over < BigInt::ZERO {
            -1
        } else {
            i32::from(rest)
        };
    let expected = value(cfg.format, nearest(cfg.format, &quotient, unit - 601));
    assert!(
        ours[changed] == expected,
        "{what}: {} for {expected}",
        ours[changed]
    );
    // |f64 − exact| ≤ 2^−50 |exact| but for the last place of subnormals.
    let x = theirs[changed];
    if x.abs() >= f64::MIN_POSITIVE && x.abs() < f64::MAX {
        let shift = u32::try_from(-1100 - unit).unwrap();
        let difference = (((big(x) << shift) * &under) - &over).magnitude() << 50u32;
        assert!(difference <= *over.magnitude(), "{what}: f64 {x:e}");
    } else {
        assert!(
            x == 0.0 && over == BigInt::ZERO || x.abs() >= f64::MAX || x.abs() < f64::MIN_POSITIVE
        );
    }
}

/// A number of random sign, mantissa of a few or all bits, and a magnitude around 1.
fn random(dither: &mut Dither) -> f64 {
    let bits = u64::from(dither.next_bits()) << 32 | u64::from(dither.next_bits());
    let mantissa = match dither.next_bits() % 3 {
        0 => bits & 0xf << 48,
        1 => bits & 0xfff << 40,
        _ => bits & ((1 << 52) - 1),
    };
    f64::from_bits(bits & 1 << 63 | (1013 + u64::from(dither.next_bits() % 20)) << 52 | mantissa)
}

#[test]
fn every_operation_stores_the_code_nearest_to_the_exact_result() {
    let mut dither = Dither::new(1, 0);
    for format in ConeFormat::ALL {
        let cfg = cfg(*format);
        for _ in 0..1500 {
            let mut next = || random(&mut dither);
            let (angle, width, k) = (next(), next(), next());
            let (outside, inside) = (next().abs(), next().abs());
            for step in [
                Step::Propagate(next()),
                Step::Reflect(k),
                Step::Refract {
                    curvature: k,
                    outside,
                    inside,
                },
                Step::Scatter(inside),
            ] {
                check(&cfg, angle, width, step);
            }
            // All that was, cancels but for a last bit.
            let held = value(cfg.format, rne(cfg.format, width));
            let angle = value(cfg.format, rne(cfg.format, angle));
            let near = f64::from_bits((-held / angle).to_bits() + 1);
            check(&cfg, angle, held, Step::Propagate(near));
            check(
                &cfg,
                angle,
                held,
                Step::Reflect(-angle / (2.0 * held.abs())),
            );
            check(
                &cfg,
                angle,
                held,
                Step::Refract {
                    curvature: -angle / held.abs(),
                    outside,
                    inside,
                },
            );
        }
    }
}

#[test]
fn every_bf16_angle_and_width_goes_through_every_operation() {
    let cfg = cfg(ConeFormat::Bf16);
    for code in (0..=u16::MAX).step_by(7) {
        let x = value(cfg.format, code.into());
        let refract = Step::Refract {
            curvature: 0.3,
            outside: 1.0,
            inside: 1.5,
        };
        for step in [
            Step::Propagate(2.5),
            Step::Reflect(-0.75),
            refract,
            Step::Scatter(0.7),
        ] {
            check(&cfg, x, 1.0, step);
            check(&cfg, 0.125, x, step);
        }
    }
}

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
            let cone = Cone {
                angle: Angle(cfg.format.sign()),
                width: Width(cfg.format.sign()),
            };
            let mut flags = Flags::default();
            let out = rtl::propagate(&cfg, cone, word(1.0), &mut cfg.dither(0), &mut flags);
            assert_eq!(out, Cone::default());
        }
    }
}

#[test]
fn extreme_subnormals_are_kept() {
    extreme(
        0.0,
        f64::from_bits(0x37a0_0000_0000_0000),
        Step::Propagate(1.0),
    );
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
            let step = Step::Refract {
                curvature,
                outside,
                inside,
            };
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
    let specials = [
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::NAN,
        f64::MAX,
        -f64::MAX,
        5e-324,
        -0.0,
        1.0,
    ];
    for rules in ConeRules::ALL {
        for set_diffuse in SetDiffuse::ALL {
            for format in ConeFormat::ALL {
                let mut config = Config::default();
                config.cone.format = *format;
                config.cone.rules = *rules;
                config.cone.set_diffuse = *set_diffuse;
                config.cone.rounding = StoreRounding::Stochastic;
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
                                let refract = Step::Refract {
                                    curvature: x,
                                    outside: y,
                                    inside: x,
                                };
                                for step in [
                                    Step::Propagate(x),
                                    Step::Reflect(x),
                                    refract,
                                    Step::Scatter(x),
                                ] {
                                    let cone = Cone {
                                        angle: Angle(a),
                                        width: Width(w),
                                    };
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

fn otk(set_diffuse: SetDiffuse) -> Cfg {
    let mut config = Config::default();
    config.cone.rules = ConeRules::Otk;
    config.cone.set_diffuse = set_diffuse;
    config.cone.rounding = StoreRounding::Truncate;
    Cfg::new(&config)
}

fn step_otk(set_diffuse: SetDiffuse, angle: f64, width: f64, step: Step) -> [f64; 2] {
    let cfg = otk(set_diffuse);
    let ours = both(&cfg, angle, width, step).0;
    let theirs = float::ray_cone(
        float::Cone {
            angle: float::Angle(angle),
            width: float::Width(width),
        },
        step,
        ConeRules::Otk,
        set_diffuse,
    );
    for (a, b) in ours.into_iter().zip([theirs.angle.0, theirs.width.0]) {
        assert!((a - b).abs() <= b.abs() / 128.0, "{ours:?} {theirs:?}");
    }
    ours
}

#[test]
fn otk_leaves_wide_cones_alone_and_narrow_ones_follow_the_note() {
    for step in [Step::Reflect(1.0), Step::Scatter(1.0)] {
        assert_eq!(step_otk(SetDiffuse::Angle, 0.25, 1.0, step), [0.25, 1.0]);
    }
    assert_eq!(
        step_otk(SetDiffuse::Angle, 0.125, 1.0, Step::Reflect(1.0)),
        [2.125, 1.0]
    );
    // The limit is one of α, not of |α|.
    assert_eq!(
        step_otk(SetDiffuse::Angle, -0.5, 1.0, Step::Reflect(1.0)),
        [1.5, 1.0]
    );
}

#[test]
fn otk_scatters_away_from_zero_and_ends_diffuse_with_or_without_the_exchange() {
    let away = step_otk(SetDiffuse::Angle, -0.0625, 1.0, Step::Scatter(1.0));
    assert!(away[0] < -0.0625 && away[1] == 1.0);
    for angle in [-0.125, 0.125] {
        let step = Step::Scatter(0.0);
        assert_eq!(step_otk(SetDiffuse::Angle, angle, -3.0, step), [0.25, 3.0]);
        assert_eq!(
            step_otk(SetDiffuse::Exchanged, angle, -3.0, step),
            [3.0, 0.25]
        );
    }
    // By the note the two never meet: angle stays angle, width stays width.
    assert_eq!(
        both(&cfg(ConeFormat::Bf16), 0.125, -3.0, Step::Scatter(0.0)).0,
        [0.375, -3.0]
    );
}

#[test]
fn cameras_and_the_choice_of_two_cones() {
    let v = |x: [f64; 3]| x.map(word);
    let frame = camera::Frame {
        u: v([3.0, 4.0, 0.0]),
        v: v([0.0, 0.0, 5.0]),
        w: v([0.0, 8.0, 6.0]),
        size: [100, 50],
    };
    let d = v([0.0, 0.8, 0.6]);
    let cfg = cfg(ConeFormat::F32);
    let (mut dither, mut flags) = (cfg.dither(0), Flags::default());
    let near = |code: u32, x: f64| {
        let got = value(cfg.format, code);
        assert!(
            (got - x).abs() <= x.abs() / f64::from(1 << 23),
            "{got} for {x}"
        );
    };
    // |U|/100 = 0.05 is the smaller; ⟨D, W⟩/⟨W, W⟩ = 0.1.
    let pinhole = camera::pinhole(&cfg, &frame, &d, &mut dither, &mut flags);
    near(pinhole.angle.0, 0.01);
    assert_eq!(pinhole.width.0, 0);
    let lens = camera::thin_lens(
        &cfg,
        &frame,
        &d,
        camera::pixel_width(&frame),
        &mut dither,
        &mut flags,
    );
    near(lens.angle.0, -0.01);
    near(lens.width.0, 0.1);
    let flat = camera::orthographic(&cfg, &frame, &mut dither, &mut flags);
    assert_eq!(flat.angle.0, 0);
    near(flat.width.0, 0.1);
    assert!(flags.is_empty());
    assert_eq!(
        rtl::choose(&cfg, [pinhole, lens], Larger::Width, false),
        lens
    );
    assert_eq!(
        rtl::choose(&cfg, [pinhole, lens], Larger::Width, true),
        pinhole
    );
    assert_eq!(
        rtl::choose(&cfg, [pinhole, flat], Larger::Angle, false),
        pinhole
    );
}

#[test]
fn a_triangles_curvature_is_its_flattest_edges_or_zero_where_signs_mix() {
    let v = |x: [f64; 3]| x.map(word);
    let points = [v([0.0, 0.0, 0.0]), v([1.0, 0.0, 0.0]), v([0.0, 2.0, 0.0])];
    let [a, b, c] = &points;
    // Normals of slope p·x and q·y: edges have curvatures p, q and their mean weighted by length².
    let normals = |p: f64, q: f64| [v([0.0, 0.0, 1.0]), v([p, 0.0, 1.0]), v([0.0, 2.0 * q, 1.0])];
    for (p, q, expected) in [
        (0.5, 0.25, 0.25),
        (-0.5, -0.25, -0.25),
        (0.5, -0.25, 0.0),
        (0.5, 0.0, 0.0),
    ] {
        let n = normals(p, q);
        let k: Dyadic = camera::triangle_curvature([a, b, c], [&n[0], &n[1], &n[2]]);
        let k = crate::formats::real(k);
        assert!((k - expected).abs() < 1e-15, "{p} {q}: {k}");
    }
    // An edge without length has no curvature.
    assert!(camera::edge_curvature([a, a], [b, c]).is_zero());
}

#[test]
fn no_knob_of_the_cones_is_dead() {
    use tapline::unit::UnitSpec;
    use tapline::unit::knobs::Value;
    let text = |t: &str| Value::Text(t.into());
    let run = |spec: &UnitSpec| {
        let cfg = Cfg::new(&spec.config);
        let (mut dither, mut flags) = (cfg.dither(0), Flags::default());
        let mut words = Vec::new();
        for start in [[0.01f64, 0.3], [-0.17, 0.9]] {
            let mut cone = cfg.load(start.map(f64::to_bits), &mut dither, &mut flags);
            for step in [
                Step::Propagate(0.7),
                Step::Reflect(0.3),
                Step::Scatter(0.9),
                Step::Scatter(0.2),
            ] {
                cone = rtl::ray_cone(&cfg, cone, operands(step), &mut dither, &mut flags);
                words.push(cone.pack(cfg.format, cfg.order));
            }
        }
        words
    };
    for (path, values, enable) in [
        ("cone.format", vec![text("f16"), text("f32")], None),
        (
            "cone.rounding",
            vec![text("truncate"), text("stochastic")],
            None,
        ),
        ("cone.lane_order", vec![text("width-low")], None),
        (
            "cone.seed",
            vec![Value::Integer(1), Value::Integer(4_294_967_295)],
            Some(("cone.rounding", "stochastic")),
        ),
        ("cone.rules", vec![text("otk")], None),
        (
            "cone.set_diffuse",
            vec![text("exchanged")],
            Some(("cone.rules", "otk")),
        ),
    ] {
        let mut base = UnitSpec::default();
        if let Some((other, value)) = enable {
            base.set(other, &text(value)).unwrap();
        }
        for value in values {
            let mut changed = base.clone();
            changed.set(path, &value).unwrap();
            assert_ne!(run(&changed), run(&base), "{path} = {value}");
        }
    }
}
