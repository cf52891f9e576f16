//! Extremes of the ENV operation on the integer model: defined, flagged, and right.
#![expect(
    clippy::float_cmp,
    clippy::unwrap_used,
    reason = "registers are exact; a test stops at the first thing that is not as it should be"
)]

use rtl_model::regs::Reg;
use rtl_model::stages::Roms;
use support::reference::{Draw, PLAIN, Random, noise, plain};
use support::rtl::{Traced, bound, lod, near, trace};
use tapline::conformance::extremes::straight;
use tapline::engine::encode;
use tapline::fragment::Fragment;
use tapline::scene::pyramid::factors;
use tapline::unit::UnitSpec;
use tapline::unit::knobs::Value;

fn run(f: &Fragment) -> Traced {
    trace(&UnitSpec::default(), f, 256, None)
}

/// The registers of the back end as values, and the face.
fn values(t: &Traced) -> (usize, Vec<Vec<f64>>) {
    let registers = [
        Reg::FaceU,
        Reg::FaceV,
        Reg::JacD,
        Reg::CovK,
        Reg::EigenLambda,
        Reg::EigenAxis,
        Reg::FootLength,
        Reg::FootWidth,
        Reg::FootLod,
        Reg::FootStep,
    ];
    (t.out.face, registers.map(|r| t.values(r)).into())
}

#[test]
fn extreme_k_zero_gives_one_probe_on_level_0_along_u() {
    let t = run(&PLAIN);
    assert_eq!(t.values(Reg::CovK), [0.0; 3]);
    assert_eq!(t.values(Reg::EigenLambda), [0.0; 2]);
    assert_eq!(t.values(Reg::EigenAxis), [1.0, 0.0]);
    assert_eq!((t.out.probes, lod(&t)), (1, 0.0));
    assert!(t.out.flags.is_empty());
}

#[test]
fn extreme_k_isotropic_takes_one_probe_and_the_axis_along_u() {
    let t = run(&straight([[0.5, 0.0], [0.0, 0.5]]));
    assert_eq!(t.values(Reg::CovK), [0.25, 0.0, 0.25]);
    assert_eq!(t.values(Reg::EigenAxis), [1.0, 0.0]);
    for i in 0..2 {
        near(t.value(Reg::EigenLambda, i), 0.5, 0.5 * bound("eigen.lambda 1"));
    }
    // M = m = 64 texels: one probe, though λ1 and λ2 may differ in their last bits.
    assert_eq!((t.out.probes, lod(&t)), (1, 6.0));
}

#[test]
fn extreme_a_equal_to_c_with_b_points_along_a_diagonal_of_b_s_sign() {
    for sign in [1.0, -1.0] {
        let t = run(&straight([[0.5, sign * 0.25], [sign * 0.25, 0.5]]));
        assert_eq!(t.values(Reg::CovK), [0.3125, sign * 0.25, 0.3125]);
        // 45° is an entry of the table: rounded once there, once in the register.
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let slack = 2.0 * libm::ldexp(0.5, -20);
        near(t.value(Reg::EigenAxis, 0), half, slack);
        near(t.value(Reg::EigenAxis, 1), sign * half, slack);
        // λ = ¾, ¼: M = 96, m = 32.
        assert_eq!((t.out.probes, lod(&t)), (3, 5.0));
    }
}

#[test]
fn extreme_rank_one_k_has_no_width_and_takes_all_probes() {
    let t = run(&straight([[0.375, 0.0], [0.5, 0.0]]));
    assert_eq!(t.values(Reg::JacD), [0.375, 0.0, 0.5, 0.0]);
    near(t.value(Reg::EigenLambda, 0), 0.625, 0.625 * bound("eigen.lambda 1"));
    assert!(t.value(Reg::EigenLambda, 1) <= 0.625 * bound("eigen.lambda 2"));
    // M = 80 texels, m = 5.
    assert_eq!(t.out.probes, 16);
    near(t.value(Reg::FootLength, 0), 80.0, libm::ldexp(1.0, -12));
    near(t.value(Reg::FootWidth, 0), 5.0, libm::ldexp(1.0, -12));
    near(lod(&t), libm::log2(5.0), bound("footprint.lod"));
}

