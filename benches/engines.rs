//! Speed of the unit, stage by stage and whole, beside two yardsticks in the same run.
//!
//! One thread, but for `two_threads`. `floor` fetches the same texels after the same set-up and address
//! arithmetic and folds them together; `scalar_f32` is a plain f32 back end over the same requests.
//! Ratios are what counts. `cargo bench --bench engines -- --once SCENE PART` runs a part once, for
//! counting instructions.
#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    clippy::cast_sign_loss,
    reason = "bench code on small numbers"
)]

mod support;

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput};
use support::{Bench, PARTS, used};
use tapline::cube::direction;
use tapline::distance::{Distance, DistanceCube};
use tapline::engine::hit::{HitF64, HitRtl};
use tapline::fragment::HitFragment;
use tapline::policy::LookUp;
use tapline::reference::Distances;
use tapline::unit::{ReferenceAxis, UnitSpec};

fn main() {
    let args: Vec<String> = std::env::args().collect();
    if let Some(at) = args.iter().position(|a| a == "--once") {
        let (Some(scene), Some(part)) = (args.get(at + 1), args.get(at + 2)) else {
            eprintln!("--once SCENE PART");
            std::process::exit(2);
        };
        let mut bench = Bench::new(scene);
        println!(
            "{} fragments, {} probes, {} cores",
            bench.fragments(),
            bench.probes(),
            support::cores()
        );
        black_box(bench.run(part));
        return;
    }
    let mut criterion = Criterion::default().configure_from_args().sample_size(20);
    for scene in ["sphere", "scratches"] {
        let mut bench = Bench::new(scene);
        println!("{scene}: {} fragments, {} probes", bench.fragments(), bench.probes());
        let mut group = criterion.benchmark_group(scene);
        group.throughput(Throughput::Elements(bench.fragments()));
        for part in PARTS.iter().filter(|part| used(scene, part)) {
            group.bench_function(BenchmarkId::from_parameter(part), |b| {
                b.iter(|| black_box(bench.run(part)));
            });
        }
        group.finish();
    }
    hit(&mut criterion);
    criterion.final_summary();
}

/// Rays in a box room: the search alone, and with a cone the footprint and the filter behind it.
fn hit(criterion: &mut Criterion) {
    const RAYS: u32 = 16 * 1024;
    let spec = UnitSpec::default();
    let room = Distance::Box([4.0, 3.0, 2.5]);
    let settings = spec.settings(ReferenceAxis::Exact);
    let cube = distance_cube(128);
    let rays = |cone| -> Vec<HitFragment> {
        let place = |i: u32, by: u32| f64::from(i.wrapping_mul(by) >> 8) / 8_388_608.0 - 1.0;
        (0..RAYS)
            .map(|i| HitFragment {
                x: [2_654_435_769, 3_144_134_277, 1_640_531_527].map(|by| 2.0 * place(i, by)),
                r: [2_246_822_519, 3_266_489_917, 668_265_263].map(|by| place(i, by)),
                cone,
            })
            .collect()
    };
    let mut group = criterion.benchmark_group("hit");
    group.throughput(Throughput::Elements(RAYS.into()));
    let Ok(ideal) = HitRtl::new(&spec, &room, None, 256) else {
        return;
    };
    let Ok(mapped) = HitRtl::new(&spec, &cube, None, 256) else {
        return;
    };
    let float = HitF64::new(&settings, &cube, None, 256);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let Ok(pool) = pool else { return };
    for (name, cone) in [("search", None), ("footprint", Some([0.001, 0.01]))] {
        let rays = rays(cone);
        group.bench_function(BenchmarkId::new("rtl_cube", name), |b| {
            b.iter(|| pool.install(|| black_box(mapped.filter(&rays, &|_| {}))));
        });
        group.bench_function(BenchmarkId::new("rtl_box", name), |b| {
            b.iter(|| pool.install(|| black_box(ideal.filter(&rays, &|_| {}))));
        });
        group.bench_function(BenchmarkId::new("f64_cube", name), |b| {
            b.iter(|| pool.install(|| black_box(float.filter(&rays, &|_| {}))));
        });
    }
    group.finish();
}

/// The room's distances in a cube map.
fn distance_cube(size: usize) -> Distance {
    let ideal = Distances::new(&Distance::Box([4.0, 3.0, 2.5]));
    let place = |i: usize| (2 * i + 1) as f64 / size as f64 - 1.0;
    let texels = (0..6 * size * size)
        .map(|i| {
            let (face, x, y) = (i / (size * size), i % size, i / size % size);
            let q = direction(face, place(x), place(y));
            ideal.read(q, LookUp::Bilinear) as f32
        })
        .collect();
    Distance::Cube(DistanceCube { size, texels })
}
