//! The figures that `compare` and `diff` print.
#![expect(clippy::float_cmp, reason = "values that must be exact are compared exactly")]

use tapline::picture::Picture;
use tapline::report::flip::compare_with_flip;
use tapline::report::metrics::compare;
use tapline::srgb::srgb_decode;

/// A picture of grey fragments with the given linear values.
fn greys(width: usize, values: &[f64]) -> Picture {
    let mut picture = Picture::new(width, values.len() / width);
    for (at, &value) in values.iter().enumerate() {
        picture.rgb[at] = [value; 3];
        picture.covered[at] = true;
    }
    picture
}

/// Linear light of an encoded value.
fn shown(encoded: f64) -> f64 {
    srgb_decode(encoded)
}

#[test]
fn identical_pictures_have_no_psnr_and_no_error() {
    let a = greys(2, &[0.0, 0.1, 0.5, 7.0]);
    let pair = compare(&a, &a, 0.0).unwrap();
    assert_eq!(pair.psnr_db, None);
    assert_eq!((pair.max_abs, pair.rmse, pair.rel_mse), (0.0, 0.0, 0.0));
    assert_eq!((pair.share_over_1_lsb8, pair.fragments), (0.0, 4));
}

#[test]
fn a_constant_offset_of_a_hundredth_is_40_db() {
    // Shown values differ by 0.01 everywhere: MSE 1e-4, PSNR 40 dB. Encoding after decoding is
    // within 1e-12 (see srgb.rs), so MSE is within 2e-10 of itself and PSNR within 1e-9 dB.
    let a = greys(2, &[0.31, 0.51, 0.71, 0.91].map(shown));
    let b = greys(2, &[0.30, 0.50, 0.70, 0.90].map(shown));
    let pair = compare(&a, &b, 0.0).unwrap();
    assert!((pair.psnr_db.unwrap() - 40.0).abs() < 1e-8, "{pair:?}");
    assert!((pair.rmse - 0.01).abs() < 1e-11);
    assert!((pair.max_lsb8 - 2.55).abs() < 1e-9);
    assert!((pair.mean_lsb8 - 2.55).abs() < 1e-9);
    assert!((pair.bias_lsb8 - 2.55).abs() < 1e-9);
    let back = compare(&b, &a, 0.0).unwrap();
    assert!((back.bias_lsb8 + 2.55).abs() < 1e-9, "the sign is a - b");
}

#[test]
fn relative_error_takes_the_second_picture_as_the_reference() {
    let a = greys(1, &[3.0]);
    let b = greys(1, &[2.0]);
    // (3−2)²/(2² + 1e-4) and (2−3)²/(3² + 1e-4), one rounding each in the sum and the division.
    let forth = compare(&a, &b, 0.0).unwrap().rel_mse;
    let back = compare(&b, &a, 0.0).unwrap().rel_mse;
    assert!((forth - 1.0 / 4.0001).abs() < 1e-15, "{forth}");
    assert!((back - 1.0 / 9.0001).abs() < 1e-15, "{back}");
}

#[test]
fn values_above_white_are_equal_when_shown_and_unequal_in_linear_light() {
    let pair = compare(&greys(1, &[3.0]), &greys(1, &[2.0]), 0.0).unwrap();
    assert_eq!((pair.psnr_db, pair.max_abs), (None, 0.0));
    assert!(pair.rel_mse > 0.2);
    let darker = compare(&greys(1, &[3.0]), &greys(1, &[2.0]), -2.0).unwrap();
    assert!(darker.psnr_db.is_some(), "two stops down both are below white");
}

#[test]
fn a_stop_of_exposure_doubles_the_light() {
    let a = greys(1, &[0.2]);
    let b = greys(1, &[0.1]);
    let doubled = compare(&greys(1, &[0.4]), &greys(1, &[0.2]), 0.0).unwrap();
    let exposed = compare(&a, &b, 1.0).unwrap();
    assert_eq!(exposed.max_abs, doubled.max_abs);
    assert_eq!(exposed.psnr_db, doubled.psnr_db);
}

#[test]
fn only_fragments_count() {
    let mut a = greys(2, &[0.5, 0.5, 0.5, 0.5]);
    let mut b = greys(2, &[0.5, 0.5, 0.5, 0.2]);
    let all = compare(&a, &b, 0.0).unwrap();
    assert_eq!((all.fragments, all.worst_pixel), (4, [1, 1]));
    a.covered[3] = false;
    b.covered[3] = false;
    let masked = compare(&a, &b, 0.0).unwrap();
    assert_eq!((masked.fragments, masked.psnr_db), (3, None));
    b.covered[3] = true;
    let one_sided = compare(&a, &b, 0.0).unwrap();
    assert_eq!((one_sided.fragments, one_sided.coverage_differs), (4, 1));
    assert_eq!(one_sided.max_abs, all.max_abs, "a one-sided pixel counts");
}

