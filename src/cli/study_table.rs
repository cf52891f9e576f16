//! `study table`: rows of a result file for a terminal or a document.

use std::path::Path;

use serde_json::Value;

use super::study::plain;
use crate::error::InputError;
use crate::report::table::{Align, significant};
use crate::study::front::{error_figure, figure, front};
use crate::study::measures::{is_column, names};
use crate::study::store::Results;

/// Figures that are shown if none are named.
const USUAL: [&str; 5] =
    ["psnr_db", "max_lsb8", "share_over_1_lsb8", "gates", "cycles_per_fragment"];

/// The rows as text.
pub(super) fn table(
    path: &Path,
    columns: &[String],
    scene: Option<&str>,
    only_front: bool,
    markdown: bool,
) -> Result<String, InputError> {
    let results = Results::read(path, true)?;
    if let Some(wrong) = columns.iter().find(|c| !is_column(c)) {
        let expected = format!("figures out of {}", names().join(", "));
        return Err(InputError::new(
            "--columns",
            expected,
            format!("`{wrong}`"),
            "check the spelling",
        ));
    }
    let columns: Vec<String> =
        if columns.is_empty() { USUAL.map(String::from).to_vec() } else { columns.to_vec() };
    let on_front = front(&results.rows, &error_figure(&results));
    let shown: Vec<&Value> = results
        .rows
        .iter()
        .zip(on_front)
        .filter(|(row, on)| {
            (*on || !only_front) && scene.is_none_or(|s| row.get("scene") == Some(&s.into()))
        })
        .map(|(row, _)| row)
        .collect();
    let axes = results.axes();
    let mut head = vec![("row".to_string(), Align::Right), ("scene".into(), Align::Left)];
    head.extend(axes.iter().map(|a| (a.clone(), Align::Left)));
    head.extend(columns.iter().map(|c| (c.clone(), Align::Right)));
    let cells = |row: &Value| -> Vec<String> {
        let get = |v: Option<&Value>| match v {
            None | Some(Value::Null) => "–".to_string(),
            Some(Value::String(t)) => t.clone(),
            Some(other) => other.to_string(),
        };
        let mut cells = vec![get(row.get("row")), get(row.get("scene"))];
        cells.extend(axes.iter().map(|a| get(row.get("set").and_then(|s| s.get(a)))));
        cells.extend(columns.iter().map(|c| match figure(row, c) {
            None => "–".into(),
            Some(x) if x.is_infinite() => "equal".into(),
            Some(x) => significant(x, 4),
        }));
        cells
    };
    if markdown {
        let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        let mut out = line(head.iter().map(|(name, _)| name.clone()).collect());
        out += &line(
            head.iter()
                .map(|(_, a)| if *a == Align::Left { "---" } else { "---:" }.into())
                .collect(),
        );
        out.extend(shown.into_iter().map(|row| line(cells(row))));
        return Ok(out);
    }
    let mut table = plain(&head);
    for row in shown {
        table.row(cells(row));
    }
    Ok(table.to_string())
}
