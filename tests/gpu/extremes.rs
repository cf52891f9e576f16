//! Extremes of the ENV operation on the device: one test a case. Every register of every stage is explained there, and the
//! fused kernel agrees with the float reference or reports that it left the range of f32.

use tapline::cube::CubeMap;
use tapline::engine::gpu::check::check_env;
use tapline::engine::gpu::{Filtered, GpuEnv, flag_names};
use tapline::fragment::Fragment;
use tapline::gpu::Gpu;
use tapline::reference::{Env, NoTap, Prepared, Texture, env};
use tapline::settings::Settings;

use crate::checks::{PLAIN, assert_explained, noisy_cube, numbered};
use support::gpu::on_gpu;

/// The names of flags that a device may add: it left its range.
const OWN: [&str; 3] = ["gpu.overflow", "gpu.input.saturated", "gpu.input.underflow"];

pub(crate) struct Both {
    pub(crate) gpu: Filtered,
    pub(crate) f64: Env,
    pub(crate) names: Vec<&'static str>,
}

impl Both {
    pub(crate) fn left_the_range(&self) -> bool {
        self.names.iter().any(|n| OWN.contains(n) || n.ends_with(".saturated"))
    }
}

/// The fragments through stage checks, the fused kernel and the float reference.
pub(crate) fn run(
    gpu: &Gpu,
    settings: &Settings,
    map: &CubeMap,
    fragments: &[Fragment],
) -> Vec<Both> {
    let numbered = numbered(fragments);
    let checks = check_env(gpu, settings, map, &numbered, &|_| {}).expect("the device stays");
    assert_explained(&checks, 20);
    let engine = GpuEnv::new(gpu, settings, map, fragments.first()).expect("a map within limits");
    let (results, reports) = engine.filter(&numbered, &|_| {}).expect("the device stays");
    let prepared = Prepared::new(settings);
    let texture = Texture::new(map);
    let both: Vec<Both> = results
        .into_iter()
        .zip(fragments)
        .map(|(gpu, fragment)| Both {
            names: flag_names(gpu.flags),
            gpu,
            f64: env(&prepared, fragment, map.size(), Some(&texture), &mut NoTap),
        })
        .collect();
    let left = both.iter().filter(|b| b.left_the_range()).count();
    assert_eq!(reports.beyond_f32.map_or(0, |(n, _)| n), u64::try_from(left).unwrap_or(0));
    both
}

/// The fused kernel has the reference's probes, flags, LOD and colour: `steps` 8-bit steps of the map's range at most.
pub(crate) fn agree(both: &[Both], steps: f64) {
    for (i, b) in both.iter().enumerate() {
        assert!(b.gpu.color.iter().all(|c| c.is_finite()), "{i}");
        if b.left_the_range() {
            continue;
        }
        let theirs: Vec<&str> = b.f64.flags.names().collect();
        assert_eq!(b.names, theirs, "{i}");
        assert_eq!(b.gpu.probes, b.f64.probes, "{i}");
        assert!((b.gpu.lod - b.f64.lod).abs() < 1e-4, "{i}: {} {}", b.gpu.lod, b.f64.lod);
        for c in 0..3 {
            let off = (b.gpu.color[c] - b.f64.color[c]).abs();
            assert!(off <= steps / 255.0, "{i}: {:?} {:?}", b.gpu.color, b.f64.color);
        }
    }
}

/// The cases of one extreme, which nothing takes out of the range.
pub(crate) fn extreme(fragments: &[Fragment]) {
    on_gpu(|gpu| {
        let both = run(gpu, &Settings::default(), &noisy_cube(64), fragments);
        assert!(both.iter().all(|b| !b.left_the_range()), "within the range of f32");
        agree(&both, 0.05);
    });
}

/// v, n along z; ∂n given: D = 2·∂n there.
pub(crate) fn bent(dn_dx: [f64; 3], dn_dy: [f64; 3]) -> Fragment {
    Fragment { dn_dx, dn_dy, ..PLAIN }
}

