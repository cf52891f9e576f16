//! Texel formats against the `half` crate and the texts of their specifications.

#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::float_cmp,
    reason = "the oracle is in floats; every conversion here is exact"
)]

use half::f16;
use proptest::prelude::*;
use rtl_model::texel::{decode, half_to_q24, keeps_half, to_half, to_rgb9e5};
use rtl_model::{Config, TexelFormat};
use tapline::base::random::Random;

/// Fractions that make every kind of tie and carry of an 11-bit significand.
fn fractions() -> Vec<u32> {
    let mut out = vec![0, 1, 2, 0x7f_ffff, 0x7f_fffe];
    for bit in 0..23 {
        for near in [-1i32, 0, 1] {
            let x = (1i32 << bit) + near;
            out.push(x.unsigned_abs() & 0x7f_ffff);
            out.push(!x.unsigned_abs() & 0x7f_ffff);
        }
    }
    let mut x = 1u32;
    for _ in 0..1000 {
        x = x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        out.push(x >> 9);
        out.push((x >> 9) & !0xfff);
        out.push((x >> 9) & !0xfff | 0x1000);
    }
    out
}

#[test]
fn to_half_agrees_with_the_half_crate_for_every_exponent() {
    for exponent in 0..255u32 {
        for fraction in fractions() {
            let word = exponent << 23 | fraction;
            let want = f16::from_f32(f32::from_bits(word));
            let want = if want.is_finite() { want } else { f16::MAX };
            assert_eq!(to_half(word), want.to_bits(), "{word:#010x}");
        }
    }
    assert_eq!(to_half(f32::INFINITY.to_bits()), f16::MAX.to_bits());
    for word in [f32::NAN.to_bits(), (-1.0f32).to_bits(), f32::NEG_INFINITY.to_bits(), 1 << 31] {
        assert_eq!(to_half(word), 0, "{word:#010x}");
    }
}

#[test]
fn every_finite_half_survives_the_round_trip_and_is_exact_with_24_bits() {
    for word in 0..=0x7bffu16 {
        let value = f16::from_bits(word).to_f32();
        assert_eq!(to_half(value.to_bits()), word);
        assert_eq!(half_to_q24(word), (f64::from(value) * 16_777_216.0) as i64);
    }
}

/// The encoder of EXT_texture_shared_exponent, from its text, in doubles (all steps are exact there).
fn shared_exponent(rgb: [f32; 3]) -> ([u64; 3], i32) {
    const MAX: f64 = 65408.0;
    let c = rgb.map(|x| if x.is_nan() { 0.0 } else { f64::from(x).clamp(0.0, MAX) });
    let max = c[0].max(c[1]).max(c[2]);
    let log = if max > 0.0 { libm::ilogb(max) } else { i32::MIN / 2 };
    let mut exponent = log.max(-16) + 1 + 15;
    let step = |exponent: i32| libm::ldexp(1.0, exponent - 15 - 9);
    if libm::floor(max / step(exponent) + 0.5) == 512.0 {
        exponent += 1;
    }
    (c.map(|x| libm::floor(x / step(exponent) + 0.5) as u64), exponent - 15)
}

#[test]
fn rgb9e5_follows_the_extension_bit_for_bit() {
    let mut random = Random::new(3);
    let mut next = || (random.word() >> 32) as u32;
    let ties =
        [0.0f32, 0.5, 1.0, 1.5, 2.5, 255.5, 256.0, 511.0, 511.5, 511.49, 65408.0, 65535.0, 1e30];
    for scale in -40..20 {
        for a in ties {
            for b in ties {
                let rgb = [a, b, 300.5].map(|x| libm::ldexpf(x, scale));
                assert_eq!(to_rgb9e5(rgb.map(f32::to_bits)), shared_exponent(rgb), "{rgb:?}");
            }
        }
    }
    for _ in 0..200_000 {
        let rgb = [0; 3].map(|_: u32| f32::from_bits(next() >> 1));
        let near = [rgb[0], libm::ldexpf(rgb[0], -3), libm::ldexpf(rgb[0], -8)];
        for rgb in [rgb, near] {
            if rgb.iter().all(|x| x.is_finite()) {
                assert_eq!(to_rgb9e5(rgb.map(f32::to_bits)), shared_exponent(rgb), "{rgb:?}");
            }
        }
    }
    assert_eq!(to_rgb9e5([f32::INFINITY.to_bits(), 0, 0]), ([511, 0, 0], 16));
}