#[test]
fn one_8_bit_step_is_not_more_than_one_step_anywhere_on_the_curve() {
    let codes: Vec<f64> = (0..=255u8).map(|c| shown(f64::from(c) / 255.0)).collect();
    let next = compare(&greys(1, &codes[1..]), &greys(1, &codes[..255]), 0.0).unwrap();
    assert_eq!((next.share_over_1_lsb8, next.fragments), (0.0, 255));
    assert!((next.max_lsb8 - 1.0).abs() < 1e-9);
    let two = compare(&greys(1, &codes[2..]), &greys(1, &codes[..254]), 0.0).unwrap();
    assert_eq!(two.share_over_1_lsb8, 1.0);
}

#[test]
fn one_channel_off_makes_a_fragment_count_once() {
    let a = greys(2, &[0.5, 0.5, 0.5, 0.5]);
    let mut b = a.clone();
    b.rgb[2] = [0.5, 0.6, 0.7];
    let pair = compare(&a, &b, 0.0).unwrap();
    assert_eq!((pair.share_over_1_lsb8, pair.worst_pixel), (0.25, [0, 1]));
}

#[test]
fn the_first_of_equally_bad_pixels_is_named() {
    let a = greys(3, &[0.5; 9]);
    let mut b = a.clone();
    for at in [4, 5, 8] {
        b.rgb[at] = [0.25; 3];
    }
    assert_eq!(compare(&a, &b, 0.0).unwrap().worst_pixel, [1, 1]);
}

#[test]
fn figures_are_the_same_bits_for_any_number_of_threads() {
    let value = |at: u32| f64::from(at * 7919 % 1013) / 1013.0;
    let a: Vec<f64> = (0..64 * 48).map(value).collect();
    let b: Vec<f64> = (0..64 * 48).map(|at| value(at + 1)).collect();
    let (a, b) = (greys(64, &a), greys(64, &b));
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| compare(&a, &b, 0.0).unwrap())
    };
    let one = with(1);
    assert!(one.psnr_db.is_some());
    for threads in [2, 3, 7] {
        assert_eq!(with(threads), one, "{threads} threads");
    }
}

#[test]
fn pictures_that_cannot_be_compared_are_refused_with_place_and_remedy() {
    let a = greys(2, &[0.5; 4]);
    let message = |b: &Picture, exposure| compare(&a, b, exposure).unwrap_err().to_string();
    assert!(message(&greys(1, &[0.5; 4]), 0.0).contains("2x2 pixels"));
    let mut bad = a.clone();
    bad.rgb[3][1] = f64::NAN;
    assert!(message(&bad, 0.0).contains("second picture, pixel 1,1"));
    bad.rgb[3][1] = f64::INFINITY;
    assert!(message(&bad, 0.0).contains("found inf"));
    bad.covered[3] = false;
    let mut uncovered = a.clone();
    uncovered.covered[3] = false;
    assert!(compare(&uncovered, &bad, 0.0).is_ok(), "background may hold anything");
    for exposure in [f64::NAN, f64::INFINITY, 65.0, -65.0] {
        assert!(message(&a, exposure).contains("--exposure"));
    }
    let empty = Picture::new(2, 2);
    assert!(compare(&empty, &empty, 0.0).unwrap_err().to_string().contains("background"));
    let nothing = Picture::new(0, 0);
    assert!(compare_with_flip(&nothing, &nothing, 0.0).is_err());
}

#[test]
fn extreme_finite_values_give_finite_shown_figures() {
    let a = greys(2, &[f64::MAX, -f64::MAX, 0.0, 5e-324]);
    let b = greys(2, &[0.0, 1.0, -0.0, 0.0]);
    for exposure in [-64.0, 0.0, 64.0] {
        let pair = compare(&a, &b, exposure).unwrap();
        assert!(pair.rel_mse.is_finite(), "{pair:?}");
        assert!(pair.psnr_db.is_some_and(f64::is_finite) && pair.max_abs == 1.0, "{pair:?}");
    }
}

#[test]
fn flip_is_zero_for_equal_pictures_and_grows_with_the_difference() {
    let ramp: Vec<f64> = (0..24u8 * 8).map(|at| f64::from(at % 24) / 24.0).collect();
    let a = greys(24, &ramp);
    assert_eq!(compare_with_flip(&a, &a, 0.0).unwrap().flip, Some(0.0));
    let moved = |step: f64| {
        let b: Vec<f64> = ramp.iter().map(|v| v + step).collect();
        compare_with_flip(&greys(24, &b), &a, 0.0).unwrap().flip.unwrap()
    };
    let (little, much) = (moved(0.02), moved(0.2));
    assert!(0.0 < little && little < much && much < 1.0, "{little} {much}");
}

#[test]
fn the_json_object_has_the_keys_that_scripts_rely_on() {
    let a = greys(1, &[0.5]);
    let json = compare(&a, &a, 0.0).unwrap().to_json("rtl", "f64");
    for key in ["psnr_db", "max_abs", "rmse", "rel_mse", "share_over_1_lsb8"] {
        assert!(json.get(key).is_some(), "{key} is missing in {json}");
    }
    assert!(json["psnr_db"].is_null());
    assert_eq!((&json["a"], &json["b"]), (&"rtl".into(), &"f64".into()));
}
