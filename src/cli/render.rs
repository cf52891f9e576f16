//! `render`: one picture by one engine.

use std::path::PathBuf;

use super::args::{RunArgs, SceneArgs, UnitArgs};
use super::output::{Kind, Origin, write_picture};
use super::progress::Bar;
use super::{Failure, subject};
use crate::engine::float::{EwaEngine, F64Engine, TruthEngine};
use crate::engine::rtl::RtlEngine;
use crate::engine::{Engine, Rung};
use crate::error::InputError;
use crate::image::whole::WholeFile;
use crate::image::write::Sample;
use crate::truth::TruthOptions;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Built-in scene; `tapline scenes` lists them.
    scene: String,
    /// Engine: rtl, f64, ewa or truth.
    #[arg(long, value_enum)]
    engine: Rung,
    /// Picture: .exr (linear) or .png (8-bit sRGB).
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
    args.scene_args.refuse_distance()?;
    subject::check_exposure(args.scene_args.exposure)?;
    args.run.prepare()?;
    if args.engine == Rung::Gpu {
        return Err(InputError::new(
            "--engine",
            "rtl, f64, ewa or truth",
            "gpu, which is not built in this version",
            "choose another",
        )
        .into());
    }
    let kind = Kind::of(&args.output)?;
    let spec = args.unit.load()?;
    let file = WholeFile::create(&args.output)?;
    let settings = args.run.settings(&spec);
    let subject = subject::load(&args.scene, &args.scene_args, &settings)?;
    let engine: Box<dyn Engine> = match args.engine {
        Rung::Rtl | Rung::Gpu => Box::new(RtlEngine::new(&spec, subject.needs(), &subject.map)?),
        Rung::F64 => Box::new(F64Engine { settings }),
        Rung::Ewa => Box::new(EwaEngine { settings }),
        Rung::Truth => Box::new(TruthEngine {
            settings,
            options: TruthOptions::default(),
        }),
    };
    let bar = Bar::new(
        args.engine.name(),
        crate::engine::to_u64(subject.scene.fragments.len()),
    );
    let rendering = engine.render(&subject, &|n| bar.add(n));
    drop(bar);
    let origin = Origin::new(&spec);
    let attributes = origin.attributes(&format!("{} by {}", args.scene, args.engine.name()));
    let sample = match args.depth {
        Depth::Half => Sample::Half,
        Depth::Float => Sample::Float,
    };
    write_picture(
        file,
        kind,
        &rendering.picture,
        args.scene_args.exposure,
        &attributes,
        sample,
    )?;
    Ok(())
}
