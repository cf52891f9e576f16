//! `compare`: the accuracy ladder of a scene, register errors, flags, speed, pictures.

use std::path::PathBuf;

use super::Failure;
use super::args::{AdapterArgs, RunArgs, SceneArgs, UnitArgs};
use super::bounds::{self, Bound};
use super::compare_files::OutFiles;
use super::compare_tables::{print_tables, to_json};
use super::job::{Caustics, Job, refuse_sampler};
use super::output::{JsonTarget, Origin};
use super::progress::Bar;
use crate::engine::gpu::check::StageChecks;
use crate::engine::registers::RegisterErrors;
use crate::engine::{Rendering, Rung};
use crate::error::InputError;
use crate::gpu::Gpu;
use crate::report::metrics::{self, Pair};
use crate::settings::Settings;
use crate::truth::TruthOptions;
use crate::unit::UnitSpec;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Built-in scene; `tapline scenes` lists them.
    #[arg(default_value = "scratches")]
    pub(super) scene: String,
    /// Engines, in any order: rtl, gpu, sampler, f64, ewa, truth. All that are there but sampler if not given.
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
    pub(super) why: String,
}

/// The results of a run of the command.
pub(super) struct Results {
    /// The engines that ran, in the ladder's order.
    pub(super) renderings: Vec<(Rung, Rendering)>,
    /// Each engine against the next.
    pub(super) pairs: Vec<(Rung, Rung, Pair)>,
    /// `rtl` against `f64`, where both ran.
    pub(super) registers: Option<RegisterErrors>,
    /// `gpu` against `f64`, stage by stage at the same operands, where both ran.
    pub(super) stages: Option<StageChecks>,
    /// The scene's caustic, if it has one.
    pub(super) caustics: Option<Caustics>,
    /// The engines that did not run.
    pub(super) skipped: Vec<Skipped>,
    /// Name and driver of the GPU that took part.
    pub(super) adapter: Option<String>,
}

impl Results {
    pub(super) fn get(&self, rung: Rung) -> Option<&Rendering> {
        self.renderings.iter().find(|(r, _)| *r == rung).map(|(_, r)| r)
    }

    /// Compares two engines that ran, unless that is done already.
    fn pair(&mut self, a: Rung, b: Rung, exposure: f64) -> Result<(), InputError> {
        let done = self.pairs.iter().any(|(x, y, _)| (*x, *y) == (a, b));
        if let (false, Some(ra), Some(rb)) = (done, self.get(a), self.get(b)) {
            let metrics = metrics::compare_with_flip(&ra.picture, &rb.picture, exposure)?;
            self.pairs.push((a, b, metrics));
        }
        Ok(())
    }
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    args.run.prepare()?;
    refuse_sampler(&args.scene, &args.engines)?;
    let Chosen { rungs, skipped, gpu } = choose(&args.engines, &args.run.adapter)?;
    let min_psnr = parse_bounds("--min-psnr", &args.min_psnr, &rungs)?;
    let max_lsb8 = parse_bounds("--max-lsb8", &args.max_lsb8, &rungs)?;
    let spec = args.unit.load()?;
    let settings = args.run.settings(&spec);
    // The folder first: the JSON file may lie in it.
    let files = match &args.out {
        None => None,
        Some(folder) => Some(OutFiles::create(folder, &rungs, &args.scene)?),
    };
    let json_target = JsonTarget::beside(args.json.as_deref(), files.as_ref().map(|f| &f.folder))?;
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
    let mut results = render_all(args, &rungs, &spec, &settings, &job, gpu)?;
    results.skipped.extend(skipped);
    for (a, b) in min_psnr.iter().chain(&max_lsb8).map(|bound| (bound.a, bound.b)) {
        results.pair(a, b, args.scene_args.exposure)?;
    }
    let value = to_json(args, &origin, &spec, &job, &results);
    if !json_target.takes_stdout() {
        unless_closed(print_tables(args, &spec, &job, &results, &settings))?;
    }
    if let Some(files) = files {
        files.write(args, &origin, &job, &settings, &results, &value)?;
    }
    unless_closed(json_target.write(&value))?;
    judge(&results, &min_psnr, &max_lsb8)
}

/// A reader of stdout that has gone changes neither the files nor the verdict.
fn unless_closed(result: Result<(), Failure>) -> Result<(), Failure> {
    match result {
        Err(Failure::Closed) => Ok(()),
        other => other,
    }
}

/// What a run renders.
struct Chosen {
    /// In the ladder's order.
    rungs: Vec<Rung>,
    skipped: Vec<Skipped>,
    gpu: Option<Gpu>,
}

