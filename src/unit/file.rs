//! `unit.toml`: reading with positions, writing with every path, presets and `--set`.

use std::fmt::Write as _;
use std::path::Path;

use toml::de::{DeTable, DeValue};

use super::UnitSpec;
use super::knobs::{Value, unknown};
use crate::base::num;
use crate::error::InputError;

/// Largest unit file that is read.
const MAX_BYTES: u64 = 1 << 20;

/// Where the values of a unit come from, for messages about the unit as a whole.
#[derive(Clone, Debug, Default)]
pub struct Origins {
    /// The unit before anything was set.
    base: UnitSpec,
    /// Every path that was set, in order, and where: "FILE, line L, column C" or "--set".
    set: Vec<(String, String)>,
}

impl Origins {
    /// Checks a unit. A refusal names the place of the setting without which the unit would pass; where
    /// no single one is to blame, the file.
    ///
    /// # Errors
    /// Those of `check`, located.
    pub fn check(
        &self,
        spec: &UnitSpec,
        check: impl Fn(&UnitSpec) -> Result<(), InputError>,
    ) -> Result<(), InputError> {
        let Err(mut error) = check(spec) else {
            return Ok(());
        };
        let refused = error.place.clone().unwrap_or_default();
        let passes = |same: &dyn Fn(&str) -> bool| {
            let unit = self.without(spec, same);
            unit.is_ok_and(|unit| check(&unit).is_ok())
        };
        let alone = self.set.iter().rfind(|(path, _)| passes(&|p| p == path));
        let culprit = alone.or_else(|| {
            let whole = |path: &str| passes(&|p| group(p) == group(path));
            self.set.iter().rfind(|(path, _)| whole(path))
        });
        if let Some((path, origin)) = culprit {
            error.subject = origin.clone();
            if group(path) != group(&refused) {
                error.found = format!("{} at {refused}", error.found);
            }
            error.place = Some(path.clone());
        } else if let Some((_, origin)) = self.set.last() {
            let source = origin.split(", line ").next().unwrap_or(origin);
            error.subject = format!("the unit of {source}");
        }
        Err(error)
    }

    /// The unit with some paths as they were before.
    fn without(
        &self,
        spec: &UnitSpec,
        paths: &dyn Fn(&str) -> bool,
    ) -> Result<UnitSpec, InputError> {
        let mut out = spec.clone();
        for knob in self.base.knobs() {
            if paths(&knob.path) {
                out.assign(&knob.path, &knob.value)?;
            }
        }
        Ok(out)
    }
}

/// The register or table that a path belongs to; another path is its own group.
fn group(path: &str) -> &str {
    let parts = if path.starts_with("registers.") {
        3
    } else if path.starts_with("tables.") {
        2
    } else {
        return path;
    };
    let end = path.match_indices('.').nth(parts - 1);
    end.map_or(path, |(at, _)| &path[..at])
}

/// The unit of `--unit` (a file, `-`, or `preset:NAME`) with the `--set` assignments applied.
pub fn load(unit: Option<&str>, sets: &[String]) -> Result<(UnitSpec, Origins), InputError> {
    let mut origins = Origins::default();
    let mut spec = match unit {
        None => UnitSpec::default(),
        Some(name) => match name.strip_prefix("preset:") {
            Some(preset) => {
                origins.base = UnitSpec::preset(preset).ok_or_else(|| {
                    InputError::new(
                        "--unit",
                        format!("a preset ({})", UnitSpec::PRESETS.join(", ")),
                        format!("`{preset}`"),
                        "name one of them or a TOML file",
                    )
                })?;
                origins.base.clone()
            }
            None => {
                let subject = self::name(Path::new(name));
                let text = read_text(Path::new(name), "unit file")?;
                let (spec, seen) = read(&subject, &text)?;
                origins.set = seen
                    .into_iter()
                    .map(|(path, offset)| (path, format!("{subject}, {}", place(&text, offset))))
                    .collect();
                spec
            }
        },
    };
    for set in sets {
        let path = assign(&mut spec, set)?;
        origins.set.push((path.into(), "--set".into()));
    }
    origins.check(&spec, UnitSpec::check_widths)?;
    Ok((spec, origins))
}

