//! `compare`: the accuracy ladder of a scene, register errors, flags, speed, pictures.

use std::path::PathBuf;

use super::args::{RunArgs, SceneArgs, UnitArgs};
use super::bounds::{self, Bound};
use super::compare_files::OutFiles;
use super::compare_tables::{print_tables, to_json};
use super::job::{Caustics, Job};
use super::output::{JsonTarget, Origin};
use super::progress::Bar;
use super::{Failure, subject};
use crate::engine::registers::RegisterErrors;
use crate::engine::{Rendering, Rung};
use crate::error::InputError;
use crate::report::metrics::{self, Pair};
use crate::settings::Settings;
use crate::truth::TruthOptions;
use crate::unit::UnitSpec;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Built-in scene; `tapline scenes` lists them.
    #[arg(default_value = "scratches")]
    pub(super) scene: String,
    /// Engines, in any order: rtl, gpu, f64, ewa, truth. All that are there if not given.
    #[arg(long, value_delimiter = ',', value_enum)]
    engines: Vec<Rung>,
    /// Folder for pictures, error maps and report.html; made if it is not there.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Results as JSON; `-` is stdout.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Fail (status 1) where the PSNR of two engines is below a bound, such as rtl:f64=50.
    #[arg(long, value_name = "A:B=DB")]
    min_psnr: Vec<String>,
    /// Fail (status 1) where two engines differ by more 8-bit steps than a bound, such as rtl:f64=2.
    #[arg(long, value_name = "A:B=STEPS")]
    max_lsb8: Vec<String>,
    /// Samples a pixel in the first round of `truth`.
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(4..=65536))]
    samples: u32,
    #[command(flatten)]
    unit: UnitArgs,
    #[command(flatten)]
    pub(super) scene_args: SceneArgs,
    #[command(flatten)]
    run: RunArgs,
}

/// Why an engine is not among the results.
pub(super) struct Skipped {
    pub(super) rung: Rung,
    pub(super) why: &'static str,
}

/// What a run of the command found.
pub(super) struct Results {
    /// The engines that ran, in the ladder's order.
    pub(super) renderings: Vec<(Rung, Rendering)>,
    /// Each engine against the next.
    pub(super) pairs: Vec<(Rung, Rung, Pair)>,
    /// `rtl` against `f64`, where both ran.
    pub(super) registers: Option<RegisterErrors>,
    /// The scene's caustic, if it has one.
    pub(super) caustics: Option<Caustics>,
    /// The engines that did not run.
    pub(super) skipped: Vec<Skipped>,
}

impl Results {
    pub(super) fn get(&self, rung: Rung) -> Option<&Rendering> {
        self.renderings
            .iter()
            .find(|(r, _)| *r == rung)
            .map(|(_, r)| r)
    }
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    subject::check_exposure(args.scene_args.exposure)?;
    args.run.prepare()?;
    args.run.adapter.refuse()?;
    let (rungs, skipped) = choose(&args.engines)?;
    let min_psnr = parse_bounds("--min-psnr", &args.min_psnr, &rungs)?;
    let max_lsb8 = parse_bounds("--max-lsb8", &args.max_lsb8, &rungs)?;
    let spec = args.unit.load()?;
    let settings = args.run.settings(&spec);
    // The folder first: the JSON file may lie in it.
    let files = match &args.out {
        None => None,
        Some(folder) => Some(OutFiles::create(folder, &rungs, &args.scene)?),
    };
    let json_target = JsonTarget::open(args.json.as_deref())?;
    let job = Job::load(&args.scene, &args.scene_args, &settings)?;
    if job.fragments() == 0 {
        return Err(InputError::new(
            "--size",
            "a picture in which a pixel centre meets the surface",
            "no fragment at all",
            "ask for a larger picture",
        )
        .into());
    }

    let origin = Origin::new(&spec);
    let mut results = render_all(args, &rungs, &spec, &settings, &job)?;
    results.skipped = skipped;
    let value = to_json(args, &origin, &spec, &job, &results);
    if !json_target.takes_stdout() {
        unless_closed(print_tables(args, &spec, &job, &results, &settings))?;
    }
    if let Some(files) = files {
        files.write(args, &origin, &job, &settings, &results, &value)?;
    }
    unless_closed(json_target.write(&value))?;
    judge(args, &results, &min_psnr, &max_lsb8)
}

/// A reader of stdout that has gone changes neither the files nor the verdict.
fn unless_closed(result: Result<(), Failure>) -> Result<(), Failure> {
    match result {
        Err(Failure::Closed) => Ok(()),
        other => other,
    }
}

