//! The rows of a study's results, and the header in front of them.

use serde_json::{Map, Value, json};

use super::measures::{Measures, columns};
use super::plan::{Place, Plan};
use super::points::Point;
use crate::engine::EngineKind;
use crate::error::InputError;
use crate::unit::knobs::Value as KnobValue;
use crate::unit::{ReferenceAxis, UnitSpec};

/// A value of a knob as JSON.
fn json_of(value: &KnobValue) -> Value {
    match value {
        KnobValue::Integer(n) => json!(n),
        KnobValue::Float(x) => json!(x),
        KnobValue::Text(t) => json!(t),
        KnobValue::Numbers(v) => json!(v),
    }
}

/// The first line of a result file: what study it is, and what its columns mean.
#[must_use]
pub fn header(plan: &Plan, points: usize, cost: &str) -> Value {
    let axes: Vec<Value> = plan.axes.iter().map(|a| json!(a.paths)).collect();
    let columns: Vec<Value> = columns()
        .filter(|c| plan.metrics.iter().any(|m| m == c.name))
        .filter(|c| {
            let kind = c.name.split('_').next().unwrap_or("");
            let other = |r: EngineKind| r.name() == kind && !plan.against.contains(&r);
            !EngineKind::ALL.into_iter().any(other)
        })
        .map(|c| json!({"name": c.name, "unit": c.unit, "meaning": c.meaning}))
        .collect();
    json!({
        "study": plan.title,
        "version": env!("CARGO_PKG_VERSION"),
        "plan": plan.hash,
        "unit_hash": plan.unit.hash(),
        "cost": cost,
        "seed": plan.seed,
        "mode": plan.mode.name(),
        "rows": points * plan.places.len(),
        "axes": axes,
        "error": plan.error,
        "columns": columns,
    })
}

/// The number of a row: places first, then points.
#[must_use]
pub fn number(plan: &Plan, points: usize, place: usize, point: usize) -> usize {
    debug_assert!(place < plan.places.len());
    place * points + point
}

/// The figures of a unit, or the reason of its refusal.
pub type Outcome = Result<Measures, InputError>;

/// A row.
#[must_use]
pub fn row(
    plan: &Plan,
    number: usize,
    place: &Place,
    point: &Point,
    spec: &UnitSpec,
    outcome: &Outcome,
) -> Value {
    let mut out = Map::new();
    out.insert("row".into(), json!(number));
    out.insert("point".into(), json!(point.number));
    out.insert("scene".into(), json!(place.scene));
    out.insert("size".into(), json!([place.size.0, place.size.1]));
    out.insert("env".into(), json!(place.env.as_ref().map(|p| p.display().to_string())));
    out.insert("face_size".into(), json!(place.face_size));
    if let Some([first, last]) = place.bounces {
        out.insert("bounces".into(), json!(format!("{first}-{last}")));
    }
    let set: Map<String, Value> =
        point.sets.iter().map(|(path, v)| (path.clone(), json_of(v))).collect();
    out.insert("set".into(), Value::Object(set));
    out.insert("unit_hash".into(), json!(spec.hash()));
    match outcome {
        Ok(measures) => {
            out.insert("metrics".into(), Value::Object(measures.to_json(&plan.metrics)));
        }
        Err(error) => {
            out.insert("refused".into(), json!(error.to_string()));
        }
    }
    out.insert("command".into(), json!(command(plan, place, point)));
    Value::Object(out)
}

