//! Extremes of the front end on the float reference: defined, finite, and right.
#![expect(clippy::float_cmp, reason = "what is exact by construction is compared exactly")]

use support::reference::{Draw, PLAIN, Random, Strict};
use tapline::fragment::Fragment;
use tapline::reference::{Env, Flag, Flags, NoTap, Prepared, env};
use tapline::settings::Settings;

fn run(f: &Fragment) -> Env {
    env(&Prepared::new(&Settings::default()), f, 256, None, &mut NoTap)
}

#[test]
fn extreme_k_zero_gives_one_probe_on_level_0_along_u() {
    let out = run(&PLAIN);
    assert_eq!((out.k, out.lambda, out.axis), ([0.0; 3], [0.0; 2], [1.0, 0.0]));
    assert_eq!((out.probes, out.lod), (1, 0.0));
    assert!(out.flags.is_empty());
}

#[test]
fn extreme_rank_one_k_has_no_width_and_takes_all_probes() {
    // D = (3, 0; 4, 0)/8: λ1 = 5/8, λ2 = 0; every step is exact.
    let out = run(&Fragment { dv_dx: [0.0; 3], dn_dx: [0.1875, -0.25, 0.0], ..PLAIN });
    assert_eq!(out.d, [[0.375, 0.0], [0.5, 0.0]]);
    assert_eq!(out.lambda, [0.625, 0.0]);
    // The axis is a quotient of roots: two roundings.
    assert!((out.axis[0] - 0.6).abs() <= f64::EPSILON && (out.axis[1] - 0.8).abs() <= f64::EPSILON);
    assert_eq!((out.probes, out.lod), (16, libm::log2(5.0)));
}

#[test]
fn extreme_silhouette_reflects_the_view_straight_on() {
    for cosine in [1e-3, 1e-10, 1e-300, 0.0] {
        let out = run(&Fragment {
            v: [1.0, 0.0, cosine],
            dv_dx: [0.0, 0.25, 0.0],
            dn_dx: [0.5, 0.0, 0.0],
            ..PLAIN
        });
        // v_r = (−1, 0, cosine), face −x: u = cosine, exact but for one rounding of cosine.
        assert_eq!((out.face, out.v), (1, 0.0));
        assert!((out.u - cosine).abs() <= cosine * f64::EPSILON);
        // ∂v_r = (…, −¼, …); ∂u from 2⟨n,v⟩∂n + 2n⟨v,∂n⟩ = (cosine, 0, 1): ∂u = 1 + u·cosine.
        let want = 1.0 + cosine * cosine;
        assert!((out.d[0][0] - want).abs() <= 4.0 * f64::EPSILON);
        assert_eq!(out.d[1][0], 0.25);
    }
}

#[test]
fn extreme_a_normal_that_faces_away_reflects_like_its_opposite() {
    let mut random = Random::new(11);
    for _ in 0..100 {
        let f = random.fragment();
        let minus = |a: [f64; 3]| a.map(|x| -x);
        let g = Fragment { n: minus(f.n), dn_dx: minus(f.dn_dx), dn_dy: minus(f.dn_dy), ..f };
        assert_eq!(run(&f), run(&g), "every product has n twice");
    }
}

#[test]
fn extreme_no_reflected_direction_is_face_plus_z_without_derivatives() {
    for (v, n) in [([0.0; 3], [1.0, 2.0, 3.0]), ([1.0, 2.0, 3.0], [0.0; 3]), ([-0.0; 3], [-0.0; 3])]
    {
        let out = run(&Fragment {
            v,
            n,
            dv_dx: [1.0, 2.0, -3.0],
            dn_dx: [3.0, 1.0, -1.0],
            h: Some([0.0, 1.0, 0.0]),
            bump: Some([1.0, 2.0]),
            rough: Some([1.0, 2.0, 3.0]),
            ..PLAIN
        });
        assert_eq!((out.face, out.u, out.v), (4, 0.0, 0.0));
        assert_eq!((out.d, out.k), ([[0.0; 2]; 2], [0.0; 3]));
        assert!(out.flags.contains(Flag::Zero));
        assert_eq!(out.flags.contains(Flag::Parallel), n == [0.0; 3]);
    }
}

#[test]
fn extreme_length_of_n_by_powers_of_two_changes_no_bit() {
    let mut random = Random::new(12);
    for _ in 0..100 {
        let mut f = random.fragment();
        f.bump = Some([random.signed(), random.signed()]);
        f.rough = Some(random.vector());
        let want = run(&f);
        for power in -10..=10 {
            let scale = |a: [f64; 3]| a.map(|x| x * 2f64.powi(power));
            let g = Fragment { n: scale(f.n), dn_dx: scale(f.dn_dx), dn_dy: scale(f.dn_dy), ..f };
            assert_eq!(run(&g), want);
        }
    }
}

#[test]
fn extreme_derivatives_of_n_far_above_n_scale_d_and_saturate_nothing_before_the_range_ends() {
    for exponent in [10, 100, 500, 1000] {
        let size = 2f64.powi(exponent);
        let out = run(&Fragment { dn_dx: [size / 2.0, 0.0, 0.0], ..PLAIN });
        assert_eq!((out.d[0][0], out.lambda), (size, [size, 0.0]));
        // λ²'s square leaves the doubles where K = 2^2000 does; λ itself does not.
        assert_eq!(out.flags.contains(Flag::CovarianceSaturated), exponent > 511);
        assert_eq!(out.probes, 16);
        assert_eq!(out.lod, 8.0);
    }
}

