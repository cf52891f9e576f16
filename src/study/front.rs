//! The frontier: rows that no other row of the same place beats.

use serde_json::Value;

use super::store::Results;
use crate::report::table::{Cell, digits, missing};

/// A figure of a row; nothing where it has none. No difference at all counts as the best there is.
#[must_use]
pub fn figure(row: &Value, name: &str) -> Option<f64> {
    match row.get("metrics")?.get(name)? {
        Value::Number(n) => n.as_f64(),
        Value::Null if name.ends_with("psnr_db") => Some(f64::INFINITY),
        Value::Null | Value::Bool(_) | Value::String(_) | Value::Array(_) | Value::Object(_) => {
            None
        }
    }
}

/// A figure as a table shows it.
#[must_use]
pub fn figure_cell(row: &Value, name: &str) -> Cell {
    match figure(row, name) {
        None => missing("–"),
        Some(x) if x.is_infinite() => missing("equal"),
        Some(x) => digits(x, 4),
    }
}

/// The figure that a frontier is drawn over where a study names none: the first of these that rows have.
const USUAL: [&str; 3] = ["truth_psnr_db", "psnr_db", "ewa_psnr_db"];

/// The figure of error that a study's units are judged by.
#[must_use]
pub fn error_figure(results: &Results) -> String {
    if let Some(named) = results.header.get("error").and_then(Value::as_str) {
        return named.into();
    }
    let has = |name: &&&str| results.rows.iter().any(|row| figure(row, name).is_some());
    USUAL.iter().find(has).unwrap_or(&USUAL[1]).to_string()
}

/// Whether a larger value of a figure is the better one.
#[must_use]
pub fn larger_is_better(name: &str) -> bool {
    ["psnr_db", "converged_share", "cache_hit_share"].iter().any(|end| name.ends_with(end))
}

/// The criteria of a row: error, gates, cycles; smaller is better.
fn scores(row: &Value, error: &str) -> Option<[f64; 3]> {
    let sign = if larger_is_better(error) { -1.0 } else { 1.0 };
    let cost = |name| figure(row, name).unwrap_or(0.0);
    Some([sign * figure(row, error)?, cost("gates"), cost("cycles_per_fragment")])
}

fn place(row: &Value) -> String {
    ["scene", "size", "env", "face_size", "bounces"]
        .map(|k| row.get(k).map(ToString::to_string).unwrap_or_default())
        .join(" ")
}

/// Which rows are on the frontier of their place: none other is at least as good in error, gates and cycles and
/// better in one of them.
#[must_use]
pub fn front(rows: &[Value], error: &str) -> Vec<bool> {
    let judged: Vec<Option<(String, [f64; 3])>> =
        rows.iter().map(|row| Some((place(row), scores(row, error)?))).collect();
    let beaten = |(here, a): &(String, [f64; 3])| {
        judged.iter().flatten().filter(|(there, _)| there == here).any(|(_, b)| {
            let no_worse = b.iter().zip(a).all(|(b, a)| b <= a);
            no_worse && b.iter().zip(a).any(|(b, a)| b < a)
        })
    };
    judged.iter().map(|row| row.as_ref().is_some_and(|row| !beaten(row))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_row_is_on_the_front_unless_another_of_its_place_is_better() {
        let row = |scene: &str, db: Value, gates: u32| json!({"scene": scene, "metrics": {"psnr_db": db, "gates": gates, "cycles_per_fragment": 1}});
        let rows = [
            row("a", json!(50), 10),
            row("a", json!(40), 10),
            row("a", json!(40), 5),
            row("b", json!(30), 20),
            row("a", Value::Null, 99),
            json!({"scene": "a", "refused": "too wide"}),
        ];
        assert_eq!(front(&rows, "psnr_db"), [true, false, true, true, true, false]);
    }
}
