//! The elliptical Gaussian of the float reference.
#![expect(clippy::float_cmp, reason = "what is exact by construction is compared exactly")]

use support::reference::{Draw, Random, map, noise, plain};
use tapline::cube::{direction, face_uv};
use tapline::reference::address::Address;
use tapline::reference::{Env, NoTap, Prepared, Texture, env, ewa, ewa_counted};
use tapline::settings::Settings;

/// The definition of ewa, literally: every lattice point for four faces around, the full quadratic form.
fn brute_force(out: &Env, texture: &Texture) -> [f64; 3] {
    let size = texture.size();
    let n = i32::try_from(size).unwrap();
    let h = 2.0 / f64::from(n);
    let t = h * h / 6.0;
    let (a, b, c) = (out.k[0] / 12.0 + t, out.k[1] / 12.0, out.k[2] / 12.0 + t);
    let det = a * c - b * b;
    let (mut sum, mut total) = ([0.0; 3], 0.0);
    for j in -4 * n..5 * n {
        for i in -4 * n..5 * n {
            let [u, v] = [i, j].map(|t| (f64::from(t) + 0.5) * h - 1.0);
            let (x, y) = (u - out.u, v - out.v);
            let q = (c * x * x - 2.0 * b * x * y + a * y * y) / det;
            if q > 9.0 {
                continue;
            }
            let (face, u, v) = face_uv(direction(out.face, u, v));
            let value = texture.bilinear(0, Address { face, u, v });
            let weight = libm::exp(-q / 2.0);
            total += weight;
            for k in 0..3 {
                sum[k] += weight * value[k];
            }
        }
    }
    sum.map(|x| x / total)
}

#[test]
fn ewa_is_the_sum_of_its_definition() {
    let mut random = Random::new(24);
    let mut large = 0;
    for size in [1usize, 2, 7, 16] {
        let cube = noise(size, 25);
        let texture = Texture::new(&cube);
        for _ in 0..40 {
            let mut f = plain([random.signed(), random.signed(), 1.0]);
            f.dv_dx = random.vector().map(|x| 2.0 * x);
            f.dv_dy = random.vector();
            let out = env(&Prepared::new(&Settings::default()), &f, size, None, &mut NoTap);
            let got = ewa_counted(&out, &texture);
            assert_eq!(got.level, 0);
            large += usize::from(got.points > 100);
            for (got, want) in got.color.into_iter().zip(brute_force(&out, &texture)) {
                // At most 2¹³ points of value ≤ 1 in two orders, bilinear at texel centres (2⁻⁵⁰), and
                // exponents ≤ 4.5 off by cond(Σ) ≤ 2¹² roundings: below 2⁻³⁶.
                assert!((got - want).abs() <= 2f64.powi(-36), "{size}: {got} {want}");
            }
        }
    }
    assert!(large > 20, "{large}");
}

#[test]
fn ewa_of_a_constant_map_is_that_constant() {
    let cube = map(32, |_, _, _| [0.3, 7.0, 65504.0]);
    let texture = Texture::new(&cube);
    let mut random = Random::new(26);
    for _ in 0..200 {
        let out =
            env(&Prepared::new(&Settings::default()), &random.fragment(), 32, None, &mut NoTap);
        let got = ewa_counted(&out, &texture);
        // Two sums of positive terms, each within points·2⁻⁵³ of itself, relatively, plus the division.
        let bound = (2.0 * got.points as f64 + 4.0) * f64::EPSILON;
        for (got, want) in got.color.into_iter().zip([0.3f32, 7.0, 65504.0]) {
            let want = f64::from(want);
            assert!((got - want).abs() <= bound * want, "{got} {want}");
        }
    }
}

