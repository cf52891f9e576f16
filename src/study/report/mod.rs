//! The report of a study: one HTML file that asks no server for anything, made from JSON alone.
//!
//! `results` is a result file; `details` is what [`details`] found about chosen rows, and may be missing.

mod charts;
pub mod details;
mod footprint;
mod section;
mod svg;
mod view;

use serde_json::Value;

use crate::report::escape::escape;
use crate::study::front::{error_figure, figure, front};
use crate::study::store::Results;
pub use charts::Chart;

/// Rows of the table at most: those of the frontier first.
const MOST_ROWS: usize = 400;

/// The page, and its figures as separate SVG files.
#[must_use]
pub fn page(results: &Results, details: Option<&Value>) -> (String, Vec<(String, String)>) {
    let header = &results.header;
    let title = text(&header["study"]);
    let error = error_figure(results);
    let on_front = front(&results.rows, &error);
    let charts = charts::all(results, &on_front, &error);
    let mut out =
        String::from("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n");
    out += "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n";
    out += &format!(
        "<title>tapline study: {}</title>\n<style>\n{}</style>\n</head>\n<body>\n",
        escape(&title),
        include_str!("page.css")
    );
    out += &format!("<h1>{}</h1>\n", escape(&title));
    out += &introduction(header, results, &on_front);
    out += "<section id=\"picked\" hidden><h2>Chosen row</h2><p id=\"picked-set\"></p><pre id=\"picked-command\"></pre><table id=\"picked-figures\"></table></section>\n";
    let mut files = Vec::new();
    let mut place = "";
    for chart in &charts {
        if chart.place != place {
            place = &chart.place;
            out += &format!("<h2>{}</h2>\n", escape(place));
        }
        out += &format!(
            "<figure>{}<figcaption>{}</figcaption></figure>\n",
            chart.svg,
            escape(&chart.caption)
        );
        files.push((chart.file.clone(), chart.svg.clone()));
    }
    if let Some(details) = details {
        for detail in details.as_array().into_iter().flatten() {
            let (section, figures) = section::section(detail);
            out += &section;
            files.extend(figures);
        }
    }
    out += &table(results, &on_front);
    out += &columns(header);
    let rows: Vec<Value> = results.rows.iter().map(slim).collect();
    // `<` must not end the script early.
    let data = Value::Array(rows).to_string().replace('<', "\\u003c");
    out += &format!("<script type=\"application/json\" id=\"rows\">{data}</script>\n");
    out += &format!("<script>\n{}</script>\n</body>\n</html>\n", include_str!("page.js"));
    (out, files)
}

/// What a click shows of a row.
fn slim(row: &Value) -> Value {
    serde_json::json!({"row": row["row"], "scene": row["scene"], "set": row["set"], "metrics": row["metrics"],
        "refused": row["refused"], "command": row["command"]})
}

fn text(value: &Value) -> String {
    value.as_str().map_or_else(
        || {
            if value.is_null() { String::new() } else { value.to_string() }
        },
        String::from,
    )
}

fn introduction(header: &Value, results: &Results, on_front: &[bool]) -> String {
    let rows = results.rows.len();
    let count = on_front.iter().filter(|on| **on).count();
    let refused = results.rows.iter().filter(|r| r["refused"].is_string()).count();
    let axes: Vec<String> =
        header["axes"].as_array().into_iter().flatten().map(|a| text(&a[0])).collect();
    let mut out = format!(
        "<p>Each dot is a texture unit: the same scenes, rendered by a bit-accurate model of the unit, and compared with \
        the same algorithm in floating point. This study varies {}. It has {rows} rows, {count} of them on a frontier: \
        no other unit of the same picture is at least as good in error, gates and cycles and better in one of them.</p>\n",
        if axes.is_empty() {
            "nothing".into()
        } else {
            axes.iter()
                .map(|a| format!("<code>{}</code>", escape(a)))
                .collect::<Vec<_>>()
                .join(", ")
        }
    );
    if refused > 0 {
        out += &format!(
            "<p>{refused} rows are units that the model refuses; their rows say why.</p>\n"
        );
    }
    out += "<p class=\"screen\">Point at a dot to see its unit, click it to get the command that repeats it.</p>\n<dl class=\"run\">";
    for (name, key) in [
        ("version", "version"),
        ("study", "plan"),
        ("unit", "unit_hash"),
        ("cost model", "cost"),
        ("seed", "seed"),
        ("points by", "mode"),
    ] {
        out += &format!("<div><dt>{name}</dt><dd>{}</dd></div>", escape(&text(&header[key])));
    }
    out + "</dl>\n"
}

