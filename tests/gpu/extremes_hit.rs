//! Extremes of the HIT operation on the device: outcomes as the float reference has them, registers one by one.

use tapline::distance::{Distance, DistanceCube};
use tapline::engine::gpu::check::check_hit;
use tapline::engine::gpu::hit::GpuHit;
use tapline::engine::hit::{HitF64, HitResult};
use tapline::fragment::HitFragment;
use tapline::gpu::Gpu;
use tapline::policy::{HitPolicy, HitStatus, Method, Outside};
use tapline::settings::Settings;

use crate::checks::{assert_explained, compared, noisy_cube};
use support::gpu::on_gpu;

const ROOM: Distance = Distance::Box([4.0, 3.0, 2.5]);

fn ray(x: [f64; 3], r: [f64; 3]) -> HitFragment {
    HitFragment { x, r, cone: Some([0.0009765625, 0.0078125]) }
}

fn with(hit: HitPolicy) -> Settings {
    Settings::default().with(|p| p.hit = hit)
}

/// The rays by the device, every register explained, and by the float reference.
fn run(
    gpu: &Gpu,
    settings: &Settings,
    distance: &Distance,
    rays: &[HitFragment],
) -> Vec<[HitResult; 2]> {
    let map = noisy_cube(32);
    let numbered: Vec<_> = (0u32..).zip(rays).map(|(i, ray)| ([i, 0], *ray)).collect();
    let maps = (&map, distance);
    let checks = check_hit(gpu, settings, maps, &numbered, &|_| {}).expect("the device stays");
    assert_explained(&checks, 10);
    let engine = GpuHit::new(gpu, settings, distance, Some(&map), 32).expect("small maps");
    let here = engine.filter(rays, &|_| {}).expect("the device stays");
    let there = HitF64::new(settings, distance, Some(&map), 32).filter(rays, &|_| {});
    here.into_iter().zip(there).map(|(a, b)| [a, b]).collect()
}

/// Status, look-ups and flags are the reference's, d and the colour are near its.
fn agree(both: &[[HitResult; 2]]) {
    for [a, b] in both {
        assert_eq!((a.status, a.iterations), (b.status, b.iterations), "{a:?} {b:?}");
        assert_eq!(a.flags, b.flags);
        assert!(a.d == b.d || (a.d - b.d).abs() <= 1e-5 * b.d.abs().max(1.0), "{a:?} {b:?}");
        for c in 0..3 {
            assert!((a.color[c] - b.color[c]).abs() <= 1e-3, "{a:?} {b:?}");
        }
    }
}

fn extreme(settings: &Settings, distance: &Distance, rays: &[HitFragment], status: HitStatus) {
    on_gpu(|gpu| {
        let both = run(gpu, settings, distance, rays);
        agree(&both);
        assert!(both.iter().all(|[a, _]| a.status == status), "{both:?}");
    });
}

#[test]
fn extreme_x_at_beyond_and_outside_of_the_reference_surface() {
    let settings = Settings::default();
    let to = [1.0, 0.125, 0.0625];
    extreme(&settings, &ROOM, &[ray([4.0, 0.0, 0.0], to)], HitStatus::AtSurface);
    let outside = [ray([5.0, 0.0, 0.0], to), ray([0.0, 1e6, 0.0], to)];
    extreme(&settings, &ROOM, &outside, HitStatus::Outside);
    let hlsl = with(HitPolicy { outside: Outside::Hlsl, ..HitPolicy::default() });
    on_gpu(|gpu| {
        let both = run(gpu, &hlsl, &ROOM, &[ray([5.0, 0.0, 0.0], [1.0, 0.0, 0.0])]);
        agree(&both);
        assert_eq!((both[0][0].status, both[0][0].d), (HitStatus::Converged, -1.0));
    });
}

#[test]
fn extreme_p_un_at_1_less_and_more_than_the_tolerance() {
    on_gpu(|gpu| {
        let tau = 1.0 / 1024.0;
        let rays = [-1.0, 1.0]
            .iter()
            .flat_map(|sign| {
                [0.5, 2.0]
                    .map(|part| ray([4.0 * (1.0 + sign * part * tau), 0.0, 0.0], [1.0, 0.25, 0.0]))
            })
            .collect::<Vec<_>>();
        let both = run(gpu, &Settings::default(), &ROOM, &rays);
        agree(&both);
        let status: Vec<HitStatus> = both.iter().map(|[a, _]| a.status).collect();
        assert_eq!(
            [status[0], status[2], status[3]],
            [HitStatus::AtSurface, HitStatus::AtSurface, HitStatus::Outside]
        );
        assert_ne!(status[1], HitStatus::AtSurface);
    });
}