#[test]
fn extreme_bump_of_14_turns_the_normal_by_86_degrees() {
    let out = run(&Fragment { h: Some([0.0, 1.0, 0.0]), bump: Some([14.0, 0.0]), ..PLAIN });
    // e1 = h × n = +x; n_mod = (14, 0, 1); v_r = 2(14, 0, 1) − 197·(0, 0, 1) = (28, 0, −195): −z.
    assert_eq!((out.face, out.u, out.v), (5, -28.0 / 195.0, 0.0));
}

#[test]
fn extreme_a_at_the_top_of_its_register_keeps_the_axis() {
    // D = diag(2^600, 2^599): K = (2^1200, 0, 2^1198) saturates, λ and the axis do not.
    let size = 2f64.powi(599);
    let out = run(&Fragment { dn_dx: [size, 0.0, 0.0], dn_dy: [0.0, size / 2.0, 0.0], ..PLAIN });
    assert_eq!(out.k, [f64::MAX, 0.0, f64::MAX]);
    assert_eq!(out.lambda, [2.0 * size, size]);
    assert_eq!(out.axis, [1.0, 0.0]);
    assert!(out.flags.contains(Flag::CovarianceSaturated));
    assert!(!out.flags.contains(Flag::LambdaSaturated));
}

#[test]
fn extreme_lambda_beyond_the_doubles_saturates_and_says_so() {
    let out = run(&Fragment { n: [0.0, 0.0, 1e-300], dn_dx: [1e300, 0.0, 0.0], ..PLAIN });
    assert_eq!(out.lambda[0], f64::MAX);
    assert!(out.flags.contains(Flag::DerivativesSaturated));
    assert!(out.flags.contains(Flag::LambdaSaturated));
    assert!(out.flags.contains(Flag::LengthSaturated));
    assert_eq!(out.flags.names().count(), 4);
}

#[test]
fn extreme_k_below_the_doubles_leaves_lambda_right() {
    let out = run(&Fragment { dn_dx: [3e-200, 0.0, 0.0], dn_dy: [0.0, 4e-200, 0.0], ..PLAIN });
    assert_eq!(out.k, [0.0; 3]);
    // λ1 = 2·4e-200 with |n| = 1: two roundings.
    assert!((out.lambda[0] - 8e-200).abs() <= 1e-9 * 8e-200);
    assert_eq!(out.axis, [0.0, 1.0]);
}

#[test]
fn extreme_minus_zero_counts_as_plus_zero() {
    let f = Fragment { v: [0.0, 0.0, -1.0], n: [0.0, 0.0, 1.0], dn_dx: [0.0, 1.0, 0.0], ..PLAIN };
    let negative = |a: [f64; 3]| a.map(|x| if x == 0.0 { -0.0 } else { x });
    let g = Fragment {
        v: negative(f.v),
        n: negative(f.n),
        dv_dx: negative(f.dv_dx),
        dv_dy: negative(f.dv_dy),
        dn_dx: negative(f.dn_dx),
        dn_dy: negative(f.dn_dy),
        ..f
    };
    let prepared = Prepared::new(&Settings::default());
    let [a, b] = [f, g].map(|f| env(&prepared, &f, 16, None, &mut Strict));
    assert_eq!(format!("{a:?}"), format!("{b:?}"));
    assert_eq!(a.face, 5);
}

#[test]
fn extreme_equal_largest_components_choose_z_then_y_then_x() {
    for signs in 0..8u32 {
        let sign = |bit: u32| if signs >> bit & 1 == 1 { -1.0 } else { 1.0 };
        let (x, y, z) = (sign(0), sign(1), sign(2));
        let face = |v: [f64; 3]| {
            // Mirroring about its own direction leaves v.
            let out = run(&Fragment { v, n: v, ..PLAIN });
            (out.face, out.u.abs(), out.v.abs())
        };
        let negative = |s: f64| usize::from(s < 0.0);
        assert_eq!(face([x, y, z]), (4 + negative(z), 1.0, 1.0));
        assert_eq!(face([x, y, 0.0]), (2 + negative(y), 1.0, 0.0));
        assert_eq!(face([x, 0.0, z]).0, 4 + negative(z));
        assert_eq!(face([x, 0.0, 0.0]), (negative(x), 0.0, 0.0));
    }
}

#[test]
fn extreme_faces_of_16384_texels_have_15_levels_and_exact_addresses() {
    let f = Fragment { dn_dx: [1.0, 0.0, 0.0], ..PLAIN };
    let out = env(&Prepared::new(&Settings::default()), &f, 16384, None, &mut Strict);
    // λ1 = 2: M = 16384, m = 1024.
    assert_eq!((out.probes, out.lod), (16, 10.0));
    let f = Fragment { dn_dx: [1000.0, 0.0, 0.0], dn_dy: [0.0, 1000.0, 0.0], ..PLAIN };
    let out = env(&Prepared::new(&Settings::default()), &f, 16384, None, &mut Strict);
    assert_eq!((out.probes, out.lod), (1, 14.0));
}

#[test]
fn extreme_h_parallel_to_n_takes_the_axis_across_the_smallest_component() {
    for (n, h, want) in [
        ([0.0, 0.0, 2.0], [0.0, 0.0, -1.0], [2.0, 0.0, 0.0]),
        ([3.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 3.0, 0.0]),
        ([0.0, 2.0, 0.0], [0.0; 3], [-2.0, 0.0, 0.0]),
    ] {
        let mut flags = Flags::default();
        let frame =
            tapline::reference::local_frame::local_frame::<f64, _>(n, h, &mut flags, &mut Strict);
        assert!(flags.contains(Flag::Parallel));
        // e_y × (0,0,2) = (2,0,0); e_z × (3,0,0) = (0,3,0); e_z × (0,2,0) = (−2,0,0).
        assert_eq!(frame.e1, want);
    }
}
