//! Trace lines: one JSON object a line, read strictly.

use serde::de::{MapAccess, Visitor};
use serde_json::Value;

use crate::error::InputError;
use crate::fragment::Fragment;

/// A line as it came: keys in order, numbers as they were written.
#[derive(Debug)]
pub(super) struct Line {
    /// Keys and values but `out`.
    pub(super) entries: Vec<(String, Value)>,
}

struct Entries(Vec<(String, Value)>);

impl<'de> serde::Deserialize<'de> for Entries {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Each;
        impl<'de> Visitor<'de> for Each {
            type Value = Entries;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a JSON object")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Entries, A::Error> {
                let mut out: Vec<(String, Value)> = Vec::new();
                while let Some((key, value)) = map.next_entry::<String, Value>()? {
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

/// Keys of an `env` line beside `id` and `out`.
const KEYS: [&str; 10] = [
    "op", "v", "n", "dv_dx", "dv_dy", "dn_dx", "dn_dy", "h", "bump", "rough",
];

/// Shortens what a user wrote so that it fits into a message.
fn short(text: &str) -> String {
    let mut out: String = text.chars().filter(|c| !c.is_control()).take(40).collect();
    if text.chars().count() > 40 {
        out.push('…');
    }
    out
}

/// Reads one line; `number` counts from 1.
pub(super) fn parse(
    subject: &str,
    number: usize,
    text: &str,
) -> Result<(Line, Fragment), InputError> {
    let here = |column: Option<usize>| match column {
        Some(column) => format!("line {number}, column {column}"),
        None => format!("line {number}"),
    };
    let remedy = "docs/trace-lines.md shows the format";
    let Entries(mut entries) = serde_json::from_str(text).map_err(|e| {
        // serde_json appends its own position, which we print with the line of the file.
        let message = e.to_string();
        let message = message.split(" at line ").next().unwrap_or("").to_string();
        InputError::new(subject, "one JSON object", message, remedy).at(here(Some(e.column())))
    })?;
    entries.retain(|(key, _)| key != "out");
    let find = |key: &str| entries.iter().find(|(k, _)| k == key).map(|(_, v)| v);
    let error = |key: &str, expected: &str, found: String| {
        InputError::new(subject, expected, found, remedy).at(format!("{}, `{key}`", here(None)))
    };
    let wrong = |key: &str, expected: &str, found: String| Err(error(key, expected, found));
    match find("op").and_then(Value::as_str) {
        Some("env") => {}
        Some(op @ ("hit" | "cone" | "tex")) => {
            return wrong(
                "op",
                "\"env\"",
                format!("\"{op}\", which this version does not build"),
            );
        }
        Some(op) => return wrong("op", "\"env\"", format!("\"{}\"", short(op))),
        None => {
            return wrong(
                "op",
                "\"env\"",
                find("op").map_or("nothing".into(), |v| short(&v.to_string())),
            );
        }
    }
    if let Some((key, _)) = entries
        .iter()
        .find(|(k, _)| k != "id" && !KEYS.contains(&k.as_str()))
    {
        return wrong(
            &short(key),
            &format!("the keys {}, id", KEYS.join(", ")),
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
    for (key, there) in [
        ("bump", fragment.bump.is_some()),
        ("rough", fragment.rough.is_some()),
    ] {
        if there && fragment.h.is_none() {
            return wrong(key, "the main direction `h` beside it", "no `h`".into());
        }
    }
    Ok((Line { entries }, fragment))
}

/// An array of `N` numbers; "inf", "-inf" and "nan" are numbers too.
fn numbers<const N: usize>(value: &Value) -> Result<[f64; N], String> {
    let Value::Array(items) = value else {
        return Err(short(&value.to_string()));
    };
    let items: &[Value; N] = items
        .as_slice()
        .try_into()
        .map_err(|_| format!("an array of {}", items.len()))?;
    let mut out = [0.0; N];
    for (o, item) in out.iter_mut().zip(items) {
        *o = match item {
            // The literal's own text: beyond a double's range it becomes infinite.
            Value::Number(n) => n.to_string().parse().map_err(|_| short(&n.to_string()))?,
            Value::String(t) => match t.as_str() {
                "inf" => f64::INFINITY,
                "-inf" => f64::NEG_INFINITY,
                "nan" => f64::NAN,
                other => return Err(format!("\"{}\"", short(other))),
            },
            Value::Null | Value::Bool(_) | Value::Array(_) | Value::Object(_) => {
                return Err(short(&item.to_string()));
            }
        };
    }
    Ok(out)
}
