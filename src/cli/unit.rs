//! `unit show|check`: every path with its value and meaning.

use crate::base::num;
use std::io::Write as _;
use std::path::PathBuf;

use clap::Subcommand;
use rtl_model::Config;
use rtl_model::regs::{Event, Kind, Reg};
use rtl_model::stages::Roms;
use serde_json::json;

use super::Failure;
use super::args::UnitArgs;
use super::output::{JsonTarget, Origin, unit_json};
use crate::error::InputError;
use crate::report::table::{Align, Table, significant};
use crate::unit::bounds::{self, Bound};
use crate::unit::file::{self, Origins};
use crate::unit::{UnitSpec, check, refused};

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// Print every path with its value, legal values and meaning.
    Show {
        /// Unit file; the default unit if not given.
        file: Option<String>,
        /// Only the TOML, fit for --unit.
        #[arg(long)]
        toml: bool,
        /// The unit as JSON; `-` is stdout.
        #[arg(long, value_name = "FILE")]
        json: Option<PathBuf>,
        #[command(flatten)]
        unit: UnitArgs,
    },
    /// Check a unit file; status 2 and the reason if it is refused.
    Check {
        /// Unit file; the default unit if not given.
        file: Option<String>,
        /// The result as JSON; `-` is stdout.
        #[arg(long, value_name = "FILE")]
        json: Option<PathBuf>,
        #[command(flatten)]
        unit: UnitArgs,
    },
}

fn merge(file: Option<&String>, unit: &UnitArgs) -> Result<(UnitSpec, Origins), InputError> {
    if let (Some(file), Some(other)) = (file, &unit.unit) {
        return Err(InputError::new(
            "unit",
            "one unit",
            format!("`{file}` and --unit {other}"),
            "name one of them",
        ));
    }
    file::load(file.map(String::as_str).or(unit.unit.as_deref()), &unit.sets)
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    match &args.action {
        Action::Check { file, json, unit } => {
            let (spec, origins) = merge(file.as_ref(), unit)?;
            origins.check(&spec, check)?;
            let target = JsonTarget::open(json.as_deref())?;
            let (registers, tables) = (register_bits(&spec.config), table_bits(&spec.config)?);
            if !target.takes_stdout() {
                let hash = spec.hash();
                writeln!(
                    std::io::stdout().lock(),
                    "unit {hash}: {registers} register bits, {tables} table bits"
                )?;
            }
            let mut root = Origin::new(&spec).json();
            root.insert("register_bits".into(), json!(registers));
            root.insert("table_bits".into(), json!(tables));
            target.write(&serde_json::Value::Object(root))
        }
        Action::Show { file, toml, json, unit } => {
            let (spec, _) = merge(file.as_ref(), unit)?;
            let target = JsonTarget::open(json.as_deref())?;
            if !target.takes_stdout() {
                if *toml {
                    write!(
                        std::io::stdout().lock(),
                        "# tapline {}, unit {}\n\n{}",
                        env!("CARGO_PKG_VERSION"),
                        spec.hash(),
                        file::to_toml(&spec)
                    )?;
                } else {
                    show(&spec)?;
                }
            }
            let mut root = Origin::new(&spec).json();
            root.insert("unit".into(), unit_json(&spec));
            root.insert("register_bits".into(), json!(register_bits(&spec.config)));
            root.insert("table_bits".into(), json!(table_bits(&spec.config)?));
            let events: Vec<&str> = Event::ALL.iter().map(|e| e.name()).collect();
            root.insert("events".into(), json!(events));
            let bounds: Vec<_> = bounds::bounds(&spec.config)
                .iter()
                .map(|b| json!({"name": b.name, "bound": b.bound, "holds": b.holds}))
                .collect();
            root.insert("bounds".into(), json!(bounds));
            target.write(&serde_json::Value::Object(root))
        }
    }
}

fn show(spec: &UnitSpec) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    writeln!(out, "tapline {}, unit {}\n", env!("CARGO_PKG_VERSION"), spec.hash())?;
    let defaults = UnitSpec::default().knobs();
    let mut table = Table::new(&[
        ("path", Align::Left),
        ("value", Align::Left),
        ("default", Align::Left),
        ("legal", Align::Left),
        ("honoured by", Align::Left),
        ("meaning", Align::Left),
    ]);
    for (knob, default) in spec.knobs().iter().zip(&defaults) {
        table.row([
            knob.path.clone(),
            knob.value.to_string(),
            default.value.to_string(),
            knob.legal.clone(),
            if knob.all_engines { "all engines" } else { "rtl" }.into(),
            knob.meaning.clone(),
        ]);
    }
    writeln!(out, "{table}")?;
    let mut words = Table::new(&[
        ("register", Align::Left),
        ("components", Align::Right),
        ("bits", Align::Right),
        ("kind", Align::Left),
        ("flag", Align::Left),
    ]);
    for reg in Reg::ALL {
        let info = reg.info();
        let block = info.kind == Kind::Block;
        words.row([
            format!("{}.{}", info.stage, info.name),
            info.components.to_string(),
            spec.config.format(*reg).width().to_string(),
            if block { "block: shared exponent" } else { "fixed" }.into(),
            if block { "-".into() } else { crate::engine::rtl::overflow_name(&spec.config, *reg) },
        ]);
    }
    writeln!(out, "{words}")?;
    writeln!(
        out,
        "{} register bits, {} table bits",
        register_bits(&spec.config),
        table_bits(&spec.config)?
    )?;
    let events: Vec<&str> = Event::ALL.iter().map(|e| e.name()).collect();
    writeln!(out, "events: {}\n", events.join(" "))?;
    let mut table = Table::new(&[
        ("bound of rtl against exact arithmetic", Align::Left),
        ("|error|", Align::Right),
        ("where it holds", Align::Left),
    ]);
    for Bound { name, bound, holds } in bounds::bounds(&spec.config) {
        table.row([name.to_string(), significant(bound, 3), holds.to_string()]);
    }
    writeln!(out, "{table}")?;
    Ok(())
}

/// Bits of all registers, each component once.
fn register_bits(config: &Config) -> u64 {
    Reg::ALL
        .iter()
        .map(|reg| num::u64(reg.info().components) * u64::from(config.format(*reg).width()))
        .sum()
}

/// Bits of all tables.
fn table_bits(config: &Config) -> Result<u64, InputError> {
    let roms = Roms::new(config).map_err(refused)?;
    Ok(roms.recip.bits()
        + roms.rsqrt.bits()
        + roms.sqrt.bits()
        + roms.log2.bits()
        + roms.angle.bits())
}
