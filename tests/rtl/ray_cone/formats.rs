//! Conversions into and out of the small formats.

use half::{bf16, f16};
use rayon::prelude::*;
use rtl_model::cone::{ConeFormat, Dither, Dyadic, SmallFloat, StoreRounding, Sum, exact, fast};

pub(crate) fn value(format: SmallFloat, code: u32) -> f64 {
    let (x, _) = format.unpack(code);
    real(x)
}

/// Exact for every code of a small format and every finite double.
pub(crate) fn real(x: Dyadic) -> f64 {
    let m = libm::ldexp(x.m as f64, x.e as i32);
    if x.negative { -m } else { m }
}

pub(crate) fn word(x: f64) -> Dyadic {
    Dyadic::binary64(x.to_bits()).0
}

pub(crate) fn sum(x: f64) -> Sum {
    exact::sum2(word(x), Dyadic::ONE, Dyadic::ZERO)
}

pub(crate) fn rne(format: SmallFloat, x: f64) -> u32 {
    format.store(StoreRounding::Rne, 0, &sum(x)).code
}

/// A code of `half` as the registers hold it: one zero, no infinity, no NaN.
fn finite(format: SmallFloat, code: u32) -> u32 {
    let magnitude = format.abs(code);
    if magnitude == 0 || magnitude > format.largest() + 1 {
        0
    } else {
        magnitude.min(format.largest()) | (code & format.sign())
    }
}

#[test]
fn every_bf16_and_f16_code_is_the_value_that_half_says_and_stores_back() {
    for code in 0..=u16::MAX {
        for (format, theirs) in [
            (SmallFloat::BF16, bf16::from_bits(code).to_f64()),
            (SmallFloat::F16, f16::from_bits(code).to_f64()),
        ] {
            let (x, is_finite) = format.unpack(code.into());
            assert_eq!(is_finite, theirs.is_finite(), "{code:#06x}");
            if theirs.is_finite() {
                assert!(real(x) == theirs, "{code:#06x}");
            }
            let kept = finite(format, code.into());
            for rounding in StoreRounding::ALL {
                for random in [0, u32::MAX] {
                    let stored = format.store(*rounding, random, &sum(real(x)));
                    assert_eq!(stored.code, kept, "{code:#06x} {rounding:?}");
                    assert!(!stored.saturated);
                }
            }
            assert_eq!(value(format, format.negate(kept)), -value(format, kept) + 0.0);
            assert_eq!(value(format, format.abs(kept)), value(format, kept).abs());
        }
    }
}

#[test]
fn f32_codes_are_their_values() {
    for i in 0..1u32 << 20 {
        let code = i.wrapping_mul(0x9e37_79b9);
        let theirs = f64::from(f32::from_bits(code));
        if theirs.is_finite() {
            assert!(value(SmallFloat::F32, code) == theirs);
            assert_eq!(rne(SmallFloat::F32, theirs), finite(SmallFloat::F32, code));
        }
    }
}

/// Rounds one binary32 code to bf16 by the store, for all three roundings.
fn check_f32(code: u32) -> bool {
    let (x, is_finite) = SmallFloat::F32.unpack(code);
    let exact = exact::sum2(x, Dyadic::ONE, Dyadic::ZERO);
    let stored = SmallFloat::BF16.store(StoreRounding::Rne, 0, &exact);
    let theirs = u32::from(bf16::from_f32(f32::from_bits(code)).to_bits());
    let expected = finite(SmallFloat::BF16, theirs);
    // Truncation drops the low half, as OptiX Toolkit's pack does.
    let cut = SmallFloat::BF16.store(StoreRounding::Truncate, 0, &exact);
    let dropped = if is_finite { finite(SmallFloat::BF16, code >> 16) } else { expected };
    // The next code away from zero if the random number is below the dropped fraction.
    let random = code.wrapping_mul(0x9e37_79b9);
    let random_store = SmallFloat::BF16.store(StoreRounding::Stochastic, random, &exact);
    let carried = if is_finite {
        let up = u32::from(u64::from(random) < u64::from(code & 0xffff) << 16);
        finite(SmallFloat::BF16, (code >> 16) + up)
    } else {
        expected
    };
    let overflows = SmallFloat::BF16.abs(theirs) == SmallFloat::BF16.largest() + 1;
    for (rounding, slow) in StoreRounding::ALL.iter().zip([stored, cut, random_store]) {
        let quick = fast::convert(SmallFloat::BF16, *rounding, random, code);
        if quick != (slow.code, slow.saturated) {
            return false;
        }
    }
    stored.code == expected
        && stored.saturated == overflows
        && cut.code == dropped
        && !cut.saturated
        && random_store.code == carried
}

