//! Fresnel and Snell against independent forms and limits.

use glam::{DVec3, dvec3};
use tapline::optics::{fresnel, fresnel_lazanyi, refract};

/// A dozen roundings of numbers up to 10 times the result's denominator.
const BOUND: f64 = 1e-13;

/// Fresnel's equations for a dielectric by the two angles.
fn by_angles(cosine: f64, n: f64) -> f64 {
    let i = libm::acos(cosine);
    let t = libm::asin(libm::sin(i) / n);
    let s = libm::sin(i - t) / libm::sin(i + t);
    let p = libm::tan(i - t) / libm::tan(i + t);
    (s * s + p * p) / 2.0
}

#[test]
fn fresnel_agrees_with_the_form_by_angles_for_dielectrics() {
    let mut compared = 0;
    for n in [1.05, 1.3, 1.5, 2.4] {
        for k in 1..100u8 {
            let cosine = f64::from(k) / 100.0;
            // i − t cancels for n near 1: the independent form carries 1e-16/0.01 of its result.
            assert!((fresnel(cosine, n, 0.0) - by_angles(cosine, n)).abs() < 1e-12);
            compared += 1;
        }
    }
    assert_eq!(compared, 396);
}

#[test]
fn fresnel_has_its_limits() {
    for (n, k) in [(1.3f64, 0.0f64), (0.2, 3.9), (1.5, 2.0), (2.4, 0.0)] {
        let normal = ((n - 1.0) * (n - 1.0) + k * k) / ((n + 1.0) * (n + 1.0) + k * k);
        assert!((fresnel(1.0, n, k) - normal).abs() < BOUND);
        assert!((fresnel_lazanyi(1.0, n, k) - normal).abs() < BOUND);
        assert!((fresnel(0.0, n, k) - 1.0).abs() < BOUND);
        assert!((fresnel_lazanyi(0.0, n, k) - 1.0).abs() < BOUND);
    }
    // Brewster: tan i = n, only s is left, ((1 − n²)/(1 + n²))² of it.
    let n = 1.3f64;
    let s = (1.0 - n * n) / (1.0 + n * n);
    assert!((fresnel(1.0 / (1.0 + n * n).sqrt(), n, 0.0) - s * s / 2.0).abs() < BOUND);
    // Leaving glass beyond the critical angle: all of it; before it: as from the other side.
    assert!((fresnel(0.3, 1.0 / 1.3, 0.0) - 1.0).abs() < BOUND);
    let inside = 0.9f64;
    let outside = (1.0 - 1.3 * 1.3 * (1.0 - inside * inside)).sqrt();
    assert!((fresnel(inside, 1.0 / 1.3, 0.0) - fresnel(outside, 1.3, 0.0)).abs() < BOUND);
}

#[test]
fn the_papers_formula_is_schlicks_without_extinction_and_near_the_exact_one() {
    let mut worst = 0.0f64;
    for k in 0..=100u8 {
        let cosine = f64::from(k) / 100.0;
        let r0 = (0.3 / 2.3) * (0.3 / 2.3);
        let schlick = r0 + (1.0 - r0) * libm::pow(1.0 - cosine, 5.0);
        assert!((fresnel_lazanyi(cosine, 1.3, 0.0) - schlick).abs() < BOUND);
        worst = worst.max((fresnel_lazanyi(cosine, 1.3, 0.0) - fresnel(cosine, 1.3, 0.0)).abs());
    }
    // Known: Schlick's formula is off by up to a few hundredths for n = 1.3, and not exact.
    assert!(worst > 0.005 && worst < 0.1, "{worst}");
}

#[test]
fn refraction_keeps_snells_law_and_ends_at_the_critical_angle() {
    for k in 1..90u8 {
        let angle = f64::from(k).to_radians();
        let d = dvec3(libm::sin(angle), 0.0, -libm::cos(angle));
        let t = refract(d, DVec3::Z, 1.0 / 1.3).unwrap();
        assert!((t.x - d.x / 1.3).abs() < BOUND && t.z < 0.0);
        assert!((t.length_squared() - 1.0).abs() < BOUND);
        assert_eq!(refract(d, DVec3::Z, 1.3).is_none(), libm::sin(angle) * 1.3 > 1.0);
    }
}
