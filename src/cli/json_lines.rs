//! Trace lines: one JSON object a line, read strictly.

use serde::de::{MapAccess, Visitor};
use serde_json::error::Category;
use serde_json::value::RawValue;

use crate::error::InputError;
use crate::fragment::{Fragment, HitFragment, TexFragment};

/// A line as it came: keys in order, values letter by letter.
#[derive(Debug)]
pub(super) struct Line {
    /// Keys and values but `out`.
    entries: Vec<(String, Box<RawValue>)>,
}

impl Line {
    /// The value of a key.
    pub(super) fn find(&self, key: &str) -> Option<&RawValue> {
        let entry = self.entries.iter().find(|(k, _)| k == key);
        entry.map(|(_, value)| &**value)
    }

    /// Refuses keys other than these and `id`.
    pub(super) fn only(
        &self,
        subject: &str,
        number: usize,
        keys: &[&str],
    ) -> Result<(), InputError> {
        let strange = |k: &str| k != "id" && !keys.contains(&k);
        match self.entries.iter().find(|(k, _)| strange(k)) {
            None => Ok(()),
            Some((key, _)) => Err(error(
                subject,
                number,
                &short(key),
                &format!("the keys {}, id", keys.join(", ")),
                "an unknown key".into(),
            )),
        }
    }

