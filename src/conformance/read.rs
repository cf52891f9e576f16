//! Reading vector files: what `vectors gen` writes, and what a simulator prints in its place.
//!
//! Both text formats take comments of either kind (`#`, `//`, `/* */`), tabs, capitals and the
//! digits of a case without separators, as `%h` prints a packed structure. `hex` has a case a line;
//! `readmemh` a case a word, with addresses.

use serde_json::{Map, Value};

use super::field::{Field, Meaning, Shape};
use super::text::Format;

/// The format that a file's first line looks like; `None` where it is blank.
#[must_use]
pub fn format_of(line: &str) -> Option<Format> {
    let line = line.trim();
    let mut starts = line.chars();
    Some(match starts.next()? {
        '{' => Format::Jsonl,
        '/' | '@' => Format::Readmemh,
        '#' => Format::Hex,
        _ if line.contains(char::is_whitespace) => Format::Hex,
        _ => Format::Readmemh,
    })
}

/// Blanks out comments, those that go over several lines too; columns stay.
#[derive(Clone, Copy, Debug, Default)]
pub struct Comments {
    /// Whether the last line left a `/*` open.
    pub open: bool,
}

impl Comments {
    /// A line without its comments.
    pub fn strip(&mut self, line: &str) -> String {
        let mut out = String::with_capacity(line.len());
        let mut rest = line;
        while !rest.is_empty() {
            let (text, comment, next) = if self.open {
                let end = rest.find("*/").map(|at| at + 2);
                self.open = end.is_none();
                ("", &rest[..end.unwrap_or(rest.len())], end)
            } else {
                let starts = [rest.find('#'), rest.find("//"), rest.find("/*")];
                let at = starts.into_iter().flatten().min().unwrap_or(rest.len());
                self.open = rest[at..].starts_with("/*");
                let end = if self.open { at + 2 } else { rest.len() };
                (&rest[..at], &rest[at..end], Some(end))
            };
            out.push_str(text);
            out.extend(comment.chars().map(|_| ' '));
            rest = next.map_or("", |at| &rest[at..]);
        }
        out
    }
}

/// The words of a line between blanks, with their columns from 1.
pub fn words(line: &str) -> impl Iterator<Item = (usize, &str)> {
    pieces(line, |c| c.is_ascii_whitespace())
}

fn pieces(line: &str, between: impl Fn(char) -> bool) -> impl Iterator<Item = (usize, &str)> {
    let mut next = 1;
    let with_columns = line.split(between).map(move |word| {
        let column = next;
        next += word.len() + 1;
        (column, word)
    });
    with_columns.filter(|(_, word)| !word.is_empty())
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

/// The numbers of a case, inputs first; the first number with a digit `x` or `z`, if there is one.
pub fn parse(
    shape: &Shape,
    format: Format,
    line: &str,
    numbers: &mut Vec<i64>,
) -> Result<Option<String>, Malformed> {
    numbers.clear();
    if format == Format::Jsonl {
        return parse_json(shape, line, numbers).map(|()| None);
    }
    let joined: String;
    let mut tokens: Vec<(usize, &str)> =
        pieces(line, |c| c == '_' || c.is_ascii_whitespace()).collect();
    let widths = || shape.numbers().map(|(field, _)| field.digits());
    if !tokens.iter().map(|(_, token)| token.len()).eq(widths()) {
        joined = tokens.iter().map(|(_, token)| *token).collect();
        if joined.len() == widths().sum::<usize>() && joined.is_ascii() {
            let mut columns = tokens.iter().flat_map(|(at, token)| (*at..).take(token.len()));
            let mut rest = joined.as_str();
            let cut = widths().map(|width| {
                let (token, after) = rest.split_at(width);
                rest = after;
                (columns.nth(width - 1).map_or(1, |last| (last + 1).saturating_sub(width)), token)
            });
            tokens = cut.collect();
        }
    }
    let end = line.len() + 1;
    let mut tokens = tokens.into_iter();
    let mut unknown = None;
    let inputs = shape.input_len();
    for (k, (field, component)) in shape.numbers().enumerate() {
        let name = || format!("{}[{component}]", field.name);
        let Some((column, token)) = tokens.next() else {
            let expected = format!("{} of {} digits", name(), field.digits());
            return Err(Malformed::new(end, expected, "the end of the line"));
        };
        if token.len() == field.digits() && is_unknown(token) {
            unknown.get_or_insert_with(|| format!("{}: {token}", name()));
            numbers.push(0);
            continue;
        }
        let number = parse_digits(field, token).ok_or_else(|| {
            let expected = format!("{} hexadecimal digits of {}", field.digits(), name());
            Malformed::new(column, expected, shown(token))
        })?;
        // What a device yields may be anything: that is for the judge.
        if k < inputs {
            in_range(field, column, number)?;
        }
        numbers.push(number);
    }
    match tokens.next() {
        None => Ok(unknown),
        Some((column, more)) => Err(Malformed::new(column, "the end of the line", shown(more))),
    }
}

/// Whether a simulator did not know some bit of a number.
fn is_unknown(token: &str) -> bool {
    let unknown = |b: u8| matches!(b, b'x' | b'X' | b'z' | b'Z' | b'?');
    token.bytes().any(unknown) && token.bytes().all(|b| unknown(b) || b.is_ascii_hexdigit())
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
