//! `conform`: named suites of seeded cases on every engine.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde_json::{Value, json};

use super::Failure;
use super::output::JsonTarget;
use super::progress::Bar;
use crate::base::num;
use crate::conformance::check::Difference;
use crate::conformance::gpu;
use crate::conformance::harness::Device as _;
use crate::conformance::run::{self, Engine, Outcome, Runner};
use crate::conformance::suite::{CASES, Suite, matches};
use crate::conformance::text as vector;
use crate::error::InputError;
use crate::gpu::Gpu;
use crate::report::table::{Table, given, text, value, whole};
use crate::unit::file;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Suites by name, with `*` for any characters: `eigen/*`, `*/default/extremes`.
    #[arg(long, value_name = "GLOB", default_value = "*")]
    suite: String,
    /// Cases of each suite, from LO to below HI.
    #[arg(long, num_args = 2, value_names = ["LO", "HI"])]
    range: Option<Vec<u64>>,
    /// Seed of all suites.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Engines, of rtl, f64 and gpu; those that are there if not given.
    #[arg(long, value_delimiter = ',', value_parser = engine)]
    engines: Option<Vec<Engine>>,
    /// GPU adapter, by index or name, as `gpu list` shows them.
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// Only the names.
    #[arg(long)]
    list: bool,
    /// Folder for a failed case: its inputs, its unit and the command that replays it.
    #[arg(long, value_name = "DIR", default_value = "conform-failures")]
    out: PathBuf,
    /// The results as JSON; `-` is stdout, and nothing else goes there.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

fn engine(text: &str) -> Result<Engine, String> {
    Engine::ALL
        .into_iter()
        .find(|e| e.name() == text)
        .ok_or_else(|| "expected rtl, f64 or gpu".into())
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let suites: Vec<Suite> =
        Suite::all().into_iter().filter(|suite| matches(&args.suite, &suite.name())).collect();
    if suites.is_empty() {
        return Err(InputError::new(
            "--suite",
            "a pattern that some suite has",
            format!("`{}`", args.suite),
            "`tapline conform --list` prints the names",
        )
        .into());
    }
    if args.list {
        let mut out = std::io::stdout().lock();
        for suite in &suites {
            writeln!(out, "{}", suite.name())?;
        }
        return Ok(());
    }
    let range = match args.range.as_deref() {
        None => 0..CASES,
        Some([low, high]) if low < high => *low..*high,
        Some(_) => {
            return Err(InputError::new(
                "--range",
                "two indices, the first below the second",
                "another order",
                "write for instance --range 0 100",
            )
            .into());
        }
    };
    let mut engines = args.engines.clone().unwrap_or(Engine::ALL.to_vec());
    let mut skipped = Vec::new();
    let mut device = None;
    if engines.contains(&Engine::Gpu) {
        match Gpu::open(args.adapter.as_deref()) {
            Ok(gpu) => device = Some(gpu),
            Err(why) if args.engines.is_some() || args.adapter.is_some() => {
                return Err(InputError::new(
                    "--engines",
                    "engines that are there",
                    format!("gpu: {why}"),
                    "`tapline gpu list` shows the adapters",
                )
                .into());
            }
            Err(why) => skipped.push((Engine::Gpu, why.to_string())),
        }
    }
    engines.retain(|engine| *engine != Engine::Gpu);
    let target = JsonTarget::open(args.json.as_deref())?;
    let cases = range.end - range.start;
    let total = cases * num::u64(suites.len());
    let bar = Bar::new("conform", total);
    let results: Vec<Result<Outcome, InputError>> = suites
        .par_iter()
        .map(|suite| {
            let outcome = Runner::new(*suite, args.seed)?.run(&engines, range.clone());
            bar.add(outcome.cases);
            Ok(outcome)
        })
        .collect();
    drop(bar);
    let mut outcomes = Vec::new();
    for outcome in results {
        outcomes.push(outcome?);
    }
    if let Some(device) = &device {
        on_device(device, &suites, &mut outcomes, args.seed, &range)?;
        engines.push(Engine::Gpu);
    }
    report(args, &suites, &outcomes, &engines, &skipped, target)
}

/// Adds what a device makes of the suites of whole operations, one after the other: a kernel has the device to itself.
fn on_device(
    device: &Gpu,
    suites: &[Suite],
    outcomes: &mut [Outcome],
    seed: u64,
    range: &std::ops::Range<u64>,
) -> Result<(), InputError> {
    let concerned = suites.iter().filter(|s| gpu::concerns(s)).count();
    let cases = range.end - range.start;
    let bar = Bar::new("gpu", cases * num::u64(concerned));
    for (suite, outcome) in suites.iter().zip(outcomes) {
        if !gpu::concerns(suite) {
            continue;
        }
        let checked = gpu::run(device, *suite, seed, range.clone())?;
        bar.add(checked.cases);
        outcome.judged += checked.judged;
        let Some((index, stage, register, text)) = checked.first else {
            continue;
        };
        outcome.failed += 1;
        if outcome.failure.is_none() {
            let mut runner = Runner::new(*suite, seed)?;
            let input = runner.input(index);
            let (observed, expected) = text.split_once(" expected ").unwrap_or((&text, ""));
            outcome.failure = Some(run::Failure {
                engine: Engine::Gpu,
                index,
                output: runner.output(&input),
                input,
                difference: Difference {
                    stage,
                    field: register.into(),
                    component: 0,
                    observed: observed.into(),
                    expected: expected.into(),
                    more: num::usize(checked.unexplained.saturating_sub(1)),
                },
            });
        }
    }
    Ok(())
}

