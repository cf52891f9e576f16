//! `diff A.json B.json`: two result files of `compare`, figure by figure.

use std::collections::BTreeSet;
use std::io::Write as _;
use std::path::Path;

use serde_json::{Map, Value, json};

use super::Failure;
use super::output::JsonTarget;
use crate::error::InputError;
use crate::report::table::{Table, digits, missing, significant, text, whole};

/// Largest result file: those of `compare` take some 30 kB.
const MAX_BYTES: u64 = 64 << 20;

/// What a table compares: the list's key, the keys that name an entry, its figures.
struct List {
    key: &'static str,
    names: &'static [&'static str],
    joint: &'static str,
    figures: &'static [&'static str],
}

const LISTS: &[List] = &[
    List {
        key: "pairs",
        names: &["a", "b"],
        joint: " - ",
        figures: &["psnr_db", "max_abs", "rmse", "rel_mse", "share_over_1_lsb8"],
    },
    List {
        key: "registers",
        names: &["stage", "register"],
        joint: ".",
        figures: &["worst_lsb", "mean_lsb"],
    },
];

/// What a run was asked for: differences here explain the others. `unit` is compared path by path.
const ASKED: &[&str] = &["version", "scene", "size", "env", "face_size"];

/// One figure in both files.
struct Row {
    table: &'static str,
    name: String,
    figure: String,
    values: [Value; 2],
}

/// Compares two result files; which of the two is better is not judged.
pub(super) fn run(a: &Path, b: &Path, target: JsonTarget) -> Result<(), Failure> {
    let files = [load(a)?, load(b)?];
    let rows = rows(&files);
    if !target.takes_stdout() {
        let mut out = std::io::stdout().lock();
        let differing = table(rows.iter().filter(|r| r.values[0] != r.values[1]));
        if differing.is_empty() {
            writeln!(out, "no difference in {} figures", rows.len())?;
        } else {
            let (some, all) = (differing.len(), rows.len());
            writeln!(out, "{differing}\n{some} of {all} figures differ")?;
        }
    }
    target.write(&json!({
        "version": env!("CARGO_PKG_VERSION"),
        "a": a.display().to_string(),
        "b": b.display().to_string(),
        "unit_hash": [files[0].get("unit_hash"), files[1].get("unit_hash")],
        "seed": [files[0].get("seed"), files[1].get("seed")],
        "figures": table(&rows).json(),
    }))
}

fn table<'a>(rows: impl IntoIterator<Item = &'a Row>) -> Table {
    let shown = |x: &Value| whole(shown(x)).with(x);
    Table::of(
        rows,
        &[
            ("table", "table", &|r| text(r.table)),
            ("entry", "entry", &|r| text(&r.name)),
            ("figure", "figure", &|r| text(&r.figure)),
            ("A", "a", &|r| shown(&r.values[0])),
            ("B", "b", &|r| shown(&r.values[1])),
            ("B - A", "", &|r| {
                let [x, y] = [0, 1].map(|i| r.values[i].as_f64());
                x.zip(y).map_or(missing(""), |(x, y)| digits(y - x, 4))
            }),
        ],
    )
}

fn load(path: &Path) -> Result<Map<String, Value>, InputError> {
    let name = path.display().to_string();
    let wrong = |found: String| {
        InputError::new(
            &name,
            "a result file of `compare --json`",
            found,
            "name two of them, or two pictures",
        )
    };
    let size = std::fs::metadata(path).map_err(|e| wrong(e.to_string()))?.len();
    if size > MAX_BYTES {
        return Err(wrong(format!("{size} bytes")));
    }
    let text = std::fs::read_to_string(path).map_err(|e| wrong(e.to_string()))?;
    let value: Value = serde_json::from_str(&text).map_err(|e| {
        let place = format!("line {}, column {}", e.line(), e.column());
        wrong("text that is not JSON".into()).at(place)
    })?;
    let Value::Object(map) = value else {
        return Err(wrong("JSON that is no object".into()));
    };
    for list in LISTS {
        let Some(entries) = map.get(list.key).and_then(Value::as_array) else {
            return Err(wrong(format!("no list `{}`", list.key)).at(list.key));
        };
        for (i, entry) in entries.iter().enumerate() {
            if entry_name(list, entry).is_none() {
                let place = format!("{}[{i}]", list.key);
                return Err(
                    wrong(format!("an entry without `{}`", list.names.join("`, `"))).at(place)
                );
            }
        }
    }
    Ok(map)
}

