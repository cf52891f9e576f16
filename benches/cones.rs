//! Ray cones in batches: propagation in the unit's registers beside plain f32 arithmetic, in the same run, on one core.
//!
//! A batch of 4096 cones stays in the first-level cache. `plain_f32` is w + α·d and the change of signs in hardware
//! floats, without a store into a shorter format: what a renderer with f32 cones pays.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput};
use rtl_model::Config;
use rtl_model::cone::{Angle, Cone, ConeFormat, Dither, StoreRounding, Width};
use rtl_model::fx::Flags;
use rtl_model::stages::ray_cone::{Cfg, Step, ray_cone};
use tapline::engine::cones::propagate_batch;
use tapline::engine::dispatch::Level;

const CONES: u32 = 4096;

fn mixed(i: u32, salt: u32) -> u32 {
    let x = (i ^ salt).wrapping_mul(0x9E37_79B1);
    (x ^ (x >> 15)).wrapping_mul(0x85EB_CA77)
}

/// A number of either sign from 2^-7 to 2^5.
fn number(i: u32, salt: u32) -> f32 {
    let bits = mixed(i, salt);
    f32::from_bits((bits & 0x807f_ffff) | ((120 + bits % 12) << 23))
}

fn cfg(format: ConeFormat, rounding: StoreRounding) -> Cfg {
    let mut config = Config::default();
    config.policy.cone.format = format;
    config.policy.cone.rounding = rounding;
    Cfg::new(&config)
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args().sample_size(20);
    let mut group = criterion.benchmark_group("propagate");
    group.throughput(Throughput::Elements(CONES.into()));
    let level = Level::detect();
    let distances: Vec<u32> = (0..CONES).map(|i| number(i, 3).abs().to_bits()).collect();
    for (name, format, rounding) in [
        ("bf16_rne", ConeFormat::Bf16, StoreRounding::Rne),
        ("bf16_truncate", ConeFormat::Bf16, StoreRounding::Truncate),
        ("bf16_stochastic", ConeFormat::Bf16, StoreRounding::Stochastic),
        ("f16_rne", ConeFormat::F16, StoreRounding::Rne),
        ("f32_rne", ConeFormat::F32, StoreRounding::Rne),
    ] {
        let cfg = cfg(format, rounding);
        let mut flags = Flags::default();
        let start: Vec<Cone> = (0..CONES)
            .map(|i| {
                let words = [number(i, 1), number(i, 2)].map(|x| f64::from(x).to_bits());
                cfg.load(words, &mut Dither::new(0, 0), &mut flags)
            })
            .collect();
        let mut cones = start.clone();
        group.bench_function(BenchmarkId::new("rtl", name), |b| {
            b.iter(|| {
                cones.copy_from_slice(&start);
                let (cones, distances) = (black_box(&mut cones), black_box(&distances));
                propagate_batch(level, &cfg, cones, distances, 0);
            });
        });
    }
    let start: Vec<[f32; 2]> = (0..CONES).map(|i| [number(i, 1), number(i, 2)]).collect();
    let plain: Vec<f32> = distances.iter().map(|d| f32::from_bits(*d)).collect();
    let mut cones = start.clone();
    group.bench_function("plain_f32", |b| {
        b.iter(|| {
            cones.copy_from_slice(&start);
            for ([angle, width], d) in black_box(&mut cones).iter_mut().zip(black_box(&plain)) {
                let w = *width + *angle * d;
                let turned = *angle < 0.0 && w < 0.0;
                *angle = if turned { -*angle } else { *angle };
                *width = if turned { -w } else { w };
            }
        });
    });
    group.finish();

    // The other operations, one cone at a time: exact sums and quotients of any operands.
    let mut group = criterion.benchmark_group("operation");
    group.throughput(Throughput::Elements(1));
    let cfg = cfg(ConeFormat::Bf16, StoreRounding::Rne);
    let cone = Cone { angle: Angle(0x3c23), width: Width(0x3d4c) };
    let operand = |x: f64| rtl_model::cone::Dyadic::binary64(x.to_bits()).0;
    for (name, step) in [
        ("propagate", Step::Propagate(operand(2.7))),
        ("reflect", Step::Reflect(operand(1.3))),
        (
            "refract",
            Step::Refract { curvature: operand(1.3), outside: operand(1.0), inside: operand(1.5) },
        ),
        ("scatter", Step::Scatter(operand(0.8))),
    ] {
        group.bench_function(name, |b| {
            let mut dither = Dither::new(0, 0);
            let mut flags = Flags::default();
            b.iter(|| ray_cone(&cfg, black_box(cone), black_box(step), &mut dither, &mut flags));
        });
    }
    group.finish();
    criterion.final_summary();
}