#[test]
fn extreme_lambda_ratio_of_a_million_is_clamped_to_all_probes() {
    for size in [256u32, 4096] {
        let f = straight([[1.0, 0.0], [0.0, 1e-6]]);
        let t = trace(&UnitSpec::default(), &f, size, None);
        let length = f64::from(size) / 2.0;
        near(t.value(Reg::FootLength, 0), length, libm::ldexp(1.0, -12));
        near(t.value(Reg::FootWidth, 0), length / 16.0, libm::ldexp(1.0, -12));
        assert_eq!(t.out.probes, 16);
        near(lod(&t), libm::log2(length / 16.0), libm::ldexp(1.0, -8));
        assert_eq!(t.values(Reg::EigenAxis), [1.0, 0.0]);
    }
}

#[test]
fn extreme_silhouette_reflects_the_view_straight_on() {
    for cosine in [1e-3, 1e-10, 1e-300, 0.0] {
        let t = run(&Fragment {
            v: [1.0, 0.0, cosine],
            dv_dx: [0.0, 0.25, 0.0],
            dn_dx: [0.5, 0.0, 0.0],
            ..PLAIN
        });
        assert_eq!(t.out.face, 1);
        near(t.value(Reg::FaceU, 0), cosine, bound("cube_face.u, v"));
        assert_eq!(t.value(Reg::FaceV, 0), 0.0);
        // |∂v|/|v| + 2|∂n|/|n| = 1.25 at most.
        let slack = 1.25 * bound("jacobian.d, factor") + bound("jacobian.d, absolute");
        near(t.value(Reg::JacD, 0), 1.0 + cosine * cosine, slack);
        near(t.value(Reg::JacD, 2), 0.25, slack);
        assert!(t.out.flags.is_empty());
    }
}

#[test]
fn extreme_a_normal_that_faces_away_reflects_like_its_opposite() {
    let mut random = Random::new(11);
    let minus = |a: [f64; 3]| a.map(|x| -x);
    for _ in 0..100 {
        let f = random.fragment();
        let g = Fragment { n: minus(f.n), dn_dx: minus(f.dn_dx), dn_dy: minus(f.dn_dy), ..f };
        assert_eq!(values(&run(&f)), values(&run(&g)), "half-even is symmetric");
    }
}

#[test]
fn extreme_no_reflected_direction_is_face_plus_z_without_derivatives() {
    for (v, n) in [([0.0; 3], [1.0, 2.0, 3.0]), ([1.0, 2.0, 3.0], [0.0; 3]), ([-0.0; 3], [-0.0; 3])]
    {
        for extra in [false, true] {
            let t = run(&Fragment {
                v,
                n,
                dv_dx: [1.0, 2.0, -3.0],
                dn_dx: [3.0, 1.0, -1.0],
                h: extra.then_some([0.0, 1.0, 0.0]),
                bump: extra.then_some([1.0, 2.0]),
                rough: extra.then_some([1.0, 2.0, 3.0]),
                ..PLAIN
            });
            assert_eq!(t.out.face, 4);
            assert_eq!((t.value(Reg::FaceU, 0), t.value(Reg::FaceV, 0)), (0.0, 0.0));
            assert_eq!(t.values(Reg::JacD), [0.0; 4]);
            assert_eq!(t.values(Reg::CovK), [0.0; 3]);
            assert_eq!((t.out.probes, lod(&t)), (1, 0.0));
            assert!(t.flagged("cube_face.zero"));
            assert_eq!(t.flagged("local_frame.parallel"), extra && n == [0.0; 3]);
        }
    }
}

