//! `budget`: bounds of every register beside the worst errors seen, and whose words a scene's error comes from.

use std::io::Write as _;
use std::path::PathBuf;

use serde_json::json;

use super::Failure;
use super::args::{SceneArgs, UnitArgs};
use super::output::{JsonTarget, Origin};
use super::progress::Bar;
use super::subject;
use crate::conformance::attribution::{Part, attribute};
use crate::conformance::budget::{self, Row, Verdict};
use crate::conformance::certify::{Certified, certify};
use crate::engine::Subject;
use crate::error::InputError;
use crate::report::table::{Align, Table, significant};
use crate::unit::{ReferenceAxis, UnitSpec};

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Instead of bounds: the share of each stage in the error of a scene (ENV).
    #[arg(long, value_name = "SCENE")]
    attribution: Option<String>,
    /// The fragments of an ENV scene instead of the suites' inputs.
    #[arg(long = "scene", value_name = "SCENE", conflicts_with = "attribution")]
    over: Option<String>,
    /// Cases of each class and operation.
    #[arg(long, value_name = "N", default_value_t = 1000)]
    cases: u64,
    /// Seed of the cases.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Leave the whole domains out.
    #[arg(long)]
    quick: bool,
    /// The tables as JSON; `-` is stdout, and nothing else goes there.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    unit: UnitArgs,
    #[command(flatten)]
    scene: SceneArgs,
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let spec = args.unit.load()?;
    let target = JsonTarget::open(args.json.as_deref())?;
    match &args.attribution {
        Some(scene) => shares(args, &spec, scene, target),
        None => bounds(args, &spec, target),
    }
}

fn word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Holds => "holds",
        Verdict::Exact => "exact",
        Verdict::Vacuous => "vacuous",
        Verdict::Exceeded => "EXCEEDED",
    }
}

fn bounds(args: &Args, spec: &UnitSpec, target: JsonTarget) -> Result<(), Failure> {
    let (rows, cases) = match &args.over {
        None => {
            let bar = Bar::new("budget", budget::total(args.cases));
            let rows = budget::registers(spec, args.cases, args.seed, &|n| bar.add(n))?;
            (rows, format!("{} cases", budget::total(args.cases)))
        }
        Some(name) => {
            let subject = env_scene(args, spec, name)?;
            let count = subject.scene.fragments.len();
            (budget::scene(spec, &subject)?, format!("{count} fragments of {name}"))
        }
    };
    let certified = if args.quick { Vec::new() } else { certify(spec)? };
    if !target.takes_stdout() {
        print(spec, (args.seed, &cases), &rows, &certified)?;
    }
    let mut root = Origin::new(spec).json();
    root.insert("seed".into(), json!(args.seed));
    let list: Vec<_> = rows
        .iter()
        .map(|r| {
            json!({
                "stage": r.stage.name(), "register": r.name, "bound_lsb": r.bound, "worst_lsb": r.worst,
                "used": r.used, "components": r.count, "exceeded": r.exceeded, "verdict": word(r.verdict()),
            })
        })
        .collect();
    root.insert("registers".into(), json!(list));
    let list: Vec<_> = certified
        .iter()
        .map(|c| {
            json!({
                "name": c.name, "domain": c.domain, "inputs": c.inputs, "bound": c.bound, "worst": c.worst,
                "unit": c.unit, "certified": c.holds(),
            })
        })
        .collect();
    root.insert("certified".into(), json!(list));
    target.write(&serde_json::Value::Object(root))?;
    let broken: Vec<String> = rows
        .iter()
        .filter(|r| r.verdict() == Verdict::Exceeded)
        .map(|r| format!("{}.{}", r.stage.name(), r.name))
        .chain(certified.iter().filter(|c| !c.holds()).map(|c| c.name.clone()))
        .collect();
    if broken.is_empty() {
        Ok(())
    } else {
        Err(Failure::Disagrees(format!("beyond the bound: {}", broken.join(", "))))
    }
}

