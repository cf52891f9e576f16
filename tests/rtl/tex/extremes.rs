//! Inputs at the ends of every range: defined bits, flags, no panic, the same in both engines where numbers fit.

use proptest::prelude::*;
use rtl_model::cone::{Angle, Cone, Width};
use rtl_model::regs::Reg;
use rtl_model::unit::{Tangents, TexWords};
use rtl_model::{NoTap, NoTapStandard};
use tapline::engine::tex::TexRtl;
use tapline::fragment::TexFragment;
use tapline::unit::UnitSpec;

use super::{by_f64, by_rtl, request};

const DOWN: [f64; 3] = [0.0, -1.0, 0.0];
const UP: [f64; 3] = [0.0, 1.0, 0.0];
const S: [f64; 3] = [2.0, 0.0, 0.0];
const T: [f64; 3] = [0.0, 0.0, 2.0];

fn engine() -> TexRtl {
    TexRtl::sized(&UnitSpec::default(), [256, 256]).unwrap()
}

/// λ of both engines; the integer model's within 2^-16 of the larger one.
fn lambdas(fragment: &TexFragment, width: f64) -> ([f64; 2], Vec<String>) {
    let (probe, _, flags) = by_rtl(&engine(), fragment, width);
    let there = by_f64(&UnitSpec::default(), fragment, width, [256, 256]);
    let got = [0, 1].map(|i| probe.get(Reg::EigenLambda)[i].value());
    for i in 0..2 {
        let bound = there.lambda[0] / 65536.0;
        assert!(
            (got[i] - there.lambda[i]).abs() <= bound.max(f64::MIN_POSITIVE),
            "{got:?} {there:?}"
        );
    }
    let names: Vec<String> = there.flags.names().map(String::from).collect();
    for name in &names {
        assert!(flags.contains(name), "{flags:?} lacks {name}");
    }
    (there.lambda, names)
}

#[test]
fn d_parallel_to_n_is_a_disc() {
    for d in [DOWN, UP] {
        let (lambda, flags) = lambdas(&request(d, UP, S, T), 0.25);
        assert!((lambda[0] - 32.0).abs() < 1e-9 && (lambda[1] - 32.0).abs() < 1e-9);
        assert_eq!(flags, ["surface_footprint.parallel"]);
    }
}

#[test]
fn the_normal_that_makes_otk_s_basis_nan_makes_none_here() {
    // N = ±(1, −1, 1)/√3 is where OptiX Toolkit's orthonormal basis divides 0 by 0.
    let third = 1.0 / 3.0f64.sqrt();
    for sign in [1.0, -1.0] {
        let n = [third, -third, third].map(|c| sign * c);
        for d in [n, n.map(|c| -c), [0.2, 0.9, -0.1]] {
            let (lambda, _) = lambdas(&request(d, n, [1.0, 1.0, 0.0], [0.0, 1.0, 1.0]), 0.5);
            assert!(lambda[0].is_finite() && lambda[0] > 0.0 && lambda[1] > 0.0);
        }
    }
}

#[test]
fn d_across_n_stops_at_the_cap() {
    let (lambda, _) = lambdas(&request([1.0, 0.0, 0.0], UP, S, T), 0.25);
    assert!((lambda[0] - 512.0).abs() < 1e-9 && (lambda[1] - 32.0).abs() < 1e-9);
}

#[test]
fn no_width_is_a_point_and_signs_do_not_count() {
    let fragment = request([0.5, -1.0, 0.0], UP, S, T);
    assert_eq!(lambdas(&fragment, 0.0).0, [0.0, 0.0]);
    assert_eq!(lambdas(&fragment, -0.0).0, [0.0, 0.0]);
    assert_eq!(lambdas(&fragment, -0.25), lambdas(&fragment, 0.25));
}

#[test]
fn widths_from_the_least_subnormal_to_the_largest_number() {
    // bf16 has the range of binary32; a subnormal keeps its own width.
    for width in [libm::exp2(-133.0), libm::exp2(-126.0), 1e-20, 1e9, libm::exp2(127.0)] {
        // As the register holds it.
        let mut flags = rtl_model::fx::Flags::default();
        let unit = engine();
        let cfg = &unit.unit.cone;
        let cone = cfg.load([0, width.to_bits()], &mut cfg.dither(0), &mut flags);
        let held = tapline::engine::tex::value(cfg.width(cone.width));
        assert!(held > 0.0);
        let (lambda, _) = lambdas(&request([0.5, -1.0, 0.0], UP, S, T), held);
        assert!(lambda[1] > 0.0);
    }
}

