//! Writing vector files: one case a line, as hexadecimal numbers, as JSON, or as words for `$readmemh`.
//!
//! Every number fills whole hexadecimal digits: signed ones in two's complement with the sign repeated, binary64 words as
//! their 64 bits. `hex` separates numbers by spaces; `readmemh` joins the same digits by underscores to one word a case,
//! the first number in the top bits.

use std::fmt::Write as _;

use serde_json::{Map, Value, json};

use super::field::{Field, Meaning, Shape, digits};
use super::harness::Build;
use super::subject::Subject;

/// Version of the files' layout.
pub const VERSION: u32 = 1;

/// How a vector file is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Format {
    /// Hexadecimal numbers with spaces between.
    Hex,
    /// One JSON object a line.
    Jsonl,
    /// One word a line, for `$readmemh`.
    Readmemh,
}

impl Format {
    /// Every format.
    pub const ALL: [Self; 3] = [Self::Hex, Self::Jsonl, Self::Readmemh];

    const fn separator(self) -> char {
        match self {
            Self::Readmemh => '_',
            Self::Hex | Self::Jsonl => ' ',
        }
    }

    const fn comment(self) -> &'static str {
        match self {
            Self::Readmemh => "//",
            Self::Hex | Self::Jsonl => "#",
        }
    }
}

/// The header of a vector file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Header {
    /// What was run.
    pub subject: Subject,
    /// Hash of the unit.
    pub unit: String,
    /// Which parts of it, and its memories.
    pub build: Build,
    /// Level of the patterns.
    pub level: u32,
    /// Seed.
    pub seed: u64,
    /// Cases.
    pub count: u64,
}

impl Header {
    /// The keys and values, in order.
    fn pairs(&self) -> [(&'static str, String); 9] {
        [
            ("vectors", VERSION.to_string()),
            ("tapline", env!("CARGO_PKG_VERSION").into()),
            ("subject", self.subject.name().into()),
            ("unit", self.unit.clone()),
            ("parts", parts(self.build)),
            ("size", self.build.size.to_string()),
            ("level", self.level.to_string()),
            ("seed", self.seed.to_string()),
            ("count", self.count.to_string()),
        ]
    }

    /// The lines before the first case.
    #[must_use]
    pub fn text(&self, shape: &Shape, format: Format) -> String {
        if format == Format::Jsonl {
            let mut map = Map::new();
            for (key, value) in self.pairs() {
                let number = value.parse::<u64>().ok().filter(|_| key != "unit");
                map.insert(key.into(), number.map_or_else(|| json!(value), |n| json!(n)));
            }
            let fields = |fields: &[Field]| fields.iter().map(describe_json).collect::<Vec<_>>();
            map.insert("inputs".into(), json!(fields(&shape.inputs)));
            map.insert("outputs".into(), json!(fields(&shape.outputs)));
            return format!("{}\n", Value::Object(map));
        }
        let comment = format.comment();
        let words: Vec<String> =
            self.pairs().iter().map(|(key, value)| format!("{key}={value}")).collect();
        let mut out = format!("{comment} {}\n", words.join(" "));
        for (title, fields) in [("in", &shape.inputs), ("out", &shape.outputs)] {
            for field in fields {
                let _ = writeln!(out, "{comment} {title:>3} {}", describe(field));
            }
        }
        out
    }

    /// What a header line contradicts: the key, what is wanted, what the line has. `None` where it
    /// agrees or is another comment.
    #[must_use]
    pub fn contradiction(&self, line: &str) -> Option<(&'static str, String, String)> {
        declared(line, "vectors")?;
        self.pairs()
            .into_iter()
            .filter(|(key, _)| ["vectors", "subject", "unit", "parts", "size"].contains(key))
            .find_map(|(key, want)| {
                let has = declared(line, key)?;
                (has != want).then_some((key, want, has))
            })
    }
}

/// What a header line says of a key, in any format.
#[must_use]
pub fn declared(line: &str, key: &str) -> Option<String> {
    let line = line.trim();
    if line.starts_with('{') {
        let value: Value = serde_json::from_str(line).ok()?;
        let value = value.get(key)?;
        return Some(value.as_str().map_or_else(|| value.to_string(), str::to_string));
    }
    let mut words = line.trim_start_matches(['#', '/', '*']).split_whitespace();
    words.find_map(|word| word.strip_prefix(key)?.strip_prefix('=').map(str::to_string))
}

/// Which parts a build has.
fn parts(build: Build) -> String {
    match (build.bump, build.rough) {
        (true, true) => "bump+rough",
        (true, false) => "bump",
        (false, true) => "rough",
        (false, false) => "plain",
    }
    .into()
}

/// One line about a field.
fn describe(field: &Field) -> String {
    let sign = if field.signed { "signed" } else { "unsigned" };
    let mut out = format!(
        "{}[{}] {sign} {} bits, {} digits",
        field.name,
        field.components,
        field.bits,
        field.digits()
    );
    if let Some(frac) = field.frac {
        let _ = write!(out, ", {frac} fraction bits");
    }
    let _ = write!(out, ": {}", field.text);
    let names = field.meaning.names();
    if !names.is_empty() {
        let _ = write!(out, " ({})", names.join(" "));
    }
    out
}

fn describe_json(field: &Field) -> Value {
    let mut out = json!({
        "name": field.name, "stage": field.stage.name(), "components": field.components,
        "signed": field.signed, "bits": field.bits, "text": field.text,
    });
    if let Some(frac) = field.frac {
        out["frac"] = json!(frac);
    }
    if let Meaning::Choice(names) | Meaning::Flags(names) = &field.meaning {
        out["names"] = json!(names);
    }
    out
}

/// The numbers of some fields with a separator between.
#[must_use]
pub fn tokens(fields: &[Field], numbers: &[i64], separator: char) -> String {
    let mut out = String::new();
    let mut rest = numbers.iter();
    for field in fields {
        for number in rest.by_ref().take(field.components) {
            if !out.is_empty() {
                out.push(separator);
            }
            digits(field, *number, &mut out);
        }
    }
    out
}

/// A case as a line, without its end.
#[must_use]
pub fn line(shape: &Shape, format: Format, input: &[i64], output: &[i64]) -> String {
    if format == Format::Jsonl {
        let value = json!({
            "in": object(&shape.inputs, input), "out": object(&shape.outputs, output),
        });
        return value.to_string();
    }
    let separator = format.separator();
    let mut out = tokens(&shape.inputs, input, separator);
    out.push(separator);
    out.push_str(&tokens(&shape.outputs, output, separator));
    out
}

/// A number as JSON has it: words of binary64 by their digits, for they are no integers of 53 bits.
fn number_json(field: &Field, number: i64) -> Value {
    if field.meaning == Meaning::Word {
        json!(format!("0x{:016x}", number.cast_unsigned()))
    } else {
        json!(number)
    }
}

fn object(fields: &[Field], numbers: &[i64]) -> Value {
    let mut map = Map::new();
    let mut rest = numbers.iter();
    for field in fields {
        let mut values: Vec<Value> =
            rest.by_ref().take(field.components).map(|n| number_json(field, *n)).collect();
        let value = if field.components == 1 {
            values.pop().unwrap_or(Value::Null)
        } else {
            Value::Array(values)
        };
        map.insert(field.name.clone(), value);
    }
    Value::Object(map)
}