fn report(
    args: &Args,
    suites: &[Suite],
    outcomes: &[Outcome],
    engines: &[Engine],
    skipped: &[(Engine, String)],
    target: JsonTarget,
) -> Result<(), Failure> {
    let failed: Vec<_> =
        suites.iter().zip(outcomes).filter(|(_, outcome)| outcome.failure.is_some()).collect();
    for (suite, outcome) in suites.iter().zip(outcomes) {
        if let Some(why) = outcome.vacuous {
            super::note(&format!("{}: {why}: the comparison shows little", suite.name()));
        }
        if let Some(failure) = &outcome.failure {
            keep(&folder(args, suite), suite, failure, args.seed)?;
        }
    }
    let names: Vec<&str> = engines.iter().map(|e| e.name()).collect();
    let value: Value = json!({
        "version": env!("CARGO_PKG_VERSION"), "seed": args.seed, "engines": names,
        "suites": table(args, suites.iter().zip(outcomes)).json(),
        "skipped": skipped.iter().map(|(e, why)| json!({"engine": e.name(), "why": why})).collect::<Vec<_>>(),
    });
    let judged: u64 = outcomes.iter().map(|o| o.judged).sum();
    if !target.takes_stdout() {
        let mut out = std::io::stdout().lock();
        if !failed.is_empty() {
            writeln!(out, "{}", table(args, failed.iter().copied()))?;
        }
        let failed = failed.len();
        let cases: u64 = outcomes.iter().map(|o| o.cases).sum();
        writeln!(
            out,
            "{} suites, {cases} cases on {}, {judged} components against exact arithmetic: {failed} suites failed; tapline {}, seed {}",
            suites.len(),
            names.join(" and "),
            env!("CARGO_PKG_VERSION"),
            args.seed
        )?;
        for (engine, why) in skipped {
            writeln!(out, "skipped: {}, {why}", engine.name())?;
        }
    }
    target.write(&value)?;
    if failed.is_empty() {
        return Ok(());
    }
    let (failed, out) = (failed.len(), args.out.display());
    Err(Failure::Disagrees(format!("{failed} suites failed; see {out}")))
}

/// The folder of a failed case of a suite.
fn folder(args: &Args, suite: &Suite) -> PathBuf {
    args.out.join(suite.name().replace('/', "-"))
}

/// What came of suites, with the first difference of those that failed.
fn table<'a>(args: &Args, of: impl Iterator<Item = (&'a Suite, &'a Outcome)>) -> Table {
    Table::of(
        of,
        &[
            ("suite", "suite", &|(suite, _)| text(suite.name())),
            ("cases", "cases", &|(_, o)| whole(o.cases)),
            ("failed", "failed", &|(_, o)| whole(o.failed)),
            ("", "judged", &|(_, o)| value(o.judged)),
            ("", "vacuous", &|(_, o)| value(o.vacuous)),
            ("first difference", "failure", &|(suite, o)| {
                let Some(f) = &o.failure else { return given(None::<Value>) };
                let (engine, difference) = (f.engine.name(), &f.difference);
                text(format!("case {} on {engine}: {}", f.index, difference.text())).with(json!({
                    "index": f.index, "engine": engine, "stage": difference.stage.name(),
                    "field": difference.field, "folder": folder(args, suite).display().to_string(),
                }))
            }),
        ],
    )
}

/// Writes a failed case's folder.
fn keep(folder: &Path, suite: &Suite, failure: &run::Failure, seed: u64) -> Result<(), InputError> {
    let write = |name: &str, text: String| {
        let path = folder.join(name);
        std::fs::write(&path, text).map_err(|e| {
            InputError::new(
                path.display().to_string(),
                "a file that can be written",
                e.to_string(),
                "choose another --out",
            )
        })
    };
    std::fs::create_dir_all(folder).map_err(|e| {
        InputError::new(
            folder.display().to_string(),
            "a folder that can be made",
            e.to_string(),
            "choose another --out",
        )
    })?;
    let spec = suite.configuration.unit()?;
    let mut runner = Runner::new(*suite, seed)?;
    let original = runner.input(failure.index);
    let model = runner.model();
    let shape = model.shape().clone();
    let output = runner.output(&original);
    let line =
        |input: &[i64], output: &[i64]| vector::line(&shape, vector::Format::Jsonl, input, output);
    let (index, name) = (failure.index, suite.name());
    write("unit.toml", file::to_toml(&spec))?;
    write("case.jsonl", format!("{}\n", line(&original, &output)))?;
    write("minimised.jsonl", format!("{}\n", line(&failure.input, &failure.output)))?;
    write(
        "replay.txt",
        format!(
            "tapline conform --suite {name} --range {index} {} --seed {seed} --engines {}\n{}\n",
            index + 1,
            failure.engine.name(),
            failure.difference.text()
        ),
    )
}
