//! Every extreme of the ENV operation on the float reference: defined, finite, and right.
#![expect(
    clippy::float_cmp,
    reason = "what is exact by construction is compared exactly"
)]

mod reference_support;

use proptest::prelude::*;
use reference_support::{Random, map};
use tapline::fragment::Fragment;
use tapline::policy::{Axis, Count, Dnmod, Minor, Placement, Weights};
use tapline::reference::angle::Angles;
use tapline::reference::eigen::{Axes, eigen};
use tapline::reference::footprint::{Chain, Footprint, Rule, footprint};
use tapline::reference::{Env, Flag, Flags, NoTap, Prepared, Tap, Texture, env};
use tapline::settings::{AngleTable, Settings};
use tapline::stage::Stage;

const PLAIN: Fragment = Fragment {
    v: [0.0, 0.0, 1.0],
    n: [0.0, 0.0, 1.0],
    dv_dx: [0.0; 3],
    dv_dy: [0.0; 3],
    dn_dx: [0.0; 3],
    dn_dy: [0.0; 3],
    h: None,
    bump: None,
    rough: None,
};

fn run(f: &Fragment) -> Env {
    env(
        &Prepared::new(&Settings::default()),
        f,
        256,
        None,
        &mut NoTap,
    )
}

fn axes(k: [f64; 3], minor: Minor) -> Axes<f64> {
    eigen(k, [None; 2], (Axis::EigenExact, minor), None, &mut NoTap)
}

fn probes(lambda: [f64; 2], count: Count, max_probes: u32) -> Footprint {
    let chain = Chain {
        size: 256,
        levels: 9,
    };
    let rule = Rule { count, max_probes };
    footprint(
        lambda,
        [1.0, 0.0],
        chain,
        rule,
        &mut Flags::default(),
        &mut NoTap,
    )
}

/// Fails on a value that is not finite, and on −0.
struct Strict;

impl Tap for Strict {
    fn put(&mut self, stage: Stage, register: &'static str, component: usize, value: f64) {
        let bits = value.to_bits();
        assert!(
            value.is_finite() && bits != (-0.0f64).to_bits(),
            "{stage:?} {register} {component}: {value}"
        );
    }