fn config(format: TexelFormat, int: u32, frac: u32) -> Config {
    Config::default().with(|p| {
        p.texel.format = format;
        p.texel.int = int;
        p.texel.frac = frac;
    })
}

#[test]
fn unorm8_texels_are_the_nearest_255ths() {
    let unit = config(TexelFormat::Unorm8, 1, 24);
    for code in 0..=255u32 {
        let x = code as f32 / 255.0;
        let [got, ..] = decode(&unit, [x.to_bits(); 3]);
        // |got − code/255·2^24| ≤ ½.
        let doubled = (2 * 255 * got - 2 * i64::from(code) * (1 << 24)).abs();
        assert!(doubled <= 255, "{code}");
        // Just past half a step it is the next code.
        let edge = libm::nextafterf((f64::from(code) + 0.5) as f32 / 255.0, 2.0) * 1.000_001;
        let [next, ..] = decode(&unit, [edge.to_bits(); 3]);
        let want = (code + 1).min(255);
        assert!((2 * 255 * next - 2 * i64::from(want) * (1 << 24)).abs() <= 255, "{code}");
    }
    let decoded = |x: f32| decode(&unit, [x.to_bits(); 3])[0];
    assert_eq!(decoded(7.0), 1 << 24);
    assert_eq!(decoded(f32::INFINITY), 1 << 24);
    assert_eq!(decoded(-1.0), 0);
    assert_eq!(decoded(f32::NAN), 0);
}

#[test]
fn q_texels_are_rounded_to_even_and_saturate() {
    let unit = config(TexelFormat::Q, 4, 8);
    let decoded = |x: f32| decode(&unit, [x.to_bits(); 3])[0];
    for k in 0..4095 {
        let lsb = 1.0 / 256.0;
        let x = k as f32 * lsb;
        assert_eq!(decoded(x), k);
        let tie = if k % 2 == 0 { k } else { k + 1 };
        assert_eq!(decoded(x + lsb / 2.0), tie.min(4095), "{k} and a half");
    }
    for big in [15.999, 16.0, 1e38, f32::INFINITY] {
        assert_eq!(decoded(big), 4095);
    }
}

#[test]
fn half_texels_are_kept_only_where_the_datapath_holds_them_all() {
    assert!(keeps_half(&config(TexelFormat::Half, 16, 24)));
    assert!(!keeps_half(&config(TexelFormat::Half, 15, 24)));
    assert!(!keeps_half(&config(TexelFormat::Half, 17, 23)));
    assert!(!keeps_half(&config(TexelFormat::Q, 17, 24)));
    let unit = config(TexelFormat::Half, 17, 24);
    for word in (0..=0x7bffu16).step_by(7) {
        let value = f16::from_bits(word).to_f32();
        assert_eq!(decode(&unit, [value.to_bits(); 3]), [half_to_q24(word); 3]);
    }
}

proptest! {
    #[test]
    fn a_decoded_texel_never_leaves_its_range(
        words in prop::array::uniform3(any::<u32>()),
        int in 1u32..=17,
        frac in 4u32..=24,
    ) {
        for &format in TexelFormat::ALL {
            for texel in decode(&config(format, int, frac), words) {
                prop_assert!((0..1 << (int + frac)).contains(&texel), "{:?} {}", format, texel);
            }
        }
    }
}
