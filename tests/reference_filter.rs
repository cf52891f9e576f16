//! Probe weights, the filter and the elliptical Gaussian of the float reference.
#![expect(
    clippy::float_cmp,
    reason = "what is exact by construction is compared exactly"
)]

mod reference_support;

use reference_support::{Random, apply, map};
use tapline::cube::{CubeMap, direction, face_uv};
use tapline::fragment::Fragment;
use tapline::policy::{Axis, Count, Weights};
use tapline::reference::address::Address;
use tapline::reference::{Env, NoTap, Prepared, Texture, env, ewa, ewa_counted, probe_weights};
use tapline::settings::Settings;

/// A map of random texels in 0…1, multiples of 1/256: sums of four halve exactly in floats.
fn noise(size: usize, seed: u64) -> CubeMap {
    let mut random = Random::new(seed);
    let texels: Vec<[f32; 3]> = (0..6 * size * size)
        .map(|_| {
            #[expect(clippy::cast_possible_truncation, reason = "texels are floats")]
            random
                .vector()
                .map(|x| (x * 128.0 + 128.0).floor() as f32 / 256.0)
        })
        .collect();
    map(size, |face, x, y| texels[(face * size + y) * size + x])
}

fn plain(v: [f64; 3]) -> Fragment {
    Fragment {
        v,
        n: v,
        dv_dx: [0.0; 3],
        dv_dy: [0.0; 3],
        dn_dx: [0.0; 3],
        dn_dy: [0.0; 3],
        h: None,
        bump: None,
        rough: None,
    }
}

#[test]
fn probe_weights_sum_to_the_power_of_two_and_fall_from_the_middle() {
    for end_points in [false, true] {
        for bits in 0..=20 {
            for count in 1..=64u32 {
                let weights = probe_weights(count, bits, end_points);
                assert_eq!(weights.len(), count as usize);
                let sum: u64 = weights.iter().map(|&w| u64::from(w)).sum();
                assert_eq!(sum, 1 << bits, "{count} probes, {bits} bits");
                let middle = (count as usize - 1) / 2;
                // Eight bits and more never need the other rounding for these counts.
                let error = if bits >= 8 { 0.5 } else { 1.0 };
                let half_line = f64::from(if end_points {
                    (count - 1).max(1)
                } else {
                    count
                });
                let bell = |i: usize| {
                    let x = (2.0 * i as f64 + 1.0 - f64::from(count)) / half_line;
                    libm::exp(-2.0 * x * x)
                };
                let total: f64 = (0..count as usize).map(bell).sum();
                for (i, &w) in weights.iter().enumerate() {
                    if i != middle {
                        let exact = bell(i) / total * f64::from(1u32 << bits);
                        assert!((f64::from(w) - exact).abs() <= error + 1e-9);
                        let mirrored = count as usize - 1 - i;
                        assert!(mirrored == middle || weights[mirrored] == w);
                    }
                }
            }
        }
    }
}

#[test]
fn probe_weights_of_a_few_counts_are_these() {
    assert_eq!(probe_weights(1, 8, false), [256]);
    assert_eq!(probe_weights(2, 8, false), [128, 128]);
    // e^(−8/9) = 0.41111: 57.75, 140.49, 57.75 of 256 → 58, 140, 58.
    assert_eq!(probe_weights(3, 8, false), [58, 140, 58]);
    // With end points x = ±1: e^−2 = 0.13534: 27.27, 201.47, 27.27 → 27, 201, 27 and 1 left over.
    assert_eq!(probe_weights(3, 8, true), [27, 202, 27]);
    // The residue goes to the lower of two middle probes: 30.8, 97.2 → … of 2^1: 0, 1, 1, 0.
    assert_eq!(probe_weights(16, 1, false)[7], 2);
}