#[test]
fn zero_vectors_and_parallel_derivatives_have_an_answer() {
    let zero = [0.0; 3];
    let cases = [
        (zero, UP, S, T, "surface_footprint.parallel"),
        (DOWN, zero, S, T, "surface_footprint.parallel"),
        (zero, zero, S, T, "surface_footprint.parallel"),
        ([0.5, -1.0, 0.0], UP, zero, T, "surface_footprint.degenerate"),
        ([0.5, -1.0, 0.0], UP, S, zero, "surface_footprint.degenerate"),
        ([0.5, -1.0, 0.0], UP, zero, zero, "surface_footprint.degenerate"),
        ([0.5, -1.0, 0.0], UP, S, [4.0, 0.0, 0.0], "surface_footprint.degenerate"),
    ];
    for (d, n, s, t, flag) in cases {
        let (lambda, flags) = lambdas(&request(d, n, s, t), 0.25);
        assert!(lambda.iter().all(|l| l.is_finite()));
        assert!(flags.iter().any(|f| f == flag), "{flags:?}");
    }
}

#[test]
fn what_is_not_finite_is_replaced_and_flagged() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let fragment = request([bad, -1.0, 0.0], UP, S, T);
        let (_, _, flags) = by_rtl(&engine(), &fragment, 0.25);
        let there = by_f64(&UnitSpec::default(), &fragment, 0.25, [256, 256]);
        let name = "surface_footprint.non_finite";
        assert!(flags.iter().any(|f| f == name));
        assert!(there.flags.names().any(|f| f == name));
        assert!(there.lambda.iter().chain(&there.k).all(|x| x.is_finite()));
    }
}

#[test]
fn vectors_of_any_length_give_the_same_footprint() {
    let fragment = request([0.5, -1.0, 0.3], [0.1, 1.0, 0.2], S, T);
    let (base, _) = lambdas(&fragment, 0.25);
    for power in [-900.0, -40.0, 40.0, 900.0] {
        let scale = libm::exp2(power);
        let mut scaled = fragment;
        scaled.d = scaled.d.map(|c| c * scale);
        scaled.n = scaled.n.map(|c| c / scale);
        assert_eq!(lambdas(&scaled, 0.25).0, base);
    }
}

fn words() -> impl Strategy<Value = TexWords> {
    let vector = || prop::array::uniform3(any::<u64>());
    let tangents = prop_oneof![
        (vector(), vector()).prop_map(|(s, t)| Tangents::Surface([s, t])),
        (vector(), vector(), prop::array::uniform4(any::<u64>()))
            .prop_map(|(s, t, st)| { Tangents::Triangle { edges: [s, t], st } }),
    ];
    (any::<[u32; 2]>(), vector(), vector(), tangents, any::<[u64; 2]>()).prop_map(
        |([angle, width], d, n, tangents, st)| TexWords {
            cone: Cone { angle: Angle(angle), width: Width(width) },
            d,
            n,
            tangents,
            st,
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Any bits: no panic, and the tap that assumes standard registers has the same results.
    #[test]
    fn any_bits_are_answered(words in prop::collection::vec(words(), 1..6)) {
        let engine = engine();
        let any = engine.lanes::<32, _>(&words, &mut NoTap);
        let standard = engine.lanes::<32, _>(&words, &mut NoTapStandard);
        for (lane, word) in words.iter().enumerate() {
            prop_assert_eq!(any.1.probes[lane], standard.1.probes[lane]);
            prop_assert_eq!(any.1.flags[lane], standard.1.flags[lane]);
            prop_assert_eq!(any.0.env.line.lod[lane], standard.0.env.line.lod[lane]);
            // One lane alone has the same bits.
            let (one, out) = engine.lanes::<1, _>(&[*word], &mut NoTap);
            prop_assert_eq!(one.front.surface[0].d, any.0.front.surface[lane].d);
            prop_assert_eq!(out.flags[0], any.1.flags[lane]);
        }
    }
}
