//! `unit show|check`: every path with its value and meaning.

use crate::base::num;
use crate::engine::ranges::LoadEvent;
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
use crate::engine::rtl::overflow_name;
use crate::error::InputError;
use crate::report::table::{Table, digits, text, whole};
use crate::unit::bounds;
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
            target.write(&Origin::new(&spec).object(json!({
                "register_bits": registers, "table_bits": tables,
            })))
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
            let events = events();
            target.write(&Origin::new(&spec).object(json!({
                "unit": unit_json(&spec),
                "register_bits": register_bits(&spec.config),
                "table_bits": table_bits(&spec.config)?,
                "events": events,
                "bounds": bounds(&spec).json(),
            })))
        }
    }
}

fn bounds(spec: &UnitSpec) -> Table {
    Table::of(
        bounds::bounds(&spec.config),
        &[
            ("bound of rtl against exact arithmetic", "name", &|b| text(b.name)),
            ("|error|", "bound", &|b| digits(b.bound, 3)),
            ("where it holds", "holds", &|b| text(b.holds)),
        ],
    )
}

fn show(spec: &UnitSpec) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    writeln!(out, "tapline {}, unit {}\n", env!("CARGO_PKG_VERSION"), spec.hash())?;
    let defaults = UnitSpec::default().knobs();
    let knobs = Table::of(
        spec.knobs().iter().zip(&defaults),
        &[
            ("path", "", &|(k, _)| text(&k.path)),
            ("value", "", &|(k, _)| text(&k.value)),
            ("default", "", &|(_, default)| text(&default.value)),
            ("legal", "", &|(k, _)| text(&k.legal)),
            ("honoured by", "", &|(k, _)| text(if k.all_engines { "all engines" } else { "rtl" })),
            ("meaning", "", &|(k, _)| text(&k.meaning)),
        ],
    );
    writeln!(out, "{knobs}")?;
    let words = Table::of(
        Reg::ALL.iter().map(|reg| (*reg, reg.info())),
        &[
            ("register", "", &|(reg, _)| text(reg.to_string())),
            ("components", "", &|(_, info)| whole(info.components)),
            ("bits", "", &|(reg, _)| whole(spec.config.format(*reg).width())),
            ("kind", "", &|(_, info)| match info.kind {
                Kind::Block => text("block: shared exponent"),
                Kind::Fixed => text("fixed"),
            }),
            ("flag", "", &|(reg, info)| match info.kind {
                Kind::Block => text("-"),
                Kind::Fixed => text(overflow_name(&spec.config, *reg)),
            }),
        ],
    );
    writeln!(out, "{words}")?;
    writeln!(
        out,
        "{} register bits, {} table bits",
        register_bits(&spec.config),
        table_bits(&spec.config)?
    )?;
    let events = events();
    writeln!(out, "events: {}\n", events.join(" "))?;
    writeln!(out, "{}", bounds(spec))?;
    Ok(())
}

/// The names of all events, those of loading behind those of the stages.
fn events() -> Vec<&'static str> {
    let stages = Event::ALL.iter().map(|e| e.name());
    stages.chain(LoadEvent::ALL.iter().map(|e| e.name())).collect()
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
