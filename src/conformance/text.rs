//! Vector files: one case a line, as hexadecimal numbers, as JSON, or as words for `$readmemh`.
//!
//! Every number fills whole hexadecimal digits: signed ones in two's complement with the sign repeated, binary64 words as
//! their 64 bits. `hex` separates numbers by spaces; `readmemh` joins the same digits by underscores to one word a case,
//! the first number in the top bits.

use std::fmt::Write as _;

use serde_json::{Map, Value, json};

use super::field::{Field, Meaning, Shape};
use super::harness::Build;
use super::subject::Subject;

/// Version of the files' layout.
pub const VERSION: u32 = 1;

/// How a vector file is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
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

    /// What a header line contradicts: the key, what is wanted, what the line has. `None` where it agrees or is another
    /// comment.
    #[must_use]
    pub fn contradiction(
        &self,
        line: &str,
        format: Format,
    ) -> Option<(&'static str, String, String)> {
        let found = |key: &str| -> Option<String> {
            if format == Format::Jsonl {
                let value: Value = serde_json::from_str(line).ok()?;
                let value = value.get(key)?;
                return Some(value.as_str().map_or_else(|| value.to_string(), str::to_string));
            }
            let mut words = line.strip_prefix(format.comment())?.split_whitespace();
            words.find_map(|word| word.strip_prefix(key)?.strip_prefix('=').map(str::to_string))
        };
        found("vectors")?;
        self.pairs()
            .into_iter()
            .filter(|(key, _)| ["vectors", "subject", "unit", "parts", "size"].contains(key))
            .find_map(|(key, want)| {
                let has = found(key)?;
                (has != want).then_some((key, want, has))
            })
    }
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

/// Whether a line holds no case.
#[must_use]
pub fn is_comment(line: &str, format: Format) -> bool {
    match format {
        Format::Jsonl => line.starts_with("{\"vectors\""),
        Format::Hex | Format::Readmemh => line.is_empty() || line.starts_with(format.comment()),
    }
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

/// Appends a number's digits.
pub fn digits(field: &Field, number: i64, out: &mut String) {
    let bits = field.padded_bits();
    let word = number.cast_unsigned();
    let word = if bits < 64 { word & ((1 << bits) - 1) } else { word };
    let width = field.digits();
    let _ = write!(out, "{word:0width$x}");
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

/// Why a line is no case.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Malformed {
    /// Where, from 1.
    pub column: usize,
    /// What belongs there.
    pub expected: String,
    /// What is there.
    pub found: String,
}

impl Malformed {
    fn new(column: usize, expected: impl Into<String>, found: impl Into<String>) -> Self {
        Self { column, expected: expected.into(), found: found.into() }
    }
}

/// The numbers of a line, inputs first.
pub fn parse(
    shape: &Shape,
    format: Format,
    line: &str,
    numbers: &mut Vec<i64>,
) -> Result<(), Malformed> {
    numbers.clear();
    if format == Format::Jsonl {
        return parse_json(shape, line, numbers);
    }
    let separator = format.separator();
    let mut column = 1;
    let mut rest = line.split(separator).peekable();
    let inputs = shape.input_len();
    for (k, (field, component)) in shape.numbers().enumerate() {
        let name = || format!("{}[{component}]", field.name);
        let Some(token) = rest.next() else {
            let expected = format!("{} of {} digits", name(), field.digits());
            return Err(Malformed::new(column, expected, "the end of the line"));
        };
        let number = parse_digits(field, token).ok_or_else(|| {
            let expected = format!("{} hexadecimal digits of {}", field.digits(), name());
            Malformed::new(column, expected, shown(token))
        })?;
        // What a device yields may be anything: that is for the judge.
        if k < inputs {
            in_range(field, column, number)?;
        }
        numbers.push(number);
        column += token.len() + 1;
    }
    match rest.next() {
        None => Ok(()),
        Some(more) => Err(Malformed::new(column, "the end of the line", shown(more))),
    }
}

/// At most 40 characters of what was found.
fn shown(text: &str) -> String {
    let mut out: String = text.chars().take(40).collect();
    if out.len() < text.len() {
        out.push('…');
    }
    format!("`{out}`")
}

fn parse_digits(field: &Field, token: &str) -> Option<i64> {
    if token.len() != field.digits() || !token.bytes().all(|b| b.is_ascii_hexdigit()) {
        return None;
    }
    let word = u64::from_str_radix(token, 16).ok()?;
    let spare = 64 - u32::try_from(field.padded_bits()).ok()?;
    Some(if field.signed { (word << spare).cast_signed() >> spare } else { word.cast_signed() })
}

fn in_range(field: &Field, column: usize, number: i64) -> Result<(), Malformed> {
    let [low, high] = field.range;
    if (low..=high).contains(&number) {
        return Ok(());
    }
    let expected = format!("{} from {low} to {high}", field.name);
    Err(Malformed::new(column, expected, number.to_string()))
}

fn parse_json(shape: &Shape, line: &str, numbers: &mut Vec<i64>) -> Result<(), Malformed> {
    let value: Value = serde_json::from_str(line)
        .map_err(|e| Malformed::new(e.column().max(1), "one JSON object", e.to_string()))?;
    let none = Map::new();
    for (key, fields) in [("in", &shape.inputs), ("out", &shape.outputs)] {
        let object = value.get(key).and_then(Value::as_object);
        let Some(object) = object else {
            return Err(Malformed::new(1, format!("an object `{key}`"), "none"));
        };
        let known = |name: &String| fields.iter().any(|f| f.name == *name);
        if let Some(other) = object.keys().find(|name| !known(name)) {
            let expected = format!("fields of `{key}` that the header lists");
            return Err(Malformed::new(column_of(line, other), expected, shown(other)));
        }
        let object = if object.is_empty() { &none } else { object };
        for field in fields {
            let column = column_of(line, &field.name);
            let values = match object.get(&field.name) {
                Some(Value::Array(values)) => values.as_slice(),
                Some(value) => std::slice::from_ref(value),
                None => &[],
            };
            if values.len() != field.components {
                let expected = format!("{} numbers of {}", field.components, field.name);
                return Err(Malformed::new(column, expected, values.len().to_string()));
            }
            for value in values {
                let number = json_number(field, column, value)?;
                if key == "in" {
                    in_range(field, column, number)?;
                }
                numbers.push(number);
            }
        }
    }
    Ok(())
}

/// Where a key stands in a line, from 1.
fn column_of(line: &str, key: &str) -> usize {
    line.find(&format!("\"{key}\"")).map_or(1, |at| at + 1)
}

fn json_number(field: &Field, column: usize, value: &Value) -> Result<i64, Malformed> {
    let name = &field.name;
    if field.meaning == Meaning::Word {
        let word = value
            .as_str()
            .and_then(|s| s.strip_prefix("0x"))
            .filter(|s| s.len() == 16)
            .and_then(|s| u64::from_str_radix(s, 16).ok());
        return word.map(u64::cast_signed).ok_or_else(|| {
            let expected = format!("\"0x\" and 16 hexadecimal digits of {name}");
            Malformed::new(column, expected, shown(&value.to_string()))
        });
    }
    let Some(number) = value.as_i64() else {
        let expected = format!("an integer {name}");
        return Err(Malformed::new(column, expected, shown(&value.to_string())));
    };
    Ok(number)
}
