//! Trace lines: one JSON object a line, read strictly.

use serde::de::{MapAccess, Visitor};
use serde_json::error::Category;
use serde_json::value::RawValue;
use serde_json::{Map, Value};

use crate::error::InputError;

/// A line as it came: keys in order, values letter by letter.
#[derive(Debug)]
pub(super) struct Line<'a> {
    /// The file.
    subject: &'a str,
    /// From 1.
    number: usize,
    /// Keys and values but `out`.
    entries: Vec<(String, Box<RawValue>)>,
}

const REMEDY: &str = "docs/trace-lines.md shows the format";

impl<'a> Line<'a> {
    /// Reads one line; `number` counts from 1.
    pub(super) fn parse(subject: &'a str, number: usize, text: &str) -> Result<Self, InputError> {
        let wrong = |found: String, remedy: &str, column: usize| {
            InputError::new(subject, "one JSON object", found, remedy)
                .at(format!("line {number}, column {column}"))
        };
        if text.starts_with('\u{feff}') {
            return Err(wrong("a byte-order mark".into(), "save the file without it", 1));
        }
        let mut entries = entries(text).map_err(|e| {
            // serde_json appends its own position, which we print with the line of the file.
            let message = e.to_string();
            let message = message.split(" at line ").next().unwrap_or("");
            let message = message.trim_end_matches(", expected a JSON object");
            let found = match e.classify() {
                Category::Syntax => format!("text that is not JSON ({message})"),
                Category::Eof => format!("an unfinished line ({message})"),
                Category::Data | Category::Io => short(message),
            };
            wrong(found, REMEDY, e.column().max(1))
        })?;
        entries.retain(|(key, _)| key != "out");
        Ok(Self { subject, number, entries })
    }

    /// What is wrong at a key.
    pub(super) fn error(&self, key: &str, expected: &str, found: String) -> InputError {
        InputError::new(self.subject, expected, found, REMEDY)
            .at(format!("line {}, `{key}`", self.number))
    }

    /// The value of a key.
    pub(super) fn find(&self, key: &str) -> Option<&RawValue> {
        let entry = self.entries.iter().find(|(k, _)| k == key);
        entry.map(|(_, value)| &**value)
    }

    /// The value of a key that must be there.
    pub(super) fn need(&self, key: &str, expected: &str) -> Result<&RawValue, InputError> {
        self.find(key).ok_or_else(|| self.error(key, expected, "nothing".into()))
    }

    /// Refuses keys other than these and `id`.
    pub(super) fn only(&self, keys: &[&str]) -> Result<(), InputError> {
        let strange = |k: &str| k != "id" && !keys.contains(&k);
        match self.entries.iter().find(|(k, _)| strange(k)) {
            None => Ok(()),
            Some((key, _)) => Err(self.error(
                &short(key),
                &format!("the keys {}, id", keys.join(", ")),
                "an unknown key".into(),
            )),
        }
    }

    /// The array of `N` numbers at a key; `more` says what they are.
    pub(super) fn array<const N: usize>(
        &self,
        key: &str,
        more: &str,
    ) -> Result<[f64; N], InputError> {
        let expected = format!("an array of {N} numbers{more}");
        let value = self.need(key, &expected)?;
        numbers(value).map_err(|found| self.error(key, &expected, found))
    }

    /// The array of `N` numbers at a key that may be absent.
    pub(super) fn optional<const N: usize>(
        &self,
        key: &str,
    ) -> Result<Option<[f64; N]>, InputError> {
        self.find(key).map(|_| self.array(key, "")).transpose()
    }

    /// The line with `out` as its last key.
    pub(super) fn with_out(&self, out: Map<String, Value>) -> String {
        let mut text = String::from("{");
        for (key, value) in &self.entries {
            // A string's `Display` as JSON escapes what must be escaped.
            text.push_str(&Value::from(key.as_str()).to_string());
            text.push(':');
            text.push_str(value.get());
            text.push(',');
        }
        text.push_str("\"out\":");
        text.push_str(&Value::Object(out).to_string());
        text.push('}');
        text
    }
}

struct Entries(Vec<(String, Box<RawValue>)>);

impl<'de> serde::Deserialize<'de> for Entries {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Each;
        impl<'de> Visitor<'de> for Each {
            type Value = Entries;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a JSON object")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Entries, A::Error> {
                let mut out: Vec<(String, Box<RawValue>)> = Vec::new();
                while let Some((key, value)) = map.next_entry::<String, Box<RawValue>>()? {
                    if out.iter().any(|(k, _)| *k == key) {
                        return Err(serde::de::Error::custom(format!("the key `{key}` twice")));
                    }
                    out.push((key, value));
                }
                Ok(Entries(out))
            }
        }
        deserializer.deserialize_map(Each)
    }
}

/// Shortens what a user wrote so that it fits into a message.
pub(super) fn short(text: &str) -> String {
    let mut out: String = text.chars().filter(|c| !c.is_control()).take(40).collect();
    if text.chars().count() > 40 {
        out.push('…');
    }
    out
}

/// Keys and values of an object, each key once.
pub(super) fn entries(text: &str) -> Result<Vec<(String, Box<RawValue>)>, serde_json::Error> {
    serde_json::from_str(text).map(|Entries(entries)| entries)
}

/// An array of `N` numbers; "inf", "-inf" and "nan" are numbers too.
fn numbers<const N: usize>(value: &RawValue) -> Result<[f64; N], String> {
    let items: Vec<&RawValue> =
        serde_json::from_str(value.get()).map_err(|_| short(value.get()))?;
    let items: &[&RawValue; N] =
        items.as_slice().try_into().map_err(|_| format!("an array of {}", items.len()))?;
    let mut out = [0.0; N];
    for (o, item) in out.iter_mut().zip(items) {
        *o = number(item.get())?;
    }
    Ok(out)
}

/// A number, or one of the strings "inf", "-inf" and "nan".
pub(super) fn number(text: &str) -> Result<f64, String> {
    if let Ok(word) = serde_json::from_str::<String>(text) {
        return match word.as_str() {
            "inf" => Ok(f64::INFINITY),
            "-inf" => Ok(f64::NEG_INFINITY),
            "nan" => Ok(f64::NAN),
            _ => Err(short(text)),
        };
    }
    if text.starts_with(|c: char| c == '-' || c.is_ascii_digit()) {
        // A JSON number is one of Rust's; beyond a double's range it becomes infinite or zero.
        return text.parse().map_err(|_| short(text));
    }
    Err(short(text))
}