/// A cube map of distances, all alike but for those of one face.
fn cube(all: f32, plus_x: f32) -> Distance {
    let size = 8;
    let mut texels = vec![all; 6 * size * size];
    texels[..size * size].fill(plus_x);
    let (cube, _) = DistanceCube::cleaned(size, texels).expect("all texels");
    Distance::Cube(cube)
}

#[test]
fn extreme_distance_0_infinite_nan_and_the_largest() {
    on_gpu(|gpu| {
        let settings = Settings::default();
        let along = ray([0.5, 0.25, 0.0], [1.0, 0.0, 0.0]);
        let across = ray([0.5, 0.25, 0.0], [0.0, 1.0, 0.25]);
        for far in [0.0, f32::INFINITY, f32::NAN, 60_000.0, 3e30] {
            agree(&run(gpu, &settings, &cube(2.0, far), &[along, across]));
            agree(&run(gpu, &settings, &cube(far, 2.0), &[along, across]));
        }
        let nothing = run(gpu, &settings, &Distance::nothing(), &[along]);
        assert_eq!(nothing[0][0].status, HitStatus::Escaped);
        assert_eq!(nothing[0][0].d, f64::INFINITY);
    });
}

#[test]
fn extreme_a_ratio_equal_to_the_other_end_s_and_a_step_of_0() {
    // From one wall to the other of a sphere, exactly: the first guess is the hit; and τ = 0 leaves no step.
    for method in [Method::FalsePosition, Method::Secant, Method::Illinois] {
        let settings = with(HitPolicy {
            method,
            iterations: 40,
            tolerance_bits: None,
            ..HitPolicy::default()
        });
        on_gpu(|gpu| {
            let rays = [
                ray([0.0; 3], [1.0, 0.0, 0.0]),
                ray([0.5, 0.25, -0.125], [0.25, 1.0, 0.5]),
                ray([-0.5, 0.5, 0.25], [1.0, 1.0, -1.0]),
            ];
            let both = run(gpu, &settings, &Distance::Sphere(2.0), &rays);
            // Without a tolerance a search ends where no bit of an f32 is left: a converged or a stalled one.
            for [a, b] in &both {
                assert!([HitStatus::Converged, HitStatus::Stalled].contains(&a.status), "{a:?}");
                assert!((a.d - b.d).abs() <= 4.0 * f64::from(f32::EPSILON) * b.d, "{a:?} {b:?}");
            }
        });
    }
}

#[test]
fn extreme_r_along_an_axis_and_grazing_rays() {
    let rays: Vec<HitFragment> =
        [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1e-6, 0.0], [1e-20, 1.0, 1e-20]]
            .map(|r| ray([1.0, 2.875, -0.25], r))
            .to_vec();
    on_gpu(|gpu| agree(&run(gpu, &Settings::default(), &ROOM, &rays)));
}

#[test]
fn extreme_r_of_0_is_plus_z_and_flagged() {
    on_gpu(|gpu| {
        let both = run(gpu, &Settings::default(), &ROOM, &[ray([0.5, 0.0, 0.0], [0.0; 3])]);
        agree(&both);
        assert!(both[0][0].flags.iter().any(|f| f == "hit.no_direction"));
    });
}

#[test]
fn extreme_no_iterations_and_no_tolerance() {
    let none = with(HitPolicy { iterations: 0, ..HitPolicy::default() });
    extreme(&none, &ROOM, &[ray([1.0, 0.25, 0.125], [1.0, 0.125, 0.0])], HitStatus::MaxIterations);
    on_gpu(|gpu| {
        let both = run(gpu, &none, &ROOM, &[ray([1.0, 0.25, 0.125], [1.0, 0.125, 0.0])]);
        assert_eq!((both[0][0].ratio, both[0][0].iterations), (None, 0));
    });
}

#[test]
fn a_room_s_registers_are_compared_one_by_one() {
    on_gpu(|gpu| {
        let map = noisy_cube(32);
        let mut next = 1usize;
        let mut number = || {
            next += 1;
            f64::from(crate::checks::noise(next)) - 0.5
        };
        let rays: Vec<([u32; 2], HitFragment)> = (0..500)
            .map(|i| {
                let x = [4.0 * number(), 3.0 * number(), 2.5 * number()];
                ([i, 0], ray(x, [number(), number(), number()]))
            })
            .collect();
        let distance = cube(2.0, 1.0);
        let checks = check_hit(gpu, &Settings::default(), (&map, &distance), &rays, &|_| {})
            .expect("the device stays");
        assert_explained(&checks, 10_000);
        for register in ["r", "radius", "length", "ratio", "step", "d", "l", "tangent", "width"] {
            let compared = compared(&checks, "hit", register);
            assert!(compared >= 400, "hit.{register}: {compared}");
        }
    });
}
