//! The roughness pyramid against sums written out, without any file.
#![expect(
    clippy::unwrap_used,
    reason = "a test stops at the first thing that is not as it should be"
)]

use std::sync::Arc;

use proptest::prelude::*;
use tapline::policy::{Curvature, RoughnessInterpolation};
use tapline::scene::bump::BumpMap;
use tapline::scene::pyramid::{Pyramid, factors};

const EPS: f64 = f64::EPSILON;

/// Offsets in eighths, so that sums over few texels are exact.
fn map(width: usize, height: usize) -> BumpMap {
    let mut state = 1u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f32::from((state >> 24) as u8) / 32.0 - 4.0
    };
    let values: Vec<[f32; 2]> = (0..width * height).map(|_| [next(), next()]).collect();
    BumpMap::from_offsets(width, height, &values).unwrap()
}

fn pyramid(map: BumpMap, curvature: Curvature, interpolation: RoughnessInterpolation) -> Pyramid {
    Pyramid::new(Arc::new(map), curvature, interpolation)
}

fn plain(map: BumpMap) -> Pyramid {
    pyramid(map, Curvature::Pyramid, RoughnessInterpolation::Moments)
}

/// Mean and raw second moments over the exact area of a texel, one sample per 1/(w·h) part.
fn brute(map: &BumpMap, [width, height]: [usize; 2], x: usize, y: usize) -> [f64; 5] {
    // The side is cut into size × count parts: a texel of level 0 has `count` of them, one of the level
    // has `size`.
    let parts =
        |i: usize, count: usize, size: usize| (i * size..(i + 1) * size).map(move |p| p / count);
    let mut sums = [0.0; 5];
    for row in parts(y, height, map.height()) {
        for column in parts(x, width, map.width()) {
            let [b1, b2] = map.texel(column, row);
            for (sum, value) in sums.iter_mut().zip([b1, b2, b1 * b1, b1 * b2, b2 * b2]) {
                *sum += value;
            }
        }
    }
    sums.map(|sum| sum / (map.width() * map.height()) as f64)
}

#[test]
fn every_level_holds_the_moments_of_all_texels_that_it_covers() {
    for (width, height) in [(8, 8), (16, 4), (1, 8), (7, 5), (13, 13), (31, 1)] {
        let pyramid = plain(map(width, height));
        let top = pyramid.levels() - 1;
        assert_eq!(pyramid.size(top), [1, 1]);
        for level in 1..=top {
            let [columns, rows] = pyramid.size(level);
            assert_eq!([columns, rows], [(width >> level).max(1), (height >> level).max(1)]);
            for y in 0..rows {
                for x in 0..columns {
                    let m = brute(pyramid.map(), [columns, rows], x, y);
                    let want = [m[2] - m[0] * m[0], m[3] - m[0] * m[1], m[4] - m[1] * m[1]];
                    let got = pyramid.texel(level, x, y);
                    // |b| ≤ 4 per component: a second moment is at most 16; sums of at most 169 × 169
                    // parts in order lose 28561·eps·16 at worst, the square of the mean as much.
                    let bound = 2.0 * (width * width * height * height) as f64 * EPS * 16.0;
                    assert!(
                        (got.mean[0] - m[0]).abs() <= bound && (got.mean[1] - m[1]).abs() <= bound
                    );
                    for (got, want) in got.covariance.iter().zip(want) {
                        assert!((got - want).abs() <= bound, "{width}x{height} level {level}");
                    }
                }
            }
        }
        assert!(pyramid.texel(top, 0, 0).covariance[0] > 1.0);
    }
}

#[test]
fn a_power_of_two_level_covers_squares_of_texels() {
    // Level 1, texel (1, 0) of a 4 × 4 map: columns 2, 3 of rows 0, 1. Offsets are eighths of whole
    // numbers: exact.
    let map = map(4, 4);
    let four = [(2, 0), (3, 0), (2, 1), (3, 1)].map(|(x, y)| map.texel(x, y)[0]);
    let mean = four.iter().sum::<f64>() / 4.0;
    let variance = four.iter().map(|b| (b - mean) * (b - mean)).sum::<f64>() / 4.0;
    let got = plain(map).texel(1, 1, 0);
    assert_eq!(got.mean[0].to_bits(), mean.to_bits());
    assert_eq!(got.covariance[0].to_bits(), variance.to_bits());
}

