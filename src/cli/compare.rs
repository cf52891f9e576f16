//! `compare`: the accuracy ladder of a scene, register errors, flags, speed, pictures.

use std::collections::BTreeMap;
use std::path::PathBuf;

use rtl_model::regs::Reg;

use super::Failure;
use super::args::{AdapterArgs, RunArgs, SceneArgs, UnitArgs};
use super::bounds::{self, Bound};
use super::compare_files::OutFiles;
use super::compare_motion::{check_shift, motions};
use super::compare_tables::{print_tables, to_json};
use super::job::{load, refuse_sampler, tell_losses};
use super::output::{JsonTarget, Origin};
use super::progress::Bar;
use crate::engine::gpu::check::StageChecks;
use crate::engine::job::lit::Caustics;
use crate::engine::probe::RtlProbe;
use crate::engine::registers::RegisterErrors;
use crate::engine::{EngineKind, Job, Rendering, Setup};
use crate::error::InputError;
use crate::gpu::Gpu;
use crate::report::flip;
use crate::report::metrics::Pair;
use crate::report::motion::Motion;
use crate::settings::Settings;
use crate::taken::Taken;
use crate::truth::TruthOptions;
use crate::unit::UnitSpec;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Built-in scene; `tapline scenes` lists them.
    #[arg(default_value = "scratches")]
    pub(super) scene: String,
    /// Engines, in any order: rtl, gpu, sampler, f64, ewa, truth. All that are there but sampler if not given.
    #[arg(long, value_delimiter = ',', value_enum)]
    engines: Vec<EngineKind>,
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
    /// Print the table of every register too, and of every stage's own check on a GPU.
    #[arg(long)]
    pub(super) registers: bool,
    /// Samples a pixel in the first round of `truth`.
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(4..=65536))]
    samples: u32,
    /// Render everything once more with the scene moved right and down by so many pixels, such as 0.25, and report
    /// how the picture's motion differs from that of `truth`: flicker.
    #[arg(long, value_name = "PIXELS", allow_negative_numbers = true)]
    pub(super) shift: Option<f64>,
    #[command(flatten)]
    unit: UnitArgs,
    #[command(flatten)]
    pub(super) scene_args: SceneArgs,
    #[command(flatten)]
    run: RunArgs,
}

/// Why an engine is not among the results.
pub(super) struct Skipped {
    pub(super) kind: EngineKind,
    pub(super) why: String,
}

/// The results of a run of the command.
pub(super) struct Results {
    /// The engines that ran, in the ladder's order.
    pub(super) renderings: Vec<(EngineKind, Rendering)>,
    /// Each engine against the next.
    pub(super) pairs: Vec<(EngineKind, EngineKind, Pair)>,
    /// The motion of each engine against that of `truth`, with `--shift`.
    pub(super) motions: Vec<(EngineKind, Motion)>,
    /// `rtl` against `f64`, where both ran.
    pub(super) registers: Option<RegisterErrors>,
    /// `gpu` against `f64`, stage by stage at the same operands, where both ran.
    pub(super) stages: Option<StageChecks>,
    /// The scene's caustic, if it has one.
    pub(super) caustics: Option<Caustics>,
    /// What each input file was taken for.
    pub(super) inputs: Vec<Taken>,
    /// What was lost when the maps were loaded.
    pub(super) load_flags: BTreeMap<String, u64>,
    /// The engines that did not run.
    pub(super) skipped: Vec<Skipped>,
    /// Name and driver of the GPU that took part.
    pub(super) adapter: Option<String>,
}

impl Results {
    pub(super) fn get(&self, kind: EngineKind) -> Option<&Rendering> {
        self.renderings.iter().find(|(r, _)| *r == kind).map(|(_, r)| r)
    }

    /// Compares two engines that ran, unless that is done already.
    fn pair(&mut self, a: EngineKind, b: EngineKind, exposure: f64) -> Result<(), InputError> {
        let done = self.pairs.iter().any(|(x, y, _)| (*x, *y) == (a, b));
        if let (false, Some(ra), Some(rb)) = (done, self.get(a), self.get(b)) {
            let metrics = flip::compare_with_flip(&ra.picture, &rb.picture, exposure)?;
            self.pairs.push((a, b, metrics));
        }
        Ok(())
    }
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    args.run.prepare()?;
    refuse_sampler(&args.scene, &args.engines)?;
    let Chosen { kinds, skipped, gpu } = choose(&args.engines, &args.run.adapter)?;
    let min_psnr = parse_bounds("--min-psnr", &args.min_psnr, &kinds)?;
    let max_lsb8 = parse_bounds("--max-lsb8", &args.max_lsb8, &kinds)?;
    check_shift(args.shift, &kinds)?;
    let spec = args.unit.load()?;
    let settings = args.run.settings(&spec);
    // The folder first: the JSON file may lie in it.
    let files = match &args.out {
        None => None,
        Some(folder) => Some(OutFiles::create(folder, &kinds, &args.scene)?),
    };
    let json_target = JsonTarget::beside(args.json.as_deref(), files.as_ref().map(|f| &f.folder))?;
    let (job, inputs) = load(&args.scene, &args.scene_args, &settings)?;
    if job.fragments() == 0 {
        return Err(InputError::new(
            "--size",
            "a picture in which a pixel centre meets the surface",
            "no fragment at all",
            "ask for a larger picture",
        )
        .into());
    }

