//! The report of a study: one HTML file that asks no server for anything, made from JSON alone.
//!
//! `results` is a result file; `details` is what [`details`] found about chosen rows, and may be missing.

mod charts;
mod detail;
pub mod details;
mod footprint;
mod svg;
mod view;

use maud::{Markup, PreEscaped, html};
use serde_json::Value;

use crate::report::page::{self, facts, head, list, plain, section, words};
use crate::report::table::{Align, whole};
use crate::study::front::{error_figure, figure, figure_cell, front};
use crate::study::store::Results;
pub use charts::Chart;

/// Rows of the table at most: those of the frontier first.
const MOST_ROWS: usize = 400;

/// The page, and its figures as separate SVG files.
#[must_use]
pub fn page(results: &Results, details: Option<&Value>) -> (String, Vec<(String, String)>) {
    let header = &results.header;
    let title = words(&header["study"]);
    let error = error_figure(results);
    let on_front = front(&results.rows, &error);
    let charts = charts::all(results, &on_front, &error);
    let details: Vec<_> = details.map_or(&[][..], list).iter().map(detail::section).collect();
    // `<` must not end the script early.
    let data = Value::Array(results.rows.iter().map(slim).collect());
    let data = data.to_string().replace('<', "\\u003c");
    let body = html! {
        (introduction(header, results, &on_front))
        section #picked hidden {
            h2 { "Chosen row" } p #picked-set {} pre #picked-command {} table #picked-figures {}
        }
        @for here in charts.chunk_by(|a, b| a.place == b.place) {
            h2 { (here[0].place) }
            @for chart in here { (drawing(&chart.svg, &chart.caption)) }
        }
        @for (part, _) in &details { (part) }
        (rows(results, &on_front))
        (section("Figures", &columns(header)))
        script type="application/json" #rows { (PreEscaped(data)) }
    };
    let heading = format!("tapline study: {title}");
    let page = page::page(&heading, &title, &body, include_str!("page.js"));
    let files = charts.into_iter().map(|chart| (chart.file, chart.svg));
    (page, files.chain(details.into_iter().flat_map(|(_, files)| files)).collect())
}

/// A drawing and its caption.
fn drawing(svg: &str, caption: &str) -> Markup {
    html! { figure.drawing { (PreEscaped(svg)) figcaption { (caption) } } }
}

/// The details of a row that a click shows.
fn slim(row: &Value) -> Value {
    serde_json::json!({"row": row["row"], "scene": row["scene"], "set": row["set"], "metrics": row["metrics"],
        "refused": row["refused"], "command": row["command"]})
}

fn introduction(header: &Value, results: &Results, on_front: &[bool]) -> Markup {
    let count = on_front.iter().filter(|on| **on).count();
    let refused = results.rows.iter().filter(|r| r["refused"].is_string()).count();
    let axes = list(&header["axes"]);
    let fact = |name, key| (name, words(&header[key]));
    html! {
        p {
            "Each dot is a texture unit: the same scenes, rendered by a bit-accurate model of the unit, and compared with \
             the same algorithm in floating point. This study varies "
            @if axes.is_empty() { "nothing" }
            @for (i, axis) in axes.iter().enumerate() {
                @if i > 0 { ", " } code { (words(&axis[0])) }
            }
            ". It has " (results.rows.len()) " rows, " (count) " of them on a frontier: no other unit of the same picture \
             is at least as good in error, gates and cycles and better in one of them."
        }
        @if refused > 0 { p { (refused) " rows are units that the model refuses; their rows say why." } }
        p.screen { "Point at a dot to see its unit, click it to get the command that repeats it." }
        (facts(&[
            fact("version", "version"), fact("study", "plan"), fact("unit", "unit_hash"), fact("cost model", "cost"),
            fact("seed", "seed"), fact("points by", "mode"),
        ]))
    }
}

/// The changes of a row's unit, in words.
pub(super) fn setting(row: &Value) -> String {
    let set = row["set"].as_object().into_iter().flatten();
    let parts: Vec<String> =
        set.map(|(path, value)| format!("{path} = {}", words(value))).collect();
    if parts.is_empty() { "the unit itself".into() } else { parts.join(", ") }
}

/// The figures that the table of rows has, as far as rows have them.
const SHOWN: [&str; 11] = [
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
];

fn rows(results: &Results, on_front: &[bool]) -> Markup {
    let axes = results.axes();
    let has = |name: &&str| results.rows.iter().any(|row| figure(row, name).is_some());
    let figures: Vec<&str> = SHOWN.into_iter().filter(has).collect();
    let mut order: Vec<(&Value, bool)> =
        results.rows.iter().zip(on_front.iter().copied()).collect();
    order.sort_by_key(|(_, on)| !on);
    let body = html! {
        p {
            @if order.len() > MOST_ROWS {
                "The first " (MOST_ROWS) " of " (order.len()) ", those on a frontier in front and in bold; results.csv has all."
            } @else { "Those on a frontier come first, in bold." }
        }
        div.scroll { table.rows {
            thead { tr {
                (head("row", Align::Right)) (head("scene", Align::Left))
                @for axis in &axes { (head(axis, Align::Left)) }
                @for name in &figures { (head(name, Align::Right)) }
            } }
            tbody { @for (row, on) in order.into_iter().take(MOST_ROWS) {
                tr.front[on] data-row=(row["row"]) {
                    (whole(&row["row"])) (plain(&row["scene"]))
                    @for axis in &axes { (plain(&row["set"][axis])) }
                    @if let Some(why) = row["refused"].as_str() { td colspan=(figures.len()) { "refused: " (why) } }
                    @else { @for name in &figures { (figure_cell(row, name)) } }
                }
                "\n"
            } }
        } }
    };
    section("Rows", &body)
}

fn columns(header: &Value) -> Markup {
    html! {
        dl.columns { @for column in list(&header["columns"]) {
            dt {
                code { (words(&column["name"])) }
                @if column["unit"] != "" { " (" (words(&column["unit"])) ")" }
            }
            dd { (words(&column["meaning"])) }
        } }
    }
}
