//! Every policy on the device: each value changes what it is for, the registers stay explained, and the picture stays the
//! float reference's.

use tapline::cube::CubeMap;
use tapline::distance::Distance;
use tapline::engine::gpu::GpuEnv;
use tapline::engine::gpu::check::{check_env, check_hit};
use tapline::engine::gpu::hit::GpuHit;
use tapline::engine::hit::HitF64;
use tapline::fragment::{Fragment, HitFragment, PixelFragment};
use tapline::gpu::Gpu;
use tapline::policy::{
    Axis, ConeEnv, Count, Dnmod, HitFootprint, HitPolicy, LookUp, Method, Minor, Outside, Weights,
};
use tapline::reference::{NoTap, Prepared, Texture, env};
use tapline::settings::Settings;

use crate::checks::{assert_explained, noise, noisy_cube, numbered};
use support::gpu::on_gpu;

fn fragments() -> Vec<Fragment> {
    let mut next = 100usize;
    let mut number = || {
        next += 1;
        f64::from(noise(next)) - 0.5
    };
    let mut vector = |scale: f64| [number(), number(), number()].map(|c| c * scale);
    (0..200)
        .map(|_| {
            let around = vector(1.0);
            Fragment {
                v: vector(2.0),
                n: [around[0], around[1], around[2] + 1.0],
                dv_dx: vector(0.02),
                dv_dy: vector(0.02),
                dn_dx: vector(0.1),
                dn_dy: vector(0.1),
                h: Some(vector(1.0)),
                bump: Some([vector(1.0)[0], vector(1.0)[1]]),
                rough: Some(vector(0.1)),
            }
        })
        .collect()
}

/// The largest difference from the reference, and the colours.
fn env_off(
    gpu: &Gpu,
    settings: &Settings,
    map: &CubeMap,
    all: &[PixelFragment],
) -> (f64, Vec<[f64; 3]>) {
    let first = all.first().map(|f| &f.fragment);
    let engine = GpuEnv::new(gpu, settings, map, first).expect("a small map");
    let (results, _) = engine.filter(all, &|_| {}).expect("the device stays");
    let prepared = Prepared::new(settings);
    let texture = Texture::new(map);
    let mut worst = 0.0f64;
    for (result, f) in results.iter().zip(all) {
        let there = env(&prepared, &f.fragment, map.size(), Some(&texture), &mut NoTap);
        // Another count is a decision at its boundary, which the stage checks judge.
        if there.probes == result.probes {
            for c in 0..3 {
                worst = worst.max((there.color[c] - result.color[c]).abs());
            }
        }
    }
    (worst, results.iter().map(|r| r.color).collect())
}

#[test]
fn every_policy_of_env_is_honoured() {
    on_gpu(|gpu| {
        let map = noisy_cube(64);
        let all = numbered(&fragments());
        let base = Settings::default();
        let (_, plain) = env_off(gpu, &base, &map, &all);
        let turned = [[0.8, -0.6, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]];
        let cases: Vec<(&str, Settings)> = vec![
            ("dnmod paper", base.clone().with(|p| p.jacobian.dnmod = Dnmod::Paper)),
            ("dnmod frame", base.clone().with(|p| p.jacobian.dnmod = Dnmod::Frame)),
            ("minor det", base.clone().with(|p| p.eigen.minor = Minor::Det)),
            ("longer", base.clone().with(|p| p.footprint.axis = Axis::LongerDerivative)),
            ("round", base.clone().with(|p| p.footprint.count = Count::Round)),
            ("pow2", base.clone().with(|p| p.footprint.count = Count::Pow2)),
            ("feline", base.clone().with(|p| p.footprint.count = Count::Feline)),
            ("5 probes", base.clone().with(|p| p.footprint.max_probes = 5)),
            ("gaussian", base.clone().with(|p| p.footprint.weights = Weights::Gaussian)),
            ("scale", Settings { roughness_scale: 12f64.sqrt(), ..base.clone() }),
            ("rotation", Settings { rotation: turned, ..base.clone() }),
        ];
        for (name, settings) in cases {
            let checks = check_env(gpu, &settings, &map, &all, &|_| {}).expect("the device stays");
            assert!(checks.first.is_none(), "{name}: {:?}", checks.first);
            assert_explained(&checks, 10_000);
            let (off, colors) = env_off(gpu, &settings, &map, &all);
            assert!(off < 1e-3, "{name}: {off}");
            // λ2 by either way is the same but for rounding; every other policy shows.
            assert!(name == "minor det" || colors != plain, "{name} changes nothing");
        }
    });
}