    let load_flags = tell_losses(&job, &spec)?;
    let origin = Origin::new(&spec);
    let mut results = render_all(args, &kinds, &spec, &settings, &job, gpu)?;
    results.skipped.extend(skipped);
    results.inputs = inputs;
    results.load_flags = load_flags;
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
    kinds: Vec<EngineKind>,
    skipped: Vec<Skipped>,
    gpu: Option<Gpu>,
}

/// The engines asked for, or all; the gpu is left out where none was named and there is none.
fn choose(asked: &[EngineKind], adapter: &AdapterArgs) -> Result<Chosen, InputError> {
    let wanted = |r: &EngineKind| (asked.is_empty() && r.is_default()) || asked.contains(r);
    let mut kinds: Vec<EngineKind> = EngineKind::ALL.into_iter().filter(wanted).collect();
    let mut skipped = Vec::new();
    let mut gpu = None;
    if !kinds.iter().any(|r| r.needs_gpu()) {
        adapter.refuse()?;
    } else {
        match adapter.open() {
            Ok(open) => gpu = Some(open),
            Err(error) if asked.is_empty() && !adapter.is_named() => {
                kinds.retain(|r| *r != EngineKind::Gpu);
                skipped.push(Skipped { kind: EngineKind::Gpu, why: error.found });
            }
            Err(error) => return Err(error),
        }
    }
    Ok(Chosen { kinds, skipped, gpu })
}

fn parse_bounds(
    name: &str,
    texts: &[String],
    kinds: &[EngineKind],
) -> Result<Vec<Bound>, InputError> {
    let bounds = texts.iter().map(|t| bounds::parse(name, t)).collect::<Result<Vec<_>, _>>()?;
    for bound in &bounds {
        for kind in [bound.a, bound.b] {
            if !kinds.contains(&kind) {
                return Err(InputError::new(
                    name,
                    "engines that this run renders",
                    format!("`{}`", kind.name()),
                    "name it in --engines",
                ));
            }
        }
    }
    Ok(bounds)
}

fn render_all(
    args: &Args,
    kinds: &[EngineKind],
    spec: &UnitSpec,
    settings: &Settings,
    job: &Job,
    gpu: Option<Gpu>,
) -> Result<Results, Failure> {
    let rtl = if kinds.contains(&EngineKind::Rtl) { Some(job.compile(spec)?) } else { None };
    let truth = TruthOptions {
        samples: args.samples,
        max_samples: args.samples.saturating_mul(4),
        ..TruthOptions::default()
    };
    let setup = Setup { spec, settings, truth, gpu: gpu.as_ref() };
    let mut renderings = Vec::new();
    let mut skipped = Vec::new();
    let adapter = gpu.as_ref().map(|gpu| gpu.adapter().title());
    for kind in kinds {
        let bar = Bar::new(kind.name(), job.total(*kind));
        let progress = |n| bar.add(n);
        let made = match &rtl {
            Some(rtl) if *kind == EngineKind::Rtl => {
                rtl.render(&progress).map_err(InputError::from)
            }
            _ => job.render(*kind, &setup, &progress),
        };
        match made {
            Ok(rendering) => renderings.push((*kind, rendering)),
            // What a device cannot do is no reason to give up the others, unless it was named.
            Err(error) if args.engines.is_empty() && kind.needs_gpu() => {
                skipped.push(Skipped { kind: *kind, why: error.found });
            }
            Err(error) => return Err(error.into()),
        }
    }
    let neighbours: Vec<(EngineKind, EngineKind)> =
        renderings.windows(2).map(|w| (w[0].0, w[1].0)).collect();
    let registers = match &rtl {
        Some(rtl) if kinds.contains(&EngineKind::F64) => {
            let bar = Bar::new("registers", job.total(EngineKind::Rtl));
            Some(rtl.registers(settings, &|n| bar.add(n)))
        }
        Some(_) | None => None,
    };
    let both =
        [EngineKind::Gpu, EngineKind::F64].map(|kind| renderings.iter().any(|(r, _)| *r == kind));
    let stages = match &gpu {
        Some(gpu) if both == [true; 2] => {
            let bar = Bar::new("stages", job.total(EngineKind::Rtl));
            let checked = job.check_stages(gpu, settings, &|n| bar.add(n));
            let mut checked = checked.map_err(InputError::from)?;
            if let (Some(first), Some(rtl)) = (&mut checked.first, &rtl) {
                first.rtl = Reg::find(first.stage.name(), first.register).map(|reg| {
                    let mut probe = RtlProbe::default();
                    rtl.trace(first.pixel, &mut probe);
                    let written = probe.get(reg).iter().filter(|code| code.is_written());
                    written.map(|code| code.value()).collect()
                });
            }
            Some(checked)
        }
        Some(_) | None => None,
    };
    // An engine that could not render makes no caustic either.
    let ran: Vec<EngineKind> = renderings.iter().map(|(kind, _)| *kind).collect();
    let caustics = match job {
        Job::Hit(job) => job.caustics(&ran, rtl.as_deref(), gpu.as_ref(), settings),
        Job::Env(_) | Job::Tex(_) => Ok(None),
    };
    let caustics = caustics.map_err(InputError::from)?;
    let (pairs, inputs, load_flags) = (Vec::new(), Vec::new(), BTreeMap::new());
    let mut results = Results {
        renderings,
        pairs,
        motions: Vec::new(),
        registers,
        stages,
        caustics,
        inputs,
        load_flags,
        skipped,
        adapter,
    };
    for (a, b) in neighbours {
        results.pair(a, b, args.scene_args.exposure)?;
    }
    if let Some(shift) = args.shift {
        results.motions = motions(job, shift, &setup, &results, args.scene_args.exposure)?;
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
