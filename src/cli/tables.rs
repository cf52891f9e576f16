//! `tables show NAME`: ROM contents, for people and for RTL.

use std::io::Write as _;
use std::path::PathBuf;

use clap::{Subcommand, ValueEnum};
use rtl_model::stages::Roms;
use rtl_model::tables::angle::BOUNDARY_FRAC;
use serde_json::json;

use super::Failure;
use super::args::UnitArgs;
use super::output::JsonTarget;
use crate::engine::decimal::decimal;
use crate::error::InputError;
use crate::unit::refused;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// Print a table: recip, rsqrt, sqrt, log2, eigen or eigen-boundaries.
    Show {
        /// Which table.
        name: String,
        /// How.
        #[arg(long, value_enum, default_value_t = Format::Text)]
        format: Format,
        /// The table as JSON beside the other format; `-` is stdout, and nothing else goes there.
        #[arg(long, value_name = "FILE")]
        json: Option<PathBuf>,
        #[command(flatten)]
        unit: UnitArgs,
    },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Index, code and value.
    Text,
    /// One hexadecimal word a line, for $readmemh; comments name the table.
    Readmemh,
    /// One JSON object.
    Json,
}

/// A table as rows of words.
struct Rom {
    frac: u32,
    /// Words of a row and what they are.
    columns: &'static [&'static str],
    rows: Vec<Vec<i64>>,
}

const NAMES: [&str; 6] = ["recip", "rsqrt", "sqrt", "log2", "eigen", "eigen-boundaries"];

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let Action::Show { name, format, json, unit } = &args.action;
    let spec = unit.load()?;
    let roms = Roms::new(&spec.config).map_err(refused)?;
    let single = |rom: &rtl_model::tables::Rom| Rom {
        frac: rom.spec.frac,
        columns: &["value"],
        rows: rom.values.iter().map(|v| vec![*v]).collect(),
    };
    let double = |frac, pairs: &[[i64; 2]]| Rom {
        frac,
        columns: &["cos", "sin"],
        rows: pairs.iter().map(|pair| pair.to_vec()).collect(),
    };
    let rom = match name.as_str() {
        "recip" => single(&roms.recip),
        "rsqrt" => single(&roms.rsqrt),
        "sqrt" => single(&roms.sqrt),
        "log2" => single(&roms.log2),
        "eigen" => double(roms.angle.spec.frac, &roms.angle.angles),
        "eigen-boundaries" => double(BOUNDARY_FRAC, &roms.angle.boundaries),
        other => {
            return Err(InputError::new(
                "tables show",
                format!("one of {}", NAMES.join(", ")),
                format!("`{other}`"),
                "choose a table",
            )
            .into());
        }
    };
    let target = JsonTarget::open(json.as_deref())?;
    let version = env!("CARGO_PKG_VERSION");
    // One integer bit: every entry is at most 1, or 2 at the end of the square root's range.
    let width = rom.frac + 2;
    let value = json!({
        "version": version, "unit_hash": spec.hash(), "seed": 0, "table": name, "frac": rom.frac,
        "columns": rom.columns, "rows": rom.rows,
    });
    if target.takes_stdout() {
        return target.write(&value);
    }
    let mut out = std::io::stdout().lock();
    match format {
        Format::Text => {
            writeln!(
                out,
                "{name}: {} rows of {}, {} fraction bits; tapline {version}, unit {}",
                rom.rows.len(),
                rom.columns.join(" "),
                rom.frac,
                spec.hash()
            )?;
            for (i, row) in rom.rows.iter().enumerate() {
                let cells: Vec<String> =
                    row.iter().map(|v| format!("{v} {}", decimal(*v, rom.frac.into()))).collect();
                writeln!(out, "{i:>5}  {}", cells.join("   "))?;
            }
        }
        Format::Readmemh => {
            let digits = usize::try_from(width.div_ceil(4)).unwrap_or(8);
            writeln!(
                out,
                "// {name}: {} rows, words {} most significant first, {width} bits each, {} fraction bits",
                rom.rows.len(),
                rom.columns.join(" "),
                rom.frac
            )?;
            writeln!(
                out,
                "// tapline {version} tables show {name} --format readmemh, unit {}",
                spec.hash()
            )?;
            for row in &rom.rows {
                let words: Vec<String> = row.iter().map(|v| format!("{v:0digits$x}")).collect();
                writeln!(out, "{}", words.concat())?;
            }
        }
        Format::Json => {
            writeln!(out, "{value}")?;
        }
    }
    drop(out);
    target.write(&value)
}