    fn event(&mut self, _: &'static str) {}
}

fn assert_finite(out: &Env) {
    let values = [out.u, out.v, out.lod]
        .into_iter()
        .chain(out.d.as_flattened().iter().copied())
        .chain(out.k)
        .chain(out.lambda)
        .chain(out.axis)
        .chain(out.color);
    for value in values {
        assert!(value.is_finite(), "{out:?}");
    }
    assert!(
        out.u.abs() <= 1.0 && out.v.abs() <= 1.0 && out.face < 6,
        "{out:?}"
    );
    assert!(out.probes >= 1 && out.lod >= 0.0, "{out:?}");
    assert!(out.lambda[0] >= 0.0 && out.lambda[1] >= 0.0, "{out:?}");
}

#[test]
fn extreme_k_zero_gives_one_probe_on_level_0_along_u() {
    let out = run(&PLAIN);
    assert_eq!(
        (out.k, out.lambda, out.axis),
        ([0.0; 3], [0.0; 2], [1.0, 0.0])
    );
    assert_eq!((out.probes, out.lod), (1, 0.0));
    assert!(out.flags.is_empty());
}

#[test]
fn extreme_k_isotropic_has_equal_axes_along_u_and_one_probe() {
    for minor in [Minor::Paper, Minor::Det] {
        let got = axes([0.0625, 0.0, 0.0625], minor);
        assert_eq!((got.lambda, got.axis), ([0.25, 0.25], [1.0, 0.0]));
    }
    assert_eq!(probes([0.25, 0.25], Count::Ceil, 16).probes, 1);
}

#[test]
fn extreme_a_equal_to_c_with_b_points_to_a_diagonal_of_its_sign() {
    // λ² = a ± b = 4 and 2 (exact sums); the axis is 1/√2 twice, to one rounding.
    for b in [1.0, -1.0] {
        let got = axes([3.0, b, 3.0], Minor::Paper);
        assert_eq!(got.lambda, [2.0, 2f64.sqrt()]);
        assert!((got.axis[0] - 0.5f64.sqrt()).abs() <= f64::EPSILON);
        assert_eq!(got.axis[1], got.axis[0] * b);
    }
}

#[test]
fn errata_r1_is_the_major_axis_when_c_is_less_than_a() {
    assert_eq!(axes([1.0, 0.0, 4.0], Minor::Paper).axis, [0.0, 1.0]);
    assert_eq!(axes([4.0, 0.0, 1.0], Minor::Paper).axis, [1.0, 0.0]);
}

#[test]
fn extreme_rank_one_k_has_no_width_and_takes_all_probes() {
    // D = (3, 0; 4, 0)/8: λ1 = 5/8, λ2 = 0; every step is exact.
    let out = run(&Fragment {
        dv_dx: [0.0; 3],
        dn_dx: [0.1875, -0.25, 0.0],
        ..PLAIN
    });
    assert_eq!(out.d, [[0.375, 0.0], [0.5, 0.0]]);
    assert_eq!(out.lambda, [0.625, 0.0]);
    // The axis is a quotient of roots: two roundings.
    assert!((out.axis[0] - 0.6).abs() <= f64::EPSILON && (out.axis[1] - 0.8).abs() <= f64::EPSILON);
    assert_eq!((out.probes, out.lod), (16, libm::log2(5.0)));
}

#[test]
fn extreme_axis_ratio_of_a_million_has_the_right_length_and_width_after_clamping() {
    // K = R diag(1, 1e-12) Rᵀ at 30°: λ1 = 1 to 1e-9, and M/16 = 8 texels stands in for λ2.
    let (c, s) = (0.75f64.sqrt(), 0.5);
    let (l1, l2) = (1.0, 1e-12);
    let k = [
        c * c * l1 + s * s * l2,
        c * s * (l1 - l2),
        s * s * l1 + c * c * l2,
    ];
    for minor in [Minor::Paper, Minor::Det] {
        let got = axes(k, minor);
        assert!((got.lambda[0] - 1.0).abs() <= 1e-9);
        let footprint = probes(got.lambda, Count::Ceil, 16);
        assert_eq!(footprint.probes, 16);
        assert!((footprint.lod - 3.0).abs() <= 1e-9 * 2.0);
    }
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
        let g = Fragment {
            n: minus(f.n),
            dn_dx: minus(f.dn_dx),
            dn_dy: minus(f.dn_dy),
            ..f
        };
        assert_eq!(run(&f), run(&g), "every product has n twice");
    }
}

#[test]
fn extreme_no_reflected_direction_is_face_plus_z_without_derivatives() {
    for (v, n) in [
        ([0.0; 3], [1.0, 2.0, 3.0]),
        ([1.0, 2.0, 3.0], [0.0; 3]),
        ([-0.0; 3], [-0.0; 3]),
    ] {
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
            let g = Fragment {
                n: scale(f.n),
                dn_dx: scale(f.dn_dx),
                dn_dy: scale(f.dn_dy),
                ..f
            };
            assert_eq!(run(&g), want);
        }
    }
}

#[test]
fn extreme_derivatives_of_n_far_above_n_scale_d_and_saturate_nothing_before_the_range_ends() {
    for exponent in [10, 100, 500, 1000] {
        let size = 2f64.powi(exponent);
        let out = run(&Fragment {
            dn_dx: [size / 2.0, 0.0, 0.0],
            ..PLAIN
        });
        assert_eq!((out.d[0][0], out.lambda), (size, [size, 0.0]));
        // λ²'s square leaves the doubles where K = 2^2000 does; λ itself does not.
        assert_eq!(
            out.flags.contains(Flag::CovarianceSaturated),
            exponent > 511
        );
        assert_eq!(out.probes, 16);
        assert_eq!(out.lod, 8.0);
    }
}

#[test]
fn extreme_bump_of_14_turns_the_normal_by_86_degrees() {
    let out = run(&Fragment {
        h: Some([0.0, 1.0, 0.0]),
        bump: Some([14.0, 0.0]),
        ..PLAIN
    });
    // e1 = h × n = +x; n_mod = (14, 0, 1); v_r = 2(14, 0, 1) − 197·(0, 0, 1) = (28, 0, −195): −z.
    assert_eq!((out.face, out.u, out.v), (5, -28.0 / 195.0, 0.0));
}

