//! `unit.toml`: reading with positions, writing with every path, presets and `--set`.

use std::fmt::Write as _;
use std::path::Path;

use toml::de::{DeTable, DeValue};

use super::UnitSpec;
use super::knobs::{Value, register};
use crate::error::InputError;

/// Largest unit file that is read.
const MAX_BYTES: u64 = 1 << 20;

/// The unit of `--unit` (a file, `-`, or `preset:NAME`) with the `--set` assignments applied.
pub fn load(unit: Option<&str>, sets: &[String]) -> Result<UnitSpec, InputError> {
    let mut spec = match unit {
        None => UnitSpec::default(),
        Some(name) => match name.strip_prefix("preset:") {
            Some(preset) => UnitSpec::preset(preset).ok_or_else(|| {
                InputError::new(
                    "--unit",
                    format!("a preset ({})", UnitSpec::PRESETS.join(", ")),
                    format!("`{preset}`"),
                    "name one of them or a TOML file",
                )
            })?,
            None => from_toml(name, &read_text(Path::new(name))?)?,
        },
    };
    for set in sets {
        let Some((path, value)) = set.split_once('=') else {
            return Err(InputError::new(
                "--set",
                "path=value",
                format!("`{set}`"),
                "write for instance --set footprint.max_probes=8",
            ));
        };
        spec.set(path.trim(), &parse_value(value.trim()))
            .map_err(|mut e| {
                e.subject = "--set".into();
                e
            })?;
    }
    Ok(spec)
}

fn read_text(path: &Path) -> Result<String, InputError> {
    use std::io::Read as _;
    let subject = path.display().to_string();
    let broken = |e: std::io::Error| {
        InputError::new(
            &subject,
            "a readable unit file in UTF-8",
            e.to_string(),
            "check the path, or use preset:default",
        )
    };
    let mut text = String::new();
    let size = if subject == "-" {
        std::io::stdin()
            .lock()
            .take(MAX_BYTES + 1)
            .read_to_string(&mut text)
    } else {
        std::fs::File::open(path)
            .map_err(broken)?
            .take(MAX_BYTES + 1)
            .read_to_string(&mut text)
    }
    .map_err(broken)?;
    if u64::try_from(size).unwrap_or(u64::MAX) > MAX_BYTES {
        return Err(InputError::new(
            &subject,
            "a unit file of at most 1 MiB",
            "a longer one",
            "check the path",
        ));
    }
    Ok(text)
}

/// A value as TOML has it, or else a bare literal.
fn parse_value(text: &str) -> Value {
    let document = format!("x = {text}");
    if let Ok(table) = DeTable::parse(&document)
        && let Some(value) = table.get_ref().get("x")
        && let Some(value) = convert(value.get_ref())
    {
        return value;
    }
    Value::Text(text.into())
}

fn convert(value: &DeValue<'_>) -> Option<Value> {
    Some(match value {
        DeValue::Integer(n) => {
            Value::Integer(i64::from_str_radix(&n.as_str().replace('_', ""), n.radix()).ok()?)
        }
        DeValue::Float(x) => Value::Float(x.as_str().replace('_', "").parse().ok()?),
        DeValue::String(t) => Value::Text(t.to_string()),
        DeValue::Array(items) => {
            let mut numbers = Vec::new();
            for item in items.iter() {
                match convert(item.get_ref())? {
                    Value::Integer(n) => numbers.push(i32::try_from(n).map(f64::from).ok()?),
                    Value::Float(x) => numbers.push(x),
                    Value::Numbers(row) => numbers.extend(row),
                    Value::Text(_) => return None,
                }
            }
            Value::Numbers(numbers)
        }
        DeValue::Boolean(_) | DeValue::Datetime(_) | DeValue::Table(_) => return None,
    })
}

/// Reads a unit file; what it leaves out keeps its default.
pub fn from_toml(subject: &str, text: &str) -> Result<UnitSpec, InputError> {
    let mut spec = UnitSpec::default();
    let table = DeTable::parse(text).map_err(|e| {
        InputError::new(
            subject,
            "TOML",
            e.message(),
            "`tapline unit show` prints a unit file",
        )
        .at(place(text, e.span().map_or(0, |s| s.start)))
    })?;
    let mut set = Vec::new();
    apply(&mut spec, subject, text, "", table.get_ref(), &mut set)?;
    // A register's width follows from two keys, whatever their order: it is checked at the end.
    for (path, here) in set {
        if let Some(reg) = register(&path) {
            spec.check_width(reg, &path)
                .map_err(|e| placed(e, subject, &here, &path))?;
        }
    }
    Ok(spec)
}

/// The error with the file's name and the place in it.
fn placed(mut error: InputError, subject: &str, here: &str, path: &str) -> InputError {
    error.subject = subject.into();
    error.place = Some(format!("{here}, {path}"));
    error
}

/// Sets what a table holds; `set` collects the paths with their places.
fn apply(
    spec: &mut UnitSpec,
    subject: &str,
    text: &str,
    prefix: &str,
    table: &DeTable<'_>,
    set: &mut Vec<(String, String)>,
) -> Result<(), InputError> {
    for (key, value) in table {
        let path = if prefix.is_empty() {
            key.get_ref().to_string()
        } else {
            format!("{prefix}.{}", key.get_ref())
        };
        let here = place(text, value.span().start);
        if let DeValue::Table(inner) = value.get_ref() {
            apply(spec, subject, text, &path, inner, set)?;
            continue;
        }
        let Some(value) = convert(value.get_ref()) else {
            return Err(InputError::new(
                subject,
                "a number, a literal or an array of numbers",
                "another type",
                "see `tapline unit show`",
            )
            .at(format!("{here}, {path}")));
        };
        spec.set_alone(&path, &value)
            .map_err(|e| placed(e, subject, &here, &path))?;
        set.push((path, here));
    }
    Ok(())
}

/// "line L, column C" of a byte offset.
fn place(text: &str, offset: usize) -> String {
    let before = text.get(..offset.min(text.len())).unwrap_or("");
    let line = before.matches('\n').count() + 1;
    let column = before.rsplit('\n').next().map_or(0, |l| l.chars().count()) + 1;
    format!("line {line}, column {column}")
}

/// Every path with its value as TOML, tables in the order of the knobs.
#[must_use]
pub fn to_toml(spec: &UnitSpec) -> String {
    let mut out = String::new();
    let mut section = String::new();
    for knob in spec.knobs() {
        let Some((table, key)) = knob.path.rsplit_once('.') else {
            continue;
        };
        if table != section {
            let gap = if section.is_empty() { "" } else { "\n" };
            // Writing to a String cannot fail.
            let _ = writeln!(out, "{gap}[{table}]");
            section = table.into();
        }
        let _ = writeln!(out, "{key} = {}", knob.value);
    }
    out
}