#[test]
fn ewa_of_an_isotropic_footprint_sees_the_same_at_equal_distances() {
    // One bright texel at four places around the centre texel's centre.
    let size = 33;
    let see = |dx: i32, dy: i32| {
        let at = [16 + dx, 16 + dy].map(|t| usize::try_from(t).unwrap());
        let cube = map(size, |face, x, y| [f32::from(u8::from(face == 4 && [x, y] == at)); 3]);
        let mut f = plain([0.0, 0.0, 1.0]);
        f.dv_dx = [0.5, 0.0, 0.0];
        f.dv_dy = [0.0, 0.5, 0.0];
        let out = env(&Prepared::new(&Settings::default()), &f, size, None, &mut NoTap);
        assert_eq!(out.k[0], out.k[2]);
        ewa(&out, &Texture::new(&cube))[0]
    };
    let centre = see(0, 0);
    for r in 1..8 {
        let first = see(r, 0);
        // Σ = K/12 + h²/6 = (0.25·16.5²/12 + 1/6) texels², the weight e^(−r²/2Σ) to 2⁷ roundings
        // (runs of 16 weights follow from one another), twice, and some for the centre.
        let variance = 0.25 * 16.5 * 16.5 / 12.0 + 1.0 / 6.0;
        let want = centre * libm::exp(-f64::from(r * r) / 2.0 / variance);
        let want = if f64::from(r * r) / variance > 9.0 { 0.0 } else { want };
        for (dx, dy) in [(r, 0), (-r, 0), (0, r), (0, -r)] {
            let got = see(dx, dy);
            assert!((got - first).abs() <= 256.0 * f64::EPSILON * first);
            assert!((got - want).abs() <= 256.0 * f64::EPSILON * want, "{got} {want}");
        }
    }
    assert!(centre > 0.0);
}

#[test]
fn ewa_takes_a_coarser_lattice_where_the_ellipse_holds_too_many_texels() {
    let cube = noise(256, 27);
    let texture = Texture::new(&cube);
    for size in [0.5, 1.0, 8.0, 1e6, 1e150] {
        let mut f = plain([0.0, 0.0, 1.0]);
        f.dv_dx = [size, 0.0, 0.0];
        f.dv_dy = [0.0, size, 0.0];
        let out = env(&Prepared::new(&Settings::default()), &f, 256, None, &mut NoTap);
        let got = ewa_counted(&out, &texture);
        // σ = size·128/√12 texels (128 to the unit) over 2^level below √(256 − 1/6):
        // level > log2(size·128/√12/15.995) = log2(size) + 1.208; then 9π·256 points at most fill the
        // ellipse, and half a point's row more around it.
        let want = (libm::log2(size) + 1.208).ceil().max(0.0);
        assert_eq!(f64::from(got.level), want, "{size}");
        assert!(got.points <= 7_600, "{}", got.points);
        assert!(got.color.iter().all(|x| (0.0..=1.0).contains(x)));
    }
}

#[test]
fn errata_scale_root_12_makes_k_over_12_hold_the_roughness_covariance_itself() {
    let mut random = Random::new(28);
    for _ in 0..100 {
        let mut f = random.fragment();
        for d in [&mut f.dv_dx, &mut f.dv_dy, &mut f.dn_dx, &mut f.dn_dy] {
            *d = [0.0; 3];
        }
        f.rough = Some(random.vector());
        let k = |scale: f64| {
            let settings = Settings { roughness_scale: scale, ..Settings::default() };
            env(&Prepared::new(&settings), &f, 256, None, &mut NoTap).k
        };
        let (paper, matched) = (k(1.0), k(12f64.sqrt()));
        let trace = paper[0] + paper[2];
        for (p, m) in paper.into_iter().zip(matched) {
            // s² = 12 to one rounding of s, squared; sums of four squares: 16 roundings of the trace.
            assert!((m / 12.0 - p).abs() <= 16.0 * f64::EPSILON * trace);
        }
    }
}

#[test]
fn errata_the_covariance_of_the_appendix_has_n_terms() {
    // Sum i = 0..n is n + 1 terms: with 1/n the mean of a constant is off, and its variance not zero.
    let b = [0.75; 9];
    let covariance = |terms: usize, divisor: f64| {
        let mean = b[..terms].iter().sum::<f64>() / divisor;
        b[..terms].iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / divisor
    };
    assert_eq!(covariance(8, 8.0), 0.0);
    assert!(covariance(9, 8.0) > 0.0);
}