#[test]
fn extreme_a_at_the_top_of_its_register_keeps_the_axis() {
    // D = diag(2^600, 2^599): K = (2^1200, 0, 2^1198) saturates, λ and the axis do not.
    let size = 2f64.powi(599);
    let out = run(&Fragment {
        dn_dx: [size, 0.0, 0.0],
        dn_dy: [0.0, size / 2.0, 0.0],
        ..PLAIN
    });
    assert_eq!(out.k, [f64::MAX, 0.0, f64::MAX]);
    assert_eq!(out.lambda, [2.0 * size, size]);
    assert_eq!(out.axis, [1.0, 0.0]);
    assert!(out.flags.contains(Flag::CovarianceSaturated));
    assert!(!out.flags.contains(Flag::LambdaSaturated));
}

#[test]
fn extreme_lambda_beyond_the_doubles_saturates_and_says_so() {
    let out = run(&Fragment {
        n: [0.0, 0.0, 1e-300],
        dn_dx: [1e300, 0.0, 0.0],
        ..PLAIN
    });
    assert_eq!(out.lambda[0], f64::MAX);
    assert!(out.flags.contains(Flag::DerivativesSaturated));
    assert!(out.flags.contains(Flag::LambdaSaturated));
    assert!(out.flags.contains(Flag::LengthSaturated));
    assert_eq!(out.flags.names().count(), 4);
}

#[test]
fn extreme_k_below_the_doubles_leaves_lambda_right() {
    let out = run(&Fragment {
        dn_dx: [3e-200, 0.0, 0.0],
        dn_dy: [0.0, 4e-200, 0.0],
        ..PLAIN
    });
    assert_eq!(out.k, [0.0; 3]);
    // λ1 = 2·4e-200 with |n| = 1: two roundings.
    assert!((out.lambda[0] - 8e-200).abs() <= 1e-9 * 8e-200);
    assert_eq!(out.axis, [0.0, 1.0]);
}