#[test]
fn a_constant_map_has_no_roughness_at_any_level() {
    let map = BumpMap::from_offsets(6, 9, &[[0.1, -0.7]; 54]).unwrap();
    for interpolation in [RoughnessInterpolation::Moments, RoughnessInterpolation::Factors] {
        for curvature in [Curvature::Pyramid, Curvature::Surface] {
            let pyramid = pyramid(map.clone(), curvature, interpolation);
            for lod in [0.0, 0.3, 1.0, 2.5, 3.0] {
                let got = pyramid.look_up(0.3, 0.9, lod);
                // A mean of equal numbers is off by some roundings of weights that sum to 1.
                let bound = 64.0 * EPS;
                assert!((got.bump[0] - f64::from(0.1f32)).abs() <= bound);
                assert!(got.rough.iter().all(|d| d.abs() <= bound), "{:?}", got.rough);
            }
        }
    }
}

#[test]
fn a_covariance_about_a_large_mean_does_not_cancel() {
    // Offsets 8 ± 2^-20: the variance is 2^-40, beside a squared mean of 64 = 2^6. Raw moments in
    // doubles would keep 2^-46·64 of it: 1 part in 64.
    let small = f32::EPSILON * 8.0;
    let values: Vec<[f32; 2]> = (0..64u8)
        .map(|i| if i % 2 == 0 { [8.0 + small, 8.0] } else { [8.0 - small, 8.0] })
        .collect();
    let got = plain(BumpMap::from_offsets(8, 8, &values).unwrap()).texel(3, 0, 0);
    let want = f64::from(small) * f64::from(small);
    assert!((got.covariance[0] - want).abs() <= 1e-9 * want);
    assert!(got.covariance[2].abs() <= 0.0);
}

#[test]
fn moments_interpolate_as_raw_moments_do() {
    let pyramid = plain(map(16, 16));
    for (s, t, lod) in [(0.1, 0.7, 1.5), (0.93, 0.02, 2.25), (0.5, 0.5, 0.5), (0.3, 0.3, 3.9)] {
        let got = pyramid.look_up(s, t, lod);
        // Raw moments by hand: bilinear on the two levels, then between them.
        let whole = if lod >= 3.0 {
            3
        } else if lod >= 2.0 {
            2
        } else {
            usize::from(lod >= 1.0)
        };
        let mut raw = [0.0; 5];
        for (level, share) in [(whole, 1.0 - (lod - whole as f64)), (whole + 1, lod - whole as f64)]
        {
            let [width, height] = pyramid.size(level);
            for y in 0..height {
                for x in 0..width {
                    // Tent weights, with every repetition that can reach.
                    let tent = |place: f64, i: usize, size: usize| -> f64 {
                        (-2..=2)
                            .map(|turn| {
                                let d = (place + f64::from(turn)) * size as f64 - (i as f64 + 0.5);
                                (1.0 - d.abs()).max(0.0)
                            })
                            .sum()
                    };
                    let weight = share * tent(s, x, width) * tent(t, y, height);
                    let m = pyramid.texel(level, x, y);
                    let [b1, b2] = m.mean;
                    let [a, b, c] = m.covariance;
                    for (sum, value) in
                        raw.iter_mut().zip([b1, b2, a + b1 * b1, b + b1 * b2, c + b2 * b2])
                    {
                        *sum += weight * value;
                    }
                }
            }
        }
        let [m1, m2, aa, ab, bb] = raw;
        let [d1, d2, d3] = got.rough;
        // Second moments below 32; some 100 roundings.
        let bound = 100.0 * 32.0 * EPS;
        assert!((got.bump[0] - m1).abs() <= bound && (got.bump[1] - m2).abs() <= bound);
        assert!((d1 * d1 + d2 * d2 - (aa - m1 * m1)).abs() <= bound, "{s} {t} {lod}");
        assert!((d2 * d3 - (ab - m1 * m2)).abs() <= bound);
        assert!((d3 * d3 - (bb - m2 * m2)).abs() <= bound);
    }
}

#[test]
fn factors_and_moments_agree_at_texel_centres_and_differ_between() {
    let both = [RoughnessInterpolation::Moments, RoughnessInterpolation::Factors]
        .map(|interpolation| pyramid(map(16, 16), Curvature::Pyramid, interpolation));
    let [moments, factors] = both.each_ref();
    // Centre of texel (1, 2) of level 2 (4 × 4), exact in binary.
    let (a, b) = (moments.look_up(0.375, 0.625, 2.0), factors.look_up(0.375, 0.625, 2.0));
    assert_eq!(a, b);
    // Between texels the spread of the means counts with the moments only, so they are rougher. Level 0
    // has only that spread.
    let (a, b) = (moments.look_up(0.5, 0.5, 0.0), factors.look_up(0.5, 0.5, 0.0));
    assert!(a.rough[2] > 0.1);
    assert_eq!(b.rough.map(f64::to_bits), [0; 3]);
}