#[test]
fn extreme_k_zero() {
    extreme(&[PLAIN]);
}

#[test]
fn extreme_k_isotropic() {
    extreme(&[bent([0.0625, 0.0, 0.0], [0.0, 0.0625, 0.0])]);
}

#[test]
fn extreme_a_equal_to_c_with_b() {
    for sign in [1.0, -1.0] {
        extreme(&[bent([0.0625, sign * 0.03125, 0.0], [sign * 0.03125, 0.0625, 0.0])]);
    }
}

#[test]
fn extreme_rank_one_k() {
    extreme(&[bent([0.1875, -0.25, 0.0], [0.0; 3]), bent([0.0; 3], [0.125, 0.125, 0.0])]);
}

#[test]
fn extreme_lambda_ratio_of_a_million() {
    extreme(&[bent([0.25, 0.0, 0.0], [0.0, 0.25e-6, 0.0])]);
}

#[test]
fn extreme_silhouette() {
    let fragments = [1e-3, 1e-10, 1e-30, 0.0].map(|cosine| Fragment {
        v: [1.0, 0.0, cosine],
        dv_dx: [0.0, 0.25, 0.0],
        dn_dx: [0.5, 0.0, 0.0],
        ..PLAIN
    });
    extreme(&fragments);
}

#[test]
fn extreme_a_normal_that_faces_away() {
    extreme(&[Fragment {
        n: [0.25, 0.125, -1.0],
        dv_dx: [-0.0625, 0.0, 0.0],
        dn_dx: [0.03125, 0.0, 0.0],
        ..PLAIN
    }]);
}

#[test]
fn extreme_no_reflected_direction() {
    on_gpu(|gpu| {
        let fragments: Vec<Fragment> =
            [([0.0; 3], [1.0, 2.0, 3.0]), ([1.0, 2.0, 3.0], [0.0; 3]), ([-0.0; 3], [-0.0; 3])]
                .map(|(v, n)| Fragment {
                    v,
                    n,
                    dv_dx: [1.0, 2.0, -3.0],
                    dn_dx: [3.0, 1.0, -1.0],
                    h: Some([0.0, 1.0, 0.0]),
                    bump: Some([1.0, 2.0]),
                    rough: Some([1.0, 2.0, 3.0]),
                    ..PLAIN
                })
                .to_vec();
        let both = run(gpu, &Settings::default(), &noisy_cube(64), &fragments);
        agree(&both, 0.05);
        for b in &both {
            assert!(b.names.contains(&"cube_face.zero"));
            assert_eq!((b.gpu.probes, b.gpu.lod), (1, 0.0));
        }
    });
}

#[test]
fn extreme_length_of_n_from_2_to_the_minus_10_to_2_to_the_10() {
    let fragments: Vec<Fragment> = (-10..=10)
        .map(|power| {
            let scale = libm::exp2(f64::from(power));
            let by = |v: [f64; 3]| v.map(|c| c * scale);
            Fragment {
                v: [0.25, 0.5, 1.0],
                n: by([0.125, -0.25, 1.0]),
                dv_dx: [-0.03125, 0.0, 0.0],
                dv_dy: [0.0, -0.03125, 0.0],
                dn_dx: by([0.03125, 0.0, 0.015625]),
                dn_dy: by([0.0, 0.03125, 0.0]),
                h: Some([0.0, 1.0, 0.0]),
                bump: Some([0.25, -0.5]),
                rough: Some([0.015625, 0.0078125, 0.0078125]),
            }
        })
        .collect();
    extreme(&fragments);
}

