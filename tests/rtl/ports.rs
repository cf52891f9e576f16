//! The integer model's ports and formats against doubles and the `fixed` crate.

#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    clippy::float_cmp,
    reason = "the oracle is in doubles; every conversion here is exact"
)]

use fixed::types::extra::{U16, U40};
use fixed::{FixedI32, FixedI64};
use proptest::prelude::*;
use rtl_model::fx::{Format, Overflow, Quantizer, Rounding};
use rtl_model::port;

fn format(int: u32, frac: u32, rounding: Rounding, overflow: Overflow) -> Format {
    Format { signed: true, int, frac, rounding, overflow }
}

proptest! {
    #[test]
    fn writes_agree_with_the_fixed_crate(x in any::<i64>(), drop in 2u32..40) {
        // Q23.40 to Q15.16; the crate drops bits towards −∞.
        let x = x >> drop;
        let wide = FixedI64::<U40>::from_bits(x);
        for (overflow, want) in [
            (Overflow::Saturate, FixedI32::<U16>::saturating_from_num(wide)),
            (Overflow::Wrap, FixedI32::<U16>::wrapping_from_num(wide)),
        ] {
            let q = Quantizer::new(format(15, 16, Rounding::Floor, overflow), 40);
            let (code, over) = q.write(x);
            prop_assert_eq!(code, i64::from(want.to_bits()));
            prop_assert_eq!(over, FixedI32::<U16>::checked_from_num(wide).is_none());
        }
        for (rounding, want) in [
            (Rounding::Floor, wide.floor()),
            (Rounding::Zero, wide.round_to_zero()),
            (Rounding::HalfAway, wide.round()),
            (Rounding::HalfEven, wide.round_ties_even()),
        ] {
            let q = Quantizer::new(format(58, 0, rounding, Overflow::Saturate), 40);
            prop_assert_eq!(q.write(x), (want.to_num::<i64>(), false));
        }
        for (rounding, frac) in [(Rounding::HalfAway, 8), (Rounding::HalfEven, 8)] {
            // The same at another scale: multiples of 2^−8 are integers after a shift by 8.
            let scaled = FixedI64::<U40>::from_bits(x >> 8);
            let q = Quantizer::new(format(50, frac, rounding, Overflow::Saturate), 48);
            let want = if rounding == Rounding::HalfAway { scaled.round() } else { scaled.round_ties_even() };
            prop_assert_eq!(q.write(x >> 8), (want.to_num::<i64>(), false));
        }
    }

    #[test]
    fn every_finite_word_unpacks_to_its_own_value(word in any::<u64>()) {
        let (m, e, finite) = port::unpack(word);
        let x = f64::from_bits(word);
        prop_assert_eq!(finite, x.is_finite());
        if x.is_finite() {
            // Two exact steps: subnormal results would round in one.
            let half = i32::try_from(e / 2).expect("small");
            let rest = i32::try_from(e).expect("small") - half;
            let back = libm::ldexp(libm::ldexp(m as f64, half), rest);
            if m.unsigned_abs() < 1 << 53 && e > -1074 {
                prop_assert_eq!(back, x);
            }
            prop_assert_eq!(m == 0, x == 0.0);
            prop_assert_eq!(m < 0, x < 0.0);
        }
    }

    #[test]
    fn a_scalar_is_rounded_once_like_the_double(x in -70000.0f64..70000.0, k in -6i64..6, exponent in -20i32..20) {
        // x·2^k is exact; so is its product with 2^frac. floor and ties-even of a double are exact.
        let x = libm::ldexp(x, i32::try_from(k).expect("small"));
        for (rounding, want) in [
            (Rounding::Floor, libm::floor as fn(f64) -> f64),
            (Rounding::Zero, libm::trunc),
            (Rounding::HalfEven, libm::rint),
            (Rounding::HalfAway, libm::round),
        ] {
            let q = Quantizer::new(format(17, 14, rounding, Overflow::Saturate), 0);
            let scaled = want(libm::ldexp(x, 14 - exponent));
            let top = f64::from(1u32 << 31);
            let over = scaled > top - 1.0 || scaled < -top;
            let code = scaled.clamp(-top, top - 1.0) as i64;
            prop_assert_eq!(port::scalar(false, &q, x.to_bits(), exponent.into()), (code, over, true));
        }
    }

    #[test]
    fn a_vector_keeps_its_direction_and_fills_its_register(
        words in prop::array::uniform3(any::<u64>()),
        width in 2u32..31,
    ) {
        let q = Quantizer::new(format(1, width - 1, Rounding::HalfEven, Overflow::Saturate), 0);
        let (block, finite) = port::vector(false, &q, words);
        let x = words.map(f64::from_bits);
        prop_assert_eq!(finite, x.iter().all(|x| x.is_finite()));
        let largest = block.m.iter().map(|m| m.abs()).max().expect("three");
        let max = (1i64 << width) - 1;
        prop_assert!(largest <= max);
        let x = x.map(|x| if x.is_nan() { 0.0 } else { x.clamp(-f64::MAX, f64::MAX) });
        if x == [0.0; 3] {
            prop_assert_eq!(block.m, [0; 3]);
            return Ok(());
        }
        prop_assert!(largest >= 1 << (width - 1), "{:?}", block);
        let frac = i32::try_from(block.frac).expect("small");
        for (m, x) in block.m.into_iter().zip(x) {
            let scaled = libm::ldexp(libm::ldexp(x, frac / 2), frac - frac / 2);
            let error = (m as f64 - scaled).abs();
            prop_assert!(error <= 0.5 || (m.abs() == max && error < 1.0), "{} {} {}", m, scaled, error);
        }
    }
}

