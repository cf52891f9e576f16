//! `cost`: the cost model's knobs, and what a unit costs stage by stage.

use std::io::Write as _;
use std::path::PathBuf;

use clap::Subcommand;
use rtl_model::unit::Needs;
use serde_json::{Value, json};

use super::Failure;
use super::args::UnitArgs;
use super::output::{JsonTarget, Origin};
use crate::error::InputError;
use crate::report::table::{Align, Table, count, fixed};
use crate::scene::SCENES;
use crate::scene::hit::is_hit_scene;
use crate::scene::tex::is_tex_scene;
use crate::stage::Stage;
use crate::study::cost::gates::Parts;
use crate::study::cost::{CostModel, Operation, Sheet};
use crate::study::known_scenes;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// Print the knobs, fit for --cost.
    Show {
        /// Knobs to start from; the defaults if not given.
        #[arg(long, value_name = "FILE")]
        cost: Option<PathBuf>,
    },
    /// What the unit that a scene needs costs, stage by stage.
    Unit {
        /// Built-in scene; it decides which stages are built.
        #[arg(default_value = "scratches")]
        scene: String,
        /// Knobs; the defaults if not given.
        #[arg(long, value_name = "FILE")]
        cost: Option<PathBuf>,
        /// The sheet as JSON; `-` is stdout.
        #[arg(long, value_name = "FILE")]
        json: Option<PathBuf>,
        #[command(flatten)]
        unit: UnitArgs,
    },
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    match &args.action {
        Action::Show { cost } => {
            write!(std::io::stdout(), "{}", CostModel::load(cost.as_deref())?.to_toml())?;
            Ok(())
        }
        Action::Unit { scene, cost, json, unit } => {
            let operation = operation(scene)?;
            let model = CostModel::load(cost.as_deref())?;
            let spec = unit.load()?;
            let target = JsonTarget::open(json.as_deref())?;
            let sheet = model.sheet(&spec.config, operation);
            if !target.takes_stdout() {
                print(&model, &sheet)?;
            }
            let mut root = Origin::new(&spec).json();
            root.insert("scene".into(), json!(scene));
            root.extend(sheet_json(&model, &sheet));
            target.write(&Value::Object(root))
        }
    }
}

/// What a scene needs of the unit, by its name alone.
fn operation(scene: &str) -> Result<Operation, InputError> {
    if is_tex_scene(scene) {
        return Ok(Operation::Tex);
    }
    if is_hit_scene(scene) {
        return Ok(Operation::Hit);
    }
    match SCENES.iter().find(|s| s.name == scene) {
        Some(info) => Ok(Operation::Env(Needs {
            bump: info.stages.contains(&Stage::Bump),
            rough: info.stages.contains(&Stage::Roughness),
        })),
        None => Err(InputError::new(
            "scene",
            format!("one of {}", known_scenes().join(", ")),
            format!("`{scene}`"),
            "`tapline scenes` lists them",
        )),
    }
}

fn numbers(model: &CostModel, parts: &Parts) -> [f64; 5] {
    #[expect(clippy::cast_precision_loss, reason = "counts of bits")]
    let bits = [parts.rom_bits, parts.register_bits].map(|n| n as f64);
    #[expect(clippy::cast_precision_loss, reason = "counts")]
    let multipliers = parts.multiplier_count() as f64;
    [multipliers, parts.logic(&model.cells), bits[0], bits[1], parts.gates(&model.cells)]
}

/// A sheet for people.
pub(super) fn print(model: &CostModel, sheet: &Sheet) -> Result<(), Failure> {
    let mut table = Table::new(&[
        ("stage", Align::Left),
        ("multipliers", Align::Right),
        ("widest (bits)", Align::Right),
        ("logic (kGE)", Align::Right),
        ("tables (bits)", Align::Right),
        ("registers (bits)", Align::Right),
        ("all (kGE)", Align::Right),
    ]);
    let mut row = |name: &str, parts: &Parts| {
        let [multipliers, logic, ..] = numbers(model, parts);
        let widest = parts.multipliers.iter().max_by_key(|([a, b], _)| a * b);
        table.row([
            name.to_string(),
            fixed(multipliers, 0),
            widest.map_or("–".into(), |([a, b], _)| format!("{a}x{b}")),
            fixed(logic / 1000.0, 1),
            count(parts.rom_bits),
            count(parts.register_bits),
            fixed(parts.gates(&model.cells) / 1000.0, 1),
        ]);
    };
    for (stage, parts) in &sheet.stages {
        row(stage.name(), parts);
    }
    row("all", &sheet.total());
    let mut out = std::io::stdout().lock();
    write!(out, "{table}")?;
    writeln!(out, "not counted:")?;
    for part in &sheet.unmodelled {
        writeln!(out, "  {part}")?;
    }
    Ok(())
}

fn sheet_json(model: &CostModel, sheet: &Sheet) -> serde_json::Map<String, Value> {
    let parts = |name: &str, parts: &Parts| {
        let [multipliers, logic, rom, registers, gates] = numbers(model, parts);
        let by_width: Vec<Value> = parts
            .multipliers
            .iter()
            .map(|([a, b], n)| json!({"widths": [a, b], "count": n}))
            .collect();
        json!({"stage": name, "multipliers": multipliers, "by_width": by_width, "adder_bits": parts.adder_bits,
            "rounding_bits": parts.rounding_bits, "muxes": parts.muxes, "zero_count_bits": parts.zero_count_bits,
            "rom_bits": rom, "register_bits": registers, "logic_gates": logic, "gates": gates})
    };
    let stages: Vec<Value> = sheet.stages.iter().map(|(s, p)| parts(s.name(), p)).collect();
    let mut out = serde_json::Map::new();
    out.insert("stages".into(), json!(stages));
    out.insert("total".into(), parts("all", &sheet.total()));
    out.insert("unmodelled".into(), json!(sheet.unmodelled));
    out
}
