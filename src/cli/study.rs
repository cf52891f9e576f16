//! `study`: sweeps, their parts and their results.

use crate::base::num;
use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Subcommand;
use serde_json::{Value, json};

use super::Failure;
use super::args::SceneArgs;
use super::job;
use super::output::{JsonTarget, output_folder};
use super::progress::Bar;
use crate::base::hash::{hash_text, text_hash};
use crate::engine::Job;
use crate::error::InputError;
use crate::report::table::{fixed, significant};
use crate::settings::Settings;
use crate::study::cost::CostModel;
use crate::study::plan::{Place, Plan};
use crate::study::runner::{Host, Study};
use crate::study::store::{Journal, Paths, Results, Shard, finish, merge, replaceable, same_study};
use crate::study::sweep::Measuring;
use crate::truth::TruthOptions;

#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub(super) struct Args {
    #[command(subcommand)]
    action: Option<Action>,
    #[command(flatten)]
    run: RunArgs,
}

#[derive(Debug, clap::Args)]
struct RunArgs {
    /// Study file in TOML; docs/studies.md lists its keys.
    #[arg(required = true)]
    file: Option<PathBuf>,
    /// Folder of the results; `study-` and the file's name if not given.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Run part K of N only, such as 2/4; `study merge` puts parts together.
    #[arg(long, value_name = "K/N", default_value = "1/1", value_parser = shard)]
    shard: Shard,
    /// Go on with a study that was interrupted.
    #[arg(long)]
    resume: bool,
    /// Cost model's knobs; `tapline cost show` prints the default.
    #[arg(long, value_name = "FILE")]
    cost: Option<PathBuf>,
    /// Keep nothing from point to point: what separate runs would do, to measure what reuse saves.
    #[arg(long)]
    no_reuse: bool,
    /// Threads; 0 takes all cores.
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
    /// How it went as JSON; `-` is stdout.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// Put the result files of all parts together.
    Merge {
        /// results-K-of-N.jsonl of every part.
        #[arg(required = true)]
        parts: Vec<PathBuf>,
        /// Folder of the whole results.
        #[arg(long, value_name = "DIR")]
        out: PathBuf,
    },
    /// Print rows as a table: the axes and some figures.
    Table {
        /// results.jsonl.
        results: PathBuf,
        /// Figures; PSNR, share of bad fragments, gates and cycles if not given.
        #[arg(long, value_delimiter = ',')]
        columns: Vec<String>,
        /// Only rows of this scene.
        #[arg(long)]
        scene: Option<String>,
        /// Only rows that no other one of the same scene beats in error, cost and cycles.
        #[arg(long)]
        front: bool,
        /// Markdown instead of plain text.
        #[arg(long)]
        markdown: bool,
    },
    /// Write report.html and figures/*.svg beside the results.
    Report {
        /// Folder of the results.
        #[arg(default_value = ".")]
        folder: PathBuf,
        /// The study file: chosen rows are rendered once more, for pictures, error maps and footprints.
        #[arg(long, value_name = "FILE")]
        study: Option<PathBuf>,
        /// Rows to show in detail; some of each frontier if not given.
        #[arg(long, value_delimiter = ',', requires = "study")]
        rows: Vec<usize>,
        /// Pixels whose footprints are drawn; the worst and a long one if not given; repeatable.
        #[arg(long = "pixel", value_name = "X,Y", requires = "study", value_parser = super::study_report::pixel)]
        pixels: Vec<[u32; 2]>,
    },
    /// Print a SLURM array script that runs a study in parts and merges them.
    Slurm {
        /// Study file.
        file: PathBuf,
        /// Folder of the results.
        #[arg(long, value_name = "DIR")]
        out: PathBuf,
        /// Parts.
        #[arg(long, default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=10_000))]
        parts: u32,
        /// Processors a part.
        #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1024))]
        cpus: u32,
    },
}

fn shard(text: &str) -> Result<Shard, String> {
    let parts = text.split_once('/').and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
    match parts {
        Some((number, of)) if (1..=of).contains(&number) && of <= 1_000_000 => {
            Ok(Shard { number, of })
        }
        _ => Err("expected K/N with K from 1 to N, such as 2/4".into()),
    }
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    match &args.action {
        None => run_study(&args.run),
        Some(Action::Merge { parts, out }) => {
            let paths = Paths::new(out, Shard::WHOLE);
            let _folder = output_folder(out)?;
            let rows = merge(parts, &paths)?;
            writeln!(std::io::stdout(), "{} rows in {}", rows, paths.jsonl.display())?;
            Ok(())
        }
        Some(Action::Table { results, columns, scene, front, markdown }) => {
            let table =
                super::study_table::table(results, columns, scene.as_deref(), *front, *markdown)?;
            write!(std::io::stdout(), "{table}")?;
            Ok(())
        }
        Some(Action::Report { folder, study, rows, pixels }) => {
            super::study_report::report(folder, study.as_deref(), rows, pixels)
        }
        Some(Action::Slurm { file, out, parts, cpus }) => {
            let plan = Plan::load(file)?;
            write!(
                std::io::stdout(),
                "{}",
                super::study_slurm::script(&plan, file, out, *parts, *cpus)
            )?;
            Ok(())
        }
    }
}

/// Scenes from files, rows to the journal.
struct Files<'a> {
    journal: Journal,
    rows: BTreeMap<usize, Value>,
    bar: Bar,
    plan: &'a Plan,
}

impl Host for Files<'_> {
    fn job(&mut self, place: &Place, settings: &Settings) -> Result<Job, InputError> {
        job_at(place, self.plan.exposure, settings)
    }

    fn row(&mut self, number: usize, row: Value) -> Result<(), InputError> {
        self.journal.append(&row)?;
        self.rows.insert(number, row);
        self.bar.add(1);
        Ok(())
    }
}