#[test]
fn special_words_unpack_as_documented() {
    let largest = ((1i64 << 53) - 1, 971, true);
    assert_eq!(port::unpack(f64::MAX.to_bits()), largest);
    assert_eq!(port::unpack(f64::INFINITY.to_bits()), (largest.0, 971, false));
    assert_eq!(port::unpack(f64::NEG_INFINITY.to_bits()), (-largest.0, 971, false));
    for nan in [f64::NAN.to_bits(), !0, 0x7ff0_0000_0000_0001] {
        assert_eq!(port::unpack(nan), (0, -1074, false));
    }
    assert_eq!(port::unpack(0), (0, -1074, true));
    assert_eq!(port::unpack(1 << 63), (0, -1074, true));
    assert_eq!(port::unpack(1), (1, -1074, true));
    assert_eq!(port::unpack(f64::MIN_POSITIVE.to_bits()), (1 << 52, -1074, true));
    assert_eq!(port::unpack((-1.0f64).to_bits()), (-(1 << 52), -52, true));
}

#[test]
fn extreme_vectors_are_normalised() {
    let q = Quantizer::new(format(1, 22, Rounding::HalfEven, Overflow::Saturate), 0);
    let vector = |x: [f64; 3]| port::vector(false, &q, x.map(f64::to_bits)).0;
    // Subnormals: exact, the leading one on the top bit.
    let tiny = f64::from_bits(1);
    assert_eq!(vector([tiny, -2.0 * tiny, 0.0]).m, [1 << 21, -(1 << 22), 0]);
    assert_eq!(vector([f64::MAX, 0.0, -0.0]).m, [(1 << 23) - 1, 0, 0]);
    // A component 2^−23 and less of the largest: half an LSB rounds to even, below it to zero.
    let m = vector([1.0, 0.5f64.powi(23), 3.0 * 0.5f64.powi(23)]).m;
    assert_eq!(m, [1 << 22, 0, 2]);
    assert_eq!(vector([1e300, tiny, -1e-300]).m[1..], [0, 0]);
    assert_eq!(vector([-0.0; 3]).m, [0; 3]);
    assert_eq!(vector([f64::NAN, 1.0, -2.0]).m, [0, 1 << 21, -(1 << 22)]);
    assert_eq!(vector([f64::INFINITY, 1.0, 0.0]).m, [(1 << 23) - 1, 0, 0]);
}