fn print(
    spec: &UnitSpec,
    (seed, cases): (u64, &str),
    rows: &[Row],
    certified: &[Certified],
) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    writeln!(
        out,
        "tapline {}, unit {}, seed {seed}, {cases}\n",
        env!("CARGO_PKG_VERSION"),
        spec.hash()
    )?;
    let mut table = Table::new(&[
        ("register", Align::Left),
        ("bound LSB", Align::Right),
        ("worst LSB", Align::Right),
        ("used %", Align::Right),
        ("components", Align::Right),
        ("", Align::Left),
    ]);
    for row in rows {
        table.row([
            format!("{}.{}", row.stage.name(), row.name),
            significant(row.bound, 4),
            significant(row.worst, 4),
            format!("{:.1}", 100.0 * row.used),
            row.count.to_string(),
            word(row.verdict()).into(),
        ]);
    }
    writeln!(out, "{table}")?;
    let vacuous = rows.iter().filter(|r| r.verdict() == Verdict::Vacuous).count();
    writeln!(out, "{} registers, {vacuous} with a vacuous bound\n", rows.len())?;
    if certified.is_empty() {
        return Ok(());
    }
    let mut table = Table::new(&[
        ("whole domain", Align::Left),
        ("inputs", Align::Right),
        ("bound", Align::Right),
        ("worst", Align::Right),
        ("unit", Align::Left),
        ("", Align::Left),
    ]);
    for c in certified {
        table.row([
            format!("{}: {}", c.name, c.domain),
            c.inputs.to_string(),
            significant(c.bound, 4),
            significant(c.worst, 4),
            c.unit.into(),
            if c.holds() { "certified" } else { "EXCEEDED" }.into(),
        ]);
    }
    writeln!(out, "{table}")?;
    Ok(())
}

/// A scene of ENV with its environment.
fn env_scene(args: &Args, spec: &UnitSpec, name: &str) -> Result<Subject, InputError> {
    args.scene.refuse_texture()?;
    args.scene.refuse_distance()?;
    subject::load(name, &args.scene, &spec.settings(ReferenceAxis::Exact))
}

fn shares(args: &Args, spec: &UnitSpec, scene: &str, target: JsonTarget) -> Result<(), Failure> {
    let subject = env_scene(args, spec, scene)?;
    let parts = attribute(spec, &subject)?;
    let (whole, stages): (Vec<&Part>, Vec<&Part>) =
        parts.iter().partition(|p| p.name == "all of the unit");
    let squares: f64 = stages.iter().map(|p| p.rmse * p.rmse).sum();
    let share = |part: &Part| 100.0 * part.rmse * part.rmse / squares.max(f64::MIN_POSITIVE);
    if !target.takes_stdout() {
        let mut out = std::io::stdout().lock();
        writeln!(
            out,
            "tapline {}, unit {}, scene {scene}: error of the colour, sRGB, peak 1, by whose words cause it\n",
            env!("CARGO_PKG_VERSION"),
            spec.hash()
        )?;
        let mut table = Table::new(&[
            ("words of", Align::Left),
            ("rmse", Align::Right),
            ("worst", Align::Right),
            ("share of the squares %", Align::Right),
        ]);
        for part in &stages {
            table.row([
                part.name.clone(),
                significant(part.rmse, 3),
                significant(part.max_abs, 3),
                format!("{:.1}", share(part)),
            ]);
        }
        for part in &whole {
            table.row([
                part.name.clone(),
                significant(part.rmse, 3),
                significant(part.max_abs, 3),
                String::new(),
            ]);
        }
        writeln!(out, "{table}")?;
    }
    let mut root = Origin::new(spec).json();
    root.insert("scene".into(), json!(scene));
    let list: Vec<_> = stages
        .iter()
        .map(|p| json!({"name": p.name, "rmse": p.rmse, "max_abs": p.max_abs, "share": share(p) / 100.0}))
        .collect();
    root.insert("parts".into(), json!(list));
    root.insert("rmse".into(), json!(whole.first().map(|p| p.rmse)));
    target.write(&serde_json::Value::Object(root))
}