/// Builds a place's scene as `compare` does.
pub(super) fn job_at(place: &Place, exposure: f64, settings: &Settings) -> Result<Job, InputError> {
    let args = SceneArgs {
        env: place.env.clone(),
        face_size: place.face_size,
        bounces: place.bounces,
        size: place.size,
        exposure,
        ..SceneArgs::plain()
    };
    job::load(&place.scene, &args, settings).map(|(job, _)| job)
}

/// How a plan's units are measured.
pub(super) fn measuring(plan: &Plan, cost: CostModel, reuse: bool) -> Measuring {
    Measuring {
        against: plan.against.clone(),
        truth: TruthOptions {
            samples: plan.samples,
            max_samples: plan.samples.saturating_mul(4),
            ..TruthOptions::default()
        },
        exposure: plan.exposure,
        cost,
        reuse,
        figures: plan.metrics.clone(),
    }
}

fn run_study(args: &RunArgs) -> Result<(), Failure> {
    let Some(file) = &args.file else {
        return Err(InputError::new(
            "study",
            "a study file",
            "none",
            "docs/studies.md has examples",
        )
        .into());
    };
    super::args::threads(args.threads)?;
    let study = Study::new(Plan::load(file)?);
    let cost = CostModel::load(args.cost.as_deref())?;
    let cost_hash = hash_text(text_hash(&cost.to_toml()));
    let out = args.out.clone().unwrap_or_else(|| {
        let stem = file.file_stem().map_or("study".into(), |s| s.to_string_lossy().into_owned());
        PathBuf::from(format!("study-{stem}"))
    });
    let folder = output_folder(&out)?;
    let target = JsonTarget::beside(args.json.as_deref(), Some(&folder))?;
    let paths = Paths::new(&out, args.shard);
    let header = study.header(&cost_hash, args.shard);
    let (journal, done) = open(&paths, &header, args.resume)?;
    let Some(journal) = journal else {
        super::note(&format!("{} is complete already", paths.jsonl.display()));
        return Ok(());
    };

    let rows = args.shard.range(study.rows()).len();
    let bar = Bar::new("rows", num::u64(rows));
    bar.add(num::u64(done.len()));
    let kept = done.len();
    let mut files = Files { journal, rows: done.clone(), bar, plan: &study.plan };
    let start = Instant::now();
    let how = measuring(&study.plan, cost, !args.no_reuse);
    let spent = study.run(args.shard, &done, &how, &mut files)?;
    let seconds = start.elapsed().as_secs_f64();
    let Files { journal, rows, bar, .. } = files;
    drop(bar);
    finish(&paths, &header, &rows)?;
    remove(&paths.journal)?;
    drop(journal);

    let refused = rows.values().filter(|r| r.get("refused").is_some()).count();
    let share = spent.saved[0] as f64 / spent.saved[1].max(1) as f64;
    let summary = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "unit_hash": study.plan.unit.hash(),
        "seed": study.plan.seed,
        "plan": study.plan.hash,
        "results": paths.jsonl.display().to_string(),
        "rows": rows.len(),
        "rows_run": rows.len() - kept,
        "refused": refused,
        "seconds": seconds,
        "rtl_seconds": spent.rtl_seconds,
        "steps_kept": spent.saved[0],
        "steps": spent.saved[1],
        "reuse": !args.no_reuse,
    });
    if !target.takes_stdout() {
        let mut out = std::io::stdout().lock();
        writeln!(
            out,
            "{}: {} rows, {} of them run now in {} s",
            study.plan.title,
            rows.len(),
            rows.len() - kept,
            fixed(seconds, 1)
        )?;
        if refused > 0 {
            writeln!(out, "refused: {refused} rows say why")?;
        }
        writeln!(
            out,
            "integer model: {} s; of its steps in front of the filter {} % were there already",
            significant(spent.rtl_seconds, 3),
            fixed(100.0 * share, 1)
        )?;
        writeln!(out, "{}\n{}", paths.jsonl.display(), paths.csv.display())?;
    }
    target.write(&summary)
}

/// The journal to write to and the rows that are there; no journal where nothing is left to do.
fn open(
    paths: &Paths,
    header: &Value,
    resume: bool,
) -> Result<(Option<Journal>, BTreeMap<usize, Value>), InputError> {
    let started = paths.journal.exists();
    if !resume {
        if started {
            return Err(InputError::new(
                paths.journal.display().to_string(),
                "no study that was interrupted or goes on",
                "one",
                "go on with --resume, or remove the file",
            ));
        }
        replaceable(&paths.jsonl, header)?;
        return Ok((Some(Journal::create(&paths.journal, header)?), BTreeMap::new()));
    }
    if !started && paths.jsonl.exists() {
        let before = Results::read(&paths.jsonl, false)?;
        same_study(&paths.jsonl, &before.header, header)?;
        return Ok((None, BTreeMap::new()));
    }
    if !started {
        return Ok((Some(Journal::create(&paths.journal, header)?), BTreeMap::new()));
    }
    if std::fs::metadata(&paths.journal).is_ok_and(|m| m.len() == 0) {
        return Ok((Some(Journal::create(&paths.journal, header)?), BTreeMap::new()));
    }
    let (journal, before) = Journal::resume(&paths.journal, header)?;
    let rows = before.by_number(&paths.journal)?;
    Ok((Some(journal), rows))
}

fn remove(path: &Path) -> Result<(), InputError> {
    std::fs::remove_file(path).map_err(|e| {
        InputError::new(
            path.display().to_string(),
            "a file that can be removed",
            e.to_string(),
            "remove it by hand",
        )
    })
}
