//! Tables of the page, and values of the run's JSON as text.

use serde_json::Value;

use crate::report::escape::escape;
use crate::report::table::{count, significant};

/// A column of a table: title with unit, and whether it holds numbers.
pub(super) type Column = (&'static str, bool);

/// A cell: what is shown and, for numbers, the value that sorting uses.
pub(super) struct Cell {
    pub(super) text: String,
    pub(super) value: Option<f64>,
}

/// A table, or nothing where there is no row.
pub(super) fn table(
    columns: &[Column],
    rows: impl Iterator<Item = Vec<Cell>>,
    sortable: bool,
) -> String {
    let mut body = String::new();
    for row in rows {
        body += "<tr>";
        for (cell, &(_, numeric)) in row.iter().zip(columns) {
            let class = if numeric { " class=\"n\"" } else { "" };
            let value = cell.value.map(|value| format!(" data-value=\"{value:e}\""));
            let value = value.unwrap_or_default();
            body += &format!("<td{class}{value}>{}</td>", escape(&cell.text));
        }
        body += "</tr>\n";
    }
    if body.is_empty() {
        return body;
    }
    let mut head = String::new();
    for (title, numeric) in columns {
        let class = if *numeric { " class=\"n\"" } else { "" };
        head += &format!("<th{class} scope=\"col\">{title}</th>");
    }
    let class = if sortable { " class=\"sortable\"" } else { "" };
    format!(
        "<div class=\"scroll\"><table{class}>\n<thead><tr>{head}</tr></thead>\n\
         <tbody>\n{body}</tbody>\n</table></div>\n"
    )
}

pub(super) fn plain(text: String) -> Cell {
    Cell { text, value: None }
}

/// A number of the object times a factor: to four digits, from 10 000 on to the unit in groups.
pub(super) fn number(value: &Value, factor: f64) -> Cell {
    let Some(figure) = value.as_f64() else {
        // No number: the words that stand there; sorts below every figure.
        let words = text(value);
        return Cell {
            text: if words.is_empty() { "–".to_owned() } else { words },
            value: Some(f64::MIN),
        };
    };
    let figure = figure * factor;
    let whole = (10_000.0..1e15).contains(&figure);
    let text = match value.as_u64() {
        Some(number) if figure < 10_000.0 && factor <= 1.0 => count(number),
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between 10^4 and 10^15"
        )]
        _ if whole => count(figure.round() as u64),
        _ => significant(figure, 4),
    };
    Cell { text, value: Some(figure) }
}

/// A value as text: strings without quotes, null as nothing, the rest as JSON.
pub(super) fn text(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Null => String::new(),
        Value::Bool(_) | Value::Number(_) | Value::Array(_) | Value::Object(_) => value.to_string(),
    }
}

pub(super) fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

pub(super) fn object(value: &Value) -> Vec<(&String, &Value)> {
    value.as_object().into_iter().flatten().collect()
}