#[test]
fn extreme_derivatives_of_n_far_above_n_and_an_overflow_that_is_reported() {
    on_gpu(|gpu| {
        let fragments =
            [1e3, 1e9, 1e18, 1e25, 1e37].map(|size| bent([size, 0.0, 0.0], [0.0, 1.0, 0.0]));
        let both = run(gpu, &Settings::default(), &noisy_cube(64), &fragments);
        agree(&both, 0.05);
        assert!(!both[0].left_the_range() && !both[1].left_the_range());
        // K is beyond 2¹²⁸ from |D| = 2⁶⁴ on; doubles are not.
        for b in &both[3..] {
            assert!(b.names.contains(&"covariance.k.saturated"), "{:?}", b.names);
            assert!(b.f64.flags.is_empty());
            assert_eq!((b.gpu.probes, b.gpu.lod), (b.f64.probes, b.f64.lod));
        }
    });
}

#[test]
fn extreme_bump_of_14() {
    extreme(&[Fragment {
        v: [0.25, 0.5, 1.0],
        h: Some([0.0, 1.0, 0.0]),
        bump: Some([14.0, -14.0]),
        dv_dx: [-0.0009765625, 0.0, 0.0],
        dv_dy: [0.0, -0.0009765625, 0.0],
        ..PLAIN
    }]);
}

#[test]
fn extreme_one_of_a_and_c_at_the_top_of_its_register() {
    extreme(&[
        bent([127.0, 0.0, 0.0], [0.0, 0.0009765625, 0.0]),
        bent([0.0009765625, 0.0, 0.0], [0.0, 127.0, 0.0]),
    ]);
}

#[test]
fn extreme_minus_zero_counts_as_plus_zero() {
    on_gpu(|gpu| {
        let f = bent([0.0625, 0.0, 0.0], [0.0, 0.03125, 0.0]);
        let minus = |v: [f64; 3]| v.map(|c| if c == 0.0 { -0.0 } else { c });
        let g = Fragment {
            v: minus(f.v),
            n: minus(f.n),
            dv_dx: minus(f.dv_dx),
            dv_dy: minus(f.dv_dy),
            dn_dx: minus(f.dn_dx),
            dn_dy: minus(f.dn_dy),
            ..f
        };
        let both = run(gpu, &Settings::default(), &noisy_cube(64), &[f, g]);
        agree(&both, 0.05);
        assert_eq!(both[0].gpu, both[1].gpu);
    });
}

/// Settings whose axis comes from the angle table.
fn with_table() -> Settings {
    use tapline::policy::Placement;
    use tapline::settings::AngleTable;
    Settings {
        reference_table: Some(AngleTable { entries: 32, placement: Placement::Edges, order: 0 }),
        ..Settings::default()
    }
}

#[test]
fn extreme_alpha_at_a_table_boundary_and_one_ulp_to_each_side() {
    on_gpu(|gpu| {
        // The boundary between the entries 0 and 1 of 32: half of 90°/32.
        let alpha = std::f64::consts::FRAC_PI_2 / 64.0;
        let fragments: Vec<Fragment> = [-1.0, 0.0, 1.0]
            .map(|ulp| {
                let alpha = alpha * (1.0 + ulp * libm::exp2(-20.0));
                let (c, s) = (libm::cos(alpha), libm::sin(alpha));
                bent([0.25 * c, -0.25 * s, 0.0], [0.03125 * s, 0.03125 * c, 0.0])
            })
            .to_vec();
        let both = run(gpu, &with_table(), &noisy_cube(64), &fragments);
        // Exactly at the boundary either entry is right: the probes are the same, their line is one of the two.
        agree(
            &[&both[0], &both[2]].map(|b| Both { gpu: b.gpu, f64: b.f64, names: b.names.clone() }),
            0.05,
        );
        assert_eq!(both[1].gpu.probes, both[1].f64.probes);
        assert!(both[0].f64.axis != both[2].f64.axis, "the entries differ");
        let one_of =
            |of: &Both| (0..3).all(|c| (both[1].gpu.color[c] - of.gpu.color[c]).abs() < 1e-4);
        assert!(one_of(&both[0]) || one_of(&both[2]));
    });
}

