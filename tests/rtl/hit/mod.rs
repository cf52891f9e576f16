//! The HIT operation: outcomes, extremes, and the integer model beside the float reference.

mod exact;
mod knobs;
mod room;

use std::collections::BTreeMap;

use proptest::prelude::*;
use rtl_model::Tap;
use rtl_model::regs::Reg;
use tapline::base::random::Random;
use tapline::cube::direction;
use tapline::distance::{Distance, DistanceCube};
use tapline::engine::hit::{HitF64, HitResult, HitRtl, words};
use tapline::fragment::HitFragment;
use tapline::policy::{HitStatus, LookUp, Method, Outside};
use tapline::reference::Distances;
use tapline::unit::{ReferenceAxis, UnitSpec};

const ROOM: Distance = Distance::Box([4.0, 3.0, 2.5]);

fn ray(x: [f64; 3], r: [f64; 3]) -> HitFragment {
    HitFragment { x, r, cone: None }
}

/// The same ray by the integer model and by the float reference.
fn both(spec: &UnitSpec, distance: &Distance, ray: &HitFragment) -> [HitResult; 2] {
    let rays = std::slice::from_ref(ray);
    let rtl = HitRtl::new(spec, distance, None, 64).expect("a legal unit");
    let settings = spec.settings(ReferenceAxis::Exact);
    let float = HitF64::new(&settings, distance, None, 64);
    let mut results = rtl.filter(rays, &|_| {});
    results.extend(float.filter(rays, &|_| {}));
    results.try_into().expect("two results")
}

fn default_both(distance: &Distance, ray: &HitFragment) -> [HitResult; 2] {
    both(&UnitSpec::default(), distance, ray)
}

/// Directions and starts inside of the room, the same on every machine.
fn rays(count: usize) -> Vec<HitFragment> {
    let mut random = Random::new(1);
    // 24 bits, which every register of a ray holds.
    let mut next = || libm::ldexp((random.word() >> 40) as f64, -23) - 1.0;
    (0..count)
        .map(|_| {
            let x = [2.0 * next(), 1.5 * next(), 1.25 * next()];
            ray(x, [next(), next(), next()])
        })
        .collect()
}

#[test]
fn errata_hit_one_step_is_exact_before_a_plane_with_eq_2_and_3_corrected() {
    // x, l and R see the wall x = 4, and n·x ≥ 0: f is linear in d.
    let start = ray([1.0, 0.25, 0.125], [1.0, 0.125, 0.0625]);
    for result in default_both(&ROOM, &start) {
        assert_eq!(result.status, HitStatus::Converged);
        assert_eq!(result.iterations, 1);
        // Registers of 2^−24·16 world units: d and l within a few of them.
        assert!((result.l[0] - 4.0).abs() < 1e-5, "{result:?}");
    }
}

#[test]
fn errata_hit_false_position_never_overshoots_in_a_convex_room() {
    let settings = UnitSpec::default().settings(ReferenceAxis::Exact);
    let results = HitF64::new(&settings, &ROOM, None, 64).filter(&rays(2000), &|_| {});
    let moved = results.iter().filter(|r| r.iterations > 1).count();
    assert!(moved > 500, "only {moved} rays take more than one look-up");
    assert_eq!(results.iter().filter(|r| r.overshot).count(), 0);
}

#[test]
fn errata_hit_a_valid_bit_tells_an_overshoot_at_d_0() {
    // A start outside of the surface has d < 0 as its first guess under `hlsl`, and overshoots at once.
    let mut spec = UnitSpec::default();
    spec.config.policy.hit.outside = Outside::Hlsl;
    let start = ray([5.0, 0.0, 0.0], [1.0, 0.0, 0.0]);
    for result in both(&spec, &ROOM, &start) {
        assert_eq!(result.status, HitStatus::Converged, "{result:?}");
        assert!((result.l[0] - 4.0).abs() < 0.01, "{result:?}");
    }
}