/// Applies `path=value` to a unit whose widths are checked afterwards; the path.
fn assign<'a>(spec: &mut UnitSpec, set: &'a str) -> Result<&'a str, InputError> {
    let (path, value) = set.split_once('=').ok_or_else(|| {
        InputError::new(
            "--set",
            "path=value",
            format!("`{set}`"),
            "write for instance --set footprint.max_probes=8",
        )
    })?;
    spec.assign(path.trim(), &parse_value(value.trim())).map_err(|mut error| {
        error.subject = "--set".into();
        error
    })?;
    Ok(path.trim())
}

/// A unit with `path=value` applied.
pub(super) fn set(mut spec: UnitSpec, set: &str) -> Result<UnitSpec, InputError> {
    assign(&mut spec, set)?;
    spec.check_widths()?;
    Ok(spec)
}

pub(crate) fn read_text(path: &Path, what: &str) -> Result<String, InputError> {
    use std::io::Read as _;
    let subject = name(path);
    let broken = |e: std::io::Error| {
        InputError::new(
            &subject,
            format!("a readable {what} in UTF-8"),
            e.to_string(),
            "check the path",
        )
    };
    let mut bytes = Vec::new();
    let size = if path.as_os_str() == "-" {
        std::io::stdin().lock().take(MAX_BYTES + 1).read_to_end(&mut bytes)
    } else {
        std::fs::File::open(path).map_err(broken)?.take(MAX_BYTES + 1).read_to_end(&mut bytes)
    }
    .map_err(broken)?;
    if num::u64(size) > MAX_BYTES {
        return Err(InputError::new(
            &subject,
            format!("a {what} of at most 1 MiB"),
            "a longer one",
            "check the path",
        ));
    }
    String::from_utf8(bytes).map_err(|e| {
        let good = e.utf8_error().valid_up_to();
        let before = e.as_bytes().get(..good).unwrap_or_default();
        InputError::new(
            &subject,
            "UTF-8",
            format!("the byte {:#04x}", e.as_bytes().get(good).unwrap_or(&0)),
            "save the file as UTF-8",
        )
        .at(place(&String::from_utf8_lossy(before), good))
    })
}

/// A unit file's name in messages.
pub(crate) fn name(path: &Path) -> String {
    if path.as_os_str() == "-" { "standard input".into() } else { path.display().to_string() }
}

/// A value as TOML has it, or else a bare literal.
fn parse_value(text: &str) -> Value {
    let document = format!("x = {text}");
    if !text.contains(['\n', '\r'])
        && let Ok(table) = DeTable::parse(&document)
        && let Some(value) = table.get_ref().get("x")
        && let Some(value) = convert(value.get_ref())
    {
        return value;
    }
    // TOML has no `.5` and no `5.`.
    match text.parse::<f64>() {
        Ok(x) if x.is_finite() => Value::Float(x),
        _ => Value::Text(text.into()),
    }
}

/// A value of a knob from TOML; nothing for a value that no knob has.
pub(crate) fn convert(value: &DeValue<'_>) -> Option<Value> {
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

/// Reads a unit file; a missing path keeps its default.
pub fn from_toml(subject: &str, text: &str) -> Result<UnitSpec, InputError> {
    read(subject, text).map(|(spec, _)| spec)
}

/// [`from_toml`], and the paths that were set with their byte offsets, in the order of the file.
fn read(subject: &str, text: &str) -> Result<(UnitSpec, Vec<(String, usize)>), InputError> {
    let mut spec = UnitSpec::default();
    let mut known: Vec<String> = spec.knobs().into_iter().map(|k| k.path).collect();
    known.push("tables.eigen.entries".into());
    let table = DeTable::parse(text).map_err(|e| {
        InputError::new(subject, "TOML", e.message(), "`tapline unit show` prints a unit file")
            .at(place(text, e.span().map_or(0, |s| s.start)))
    })?;
    let mut reader = Reader { spec: &mut spec, subject, text, known, seen: Vec::new() };
    reader.table("", table.get_ref())?;
    let mut seen = reader.seen;
    seen.sort_by_key(|(_, offset)| *offset);
    spec.check_widths().map_err(|mut e| {
        // The last line that sets a part of the register.
        let register = format!("{}.", e.place.unwrap_or_default());
        let last = seen.iter().rfind(|(p, _)| p.starts_with(&register));
        e.subject = subject.into();
        e.place = last.map(|(path, offset)| format!("{}, {path}", place(text, *offset)));
        e
    })?;
    Ok((spec, seen))
}

/// The result of reading a unit file.
struct Reader<'a> {
    spec: &'a mut UnitSpec,
    subject: &'a str,
    text: &'a str,
    /// Every legal path.
    known: Vec<String>,
    /// Paths that were set and where.
    seen: Vec<(String, usize)>,
}