#[test]
fn extreme_count_at_a_boundary_and_one_ulp_to_each_side() {
    on_gpu(|gpu| {
        // M/m = 4 + 2⁻⁸ is where a fifth probe begins; λ = 2|∂n| here, N/2 = 32.
        let fragments: Vec<Fragment> = [-1.0, 0.0, 1.0]
            .map(|ulp| {
                let ratio = 4.0 + 1.0 / 256.0 + ulp * libm::exp2(-18.0);
                bent([0.03125 * ratio, 0.0, 0.0], [0.0, 0.03125, 0.0])
            })
            .to_vec();
        let both = run(gpu, &Settings::default(), &noisy_cube(64), &fragments);
        let counts: Vec<u32> = both.iter().map(|b| b.gpu.probes).collect();
        assert_eq!((counts[0], counts[2]), (4, 5));
        assert!([4, 5].contains(&counts[1]), "at the boundary either is right: {counts:?}");
        agree(&both[..1], 0.05);
        agree(&both[2..], 0.05);
    });
}

#[test]
fn extreme_one_probe_at_most() {
    on_gpu(|gpu| {
        let settings = Settings::default().with(|p| p.footprint.max_probes = 1);
        let both =
            run(gpu, &settings, &noisy_cube(64), &[bent([0.25, 0.0, 0.0], [0.0, 0.03125, 0.0])]);
        agree(&both, 0.05);
        assert_eq!(both[0].gpu.probes, 1);
    });
}

#[test]
fn extreme_h_parallel_to_n() {
    on_gpu(|gpu| {
        let fragments = [[0.0, 0.0, 2.0], [0.0; 3], [0.0, 0.0, -1.0]].map(|h| Fragment {
            h: Some(h),
            bump: Some([0.25, 0.0]),
            dv_dx: [-0.0625, 0.0, 0.0],
            ..PLAIN
        });
        let both = run(gpu, &Settings::default(), &noisy_cube(64), &fragments);
        agree(&both, 0.05);
        assert!(both.iter().all(|b| b.names.contains(&"local_frame.parallel")));
    });
}

#[test]
fn extreme_covariances_with_c_0_with_b_squared_above_ac_and_all_zero() {
    // d1, d2, d3 as the pyramid makes them: c = 0 leaves d1; rounding leaves d1 = 0; nothing at all.
    let fragments: Vec<Fragment> = [[0.25, 0.0, 0.0], [0.0, 0.25, 0.125], [0.0; 3]]
        .map(|rough| Fragment {
            h: Some([0.0, 1.0, 0.0]),
            rough: Some(rough),
            dv_dx: [-0.015625, 0.0, 0.0],
            dv_dy: [0.0, -0.015625, 0.0],
            ..PLAIN
        })
        .to_vec();
    extreme(&fragments);
}

#[test]
fn extreme_numbers_that_are_not_finite_or_beyond_f32_are_reported() {
    on_gpu(|gpu| {
        let fragments = [
            Fragment { v: [f64::NAN, 0.0, 1.0], ..PLAIN },
            Fragment { v: [f64::INFINITY, 0.0, 1.0], ..PLAIN },
            Fragment { v: [0.0, 0.0, 1e300], ..PLAIN },
            Fragment { v: [0.0, 0.0, 1e-300], ..PLAIN },
        ];
        let map = noisy_cube(8);
        let settings = Settings::default();
        let engine = GpuEnv::new(gpu, &settings, &map, fragments.first()).expect("a small map");
        let (results, reports) =
            engine.filter(&numbered(&fragments), &|_| {}).expect("the device stays");
        let names: Vec<Vec<&str>> = results.iter().map(|r| flag_names(r.flags)).collect();
        assert_eq!(names[0], ["reflect.non_finite"]);
        assert_eq!(names[1], ["reflect.non_finite"]);
        assert!(names[2].contains(&"gpu.input.saturated"), "{names:?}");
        assert!(names[3].contains(&"gpu.input.underflow"), "{names:?}");
        assert_eq!(reports.beyond_f32, Some((2, [2, 0])));
        assert!(results.iter().all(|r| r.color.iter().all(|c| c.is_finite())));
    });
}