#[test]
fn errata_hit_converges_to_a_root_and_not_always_to_the_first() {
    // Every direction is 10 away but those of +x, where a near wall stands at 1: the ray passes it at x = 1, y = 0.4,
    // seen at once from the reference point, and returns the far point all the same.
    let size = 64;
    let mut texels = vec![10.0f32; 6 * size * size];
    for y in 0..size {
        for x in 0..4 {
            texels[y * size + x + 28] = 1.0;
        }
    }
    let (cube, _) = DistanceCube::cleaned(size, texels).expect("all texels");
    let start = ray([0.5, 0.0, -4.0], [0.0, 0.0, 1.0]);
    let settings = UnitSpec::default().settings(ReferenceAxis::Exact);
    let distance = Distance::Cube(cube);
    let result = &HitF64::new(&settings, &distance, None, 64).filter(&[start], &|_| {})[0];
    // The near wall lies about z = 0 on this ray at |l| = 0.5 < 1; the root found is the far one.
    assert_eq!(result.status, HitStatus::Converged);
    assert!(result.d > 10.0, "{result:?}");
}

/// The room's distances in a cube map of 128 texels a face.
fn room_cube() -> Distance {
    let size = 128usize;
    let place = |i: usize| f64::from(u32::try_from(2 * i + 1).unwrap_or(0)) / 128.0 - 1.0;
    let ideal = Distances::new(&ROOM);
    #[expect(clippy::cast_possible_truncation, reason = "maps hold binary32")]
    let texels = (0..6 * size * size)
        .map(|i| {
            let (face, x, y) = (i / (size * size), i % size, i / size % size);
            ideal.read(direction(face, place(x), place(y)), LookUp::Bilinear) as f32
        })
        .collect();
    let (cube, changed) = DistanceCube::cleaned(size, texels).expect("all texels");
    assert_eq!(changed, 0);
    Distance::Cube(cube)
}

#[test]
fn rtl_is_within_a_tenth_of_a_degree_of_f64_at_the_99th_percentile_in_a_box_room() {
    let spec = UnitSpec::default();
    let settings = spec.settings(ReferenceAxis::Exact);
    let rays = rays(4000);
    for (name, distance) in [("ideal", ROOM), ("cube", room_cube())] {
        let rtl = HitRtl::new(&spec, &distance, None, 64).expect("a legal unit");
        let there = HitF64::new(&settings, &distance, None, 64).filter(&rays, &|_| {});
        let mut angles: Vec<f64> = rtl
            .filter(&rays, &|_| {})
            .iter()
            .zip(&there)
            .map(|(a, b)| angle_deg(a.l, b.l))
            .collect();
        angles.sort_by(f64::total_cmp);
        let [median, p99, worst] = [2000, 3960, 3999].map(|i| angles[i]);
        eprintln!("{name}, degrees: median {median}, 99 % {p99}, worst {worst}");
        assert!(worst > 0.0, "nothing differs at all");
        assert!(p99 < 0.1, "{name}: {p99}");
    }
}

fn angle_deg(a: [f64; 3], b: [f64; 3]) -> f64 {
    let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let sine = (cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]).sqrt();
    libm::atan2(sine, a[0] * b[0] + a[1] * b[1] + a[2] * b[2]).to_degrees()
}

#[test]
fn extreme_starts_at_and_outside_of_the_surface() {
    for (x, status) in [
        (4.0, HitStatus::AtSurface),
        (4.0 * (1.0 - 0.5 / 1024.0), HitStatus::AtSurface),
        (4.0 * (1.0 + 0.5 / 1024.0), HitStatus::AtSurface),
        (4.0 * (1.0 + 2.0 / 1024.0), HitStatus::Outside),
        (9.0, HitStatus::Outside),
    ] {
        for result in default_both(&ROOM, &ray([x, 0.0, 0.0], [1.0, 0.0, 0.0])) {
            assert_eq!(result.status, status, "{x}");
            assert_eq!((result.iterations, result.ratio), (0, None));
            assert!(result.d.abs() < 1e-12);
        }
    }
}

#[test]
fn extreme_no_iterations_leave_the_first_guess_and_no_ratio() {
    let mut spec = UnitSpec::default();
    spec.config.policy.hit.iterations = 0;
    for result in both(&spec, &ROOM, &ray([1.0, 1.0, 0.0], [0.0, 0.0, 1.0])) {
        assert_eq!(result.status, HitStatus::MaxIterations);
        assert_eq!((result.iterations, result.ratio), (0, None));
    }
}