/// The engines asked for, or all; the gpu is left out where none was named and there is none.
fn choose(asked: &[Rung], adapter: &AdapterArgs) -> Result<Chosen, InputError> {
    let wanted = |r: &Rung| (asked.is_empty() && r.is_default()) || asked.contains(r);
    let mut rungs: Vec<Rung> = Rung::ALL.into_iter().filter(wanted).collect();
    let mut skipped = Vec::new();
    let mut gpu = None;
    if !rungs.iter().any(|r| r.needs_gpu()) {
        adapter.refuse()?;
    } else {
        match adapter.open() {
            Ok(open) => gpu = Some(open),
            Err(error) if asked.is_empty() && !adapter.is_named() => {
                rungs.retain(|r| *r != Rung::Gpu);
                skipped.push(Skipped { rung: Rung::Gpu, why: error.found });
            }
            Err(error) => return Err(error),
        }
    }
    Ok(Chosen { rungs, skipped, gpu })
}

fn parse_bounds(name: &str, texts: &[String], rungs: &[Rung]) -> Result<Vec<Bound>, InputError> {
    let bounds = texts.iter().map(|t| bounds::parse(name, t)).collect::<Result<Vec<_>, _>>()?;
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
    gpu: Option<Gpu>,
) -> Result<Results, Failure> {
    let rtl = if rungs.contains(&Rung::Rtl) { Some(job.rtl(spec)?) } else { None };
    let options = TruthOptions {
        samples: args.samples,
        max_samples: args.samples.saturating_mul(4),
        ..TruthOptions::default()
    };
    let mut renderings = Vec::new();
    let mut skipped = Vec::new();
    let adapter = gpu.as_ref().map(|gpu| gpu.adapter().title());
    for rung in rungs {
        let bar = Bar::new(rung.name(), job.total(*rung));
        let progress = |n| bar.add(n);
        let rendering = match (rung, &rtl) {
            (Rung::Rtl, Some(rtl)) => job.render_rtl(rtl, settings, &progress),
            (Rung::Gpu | Rung::Sampler, _) => {
                let made = gpu.as_ref().map(|gpu| job.render_on(gpu, *rung, settings, &progress));
                match made.transpose() {
                    Ok(rendering) => rendering,
                    // What the device cannot do is no reason to give up the others, unless it was named.
                    Err(error) if args.engines.is_empty() => {
                        let why = InputError::from(error).found;
                        skipped.push(Skipped { rung: *rung, why });
                        None
                    }
                    Err(error) => return Err(InputError::from(error).into()),
                }
            }
            _ => job.render_float(*rung, settings, &options, &progress),
        };
        renderings.extend(rendering.map(|r| (*rung, r)));
    }
    let neighbours: Vec<(Rung, Rung)> = renderings.windows(2).map(|w| (w[0].0, w[1].0)).collect();
    let registers = match &rtl {
        Some(rtl) if rungs.contains(&Rung::F64) => {
            let bar = Bar::new("registers", job.total(Rung::Rtl));
            job.registers(rtl, settings, &|n| bar.add(n))
        }
        Some(_) | None => None,
    };
    let both = [Rung::Gpu, Rung::F64].map(|rung| renderings.iter().any(|(r, _)| *r == rung));
    let stages = match &gpu {
        Some(gpu) if both == [true; 2] => {
            let bar = Bar::new("stages", job.total(Rung::Rtl));
            let checked = job.check_stages(gpu, settings, &|n| bar.add(n));
            let mut checked = checked.map_err(InputError::from)?;
            if let (Some(first), Some(rtl)) = (&mut checked.first, &rtl) {
                let register = (first.stage.name(), first.register);
                first.rtl = job.rtl_register(rtl, settings, first.pixel, register);
            }
            Some(checked)
        }
        Some(_) | None => None,
    };
    // An engine that could not render makes no caustic either.
    let ran: Vec<Rung> = renderings.iter().map(|(rung, _)| *rung).collect();
    let caustics = job.caustics(&ran, rtl.as_ref(), gpu.as_ref(), settings);
    let caustics = caustics.map_err(InputError::from)?;
    let mut results =
        Results { renderings, pairs: Vec::new(), registers, stages, caustics, skipped, adapter };
    for (a, b) in neighbours {
        results.pair(a, b, args.scene_args.exposure)?;
    }
    Ok(results)
}

fn judge(results: &Results, min_psnr: &[Bound], max_lsb8: &[Bound]) -> Result<(), Failure> {
    let pair = |bound: &Bound| {
        let mut pairs = results.pairs.iter();
        pairs.find_map(|(a, b, pair)| ((*a, *b) == (bound.a, bound.b)).then_some(pair))
    };
    let mut broken = Vec::new();
    for bound in min_psnr {
        if let Some(db) = pair(bound).and_then(|p| p.psnr_db)
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
        if let Some(p) = pair(bound)
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
    if broken.is_empty() { Ok(()) } else { Err(Failure::Disagrees(broken.join("; "))) }
}
