//! `study table`: rows of a result file for a terminal or a document.

use std::path::Path;

use serde_json::Value;

use crate::error::InputError;
use crate::report::page::words;
use crate::report::table::{Cell, Table, text, whole};
use crate::study::front::{error_figure, figure_cell, front};
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
    let titles = ["row", "scene"].into_iter().map(String::from);
    let named = |value: &Value| match words(value) {
        none if none.is_empty() => text("–"),
        words => text(words),
    };
    let cells = |row: &Value| -> Vec<Cell> {
        let mut cells = vec![whole(&row["row"]), named(&row["scene"])];
        cells.extend(axes.iter().map(|axis| named(&row["set"][axis])));
        cells.extend(columns.iter().map(|name| figure_cell(row, name)));
        cells
    };
    let titles = titles.chain(axes.clone()).chain(columns.clone());
    let table = Table::new(titles, shown.into_iter().map(cells));
    Ok(if markdown { table.markdown() } else { table.to_string() })
}