/// The command that gives a row's figures of colour again.
#[must_use]
pub fn command(plan: &Plan, place: &Place, point: &Point) -> String {
    let engines: Vec<&str> =
        ["rtl"].into_iter().chain(plan.against.iter().map(|r| r.name())).collect();
    let mut words = vec![
        "tapline".into(),
        "compare".into(),
        place.scene.clone(),
        "--size".into(),
        format!("{}x{}", place.size.0, place.size.1),
        "--engines".into(),
        engines.join(","),
    ];
    let mut option = |name: &str, value: Option<String>| {
        if let Some(value) = value {
            words.extend([name.into(), value]);
        }
    };
    option("--env", place.env.as_ref().map(|p| p.display().to_string()));
    option("--face-size", place.face_size.map(|n| n.to_string()));
    option("--bounces", place.bounces.map(|[first, last]| format!("{first}-{last}")));
    let table = plan.reference_axis == ReferenceAxis::Table;
    option("--reference-axis", table.then(|| "table".into()));
    let truth = plan.against.contains(&EngineKind::Truth) && plan.samples != 256;
    option("--samples", truth.then(|| plan.samples.to_string()));
    let dark = plan.exposure.to_bits() != 0.0f64.to_bits();
    option("--exposure", dark.then(|| plan.exposure.to_string()));
    option("--unit", plan.unit_name.clone());
    for (path, value) in plan.sets.iter().chain(&point.sets) {
        let value = match value {
            KnobValue::Text(text) => text.clone(),
            KnobValue::Integer(_) | KnobValue::Float(_) | KnobValue::Numbers(_) => {
                value.to_string()
            }
        };
        option("--set", Some(format!("{path}={value}")));
    }
    words.iter().map(|w| quoted(w)).collect::<Vec<_>>().join(" ")
}

/// A word as a POSIX shell takes it.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "._-+/=:,@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.into()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

/// Rows as CSV: numbers of the row, where it was measured, the axes' values, the figures, the command.
#[must_use]
pub fn csv(header: &Value, rows: &[Value]) -> String {
    let names = |key: &str, inner: Option<&str>| -> Vec<String> {
        let items = header.get(key).and_then(Value::as_array).into_iter().flatten();
        items
            .flat_map(|item| match (inner, item.as_array()) {
                (Some(name), _) => vec![item.get(name).cloned().unwrap_or_default()],
                (None, Some(paths)) => paths.clone(),
                (None, None) => vec![item.clone()],
            })
            .map(|v| text(&v))
            .collect()
    };
    let (axes, columns) = (names("axes", None), names("columns", Some("name")));
    let mut fixed = vec!["row", "point", "scene", "width", "height", "env", "face_size"];
    // Only where a study names bounces.
    fixed.extend(rows.iter().any(|row| row.get("bounces").is_some()).then_some("bounces"));
    let head = fixed.iter().map(ToString::to_string).chain(axes.clone()).chain(columns.clone());
    let tail = ["refused", "unit_hash", "command"];
    let mut out = line(head.chain(tail.iter().map(ToString::to_string)));
    for row in rows {
        let get = |key: &str| row.get(key).map(text).unwrap_or_default();
        let inside = |group: &str, key: &str| {
            row.get(group).and_then(|g| g.get(key)).map(text).unwrap_or_default()
        };
        let size = |i: usize| row.get("size").and_then(|s| s.get(i)).map(text).unwrap_or_default();
        let cell = |name: &&str| match *name {
            "width" => size(0),
            "height" => size(1),
            name => get(name),
        };
        let cells = fixed
            .iter()
            .map(cell)
            .chain(axes.iter().map(|a| inside("set", a)))
            .chain(columns.iter().map(|c| inside("metrics", c)))
            .chain(tail.iter().map(|k| get(k)));
        out.push_str(&line(cells));
    }
    out
}

fn text(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        Value::Bool(_) | Value::Number(_) | Value::Array(_) | Value::Object(_) => value.to_string(),
    }
}

/// A line of CSV (RFC 4180).
fn line(cells: impl Iterator<Item = String>) -> String {
    let cell = |text: String| {
        if text.contains([',', '"', '\n', '\r']) {
            format!("\"{}\"", text.replace('"', "\"\""))
        } else {
            text
        }
    };
    cells.map(cell).collect::<Vec<_>>().join(",") + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_and_cells_come_back_as_they_went_in() {
        assert_eq!(quoted("eigen.entries=8"), "eigen.entries=8");
        assert_eq!(quoted("a b's"), r"'a b'\''s'");
        assert_eq!(quoted(""), "''");
        assert_eq!(
            line(["a,b".into(), "c\"d".into(), "e".into()].into_iter()),
            "\"a,b\",\"c\"\"d\",e\n"
        );
    }
}