#[test]
fn a_footprint_inside_a_face_of_a_ramp_has_the_value_of_its_centre() {
    // Texels rise by 1 per column: every mip level and every symmetric line of probes keeps the ramp.
    let size = 64;
    let cube = map(size, |_, x, y| {
        [x, y, x + 2 * y].map(|t| u8::try_from(t).map_or(0.0, f32::from))
    });
    let texture = Texture::new(&cube);
    let mut random = Random::new(21);
    let mut several = 0;
    for case in 0..2000 {
        let settings = Settings {
            count: Count::ALL[case % 4],
            weights: Weights::ALL[case / 4 % 2],
            axis: [Axis::EigenExact, Axis::LongerDerivative][case / 8 % 2],
            ..Settings::default()
        };
        let weights_are_symmetric = settings.weights == Weights::Box;
        let mut f = plain([0.2 * random.signed(), 0.2 * random.signed(), 1.0]);
        f.dv_dx = random.vector().map(|x| 0.05 * x);
        f.dv_dy = random.vector().map(|x| 0.005 * x);
        let out = env(
            &Prepared::new(&settings),
            &f,
            size,
            Some(&texture),
            &mut NoTap,
        );
        // With |u|, |v| ≤ 0.2, λ1 ≤ 0.3 and levels up to 8 texels (¼ of a face) wide all taps are inside.
        assert!(out.lambda[0] < 0.3 && out.lod < 3.0 && out.face == 4);
        several += usize::from(out.probes > 1);
        let [x, y] = [out.u, out.v].map(|u| (u + 1.0) * 32.0 - 0.5);
        // Values below 256; at most 16 probes of 12 roundings each. Integer weights of an even number of
        // probes may put a residue on one of the two middle probes: 8 of 256 at most (½ each), times
        // half a spacing (λ1·32/4 texels at most 2.4), times 3 for the third channel.
        let bound = if weights_are_symmetric {
            0.0
        } else {
            8.0 / 256.0 * 2.4 * 3.0
        };
        for (got, want) in out.color.into_iter().zip([x, y, x + 2.0 * y]) {
            assert!(
                (got - want).abs() <= bound + 256.0 * 192.0 * f64::EPSILON,
                "{got} {want}"
            );
        }
    }
    assert!(several > 500, "{several}");
}

/// The 48 signed permutations of the axes.
fn symmetries() -> Vec<[[f64; 3]; 3]> {
    let mut all = vec![];
    for order in [
        [0, 1, 2],
        [0, 2, 1],
        [1, 0, 2],
        [1, 2, 0],
        [2, 0, 1],
        [2, 1, 0],
    ] {
        for signs in 0..8u32 {
            let mut matrix = [[0.0; 3]; 3];
            for (row, axis) in order.into_iter().enumerate() {
                matrix[row][axis] = if signs >> row & 1 == 1 { -1.0 } else { 1.0 };
            }
            all.push(matrix);
        }
    }
    all
}