/// The engines asked for, in the ladder's order, and what is left out.
fn choose(asked: &[Rung]) -> Result<(Vec<Rung>, Vec<Skipped>), InputError> {
    let why = "not built in this version";
    if asked.contains(&Rung::Gpu) {
        return Err(InputError::new(
            "--engines",
            "engines that are there: rtl, f64, ewa, truth",
            "gpu, which is not built in this version",
            "leave gpu out",
        ));
    }
    if asked.is_empty() {
        let rungs = Rung::ALL.into_iter().filter(|r| *r != Rung::Gpu).collect();
        return Ok((
            rungs,
            vec![Skipped {
                rung: Rung::Gpu,
                why,
            }],
        ));
    }
    Ok((
        Rung::ALL
            .into_iter()
            .filter(|r| asked.contains(r))
            .collect(),
        Vec::new(),
    ))
}

fn parse_bounds(name: &str, texts: &[String], rungs: &[Rung]) -> Result<Vec<Bound>, InputError> {
    let bounds = texts
        .iter()
        .map(|t| bounds::parse(name, t))
        .collect::<Result<Vec<_>, _>>()?;
    for bound in &bounds {
        for rung in [bound.a, bound.b] {
            if !rungs.contains(&rung) {
                return Err(InputError::new(
                    name,
                    "engines that this run renders",
                    format!("`{}`", rung.name()),
                    "name it in --engines",
                ));
            }
        }
    }
    Ok(bounds)
}

fn render_all(
    args: &Args,
    rungs: &[Rung],
    spec: &UnitSpec,
    settings: &Settings,
    job: &Job,
) -> Result<Results, Failure> {
    let rtl = if rungs.contains(&Rung::Rtl) {
        Some(job.rtl(spec)?)
    } else {
        None
    };
    let options = TruthOptions {
        samples: args.samples,
        max_samples: args.samples.saturating_mul(4),
        ..TruthOptions::default()
    };
    let mut renderings = Vec::new();
    for rung in rungs {
        let bar = Bar::new(rung.name(), job.total(*rung));
        let progress = |n| bar.add(n);
        let rendering = match (rung, &rtl) {
            (Rung::Rtl, Some(rtl)) => job.render_rtl(rtl, settings, &progress),
            _ => job.render_float(*rung, settings, &options, &progress),
        };
        renderings.extend(rendering.map(|r| (*rung, r)));
    }
    let mut pairs = Vec::new();
    for pair in renderings.windows(2) {
        if let [(a, ra), (b, rb)] = pair {
            let metrics =
                metrics::compare_with_flip(&ra.picture, &rb.picture, args.scene_args.exposure)?;
            pairs.push((*a, *b, metrics));
        }
    }
    let registers = match &rtl {
        Some(rtl) if rungs.contains(&Rung::F64) => {
            let bar = Bar::new("registers", job.total(Rung::Rtl));
            job.registers(rtl, settings, &|n| bar.add(n))
        }
        Some(_) | None => None,
    };
    Ok(Results {
        renderings,
        pairs,
        registers,
        caustics: job.caustics(rungs, rtl.as_ref(), settings),
        skipped: Vec::new(),
    })
}

fn judge(
    args: &Args,
    results: &Results,
    min_psnr: &[Bound],
    max_lsb8: &[Bound],
) -> Result<(), Failure> {
    let pair = |bound: &Bound| -> Result<Option<Pair>, Failure> {
        let (Some(a), Some(b)) = (results.get(bound.a), results.get(bound.b)) else {
            return Ok(None);
        };
        Ok(Some(metrics::compare(
            &a.picture,
            &b.picture,
            args.scene_args.exposure,
        )?))
    };
    let mut broken = Vec::new();
    for bound in min_psnr {
        if let Some(db) = pair(bound)?.and_then(|p| p.psnr_db)
            && db < bound.limit
        {
            broken.push(format!(
                "{} - {}: {db:.2} dB, below {} dB",
                bound.a.name(),
                bound.b.name(),
                bound.limit
            ));
        }
    }
    for bound in max_lsb8 {
        if let Some(p) = pair(bound)?
            && p.max_lsb8 > bound.limit
        {
            broken.push(format!(
                "{} - {}: {:.3} 8-bit steps at pixel {},{}, above {}",
                bound.a.name(),
                bound.b.name(),
                p.max_lsb8,
                p.worst_pixel[0],
                p.worst_pixel[1],
                bound.limit
            ));
        }
    }
    if broken.is_empty() {
        Ok(())
    } else {
        Err(Failure::Disagrees(broken.join("; ")))
    }
}