#[test]
fn extreme_minus_zero_counts_as_plus_zero() {
    let f = Fragment {
        v: [0.0, 0.0, -1.0],
        n: [0.0, 0.0, 1.0],
        dn_dx: [0.0, 1.0, 0.0],
        ..PLAIN
    };
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
fn extreme_angles_one_ulp_beside_a_table_boundary_take_the_entries_beside_it() {
    for placement in Placement::ALL.iter().copied() {
        let entries = 32;
        let angles = Angles::new(AngleTable {
            entries,
            placement,
            order: 0,
        });
        let step = std::f64::consts::PI / f64::from(entries);
        for bin in 1..entries / 2 {
            let offset = match placement {
                Placement::Edges => 0.5,
                Placement::Centres => 0.0,
            };
            let boundary = (f64::from(bin) + offset - 1.0) * step;
            if boundary <= 0.0 {
                continue;
            }
            // 1e-14 rad is 2⁶ times the error of sine and cosine below 90°.
            let [below, above] = [boundary - 1e-14, boundary + 1e-14]
                .map(|x| angles.look_up([libm::cos(x), libm::sin(x)]));
            let angle = |[c, s]: [f64; 2]| libm::atan2(s, c);
            let gap = angle(above) - angle(below);
            // Entries are half a step in 2α apart; atan2 and the entries carry a few roundings.
            assert!(
                (gap - step / 2.0).abs() <= 1e-14,
                "{placement:?} {bin}: {gap}"
            );
        }
    }
}

#[test]
fn table_axis_is_within_half_a_bin_of_the_exact_one_and_exact_along_u_and_v() {
    let mut random = Random::new(13);
    for entries in [2u32, 10, 32, 64] {
        for placement in Placement::ALL.iter().copied() {
            for order in [0, 1] {
                let angles = Angles::new(AngleTable {
                    entries,
                    placement,
                    order,
                });
                for _ in 0..300 {
                    let d = [
                        random.signed(),
                        random.signed(),
                        random.signed(),
                        random.signed(),
                    ];
                    let k = [
                        d[0] * d[0] + d[1] * d[1],
                        d[0] * d[2] + d[1] * d[3],
                        d[2] * d[2] + d[3] * d[3],
                    ];
                    let policy = (Axis::EigenTable, Minor::Paper);
                    let table = eigen(k, [None; 2], policy, Some(&angles), &mut NoTap).axis;
                    let exact = axes(k, Minor::Paper).axis;
                    let sine = (table[0] * exact[1] - table[1] * exact[0]).abs();
                    // Nearest: half a step of 90°/n. Between entries: never farther than a whole one.
                    let half = std::f64::consts::FRAC_PI_2 / f64::from(entries) / 2.0;
                    let reach = if order == 0 { half } else { 2.0 * half };
                    assert!(
                        sine <= libm::sin(reach) + 1e-12,
                        "{entries} {placement:?} {order}: {sine}"
                    );
                    assert!(table[0] > 0.0 || table == [0.0, 1.0]);
                }
                if placement == Placement::Edges {
                    for (k, want) in [([4.0, 0.0, 1.0], [1.0, 0.0]), ([1.0, 0.0, 4.0], [0.0, 1.0])]
                    {
                        let policy = (Axis::EigenTable, Minor::Paper);
                        let got = eigen::<f64, _>(k, [None; 2], policy, Some(&angles), &mut NoTap);
                        assert_eq!(got.axis, want);
                    }
                }
            }
        }
    }
}

#[test]
fn extreme_counts_beside_a_boundary_follow_the_rule_to_the_ulp() {
    // m = 1 texel (λ2 = 0), N/2 = 128: M = 128·λ1 exactly, M/m = M.
    let count = |m: f64, rule: Count, max: u32| probes([m / 128.0, 0.0], rule, max).probes;
    let ulp = 4.0 * f64::EPSILON;
    let edge = 3.0 + 1.0 / 256.0;
    assert_eq!(count(edge, Count::Ceil, 16), 3);
    assert_eq!(count(edge + ulp, Count::Ceil, 16), 4);
    assert_eq!(count(edge - ulp, Count::Ceil, 16), 3);
    assert_eq!(count(2.5, Count::Round, 16), 3);
    assert_eq!(count(2.5 - ulp, Count::Round, 16), 2);
    assert_eq!(count(4.0 + 1.0 / 256.0, Count::Pow2, 16), 4);
    assert_eq!(count(4.0 + 2.0 / 256.0, Count::Pow2, 16), 8);
    assert_eq!(count(1.75, Count::Feline, 16), 3);
    assert_eq!(count(1.75 - ulp, Count::Feline, 16), 2);
}

#[test]
fn extreme_max_probes_of_one_takes_one_probe_as_wide_as_the_line() {
    for rule in Count::ALL.iter().copied() {
        let got = probes([0.5, 0.0], rule, 1);
        assert_eq!((got.probes, got.lod), (1, 6.0), "{rule:?}");
    }
}

#[test]
fn every_count_fits_and_every_width_covers_the_line() {
    let mut random = Random::new(14);
    for max in 1..=64 {
        for rule in Count::ALL.iter().copied() {
            for _ in 0..50 {
                let lambda = [
                    libm::exp(8.0 * random.signed()),
                    libm::exp(8.0 * random.signed()),
                ];
                let got = probes(lambda, rule, max);
                assert!((1..=max).contains(&got.probes));
                if rule == Count::Pow2 {
                    assert!(got.probes.is_power_of_two());
                }
            }
        }
    }
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
fn extreme_one_ulp_to_each_side_of_edges_and_corners_changes_face_and_not_color() {
    // A map that is continuous across the seams: the direction itself.
    let cube = map(8, |face, x, y| {
        let [u, v] = [x, y].map(|t| (t as f64 + 0.5) / 4.0 - 1.0);
        let d = tapline::cube::direction(face, u, v);
        let length = d.iter().map(|x| x * x).sum::<f64>().sqrt();
        #[expect(clippy::cast_possible_truncation, reason = "texels are floats")]
        d.map(|x| (x / length) as f32)
    });
    let texture = Texture::new(&cube);
    let prepared = Prepared::new(&Settings::default());
    let above = 1.0 + f64::EPSILON;
    let below = 1.0 - f64::EPSILON / 2.0;
    for (v, faces) in [
        ([1.0, 0.25, 1.0], [4, 0, 4]),
        ([1.0, 1.0, 0.25], [2, 0, 2]),
        ([1.0, 1.0, 1.0], [4, 0, 4]),
    ] {
        let mut colors = vec![];
        for (x, face) in [(1.0, faces[0]), (above, faces[1]), (below, faces[2])] {
            let v = [x, v[1], v[2]];
            let f = Fragment { v, n: v, ..PLAIN };
            let out = env(&prepared, &f, 8, Some(&texture), &mut NoTap);
            assert_eq!(out.face, face, "{v:?}");
            colors.push(out.color);
        }
        for color in &colors {
            for (a, b) in color.iter().zip(&colors[0]) {
                // (u, v) moves by 2 ulp at most, 8/2 texels per unit, texel steps below 1 in value; the
                // taps on both sides are the same texels, mixed in another order: 16 roundings.
                assert!((a - b).abs() <= 16.0 * f64::EPSILON, "{v:?}: {colors:?}");
            }
        }
    }
}

#[test]
fn extreme_a_probe_line_over_two_edges_wraps_round_the_cube() {
    struct Line(Vec<f64>);
    impl Tap for Line {
        fn put(&mut self, stage: Stage, register: &'static str, component: usize, value: f64) {
            if stage == Stage::Address && register == "u" {
                assert_eq!(component, self.0.len());
                self.0.push(value);
            }
        }
        fn event(&mut self, _: &'static str) {}
    }
    // Texels hold their face's number; a line 8 units long has probes on −x, +z and +x.
    let cube = map(4, |face, _, _| {
        [u8::try_from(face).map_or(0.0, f32::from); 3]
    });
    let texture = Texture::new(&cube);
    let prepared = Prepared::new(&Settings {
        max_probes: 16,
        ..Settings::default()
    });
    let f = Fragment {
        dn_dx: [4.0, 0.0, 0.0],
        ..PLAIN
    };
    let mut tap = Line(vec![]);
    let out = env(&prepared, &f, 4, Some(&texture), &mut tap);
    assert_eq!((out.lambda[0], out.probes), (8.0, 16));
    let want: Vec<_> = (0..16).map(|i| f64::from(i) * 0.5 - 3.75).collect();
    assert_eq!(tap.0, want);
    // The same look-ups by direction: (u, 0, 1) is −x, +z or +x. Sums of 16 values below 5: 16 roundings.
    let mean = (0..16).map(|i| {
        let u = f64::from(i) * 0.5 - 3.75;
        let (face, s, t) = tapline::cube::face_uv([u, 0.0, 1.0]);
        texture.bilinear(
            0,
            tapline::reference::address::Address { face, u: s, v: -t },
        )[0]
    });
    let mean = mean.sum::<f64>() / 16.0;
    assert!(
        (out.color[0] - mean).abs() <= 16.0 * f64::EPSILON * 5.0,
        "{} {mean}",
        out.color[0]
    );
}

#[test]
fn extreme_faces_of_one_texel_and_of_sizes_that_are_no_power_of_two_are_filtered() {
    let mut random = Random::new(15);
    for size in [1usize, 3, 5, 6, 7, 12] {
        let cube = map(size, |_, _, _| [0.25, 0.5, 0.125]);
        let texture = Texture::new(&cube);
        let prepared = Prepared::new(&Settings::default());
        for _ in 0..100 {
            let f = random.fragment();
            let out = env(&prepared, &f, size, Some(&texture), &mut Strict);
            assert_eq!(out.color, [0.25, 0.5, 0.125]);
            assert!(out.lod <= f64::from(size.ilog2()));
        }
    }
}

#[test]
fn extreme_faces_of_16384_texels_have_15_levels_and_exact_addresses() {
    let f = Fragment {
        dn_dx: [1.0, 0.0, 0.0],
        ..PLAIN
    };
    let out = env(
        &Prepared::new(&Settings::default()),
        &f,
        16384,
        None,
        &mut Strict,
    );
    // λ1 = 2: M = 16384, m = 1024.
    assert_eq!((out.probes, out.lod), (16, 10.0));
    let f = Fragment {
        dn_dx: [1000.0, 0.0, 0.0],
        dn_dy: [0.0, 1000.0, 0.0],
        ..PLAIN
    };
    let out = env(
        &Prepared::new(&Settings::default()),
        &f,
        16384,
        None,
        &mut Strict,
    );
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

#[test]
fn extreme_texels_at_the_ends_of_half_floats_pass_exactly() {
    for value in [65504.0f32, 5.960_464_5e-8, -65504.0, -1.0] {
        for weights in [Weights::Box, Weights::Gaussian] {
            let cube = map(8, |_, _, _| [value; 3]);
            let texture = Texture::new(&cube);
            let prepared = Prepared::new(&Settings {
                weights,
                ..Settings::default()
            });
            let mut random = Random::new(16);
            for _ in 0..50 {
                let out = env(&prepared, &random.fragment(), 8, Some(&texture), &mut NoTap);
                assert_eq!(out.color, [f64::from(value); 3]);
            }
        }
    }
}

fn finite() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => any::<u64>().prop_map(f64::from_bits).prop_filter("finite", |x| x.is_finite()),
        1 => Just(0.0),
        1 => Just(-0.0),
        1 => Just(1.0),
        1 => Just(f64::MAX),
        1 => Just(f64::from_bits(1)),
        2 => -2.0..2.0,
    ]
}

fn vector() -> impl Strategy<Value = [f64; 3]> {
    [finite(), finite(), finite()]
}

prop_compose! {
    fn fragment()(
        v in vector(), n in vector(),
        d in [vector(), vector(), vector(), vector()],
        h in proptest::option::of(vector()),
        bump in proptest::option::of([finite(), finite()]),
        rough in proptest::option::of(vector()),
    ) -> Fragment {
        Fragment { v, n, dv_dx: d[0], dv_dy: d[1], dn_dx: d[2], dn_dy: d[3], h, bump, rough }
    }
}

prop_compose! {
    fn settings()(
        max_probes in 0u32..40,
        policy in (0usize..4, 0usize..3, 0usize..2, 0usize..2, 0usize..3),
        scale in finite(), rotate in any::<bool>(), rotation in [vector(), vector(), vector()],
        table in proptest::option::of((0u32..70, 0usize..2, 0u32..2)),
        probe_weight_bits in 0u32..20,
    ) -> Settings {
        let plain = Settings::default();
        Settings {
            max_probes,
            count: Count::ALL[policy.0],
            axis: Axis::ALL[policy.1],
            weights: Weights::ALL[policy.2],
            minor: Minor::ALL[policy.3],
            dnmod: Dnmod::ALL[policy.4],
            roughness_scale: scale,
            rotation: if rotate { rotation } else { plain.rotation },
            reference_table: table.map(|(entries, placement, order)| AngleTable {
                entries, placement: Placement::ALL[placement], order,
            }),
            probe_weight_bits,
            ..plain
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1500))]

    #[test]
    fn every_finite_fragment_gives_finite_numbers_and_the_trace_changes_nothing(
        f in fragment(), settings in settings(), size in 1usize..20_000,
    ) {
        let prepared = Prepared::new(&settings);
        let out = env(&prepared, &f, size, None, &mut NoTap);
        assert_finite(&out);
        prop_assert!(!out.flags.contains(Flag::NonFinite));
        let traced = env(&prepared, &f, size, None, &mut Strict);
        prop_assert_eq!(out, traced);
        let cube = map(5, |face, x, y| [face, x, y].map(|t| u8::try_from(t).map_or(0.0, f32::from)));
        let texture = Texture::new(&cube);
        let seen = env(&prepared, &f, size, Some(&texture), &mut NoTap);
        assert_finite(&seen);
        for channel in tapline::reference::ewa(&seen, &texture) {
            prop_assert!(channel.is_finite());
        }
    }

    #[test]
    fn numbers_that_are_not_finite_are_replaced_and_flagged(
        mut f in fragment(), at in 0usize..3, which in 0usize..3,
    ) {
        f.v[at] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY][which];
        let out = env(&Prepared::new(&Settings::default()), &f, 64, None, &mut Strict);
        assert_finite(&out);
        prop_assert!(out.flags.contains(Flag::NonFinite));
    }
}
