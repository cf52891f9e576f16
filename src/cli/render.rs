//! `render`: one picture by one engine.

use std::path::PathBuf;

use super::Failure;
use super::args::{RunArgs, SceneArgs, UnitArgs};
use super::job::{load, refuse_sampler, tell_losses};
use super::output::{Kind, Origin, write_picture};
use super::progress::Bar;
use crate::engine::{EngineKind, Setup};
use crate::image::whole::WholeFile;
use crate::image::write::Sample;
use crate::truth::TruthOptions;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Built-in scene; `tapline scenes` lists them.
    scene: String,
    /// Engine: rtl, gpu, sampler, f64, ewa or truth.
    #[arg(long, value_enum)]
    engine: EngineKind,
    /// Picture: .exr (linear) or .png (8-bit sRGB); `-` is an EXR on stdout.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Samples of an EXR file.
    #[arg(long, value_enum, default_value_t = Depth::Float)]
    depth: Depth,
    #[command(flatten)]
    unit: UnitArgs,
    #[command(flatten)]
    scene_args: SceneArgs,
    #[command(flatten)]
    run: RunArgs,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Depth {
    Half,
    Float,
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    args.run.prepare()?;
    refuse_sampler(&args.scene, &[args.engine])?;
    let gpu = if args.engine.needs_gpu() {
        Some(args.run.adapter.open()?)
    } else {
        args.run.adapter.refuse()?;
        None
    };
    let kind = Kind::of(&args.output)?;
    let spec = args.unit.load()?;
    let file = WholeFile::create(&args.output)?;
    let settings = args.run.settings(&spec);
    let (job, _) = load(&args.scene, &args.scene_args, &settings)?;
    if args.engine == EngineKind::Rtl {
        tell_losses(&job, &spec)?;
    }
    let bar = Bar::new(args.engine.name(), job.total(args.engine));
    let progress = |n| bar.add(n);
    let truth = TruthOptions::default();
    let setup = Setup { spec: &spec, settings: &settings, truth, gpu: gpu.as_ref() };
    let rendering = job.render(args.engine, &setup, &progress)?;
    drop(bar);
    let origin = Origin::new(&spec);
    let attributes = origin.attributes(&format!("{} by {}", args.scene, args.engine.name()));
    let sample = match args.depth {
        Depth::Half => Sample::Half,
        Depth::Float => Sample::Float,
    };
    write_picture(file, kind, &rendering.picture, args.scene_args.exposure, &attributes, sample)?;
    Ok(())
}