#[test]
fn extreme_length_of_n_by_powers_of_two_changes_no_bit() {
    let mut random = Random::new(12);
    for _ in 0..50 {
        let mut f = random.fragment();
        f.bump = Some([random.signed(), random.signed()]);
        f.rough = Some(random.vector());
        let want = values(&run(&f));
        for power in -10..=10 {
            let scale = |a: [f64; 3]| a.map(|x| libm::ldexp(x, power));
            let g = Fragment { n: scale(f.n), dn_dx: scale(f.dn_dx), dn_dy: scale(f.dn_dy), ..f };
            assert_eq!(values(&run(&g)), want, "2^{power}");
        }
    }
}

#[test]
fn extreme_derivatives_of_n_far_above_n_saturate_and_flag() {
    // Below the registers' ends nothing is flagged: ∂n = 63, D = 126.
    let t = run(&straight([[126.0, 0.0], [0.0, 126.0]]));
    assert!(t.out.flags.is_empty(), "{:?}", t.out.flags);
    assert_eq!(t.values(Reg::JacD), [126.0, 0.0, 0.0, 126.0]);
    assert_eq!((t.out.probes, lod(&t)), (1, 8.0));
    for exponent in [8, 10, 100, 1000] {
        let t = run(&straight([[libm::ldexp(1.0, exponent), 0.0], [0.0, 0.0]]));
        let saturated = t.flagged("jacobian.dn_dx.saturated");
        assert!(saturated || exponent == 8, "2^{exponent}: {:?}", t.out.flags);
        assert!(!t.out.flags.is_empty());
        // Still the largest footprint along u.
        assert_eq!(t.values(Reg::EigenAxis), [1.0, 0.0]);
        assert_eq!((t.out.probes, lod(&t)), (16, 8.0));
    }
}

#[test]
fn extreme_bump_of_14_turns_the_normal_by_86_degrees() {
    let t = run(&Fragment { h: Some([0.0, 1.0, 0.0]), bump: Some([14.0, 0.0]), ..PLAIN });
    assert_eq!(t.out.face, 5);
    let slack = bound("cube_face.u, v, bumped");
    near(t.value(Reg::FaceU, 0), -28.0 / 195.0, slack);
    near(t.value(Reg::FaceV, 0), 0.0, slack);
    assert!(t.out.flags.is_empty(), "{:?}", t.out.flags);
}

#[test]
fn extreme_a_at_the_top_of_its_register_keeps_the_axis() {
    // The largest D of its format, 256 − 2⁻²², needs a ∂n at the top of its own.
    let top = 256.0 - libm::ldexp(1.0, -20);
    for (d, axis) in
        [([[top, 0.0], [0.0, 128.0]], [1.0, 0.0]), ([[128.0, 0.0], [0.0, top]], [0.0, 1.0])]
    {
        let t = run(&straight(d));
        assert!(t.out.flags.is_empty(), "{:?}", t.out.flags);
        assert_eq!(t.values(Reg::EigenAxis), axis);
        let trace = top * top + 128.0 * 128.0;
        let slack = trace * bound("covariance.k");
        let (big, small) = if axis[0] == 1.0 { (0, 2) } else { (2, 0) };
        near(t.value(Reg::CovK, big), top * top, slack);
        near(t.value(Reg::CovK, small), 128.0 * 128.0, slack);
        // One exponent for all: codes within two of a power of two, none beyond the register.
        let code = t.code(Reg::CovK, big).raw;
        assert!(
            code < 1 << 30
                && code + 8 >= (code + 8).cast_unsigned().next_power_of_two().cast_signed() / 2
        );
    }
}