impl Reader<'_> {
    fn fail<T>(&self, offset: usize, path: &str, mut error: InputError) -> Result<T, InputError> {
        error.subject = self.subject.into();
        error.place = Some(format!("{}, {path}", place(self.text, offset)));
        Err(error)
    }

    fn table(&mut self, prefix: &str, table: &DeTable<'_>) -> Result<(), InputError> {
        for (key, value) in table {
            let path = if prefix.is_empty() {
                key.get_ref().to_string()
            } else {
                format!("{prefix}.{}", key.get_ref())
            };
            let inside = format!("{path}.");
            if let DeValue::Table(inner) = value.get_ref() {
                // An unknown table is wrong even if it is empty; with keys in it, a key is named.
                if inner.is_empty() && !self.known.iter().any(|k| k.starts_with(&inside)) {
                    return self.fail(key.span().start, &path, unknown(&path));
                }
                self.table(&path, inner)?;
                continue;
            }
            if self.known.iter().any(|k| k.starts_with(&inside)) {
                let found = "a single value";
                let error = InputError::new("", "a table", found, "see `tapline unit show`");
                return self.fail(value.span().start, &path, error);
            }
            if !self.known.contains(&path) {
                // A path that is understood but never shown, such as a block's overflow, has its own words.
                let own = convert(value.get_ref())
                    .map(|v| self.spec.clone().assign(&path, &v))
                    .filter(|r| r.as_ref().err() != Some(&unknown(&path)));
                match own {
                    None => return self.fail(key.span().start, &path, unknown(&path)),
                    Some(Err(e)) => return self.fail(value.span().start, &path, e),
                    Some(Ok(())) => {}
                }
            }
            let Some(converted) = convert(value.get_ref()) else {
                let error = InputError::new(
                    "",
                    "a number, a literal or an array of numbers",
                    described(value.get_ref()),
                    "see `tapline unit show`",
                );
                return self.fail(value.span().start, &path, error);
            };
            if let Err(e) = self.spec.assign(&path, &converted) {
                return self.fail(value.span().start, &path, e);
            }
            self.seen.push((path, value.span().start));
        }
        let twice = ["eigen.entries", "tables.eigen.entries"]
            .iter()
            .all(|name| self.seen.iter().any(|(path, _)| path == name));
        if twice && let Some((_, offset)) = self.seen.last() {
            let error = InputError::new(
                "",
                "`eigen.entries` or its other name `tables.eigen.entries`",
                "both",
                "remove one",
            );
            return self.fail(*offset, "eigen.entries", error);
        }
        Ok(())
    }
}

/// What a value is, where it is nothing that a unit has.
pub(crate) fn described(value: &DeValue<'_>) -> String {
    match value {
        DeValue::Integer(n) => format!("{}, which is too large", n.as_str()),
        DeValue::Float(x) => x.as_str().into(),
        DeValue::Boolean(b) => b.to_string(),
        DeValue::String(_) => "a string".into(),
        DeValue::Datetime(_) => "a date".into(),
        DeValue::Array(_) => "an array of something else".into(),
        DeValue::Table(_) => "a table".into(),
    }
}

/// "line L, column C" of a byte offset.
pub(crate) fn place(text: &str, offset: usize) -> String {
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
