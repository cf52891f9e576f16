//! `budget`: bounds of every register with the worst errors seen, and the share of each stage in a scene's error.

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
use crate::engine::EnvJob;
use crate::error::InputError;
use crate::report::table::{Table, digits, missing, places, text, value, whole};
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
            let flags = [
                "--env",
                "--texture",
                "--bounces",
                "--bump",
                "--face-size",
                "--mesh",
                "--distance",
            ];
            args.scene.refuse_idle(&flags, "--scene or --attribution beside it")?;
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
    target.write(&Origin { seed: args.seed, ..Origin::new(spec) }.object(json!({
        "registers": registers(&rows).json(),
        "certified": domains(&certified).json(),
    })))?;
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

fn registers(rows: &[Row]) -> Table {
    Table::of(
        rows,
        &[
            ("register", "", &|r| text(format!("{}.{}", r.stage.name(), r.name))),
            ("", "stage", &|r| value(r.stage.name())),
            ("", "register", &|r| value(r.name)),
            ("bound LSB", "bound_lsb", &|r| digits(r.bound, 4)),
            ("worst LSB", "worst_lsb", &|r| digits(r.worst, 4)),
            ("used %", "used", &|r| places(100.0 * r.used, 1).with(r.used)),
            ("components", "components", &|r| whole(r.count)),
            ("", "exceeded", &|r| value(r.exceeded)),
            (" ", "verdict", &|r| text(word(r.verdict()))),
        ],
    )
}

fn domains(certified: &[Certified]) -> Table {
    Table::of(
        certified,
        &[
            ("whole domain", "", &|c| text(format!("{}: {}", c.name, c.domain))),
            ("", "name", &|c| value(&c.name)),
            ("", "domain", &|c| value(&c.domain)),
            ("inputs", "inputs", &|c| whole(c.inputs)),
            ("bound", "bound", &|c| digits(c.bound, 4)),
            ("worst", "worst", &|c| digits(c.worst, 4)),
            ("unit", "unit", &|c| text(c.unit)),
            (" ", "certified", &|c| {
                text(if c.holds() { "certified" } else { "EXCEEDED" }).with(c.holds())
            }),
        ],
    )
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
    writeln!(out, "{}", registers(rows))?;
    let vacuous = rows.iter().filter(|r| r.verdict() == Verdict::Vacuous).count();
    writeln!(out, "{} registers, {vacuous} with a vacuous bound\n", rows.len())?;
    if !certified.is_empty() {
        writeln!(out, "{}", domains(certified))?;
    }
    Ok(())
}

/// A scene of ENV with its environment.
fn env_scene(args: &Args, spec: &UnitSpec, name: &str) -> Result<EnvJob, InputError> {
    args.scene.refuse_texture()?;
    args.scene.refuse_distance()?;
    subject::load(name, &args.scene, &spec.settings(ReferenceAxis::Exact)).map(|(job, _)| job)
}

/// The part that is no stage.
const WHOLE: &str = "all of the unit";

fn shares(args: &Args, spec: &UnitSpec, scene: &str, target: JsonTarget) -> Result<(), Failure> {
    let subject = env_scene(args, spec, scene)?;
    let parts = attribute(spec, &subject)?;
    let (whole, stages): (Vec<&Part>, Vec<&Part>) = parts.iter().partition(|p| p.name == WHOLE);
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
        let table = Table::of(
            stages.iter().chain(&whole),
            &[
                ("words of", "", &|p| text(&p.name)),
                ("rmse", "", &|p| digits(p.rmse, 3)),
                ("worst", "", &|p| digits(p.max_abs, 3)),
                ("share of the squares %", "", &|p| {
                    if p.name == WHOLE { missing("") } else { places(share(p), 1) }
                }),
            ],
        );
        writeln!(out, "{table}")?;
    }
    let list: Vec<_> = stages
        .iter()
        .map(|p| json!({"name": p.name, "rmse": p.rmse, "max_abs": p.max_abs, "share": share(p) / 100.0}))
        .collect();
    target.write(&Origin::new(spec).object(json!({
        "scene": scene,
        "parts": list,
        "rmse": whole.first().map(|p| p.rmse),
    })))
}