#[test]
fn extreme_minus_zero_counts_as_plus_zero() {
    let negative = |a: [f64; 3]| a.map(|x| if x == 0.0 { -0.0 } else { x });
    let f = Fragment {
        v: [0.0, 0.0, -1.0],
        dn_dx: [0.0, 1.0, 0.0],
        h: Some([0.0, 1.0, 0.0]),
        bump: Some([0.0, 0.25]),
        rough: Some([0.0, 0.5, 0.0]),
        ..PLAIN
    };
    let g = Fragment {
        v: negative(f.v),
        n: negative(f.n),
        dv_dx: negative(f.dv_dx),
        dv_dy: negative(f.dv_dy),
        dn_dx: negative(f.dn_dx),
        dn_dy: negative(f.dn_dy),
        h: f.h.map(negative),
        bump: Some([-0.0, 0.25]),
        rough: Some([-0.0, 0.5, -0.0]),
    };
    let [a, b] = [run(&f), run(&g)];
    assert_eq!(a.probe.registers, b.probe.registers);
    assert_eq!((a.out.face, &a.out.flags), (b.out.face, &b.out.flags));
}

#[test]
fn extreme_alpha_at_a_table_boundary_and_one_ulp_to_each_side() {
    for entries in [10, 32] {
        let mut spec = UnitSpec::default();
        spec.config.tables.eigen.entries = entries;
        let rom = Roms::new(&spec.config).unwrap().angle;
        assert_eq!(rom.boundaries.len(), usize::try_from(entries / 2).unwrap());
        for (k, [cos, sin]) in (0..).zip(&rom.boundaries) {
            // |2b| : |c − a| as sin θ : cos θ, exactly on the boundary's constants.
            assert_eq!(rom.index(*sin, *cos), k, "on it: the lower entry");
            assert_eq!(rom.index(sin - 1, *cos), k);
            assert_eq!(rom.index(sin + 1, *cos), k + 1);
            assert_eq!(rom.index(*sin, cos + 1), k);
            assert_eq!(rom.index(*sin, cos - 1), k + 1);
        }
    }
}

#[test]
fn extreme_count_at_a_boundary_and_one_ulp_to_each_side() {
    // λ2·128 = 8 texels and M = 8(n + 2⁻⁸): exactly on the boundary between n and n + 1 probes.
    for n in 1..16 {
        for (ulps, want) in [(-1.0, n), (0.0, n), (1.0, n + 1)] {
            let length = 8.0 * (f64::from(n) + libm::ldexp(1.0, -8)) + ulps * libm::ldexp(1.0, -12);
            let t = run(&straight([[length / 128.0, 0.0], [0.0, 8.0 / 128.0]]));
            assert_eq!(t.value(Reg::FootLength, 0), length, "{n} probes, {ulps} ulp");
            assert_eq!(t.value(Reg::FootWidth, 0), 8.0);
            assert_eq!(t.out.probes, i64::from(want), "{n} probes, {ulps} ulp");
        }
    }
    // Beyond the last one the width grows instead.
    let t = run(&straight([[17.0 / 16.0, 0.0], [0.0, 1.0 / 16.0]]));
    assert_eq!((t.out.probes, t.value(Reg::FootWidth, 0)), (16, 8.5));
}

#[test]
fn extreme_one_probe_at_most_is_as_wide_as_the_line_is_long() {
    let mut spec = UnitSpec::default();
    spec.set("footprint.max_probes", &Value::Integer(1)).unwrap();
    let f = straight([[0.5, 0.0], [0.0, 1.0 / 64.0]]);
    let t = trace(&spec, &f, 256, None);
    assert_eq!((t.out.probes, lod(&t)), (1, 6.0));
    assert_eq!(t.value(Reg::FootWidth, 0), 64.0);
}

