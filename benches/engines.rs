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
        println!(
            "{scene}: {} fragments, {} probes",
            bench.fragments(),
            bench.probes()
        );
        let mut group = criterion.benchmark_group(scene);
        group.throughput(Throughput::Elements(bench.fragments()));
        for part in PARTS.iter().filter(|part| used(scene, part)) {
            group.bench_function(BenchmarkId::from_parameter(part), |b| {
                b.iter(|| black_box(bench.run(part)));
            });
        }
        group.finish();
    }
    criterion.final_summary();
}