/// Whether all 2^16 binary32 codes with an upper half become the bf16 of `half`.
fn all_lower_halves_are_right(high: u32) -> bool {
    (0..1u32 << 16).all(|low| {
        let code = high << 16 | low;
        let theirs = u32::from(bf16::from_f32(f32::from_bits(code)).to_bits());
        let infinite = SmallFloat::BF16.abs(theirs) == SmallFloat::BF16.largest() + 1;
        fast::convert(SmallFloat::BF16, StoreRounding::Rne, 0, code)
            == (finite(SmallFloat::BF16, theirs), infinite)
    })
}

/// What is cut off decides with the last bit that stays, and a carry runs into the exponent: the ends of the upper
/// significand stand for all. The next test has every upper half with the lower ones that matter.
#[test]
fn every_lower_half_of_a_binary32_code_rounds_as_half_does_at_every_sign_and_exponent() {
    let wrong = (0..1u32 << 9).into_par_iter().find_any(|exponent| {
        [0, 1, 0x3f, 0x40, 0x7e, 0x7f]
            .iter()
            .any(|m| !all_lower_halves_are_right(exponent << 7 | m))
    });
    assert_eq!(wrong, None, "sign and exponent of a binary32 code");
}

/// `cargo test --release --test rtl every_binary32 -- --ignored`
#[test]
#[ignore = "2^32 inputs: seconds when optimised, minutes when not"]
fn every_binary32_number_becomes_the_bf16_of_half() {
    let wrong = (0..1u32 << 16).into_par_iter().find_any(|high| !all_lower_halves_are_right(*high));
    assert_eq!(wrong, None, "upper half of a binary32 code");
}

#[test]
fn the_general_store_agrees_in_every_rounding_for_every_upper_half_of_a_binary32_code() {
    let wrong = (0..1u32 << 16).into_par_iter().find_any(|high| {
        let lows = [0, 1, 0x7ffe, 0x7fff, 0x8000, 0x8001, 0xfffe, 0xffff];
        let others = (0..8).map(|i| (high * 40_503 + i * 7919) & 0xffff);
        lows.into_iter().chain(others).any(|low| !check_f32(high << 16 | low))
    });
    assert_eq!(wrong, None, "upper half of a binary32 code");
}

/// `half` takes a double to binary32 first on some machines, which rounds twice; binary32 is safe.
#[test]
fn binary32_numbers_round_to_f16_as_half_does() {
    let mut dither = Dither::new(11, 0);
    for _ in 0..1 << 20 {
        let bits = dither.next_bits();
        // Exponents around binary16's range.
        let code = bits & 0x807f_ffff | (95 + (bits >> 23 & 63)) << 23;
        let x = f32::from_bits(code);
        let theirs = u32::from(f16::from_f32(x).to_bits());
        assert_eq!(rne(SmallFloat::F16, x.into()), finite(SmallFloat::F16, theirs), "{x:?}");
    }
}

#[test]
fn stochastic_stores_are_right_on_average_and_never_move_exact_values() {
    // 1 + 2^-7·¼: a quarter of the stores go up. 2^16 draws have a standard deviation of 111.
    let x = sum(1.0 + 1.0 / 512.0);
    let ups: u32 = (0..1u64 << 16)
        .map(|ray| {
            let random = Dither::new(5, ray).next_bits();
            let code = SmallFloat::BF16.store(StoreRounding::Stochastic, random, &x).code;
            assert!(code == 0x3f80 || code == 0x3f81);
            code - 0x3f80
        })
        .sum();
    assert!((16384 - 555..16384 + 555).contains(&ups), "{ups}");
}

#[test]
fn lanes_pack_in_both_orders_and_never_exchange() {
    use rtl_model::cone::{Angle, Cone, LaneOrder, Width};
    for format in ConeFormat::ALL {
        let format = format.float();
        let cone = Cone { angle: Angle(rne(format, 1.0)), width: Width(rne(format, 2.0)) };
        let low = cone.pack(format, LaneOrder::AngleLow);
        let high = cone.pack(format, LaneOrder::WidthLow);
        assert_ne!(low, high);
        assert_eq!(Cone::unpack(low, format, LaneOrder::AngleLow), cone);
        assert_eq!(Cone::unpack(high, format, LaneOrder::WidthLow), cone);
    }
    let cone = Cone { angle: Angle(0x3f80), width: Width(0x4000) };
    assert_eq!(cone.pack(SmallFloat::BF16, LaneOrder::AngleLow), 0x4000_3f80);
    assert_eq!(cone.pack(SmallFloat::BF16, LaneOrder::WidthLow), 0x3f80_4000);
}
