//! Speed of the fused ENV kernel beside the integer model and the float reference, all on all cores, in one run.
//!
//!     cargo bench --bench gpu
//!
//! `gpu` rounds the fragments to f32, uploads them, runs the kernel and reads the colours back; `kernel` runs it on operands
//! that are there and leaves the colours there. Maps are uploaded and kernels compiled before. The median of seven turns,
//! each of which runs everything once; only the ratios mean anything.

use std::hint::black_box;
use std::time::Instant;

use tapline::engine::float::F64Engine;
use tapline::engine::gpu::GpuEnv;
use tapline::engine::rtl::RtlEngine;
use tapline::engine::{Engine as _, EnvJob};
use tapline::gpu::{Gpu, GpuError};
use tapline::mips::build_mips;
use tapline::scene::{self, SceneOptions};
use tapline::unit::{ReferenceAxis, UnitSpec};

const TURNS: usize = 7;
const SCENES: [&str; 2] = ["sphere", "scratches"];

fn main() {
    match Gpu::open(None) {
        Ok(gpu) => {
            if let Err(error) = run(&gpu) {
                eprintln!("{error}");
                std::process::exit(1);
            }
        }
        Err(error) => eprintln!("nothing measured: {error}"),
    }
}

fn subject(name: &str, spec: &UnitSpec) -> Option<EnvJob> {
    let options = SceneOptions { width: 512, height: 512, ..SceneOptions::default() };
    let scene = scene::build(name, &options, &spec.settings(ReferenceAxis::Exact)).ok()?;
    let map = build_mips(scene.environment());
    let background = vec![[0.0; 3]; scene.width * scene.height];
    Some(EnvJob { scene, map, background })
}

fn run(gpu: &Gpu) -> Result<(), GpuError> {
    let spec = UnitSpec::default();
    let settings = spec.settings(ReferenceAxis::Exact);
    println!("{}", gpu.adapter().title());
    println!(
        "| scene | fragments | rtl (Mfragments/s) | f64 | gpu | kernel | gpu / rtl | kernel / rtl | gpu / f64 | kernel / f64 |"
    );
    println!("|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|");
    for name in SCENES {
        let Some(subject) = subject(name, &spec) else {
            continue;
        };
        let first = subject.scene.fragments.first().map(|f| &f.fragment);
        let engine = GpuEnv::new(gpu, &settings, &subject.map, first)?;
        let Ok(rtl) = RtlEngine::new(&spec, subject.needs(), &subject.map) else {
            continue;
        };
        let f64 = F64Engine { settings: settings.clone() };
        let (batch, on_device) = engine.upload(&subject.scene.fragments)?;
        let fragments = subject.scene.fragments.len();
        // Fragments per microsecond: rtl, f64, gpu, kernel.
        let mut rates: [Vec<f64>; 4] = Default::default();
        for _ in 0..TURNS {
            let rate = |count: usize, seconds: f64| count as f64 / seconds / 1e6;
            rates[0].push(rate(fragments, rtl.render(&subject, &|_| {})?.seconds));
            rates[1].push(rate(fragments, f64.render(&subject, &|_| {})?.seconds));
            rates[2].push(rate(fragments, engine.render(&subject, &|_| {})?.seconds));
            let start = Instant::now();
            black_box(engine.run(&batch)?);
            rates[3].push(rate(on_device, start.elapsed().as_secs_f64()));
        }
        let [rtl, f64, gpu, kernel] = rates.map(|mut of| {
            of.sort_by(f64::total_cmp);
            of[TURNS / 2]
        });
        println!(
            "| {name} | {fragments} | {rtl:.2} | {f64:.2} | {gpu:.2} | {kernel:.2} | {:.2} | {:.2} | {:.2} | {:.2} |",
            gpu / rtl,
            kernel / rtl,
            gpu / f64,
            kernel / f64
        );
    }
    Ok(())
}