#[test]
fn every_policy_of_hit_is_honoured() {
    on_gpu(|gpu| {
        let map = noisy_cube(64);
        let mut next = 5000usize;
        let mut number = || {
            next += 1;
            f64::from(noise(next)) - 0.5
        };
        let rays: Vec<HitFragment> = (0..300)
            .map(|_| HitFragment {
                x: [3.0 * number(), 2.0 * number(), 2.0 * number()],
                r: [number(), number(), number()],
                cone: Some([0.01, 0.05]),
            })
            .collect();
        let cube = map_of_walls();
        let pixels: Vec<_> = (0u32..).zip(&rays).map(|(i, ray)| ([i, 0], *ray)).collect();
        let hit = HitPolicy::default();
        let with = |hit| Settings::default().with(|p| p.hit = hit);
        let cases = [
            ("plain", with(hit)),
            ("secant", with(HitPolicy { method: Method::Secant, iterations: 8, ..hit })),
            ("illinois", with(HitPolicy { method: Method::Illinois, iterations: 8, ..hit })),
            ("nearest", with(HitPolicy { lookup: LookUp::Nearest, ..hit })),
            ("plane", with(HitPolicy { footprint: HitFootprint::Plane, ..hit })),
            ("hlsl", with(HitPolicy { outside: Outside::Hlsl, ..hit })),
            ("tolerance", with(HitPolicy { tolerance_bits: Some(4), ..hit })),
            ("constant", Settings::default().with(|p| p.cone.env = ConeEnv::Otk)),
        ];
        for (name, settings) in cases {
            let room = Distance::Box([2.0, 1.5, 1.75]);
            let both = [&cube, &room];
            let distances = if ["plain", "plane"].contains(&name) { &both[..] } else { &both[..1] };
            for distance in distances {
                let maps = (&map, *distance);
                let checks =
                    check_hit(gpu, &settings, maps, &pixels, &|_| {}).expect("the device stays");
                assert!(checks.first.is_none(), "{name}: {:?}", checks.first);
                assert_explained(&checks, 10_000);
                let engine =
                    GpuHit::new(gpu, &settings, distance, Some(&map), 64).expect("small maps");
                let here = engine.filter(&rays, &|_| {}).expect("the device stays");
                let there = HitF64::new(&settings, distance, Some(&map), 64).filter(&rays, &|_| {});
                let same = |(a, b): &(
                    &tapline::engine::hit::HitResult,
                    &tapline::engine::hit::HitResult,
                )| {
                    (a.status, a.iterations, a.probes) == (b.status, b.iterations, b.probes)
                        && (0..3).all(|c| (a.color[c] - b.color[c]).abs() < 5e-3)
                };
                let alike = here.iter().zip(&there).filter(same).count();
                // Searches that end at the limit of the tolerance, and texels of the nearest look-up, may go either way.
                assert!(alike * 100 >= 97 * rays.len(), "{name}: {alike} of {}", rays.len());
            }
        }
    });
}

/// Distances of 2 to 3, smooth over each face.
fn map_of_walls() -> Distance {
    let size = 16usize;
    let texels = (0..6 * size * size)
        .map(|i| {
            let (x, y) = (i % size, i / size % size);
            2.0 + f32::from(u16::try_from(x * y).unwrap_or(0)) / 256.0
        })
        .collect();
    let (cube, _) = tapline::distance::DistanceCube::cleaned(size, texels).expect("all texels");
    Distance::Cube(cube)
}