    /// The line with `out` as its last key.
    pub(super) fn with_out(&self, out: &serde_json::Map<String, serde_json::Value>) -> String {
        let mut text = String::from("{");
        for (key, value) in &self.entries {
            // A string's `Display` as JSON escapes what must be escaped.
            text.push_str(&serde_json::Value::from(key.as_str()).to_string());
            text.push(':');
            text.push_str(value.get());
            text.push(',');
        }
        text.push_str("\"out\":");
        text.push_str(&serde_json::Value::Object(out.clone()).to_string());
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

/// What a line asks for.
#[derive(Clone, Copy, Debug)]
pub(super) enum Op {
    /// Filter the environment for a fragment.
    Env(Fragment),
    /// Find where a ray meets a distance map.
    Hit(HitFragment),
    /// A cone's footprint on a textured surface.
    Tex(TexFragment, [f64; 2]),
}

/// Keys of a `hit` line beside `id` and `out`.
const HIT_KEYS: [&str; 4] = ["op", "x", "r", "cone"];

/// Keys of an `env` line beside `id` and `out`.
const KEYS: [&str; 10] = ["op", "v", "n", "dv_dx", "dv_dy", "dn_dx", "dn_dy", "h", "bump", "rough"];

/// Shortens what a user wrote so that it fits into a message.
pub(super) fn short(text: &str) -> String {
    let mut out: String = text.chars().filter(|c| !c.is_control()).take(40).collect();
    if text.chars().count() > 40 {
        out.push('…');
    }
    out
}

const REMEDY: &str = "docs/trace-lines.md shows the format";

/// An error at a key of a line.
pub(super) fn error(
    subject: &str,
    number: usize,
    key: &str,
    expected: &str,
    found: String,
) -> InputError {
    InputError::new(subject, expected, found, REMEDY).at(format!("line {number}, `{key}`"))
}

/// Keys and values of an object, each key once.
pub(super) fn entries(text: &str) -> Result<Vec<(String, Box<RawValue>)>, serde_json::Error> {
    serde_json::from_str(text).map(|Entries(entries)| entries)
}

/// The line if it is an object with that `op`; what is wrong with others, [`parse`] says.
pub(super) fn with_op(text: &str, op: &str) -> Option<Line> {
    let mut entries = entries(text).ok()?;
    entries.retain(|(key, _)| key != "out");
    let line = Line { entries };
    let found = line.find("op").and_then(|v| serde_json::from_str::<String>(v.get()).ok());
    (found.as_deref() == Some(op)).then_some(line)
}

/// Reads one line; `number` counts from 1.
pub(super) fn parse(subject: &str, number: usize, text: &str) -> Result<(Line, Op), InputError> {
    let here = |column: Option<usize>| match column {
        Some(column) => format!("line {number}, column {column}"),
        None => format!("line {number}"),
    };
    let remedy = "docs/trace-lines.md shows the format";
    if text.starts_with('\u{feff}') {
        let found = "a byte-order mark";
        return Err(InputError::new(subject, "one JSON object", found, "save the file without it")
            .at(here(Some(1))));
    }
    let Entries(mut entries) = serde_json::from_str(text).map_err(|e| {
        // serde_json appends its own position, which we print with the line of the file.
        let message = e.to_string();
        let message = message.split(" at line ").next().unwrap_or("");
        let message = message.trim_end_matches(", expected a JSON object");
        let found = match e.classify() {
            Category::Syntax => format!("text that is not JSON ({message})"),
            Category::Eof => format!("an unfinished line ({message})"),
            Category::Data | Category::Io => short(message),
        };
        InputError::new(subject, "one JSON object", found, remedy).at(here(Some(e.column().max(1))))
    })?;
    entries.retain(|(key, _)| key != "out");
    let find = |key: &str| {
        let entry = entries.iter().find(|(k, _)| k == key);
        entry.map(|(_, value)| &**value)
    };
    let error = |key: &str, expected: &str, found: String| {
        InputError::new(subject, expected, found, remedy).at(format!("{}, `{key}`", here(None)))
    };
    let wrong = |key: &str, expected: &str, found: String| Err(error(key, expected, found));
    let op = find("op").and_then(|v| serde_json::from_str::<String>(v.get()).ok());
    match op.as_deref() {
        Some("env" | "hit") => {}
        Some(op) => {
            return wrong(
                "op",
                "\"env\", \"hit\", \"cone\" or \"tex\"",
                format!("\"{}\"", short(op)),
            );
        }
        None => {
            return wrong(
                "op",
                "\"env\", \"hit\", \"cone\" or \"tex\"",
                find("op").map_or("nothing".into(), |v| short(v.get())),
            );
        }
    }
    let keys: &[&str] = if op.as_deref() == Some("hit") { &HIT_KEYS } else { &KEYS };
    if let Some((key, _)) = entries.iter().find(|(k, _)| k != "id" && !keys.contains(&k.as_str())) {
        return wrong(
            &short(key),
            &format!("the keys {}, id", keys.join(", ")),
            "an unknown key".into(),
        );
    }
    let vector = |key: &str| -> Result<[f64; 3], InputError> {
        match find(key) {
            Some(value) => {
                numbers(value).map_err(|found| error(key, "an array of 3 numbers", found))
            }
            None => Err(error(key, "an array of 3 numbers", "nothing".into())),
        }
    };
    if op.as_deref() == Some("hit") {
        let ray = HitFragment {
            x: vector("x")?,
            r: vector("r")?,
            cone: find("cone")
                .map(|v| numbers(v).map_err(|found| error("cone", "an array of 2 numbers", found)))
                .transpose()?,
        };
        return Ok((Line { entries }, Op::Hit(ray)));
    }
    let fragment = Fragment {
        v: vector("v")?,
        n: vector("n")?,
        dv_dx: vector("dv_dx")?,
        dv_dy: vector("dv_dy")?,
        dn_dx: vector("dn_dx")?,
        dn_dy: vector("dn_dy")?,
        h: find("h").map(|_| vector("h")).transpose()?,
        bump: find("bump")
            .map(|v| numbers(v).map_err(|found| error("bump", "an array of 2 numbers", found)))
            .transpose()?,
        rough: find("rough").map(|_| vector("rough")).transpose()?,
    };
    for (key, there) in [("bump", fragment.bump.is_some()), ("rough", fragment.rough.is_some())] {
        if there && fragment.h.is_none() {
            return wrong(key, "the main direction `h` beside it", "no `h`".into());
        }
    }
    Ok((Line { entries }, Op::Env(fragment)))
}

/// An array of `N` numbers; "inf", "-inf" and "nan" are numbers too.
pub(super) fn numbers<const N: usize>(value: &RawValue) -> Result<[f64; N], String> {
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