#[test]
fn extreme_tolerance_0_stalls_or_converges_exactly() {
    let mut spec = UnitSpec::default();
    spec.config.policy.hit.tolerance_bits = None;
    spec.config.policy.hit.iterations = 64;
    spec.config.policy.hit.method = Method::Illinois;
    // A bracket of one unit of d holds a jump of f of at most one unit of a distance, 2^−19·8 of at least 2.5; 1/dist,
    // |l| and f round to a sixteenth of that beside it. In doubles the jump is a few ulp.
    let unit = libm::ldexp(8.0 / 2.5, -19);
    let bounds = [unit + 4.0 * unit / 16.0, 1e-12];
    let results = both(&spec, &ROOM, &ray([1.0, 0.7, 0.3], [-0.3, 0.2, 0.5]));
    for (result, bound) in results.iter().zip(bounds) {
        let ended = [HitStatus::Stalled, HitStatus::Converged, HitStatus::MaxIterations];
        assert!(ended.contains(&result.status));
        let ratio = result.ratio.expect("look-ups");
        assert!((ratio - 1.0).abs() < bound, "{ratio}");
    }
}

#[test]
fn extreme_directions_along_axes_and_grazing_rays_end_on_the_wall() {
    let mut spec = UnitSpec::default();
    spec.config.policy.hit.iterations = 32;
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let mut r = [0.0; 3];
            r[axis] = sign;
            for result in both(&spec, &ROOM, &ray([0.5, 0.25, -0.5], r)) {
                assert_eq!(result.status, HitStatus::Converged);
                let wall = [4.0, 3.0, 2.5][axis];
                assert!((result.l[axis] * sign - wall).abs() < wall / 1000.0);
            }
        }
    }
    // Along the wall z = 2.5, a little below it: the hit is on x = 4 or still on that wall within τ.
    for result in both(&spec, &ROOM, &ray([0.0, 0.0, 2.49], [1.0, 0.0, 1e-4])) {
        let gauge = (result.l[0] / 4.0).max(result.l[2] / 2.5);
        assert!((gauge - 1.0).abs() < 0.01, "{result:?}");
    }
}

#[test]
fn extreme_distances_at_and_beyond_the_largest_register_value() {
    let sphere = Distance::Sphere(1.0 - libm::ldexp(1.0, -20));
    let start = ray([0.25, 0.0, 0.0], [0.0, 1.0, 0.0]);
    for result in default_both(&sphere, &start) {
        assert!(!result.flags.iter().any(|f| f == "hit.distance.saturated"));
        assert_ne!(result.status, HitStatus::Escaped);
    }
    // What would round beyond it has the next power of two.
    let sphere = Distance::Sphere(1.0 - libm::ldexp(1.0, -30));
    for result in default_both(&sphere, &start) {
        assert_ne!(result.status, HitStatus::Escaped);
        assert!((libm::hypot(result.l[0], result.l[1]) - 1.0).abs() < 0.01);
    }
    // Beyond a register that is a bit too short nothing is there.
    let mut spec = UnitSpec::default();
    spec.config.formats[Reg::HitDistance.index()].int = 0;
    let [rtl, float] = both(&spec, &sphere, &start);
    assert_eq!(rtl.status, HitStatus::Escaped);
    assert!(rtl.flags.iter().any(|f| f == "hit.distance.saturated"));
    assert_ne!(float.status, HitStatus::Escaped);
}

#[test]
fn extreme_equal_ratios_on_both_sides_and_a_step_of_0_stall() {
    // hlsl from far outside: the ratio register is at its top on both ends of the bracket, f − p = 0.
    let mut spec = UnitSpec::default();
    spec.config.policy.hit.outside = Outside::Hlsl;
    let [rtl, _] = both(&spec, &Distance::Sphere(1.0), &ray([0.0, 3.0, 0.0], [1.0, 0.0, 0.0]));
    assert!([HitStatus::Stalled, HitStatus::MaxIterations].contains(&rtl.status));
    // A map of zeros: every f is the largest, on both engines.
    let (zeros, _) = DistanceCube::cleaned(1, vec![0.0; 6]).expect("six texels");
    for result in both(&spec, &Distance::Cube(zeros), &ray([0.5, 0.0, 0.0], [1.0, 0.0, 0.0])) {
        assert_eq!(result.status, HitStatus::Stalled, "{result:?}");
        assert_eq!(result.iterations, 1);
    }
}