/// What a unit of a row changes, in words.
pub(super) fn setting(row: &Value) -> String {
    let set = row["set"].as_object().into_iter().flatten();
    let parts: Vec<String> = set.map(|(path, value)| format!("{path} = {}", text(value))).collect();
    if parts.is_empty() { "the unit itself".into() } else { parts.join(", ") }
}

/// A figure as a table shows it.
pub(super) fn shown(row: &Value, name: &str) -> String {
    match figure(row, name) {
        None => "–".into(),
        Some(x) if x.is_infinite() => "equal".into(),
        Some(x) => crate::report::table::significant(x, 4),
    }
}

fn table(results: &Results, on_front: &[bool]) -> String {
    let axes = results.axes();
    let columns: Vec<&str> = [
        "truth_psnr_db",
        "psnr_db",
        "max_lsb8",
        "share_over_1_lsb8",
        "line_end_p95",
        "direction_p95_deg",
        "gates",
        "cycles_per_fragment",
        "texels_per_fragment",
        "tiles",
        "cache_hit_share",
    ]
    .into_iter()
    .filter(|c| results.rows.iter().any(|r| figure(r, c).is_some()))
    .collect();
    let mut order: Vec<usize> = (0..results.rows.len()).collect();
    order.sort_by_key(|i| !on_front[*i]);
    let mut out = format!(
        "<section><h2>Rows</h2>\n<p>{}</p>\n<div class=\"wide\"><table class=\"rows\">\n<thead><tr><th>row</th><th>scene</th>",
        if order.len() > MOST_ROWS {
            format!(
                "The first {MOST_ROWS} of {}, those on a frontier in front and in bold; results.csv has all.",
                order.len()
            )
        } else {
            "Those on a frontier come first, in bold.".into()
        }
    );
    for name in axes.iter().map(String::as_str).chain(columns.iter().copied()) {
        out += &format!("<th>{}</th>", escape(name));
    }
    out += "</tr></thead>\n<tbody>\n";
    for index in order.into_iter().take(MOST_ROWS) {
        let row = &results.rows[index];
        let class = if on_front[index] { " class=\"front\"" } else { "" };
        out += &format!(
            "<tr{class} data-row=\"{}\"><td>{}</td><td>{}</td>",
            text(&row["row"]),
            text(&row["row"]),
            escape(&text(&row["scene"]))
        );
        for axis in &axes {
            out += &format!("<td>{}</td>", escape(&text(&row["set"][axis])));
        }
        if row["refused"].is_string() {
            out += &format!(
                "<td colspan=\"{}\">refused: {}</td>",
                columns.len(),
                escape(&text(&row["refused"]))
            );
        } else {
            for column in &columns {
                out += &format!("<td class=\"n\">{}</td>", shown(row, column));
            }
        }
        out += "</tr>\n";
    }
    out + "</tbody></table></div></section>\n"
}

fn columns(header: &Value) -> String {
    let mut out = String::from("<section><h2>Figures</h2>\n<dl class=\"columns\">\n");
    for column in header["columns"].as_array().into_iter().flatten() {
        let unit = text(&column["unit"]);
        let unit = if unit.is_empty() { unit } else { format!(" ({unit})") };
        out += &format!(
            "<dt><code>{}</code>{}</dt><dd>{}</dd>\n",
            escape(&text(&column["name"])),
            escape(&unit),
            escape(&text(&column["meaning"]))
        );
    }
    out + "</dl></section>\n"
}
