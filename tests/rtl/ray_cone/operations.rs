//! Every operation against exact fractions, on rtl and f64.

use num_bigint::BigInt;
use rtl_model::Config;
use rtl_model::cone::{Angle, Cone, ConeFormat, Dither, Width};
use rtl_model::fx::Flags;
use rtl_model::policy::{ConeRules, SetDiffuse};
use rtl_model::stages::ray_cone::{self as rtl, Cfg};
use tapline::reference::ray_cone::{self as float, Step};

use super::formats::{rne, value, word};
use super::grid::nearest;

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
        Step::Refract { curvature, outside, inside } => {
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
    config.policy.cone.format = format;
    Cfg::new(&config)
}

pub(crate) fn operands(step: Step) -> rtl::Step {
    match step {
        Step::Propagate(d) => rtl::Step::Propagate(word(d)),
        Step::Reflect(k) => rtl::Step::Reflect(word(k)),
        Step::Refract { curvature, outside, inside } => rtl::Step::Refract {
            curvature: word(curvature),
            outside: word(outside),
            inside: word(inside),
        },
        Step::Scatter(f) => rtl::Step::Scatter(word(f)),
    }
}

/// One step by both engines from the same register values; the values and rtl's flags.
pub(crate) fn both(cfg: &Cfg, angle: f64, width: f64, step: Step) -> ([f64; 2], [f64; 2], Flags) {
    let mut flags = Flags::default();
    let cone = Cone { angle: Angle(rne(cfg.format, angle)), width: Width(rne(cfg.format, width)) };
    let (angle, width) = (value(cfg.format, cone.angle.0), value(cfg.format, cone.width.0));
    let ours = rtl::ray_cone(cfg, cone, operands(step), &mut cfg.dither(0), &mut flags);
    let theirs = float::ray_cone(
        float::Cone { angle: float::Angle(angle), width: float::Width(width) },
        step,
        ConeRules::Note,
        SetDiffuse::Angle,
    );
    (
        [value(cfg.format, ours.angle.0), value(cfg.format, ours.width.0)],
        [theirs.angle.0, theirs.width.0],
        flags,
    )
}

/// Checks one step of both engines: rtl is the nearest code, f64 within 2^−50 where nothing underflows.
pub(crate) fn check(cfg: &Cfg, angle: f64, width: f64, step: Step) {
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
    let (changed, kept, kept_before) = if moved { (1, 0, angle * sign) } else { (0, 1, width) };
    let what = format!("α {angle:e} w {width:e} {step:?}");
    assert!(ours[kept] == kept_before && theirs[kept] == kept_before, "{what}");
    // Two bits more than any format looks at, and one for the rest.
    let quotient = (&over << 600u32) / &under;
    let rest = &quotient * &under != (&over << 600u32);
    let quotient = 2 * quotient + if rest && over < BigInt::ZERO { -1 } else { i32::from(rest) };
    let expected = value(cfg.format, nearest(cfg.format, &quotient, unit - 601));
    assert!(ours[changed] == expected, "{what}: {} for {expected}", ours[changed]);
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
pub(crate) fn random(dither: &mut Dither) -> f64 {
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
                Step::Refract { curvature: k, outside, inside },
                Step::Scatter(inside),
            ] {
                check(&cfg, angle, width, step);
            }
            // All that was, cancels but for a last bit.
            let held = value(cfg.format, rne(cfg.format, width));
            let angle = value(cfg.format, rne(cfg.format, angle));
            let near = f64::from_bits((-held / angle).to_bits() + 1);
            check(&cfg, angle, held, Step::Propagate(near));
            check(&cfg, angle, held, Step::Reflect(-angle / (2.0 * held.abs())));
            check(
                &cfg,
                angle,
                held,
                Step::Refract { curvature: -angle / held.abs(), outside, inside },
            );
        }
    }
}

#[test]
fn every_bf16_angle_and_width_goes_through_every_operation() {
    let cfg = cfg(ConeFormat::Bf16);
    for code in (0..=u16::MAX).step_by(7) {
        let x = value(cfg.format, code.into());
        let refract = Step::Refract { curvature: 0.3, outside: 1.0, inside: 1.5 };
        for step in [Step::Propagate(2.5), Step::Reflect(-0.75), refract, Step::Scatter(0.7)] {
            check(&cfg, x, 1.0, step);
            check(&cfg, 0.125, x, step);
        }
    }
}