fn entry_name(list: &List, entry: &Value) -> Option<String> {
    let parts: Option<Vec<&str>> =
        list.names.iter().map(|key| entry.get(key).and_then(Value::as_str)).collect();
    Some(parts?.join(list.joint))
}

/// Every figure that one of the files has, in the order of the first, then of the second.
fn rows(files: &[Map<String, Value>; 2]) -> Vec<Row> {
    let mut out = Vec::new();
    let mut add = |table, name: &str, figure: &str, values: [Option<&Value>; 2]| {
        out.push(Row {
            table,
            name: name.into(),
            figure: figure.into(),
            values: values.map(|v| v.cloned().unwrap_or(Value::Null)),
        });
    };
    for key in ASKED {
        add("run", key, "", [files[0].get(*key), files[1].get(*key)]);
    }
    let units = [0, 1].map(|i| leaves(files[i].get("unit").unwrap_or(&Value::Null)));
    for path in union(units.each_ref().map(|u| u.iter().map(|(p, _)| p.clone()))) {
        let at = |i: usize| units[i].iter().find(|(p, _)| *p == path).map(|(_, v)| v);
        add("unit", &path, "", [at(0), at(1)]);
    }
    for list in LISTS {
        let entries = [0, 1].map(|i| {
            files[i].get(list.key).and_then(Value::as_array).map_or(&[][..], Vec::as_slice)
        });
        let named = entries.map(|e| e.iter().filter_map(|entry| entry_name(list, entry)));
        for name in union(named) {
            let find =
                |i: usize| entries[i].iter().find(|e| entry_name(list, e).as_ref() == Some(&name));
            for figure in list.figures {
                let at = |i: usize| find(i).and_then(|e| e.get(figure));
                add(list.key, &name, figure, [at(0), at(1)]);
            }
        }
    }
    let flags = [0, 1].map(|i| leaves_of(files[i].get("flags")));
    for name in union(flags.each_ref().map(|f| f.iter().map(|(p, _)| p.clone()))) {
        let at = |i: usize| flags[i].iter().find(|(p, _)| *p == name).map(|(_, v)| v);
        add("flags", &name, "", [at(0), at(1)]);
    }
    out
}

/// The names of the first, then those that only the second has.
fn union<I: Iterator<Item = String>>(names: [I; 2]) -> Vec<String> {
    let mut seen = BTreeSet::new();
    names.into_iter().flatten().filter(|n| seen.insert(n.clone())).collect()
}

fn leaves_of(value: Option<&Value>) -> Vec<(String, Value)> {
    match value.and_then(Value::as_object) {
        None => Vec::new(),
        Some(map) => map.iter().map(|(k, v)| (k.clone(), v.clone())).collect(),
    }
}

/// Every value below nested objects, under its dotted path.
fn leaves(value: &Value) -> Vec<(String, Value)> {
    let mut out = Vec::new();
    for (key, inner) in leaves_of(Some(value)) {
        if inner.is_object() {
            let below = leaves(&inner);
            out.extend(below.into_iter().map(|(p, v)| (format!("{key}.{p}"), v)));
        } else {
            out.push((key, inner));
        }
    }
    out
}

fn shown(value: &Value) -> String {
    match value {
        Value::Null => "-".into(),
        Value::String(text) => text.clone(),
        Value::Number(n) if n.is_f64() => {
            n.as_f64().map_or_else(|| n.to_string(), |x| significant(x, 5))
        }
        Value::Bool(_) | Value::Number(_) | Value::Array(_) | Value::Object(_) => value.to_string(),
    }
}