#[test]
fn the_cubes_48_symmetries_turn_fragments_maps_and_colors_alike() {
    let size = 16;
    let cube = noise(size, 22);
    let half = size as f64 / 2.0;
    let mut random = Random::new(23);
    let fragments: Vec<_> = (0..40)
        .map(|_| {
            let mut f = random.fragment();
            for d in [&mut f.dv_dx, &mut f.dv_dy, &mut f.dn_dx, &mut f.dn_dy] {
                *d = d.map(|x| x * 0.05);
            }
            f
        })
        .collect();
    let prepared = Prepared::new(&Settings::default());
    let texture = Texture::new(&cube);
    let mut several = 0;
    for matrix in symmetries() {
        let inverse: [[f64; 3]; 3] = std::array::from_fn(|i| std::array::from_fn(|j| matrix[j][i]));
        let turned_map = map(size, |face, x, y| {
            let [u, v] = [x, y].map(|t| (t as f64 + 0.5) / half - 1.0);
            let (face, u, v) = face_uv(apply(&inverse, direction(face, u, v)));
            let [x, y] = [u, v].map(|u| {
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "a texel's index"
                )]
                let index = ((u + 1.0) * half) as usize;
                index
            });
            cube.levels[0].texel(face, x, y)
        });
        let turned_texture = Texture::new(&turned_map);
        for f in &fragments {
            let g = Fragment {
                v: apply(&matrix, f.v),
                n: apply(&matrix, f.n),
                dv_dx: apply(&matrix, f.dv_dx),
                dv_dy: apply(&matrix, f.dv_dy),
                dn_dx: apply(&matrix, f.dn_dx),
                dn_dy: apply(&matrix, f.dn_dy),
                ..*f
            };
            let a = env(&prepared, f, size, Some(&texture), &mut NoTap);
            let b = env(&prepared, &g, size, Some(&turned_texture), &mut NoTap);
            several += usize::from(a.probes > 1);
            assert_eq!(a.probes, b.probes);
            // Sums are added in another order: some 2⁶ roundings of terms below 2⁶ in D (as D ≤ 2⁶ here),
            // relative to the texel (size/2 per unit, values and slopes ≤ 1 and ≤ size): 2⁻³⁴.
            for (a, b) in a.color.into_iter().zip(b.color) {
                assert!((a - b).abs() <= 2f64.powi(-34), "{a} {b} {matrix:?} {f:?}");
            }
            assert!((a.lambda[0] - b.lambda[0]).abs() <= 2f64.powi(-41));
            let mean = ewa(&a, &texture);
            let turned = ewa(&b, &turned_texture);
            for (a, b) in mean.into_iter().zip(turned) {
                // At most 2¹² points here; a point at the cut counts for at most e^(−4.5) of the middle and
                // enters or leaves only within rounding of it, which this seed does not meet.
                assert!((a - b).abs() <= 2f64.powi(-34));
            }
        }
    }
    assert!(several > 100);
}

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
            let out = env(
                &Prepared::new(&Settings::default()),
                &f,
                size,
                None,
                &mut NoTap,
            );
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
        let out = env(
            &Prepared::new(&Settings::default()),
            &random.fragment(),
            32,
            None,
            &mut NoTap,
        );
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
        let cube = map(size, |face, x, y| {
            [f32::from(u8::from(face == 4 && [x, y] == at)); 3]
        });
        let mut f = plain([0.0, 0.0, 1.0]);
        f.dv_dx = [0.5, 0.0, 0.0];
        f.dv_dy = [0.0, 0.5, 0.0];
        let out = env(
            &Prepared::new(&Settings::default()),
            &f,
            size,
            None,
            &mut NoTap,
        );
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
        let want = if f64::from(r * r) / variance > 9.0 {
            0.0
        } else {
            want
        };
        for (dx, dy) in [(r, 0), (-r, 0), (0, r), (0, -r)] {
            let got = see(dx, dy);
            assert!((got - first).abs() <= 256.0 * f64::EPSILON * first);
            assert!(
                (got - want).abs() <= 256.0 * f64::EPSILON * want,
                "{got} {want}"
            );
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
        let out = env(
            &Prepared::new(&Settings::default()),
            &f,
            256,
            None,
            &mut NoTap,
        );
        let got = ewa_counted(&out, &texture);
        // 9π·K/12 texels² of area (K = size², 128 texels to the unit) over 4^level at most 65536:
        // level ≥ log2(size·128·√(9π/12)/256) = log2(size) − 0.38.
        let want = (libm::log2(size) - 0.38).ceil().max(0.0);
        assert_eq!(f64::from(got.level), want, "{size}");
        assert!(got.points <= 70_000, "{}", got.points);
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
            let settings = Settings {
                roughness_scale: scale,
                ..Settings::default()
            };
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
fn errata_k_is_d_times_its_transpose() {
    let mut random = Random::new(29);
    let mut transposed_differs = 0;
    for _ in 0..200 {
        let f = random.fragment();
        let out = env(
            &Prepared::new(&Settings::default()),
            &f,
            256,
            None,
            &mut NoTap,
        );
        let [[p, q], [r, s]] = out.d;
        let det = (p * s - q * r) * (p * s - q * r);
        let condition = (out.k[0] + out.k[2]) * (out.k[0] + out.k[2]) / det;
        if condition > 1e6 {
            continue;
        }
        for step in 0..12 {
            let angle = f64::from(step) * 0.5;
            let (c, sn) = (libm::cos(angle), libm::sin(angle));
            let x = [p * c + q * sn, r * c + s * sn];
            let form = |[a, b, c]: [f64; 3]| {
                (c * x[0] * x[0] - 2.0 * b * x[0] * x[1] + a * x[1] * x[1]) / det
            };
            // Terms of the form are below `condition`, with some 32 roundings.
            let bound = 32.0 * f64::EPSILON * condition;
            assert!((form(out.k) - 1.0).abs() <= bound);
            let printed = [p * p + r * r, p * q + r * s, q * q + s * s];
            transposed_differs += usize::from((form(printed) - 1.0).abs() > 0.1);
        }
    }
    assert!(transposed_differs > 500, "{transposed_differs}");
}

#[test]
fn errata_the_covariance_of_the_appendix_has_n_terms() {
    // Sum i = 0..n is n + 1 terms: with 1/n the mean of a constant is off, and its variance not zero.
    let b = [0.75; 9];
    let covariance = |terms: usize, divisor: f64| {
        let mean = b[..terms].iter().sum::<f64>() / divisor;
        b[..terms]
            .iter()
            .map(|x| (x - mean) * (x - mean))
            .sum::<f64>()
            / divisor
    };
    assert_eq!(covariance(8, 8.0), 0.0);
    assert!(covariance(9, 8.0) > 0.0);
}

/// A 2×2 symmetric eigenproblem by one Jacobi rotation, whose tangent solves t² + 2θt − 1 = 0.
fn jacobi([a, b, c]: [f64; 3]) -> ([f64; 2], [f64; 2]) {
    let (t, cos) = if b == 0.0 {
        (0.0, 1.0)
    } else {
        let theta = (c - a) / (2.0 * b);
        let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
        (t, 1.0 / (t * t + 1.0).sqrt())
    };
    let sin = t * cos;
    // Columns (cos, −sin) and (sin, cos) belong to a − tb and c + tb.
    let (first, second) = (a - t * b, c + t * b);
    if first > second {
        ([first, second], [cos, -sin])
    } else {
        ([second, first], [sin, cos])
    }
}

#[test]
fn eigen_agrees_with_a_jacobi_rotation() {
    let mut random = Random::new(30);
    for case in 0..2000 {
        let [a, c] = [random.signed().abs(), random.signed().abs()];
        let k = [a, random.signed() * (a * c).sqrt(), c];
        let ([major, minor], [x, y]) = jacobi(k);
        let policy = (Axis::EigenExact, tapline::policy::Minor::ALL[case % 2]);
        let got =
            tapline::reference::eigen::eigen::<f64, _>(k, [None; 2], policy, None, &mut NoTap);
        // Eight roundings of terms below a + c on both sides; λ2² under either formula likewise.
        let bound = 32.0 * f64::EPSILON * (a + c);
        assert!((got.lambda[0] * got.lambda[0] - major).abs() <= bound);
        assert!((got.lambda[1] * got.lambda[1] - minor.max(0.0)).abs() <= bound);
        // The axis moves by the error over the gap of the eigenvalues.
        let sine = got.axis[0] * y - got.axis[1] * x;
        assert!(
            sine.abs() <= bound / (major - minor) + 8.0 * f64::EPSILON,
            "{k:?}"
        );
        assert!((got.axis[0].hypot(got.axis[1]) - 1.0).abs() <= 4.0 * f64::EPSILON);
        assert!(got.axis[0] > 0.0);
    }
}

#[test]
fn longer_derivative_takes_the_longest_column() {
    let settings = Settings {
        axis: Axis::LongerDerivative,
        ..Settings::default()
    };
    let mut f = plain([0.0, 0.0, 1.0]);
    // n = v: ∂v_r = ∂v·(2nnᵀ − I): D = −(∂v).
    f.dv_dx = [-0.25, 0.0, 0.0];
    f.dv_dy = [0.375, -0.5, 0.0];
    let out = env(&Prepared::new(&settings), &f, 256, None, &mut NoTap);
    let [[_, x], [_, y]] = out.d;
    assert_eq!((x.abs(), y.abs()), (0.375, 0.5));
    assert_eq!(out.lambda, [0.625, 0.25]);
    assert!((out.axis[1] / out.axis[0] - y / x).abs() <= 4.0 * f64::EPSILON && out.axis[0] > 0.0);
}

#[test]
#[ignore = "a measurement, not a test: run with --ignored --nocapture"]
fn speed_of_the_filter_path() {
    let cube = noise(256, 31);
    let texture = Texture::new(&cube);
    let prepared = Prepared::new(&Settings::default());
    let mut random = Random::new(32);
    for (name, rough) in [("plain", false), ("rough", true)] {
        // A mirror sphere that fills a picture of 316 × 316 pixels, row by row.
        let mut fragments = vec![];
        for y in 0..316 {
            for x in 0..316 {
                let [x, y] = [x, y].map(|t| (f64::from(t) - 157.5) / 160.0);
                let z = 1.0 - x * x - y * y;
                if z <= 0.0 {
                    continue;
                }
                let z = z.sqrt();
                let mut f = plain([-x, -y, 4.0]);
                f.n = [x, y, z];
                f.dv_dx = [-1.0 / 160.0, 0.0, 0.0];
                f.dv_dy = [0.0, -1.0 / 160.0, 0.0];
                f.dn_dx = [1.0 / 160.0, 0.0, -x / z / 160.0];
                f.dn_dy = [0.0, 1.0 / 160.0, -y / z / 160.0];
                f.h = Some([0.0, 1.0, 0.0]);
                if rough {
                    f.bump = Some([0.1 * random.signed(), 0.1 * random.signed()]);
                    f.rough = Some([0.05, 0.01, 0.02]);
                }
                fragments.push(f);
            }
        }
        let count = fragments.len() as f64;
        let nanoseconds = |start: std::time::Instant| start.elapsed().as_secs_f64() * 1e9 / count;
        let start = std::time::Instant::now();
        let probes: f64 = fragments
            .iter()
            .map(|f| env(&prepared, f, 256, Some(&texture), &mut NoTap))
            .map(|out| f64::from(out.probes) + 1e-300 * out.color[0])
            .sum();
        let whole = nanoseconds(start);
        let start = std::time::Instant::now();
        let level: f64 = fragments
            .iter()
            .map(|f| env(&prepared, f, 256, None, &mut NoTap).lod)
            .sum();
        let front = nanoseconds(start);
        let outs: Vec<_> = fragments
            .iter()
            .map(|f| env(&prepared, f, 256, None, &mut NoTap))
            .collect();
        let start = std::time::Instant::now();
        let points: u64 = outs
            .iter()
            .map(|out| ewa_counted(out, &texture).points)
            .sum();
        let elliptical = nanoseconds(start);
        eprintln!(
            "{name}: {whole:.0} ns a fragment, {front:.0} without texture; {:.2} probes, LOD {:.2}; \
             ewa {elliptical:.0} ns, {:.0} points",
            probes / count,
            level / count,
            points as f64 / count
        );
    }
}