#[test]
fn a_room_of_a_millimetre_and_one_of_a_kilometre_have_the_same_codes() {
    let engine = |scale: f64| {
        let room = Distance::Box([4.0, 3.0, 2.5].map(|h| h * scale));
        HitRtl::new(&UnitSpec::default(), &room, None, 64).expect("a legal unit")
    };
    let small = libm::ldexp(1.0, -10);
    let large = libm::ldexp(1.0, 10);
    let [base, small_room, large_room] = [1.0, small, large].map(engine);
    for one in rays(100) {
        let codes = |engine: &HitRtl, scale: f64| {
            let scaled = ray(one.x.map(|c| c * scale), one.r);
            let (block, _) = engine.lanes::<1, _>(&[words(&scaled)], &mut rtl_model::NoTap);
            let hit = block.front.hit;
            (hit.d[0], hit.l, hit.status[0])
        };
        let here = codes(&base, 1.0);
        assert_eq!(codes(&small_room, small), here);
        assert_eq!(codes(&large_room, large), here);
    }
}

#[test]
fn extreme_infinite_zero_and_nan_distances() {
    let cube = |t: f32| {
        let (cube, _) = DistanceCube::cleaned(2, vec![t; 24]).expect("24 texels");
        Distance::Cube(cube)
    };
    let start = ray([0.5, 0.0, 0.0], [0.0, 1.0, 0.0]);
    for t in [f32::INFINITY, f32::NAN, -1.0] {
        for result in default_both(&cube(t), &start) {
            assert_eq!(result.status, HitStatus::Escaped);
            assert!(result.d.is_infinite());
            assert!((result.l[1] - 1.0).abs() < 1e-6);
        }
    }
    for result in default_both(&cube(0.0), &start) {
        assert_eq!(result.status, HitStatus::Outside);
    }
}

/// Every write of every lane.
struct Lanes(Vec<BTreeMap<(Reg, usize), (i64, i64)>>);

impl Tap for Lanes {
    fn put(&mut self, lane: usize, reg: Reg, component: usize, raw: i64, frac: i64) {
        self.0[lane].insert((reg, component), (raw, frac));
    }
}

#[test]
fn a_batch_has_the_traced_registers() {
    let engine = HitRtl::new(&UnitSpec::default(), &ROOM, None, 64).expect("a legal unit");
    let mut all = rays(64);
    for ray in &mut all {
        ray.cone = Some([0.001, 0.01]);
    }
    batch::<8>(&engine, &all);
    batch::<32>(&engine, &all[..50]);
    // Rays without a cone beside others, one of them with no direction to its hit.
    let mut mixed = all.clone();
    for ray in mixed.iter_mut().step_by(3) {
        ray.cone = None;
    }
    mixed[3].x = [0.0; 3];
    for (ray, result) in mixed.iter().zip(engine.filter(&mixed, &|_| {})) {
        let (block, out) = engine.lanes::<1, _>(&[words(ray)], &mut rtl_model::NoTap);
        assert_eq!(engine.result(&block, &out, 0), result);
    }
    // The engine's own tap and its vector instructions: the same results.
    let whole = engine.filter(&all, &|_| {});
    for (ray, result) in all.iter().zip(&whole) {
        let (block, out) = engine.lanes::<1, _>(&[words(ray)], &mut rtl_model::NoTap);
        assert_eq!(&engine.result(&block, &out, 0), result);
    }
}

fn batch<const N: usize>(engine: &HitRtl, all: &[HitFragment]) {
    for chunk in all.chunks(N) {
        let mut batch = Lanes(vec![BTreeMap::new(); N]);
        let rays: Vec<_> = chunk.iter().map(words).collect();
        engine.lanes::<N, _>(&rays, &mut batch);
        for (lane, ray) in chunk.iter().enumerate() {
            let mut alone = Lanes(vec![BTreeMap::new()]);
            engine.lanes::<1, _>(&[words(ray)], &mut alone);
            assert!(alone.0[0].len() > 40);
            assert_eq!(alone.0[0], batch.0[lane]);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn any_bits_make_no_panic(bits in prop::array::uniform8(any::<u64>()), cone in any::<bool>()) {
        let f = bits.map(f64::from_bits);
        let ray = HitFragment {
            x: [f[0], f[1], f[2]],
            r: [f[3], f[4], f[5]],
            cone: cone.then_some([f[6], f[7]]),
        };
        for result in default_both(&ROOM, &ray) {
            prop_assert!(result.l.iter().all(|c| c.is_finite()));
            prop_assert!(!result.d.is_nan());
        }
    }
}