#[test]
fn extreme_equal_largest_components_choose_z_then_y_then_x() {
    let slack = bound("cube_face.u, v");
    for signs in 0..8u32 {
        let sign = |bit: u32| if signs >> bit & 1 == 1 { -1.0 } else { 1.0 };
        let (x, y, z) = (sign(0), sign(1), sign(2));
        let negative = |s: f64| usize::from(s < 0.0);
        let check = |v: [f64; 3], face: usize, u: f64, w: f64| {
            let t = run(&plain(v));
            assert_eq!(t.out.face, face, "{v:?}");
            near(t.value(Reg::FaceU, 0).abs(), u, slack);
            near(t.value(Reg::FaceV, 0).abs(), w, slack);
            assert!(t.out.flags.is_empty());
        };
        check([x, y, z], 4 + negative(z), 1.0, 1.0);
        check([x, y, 0.0], 2 + negative(y), 1.0, 0.0);
        check([x, 0.0, z], 4 + negative(z), 1.0, 0.0);
        check([0.0, y, z], 4 + negative(z), 0.0, 1.0);
        check([x, 0.0, 0.0], negative(x), 0.0, 0.0);
    }
}

#[test]
fn extreme_cube_corner_and_edge_exactly_and_one_ulp_to_each_side() {
    // One unit in the last place of the normalised ports, below and above 1.
    let ulp = libm::ldexp(1.0, -22);
    for other in [1.0, 0.5] {
        // (1, other, t): a corner or a point of the edge between +x and +z.
        for (t, face) in [(1.0 - ulp, 0), (1.0, 4), (1.0 + ulp, 4)] {
            let want = if other == 1.0 && t < 1.0 { 2 } else { face };
            let out = run(&plain([1.0, other, t]));
            assert_eq!(out.out.face, want, "(1, {other}, {t})");
            assert!(out.value(Reg::FaceU, 0).abs() <= 1.0 && out.value(Reg::FaceV, 0).abs() <= 1.0);
            // Colours do not jump: the same texels stand on both sides of the seam.
            let map = noise(8, 3);
            let spec = UnitSpec::default();
            let texture = encode::texture(&spec.config, &map).unwrap();
            let here = trace(&spec, &plain([1.0, other, t]), 8, Some(&texture));
            let there = trace(&spec, &plain([1.0, other, 1.0]), 8, Some(&texture));
            // One ulp moves an address by less than a weight step of 2⁻⁸ of a texel, twice two weights
            // round: 4 steps of 2⁻⁸ of the largest texel, 1, at most.
            for (a, b) in here.values(Reg::FilterColor).iter().zip(there.values(Reg::FilterColor)) {
                near(*a, b, 4.0 / 256.0);
            }
        }
    }
}

#[test]
fn extreme_h_parallel_to_n_takes_the_axis_across_the_smallest_component() {
    for (n, h, want) in [
        ([0.0, 0.0, 2.0], [0.0, 0.0, -1.0], [2.0, 0.0, 0.0]),
        ([3.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 3.0, 0.0]),
        ([0.0, 2.0, 0.0], [0.0; 3], [-2.0, 0.0, 0.0]),
    ] {
        let t = run(&Fragment { v: n, n, h: Some(h), bump: Some([0.5, 0.0]), ..PLAIN });
        assert!(t.flagged("local_frame.parallel"));
        for (i, want) in want.into_iter().enumerate() {
            // |n| ≤ 3: e1's register and the roots' errors, a few 2⁻²².
            near(t.value(Reg::FrameE1, i), want, libm::ldexp(1.0, -18));
        }
    }
}

#[test]
fn extreme_covariances_of_the_pyramid_make_finite_factors_and_no_flag() {
    let over = 1.0f64.next_up();
    for (cov, want) in [
        ([0.25, 0.0, 0.0], [0.5, 0.0, 0.0]),
        // b² > ac by one ulp: d1 = 0.
        ([1.0, over, 1.0], [0.0, over, 1.0]),
        ([0.0; 3], [0.0; 3]),
    ] {
        let d = factors(cov);
        assert_eq!(d, want);
        let t = run(&Fragment { h: Some([0.0, 1.0, 0.0]), rough: Some(d), ..PLAIN });
        assert!(t.out.flags.is_empty(), "{:?}", t.out.flags);
        let flat = d == [0.0; 3];
        assert_eq!(t.values(Reg::CovK) == [0.0; 3], flat);
        assert_eq!(t.out.probes == 1, flat, "rank one takes a line");
    }
}