#[test]
fn a_linear_slope_belongs_to_the_surface_when_asked() {
    // b1 grows by 1/4 a column and b2 by −1/8 a row; away from the map's own seam there is no other
    // variation, so nothing is left for the pyramid.
    let values: Vec<[f32; 2]> =
        (0..=255u8).map(|i| [f32::from(i % 16) / 4.0, -f32::from(i / 16) / 8.0]).collect();
    let map = BumpMap::from_offsets(16, 16, &values).unwrap();
    for interpolation in [RoughnessInterpolation::Moments, RoughnessInterpolation::Factors] {
        let pyramid = pyramid(map.clone(), Curvature::Surface, interpolation);
        for lod in [0.0, 0.5, 1.0, 1.25, 2.0] {
            let got = pyramid.look_up(0.52, 0.47, lod);
            // Slopes per repetition of the map: 16 columns of 1/4. Roundings of numbers up to 8; a
            // factor is the root of a covariance.
            let bound = 256.0 * EPS * 8.0;
            assert!((got.slope[0][0] - 4.0).abs() <= bound, "{lod}: {:?}", got.slope);
            assert!((got.slope[1][1] + 2.0).abs() <= bound);
            assert!(got.slope[0][1].abs() <= bound && got.slope[1][0].abs() <= bound);
            assert!(got.rough.iter().all(|d| d * d <= bound), "{lod}: {:?}", got.rough);
        }
    }
    // The same look-up in the paper's way holds the slope as roughness: a texel of level 2 has four
    // columns 1/4 apart, variance (4² − 1)/12/16, and nothing goes to the surface.
    let kept = pyramid(map, Curvature::Pyramid, RoughnessInterpolation::Factors);
    let got = kept.look_up(0.375, 0.375, 2.0);
    assert!((got.rough[0] * got.rough[0] - 15.0 / 192.0).abs() <= 16.0 * EPS);
    assert!(got.slope.iter().flatten().all(|g| g.abs() <= 0.0));
}

#[test]
fn level_of_detail_follows_the_longer_derivative_and_is_clamped() {
    let pyramid = plain(map(16, 8));
    let lod = |x: [f64; 2], y: [f64; 2]| pyramid.lod(x, y);
    // Texels: s × 16, t × 8. 4 texels: 2; 6 and 8 across: hypotenuse 10.
    assert!((lod([0.25, 0.0], [0.0, 0.125]) - 2.0).abs() <= 4.0 * EPS);
    assert!((lod([0.0, 0.0], [6.0 / 16.0, 1.0]) - 10.0f64.log2()).abs() <= 8.0 * EPS);
    for (x, want) in
        [(0.0, 0.0), (1e-300, 0.0), (1e300, 4.0), (f64::INFINITY, 4.0), (f64::NAN, 0.0)]
    {
        assert_eq!(lod([x, 0.0], [0.0, 0.0]).to_bits(), f64::to_bits(want), "{x}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn factors_multiply_back_to_the_covariance(a in 0.0..200.0f64, c in 0.0..200.0f64, r in -1.0..1.0f64) {
        let b = r * (a * c).sqrt();
        let [d1, d2, d3] = factors([a, b, c]);
        prop_assert!(d1 >= 0.0 && d3 >= 0.0);
        // Each entry is a square root squared again, or the difference of a and b²/c ≤ a.
        let bound = 8.0 * EPS;
        prop_assert!((d1 * d1 + d2 * d2 - a).abs() <= bound * a);
        prop_assert!((d2 * d3 - b).abs() <= bound * b.abs());
        prop_assert!((d3 * d3 - c).abs() <= bound * c);
    }
}

#[test]
fn factors_of_extreme_covariances_are_finite() {
    let zero = [0.0; 3];
    for (covariance, want) in [
        ([0.0, 0.0, 0.0], zero),
        ([4.0, 0.0, 0.0], [2.0, 0.0, 0.0]),
        ([0.0, 0.0, 9.0], [0.0, 0.0, 3.0]),
        // b² > ac by one ulp.
        ([1.0, 1.0 + EPS, 1.0], [0.0, 1.0 + EPS, 1.0]),
        ([4.0, -2.0, 1.0], [0.0, -2.0, 1.0]),
        ([-EPS, 0.0, -EPS], zero),
    ] {
        assert_eq!(factors(covariance).map(f64::to_bits), want.map(f64::to_bits), "{covariance:?}");
    }
    let tiny = factors([1e-320, 1e-320, 1e-320]);
    assert!(tiny.iter().all(|d| d.is_finite()));
}
