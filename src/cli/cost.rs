//! `cost`: the cost model's knobs, and the cost of a unit stage by stage.

use std::io::Write as _;
use std::path::PathBuf;

use clap::Subcommand;
use serde_json::json;

use super::Failure;
use super::args::UnitArgs;
use super::output::{JsonTarget, Origin};
use crate::report::table::{Table, grouped, missing, places, text, value, whole};
use crate::scene::registry::find;
use crate::study::cost::{CostModel, Sheet};

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
            let operation = find(scene)?.operation();
            let model = CostModel::load(cost.as_deref())?;
            let spec = unit.load()?;
            let target = JsonTarget::open(json.as_deref())?;
            let sheet = model.sheet(&spec.config, operation);
            if !target.takes_stdout() {
                print(&model, &sheet)?;
            }
            let mut stages = table(&model, &sheet).json();
            let total = stages.pop();
            target.write(&Origin::new(&spec).object(json!({
                "scene": scene, "stages": stages, "total": total, "unmodelled": sheet.unmodelled,
            })))
        }
    }
}

#[expect(clippy::cast_precision_loss, reason = "counts")]
fn number(n: u64) -> f64 {
    n as f64
}

/// What each stage costs, and at the end all of them.
fn table(model: &CostModel, sheet: &Sheet) -> Table {
    let total = sheet.total();
    let rows = sheet.stages.iter().map(|(stage, parts)| (stage.name(), parts));
    Table::of(
        rows.chain([("all", &total)]),
        &[
            ("stage", "stage", &|(name, _)| text(name)),
            ("multipliers", "multipliers", &|(_, p)| places(number(p.multiplier_count()), 0)),
            ("widest (bits)", "", &|(_, p)| {
                let widest = p.multipliers.iter().max_by_key(|([a, b], _)| a * b);
                widest.map_or(missing("–"), |([a, b], _)| whole(format!("{a}x{b}")))
            }),
            ("", "by_width", &|(_, p)| {
                let by = p.multipliers.iter().map(|(w, n)| json!({"widths": w, "count": n}));
                value(by.collect::<Vec<_>>())
            }),
            ("", "adder_bits", &|(_, p)| value(p.adder_bits)),
            ("", "rounding_bits", &|(_, p)| value(p.rounding_bits)),
            ("", "muxes", &|(_, p)| value(p.muxes)),
            ("", "zero_count_bits", &|(_, p)| value(p.zero_count_bits)),
            ("logic (kGE)", "", &|(_, p)| places(p.logic(&model.cells) / 1000.0, 1)),
            ("tables (bits)", "rom_bits", &|(_, p)| grouped(p.rom_bits).with(number(p.rom_bits))),
            ("registers (bits)", "register_bits", &|(_, p)| {
                grouped(p.register_bits).with(number(p.register_bits))
            }),
            ("", "logic_gates", &|(_, p)| value(p.logic(&model.cells))),
            ("all (kGE)", "gates", &|(_, p)| {
                let gates = p.gates(&model.cells);
                places(gates / 1000.0, 1).with(gates)
            }),
        ],
    )
}

/// A sheet for people.
fn print(model: &CostModel, sheet: &Sheet) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    write!(out, "{}", table(model, sheet))?;
    writeln!(out, "not counted:")?;
    for part in &sheet.unmodelled {
        writeln!(out, "  {part}")?;
    }
    Ok(())
}
