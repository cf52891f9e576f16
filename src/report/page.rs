//! The common parts of the pages of a run and of a study: one file that loads nothing from a server.
//!
//! `maud` escapes every text that comes from outside.

use maud::{DOCTYPE, Markup, PreEscaped, Render, html};
use serde_json::Value;

use super::escape::base64;
use super::table::{Align, Cell, Table, count, missing, significant, text, whole};

/// A whole page; `script` runs at its end.
#[must_use]
pub fn page(title: &str, heading: &str, body: &Markup, script: &str) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(include_str!("page.css"))) }
            }
            body { h1 { (heading) } (body) script { (PreEscaped(script)) } }
        }
        "\n"
    };
    page.into_string()
}

/// A part with a title; nothing where it has nothing to show.
#[must_use]
pub fn section(title: &str, body: &Markup) -> Markup {
    html! { @if !body.0.is_empty() { section { h2 { (title) } (body) } } }
}

/// The data needed to repeat a run; empty entries are left out.
#[must_use]
pub fn facts(facts: &[(&str, String)]) -> Markup {
    html! {
        dl.run {
            @for (name, value) in facts.iter().filter(|(_, value)| !value.is_empty()) {
                div { dt { (name) } dd { (value) } }
            }
        }
    }
}

/// A picture with its name; one that the viewer shows is marked.
#[must_use]
pub fn picture(name: &str, base64: &str, size: Option<(u32, u32)>, view: bool) -> Markup {
    let (width, height) = size.unzip();
    html! {
        figure data-view[view] {
            img alt=(name) width=[width] height=[height] src={ "data:image/png;base64," (base64) };
            figcaption { (name) }
        }
    }
}

/// A PNG file with its name. Its header says the size, so that the page does not jump while it loads.
#[must_use]
pub fn png(name: &str, png: &[u8], view: bool) -> Markup {
    let header = png.strip_prefix(b"\x89PNG\r\n\x1a\n").unwrap_or(&[]);
    let word = |at: usize| Some(u32::from_be_bytes(*header.get(at..)?.first_chunk()?));
    picture(name, &base64(png), word(8).zip(word(12)), view)
}

impl Table {
    /// The table of a page, or nothing where there is no row.
    #[must_use]
    pub fn html(&self, sortable: bool) -> Markup {
        html! {
            @if !self.is_empty() {
                div.scroll { table.sortable[sortable] {
                    thead { tr { @for (title, align, _) in self.shown() { (head(title, align)) } } }
                    tbody {
                        @for row in self.rows() { tr { @for (.., at) in self.shown() { (row[at]) } } "\n" }
                    }
                } }
            }
        }
    }
}

/// The head of a column.
#[must_use]
pub fn head(title: &str, align: Align) -> Markup {
    html! { th.n[align == Align::Right] scope="col" { (title) } }
}

impl Render for Cell {
    fn render(&self) -> Markup {
        let number = self.value.as_ref().and_then(Value::as_f64).map(|value| format!("{value:e}"));
        html! { td.n[self.align == Align::Right] data-value=[number] { (self.shown) } }
    }
}

/// A number of JSON times a factor: to four digits, from 10 000 on to the unit in groups.
#[must_use]
pub fn figure(value: &Value, factor: f64) -> Cell {
    let Some(figure) = value.as_f64() else {
        // No number: the words that stand there; sorts below every figure.
        let words = words(value);
        return if words.is_empty() { missing("–") } else { whole(words) }.with(f64::MIN);
    };
    let figure = figure * factor;
    let large = (10_000.0..1e15).contains(&figure);
    let shown = match value.as_u64() {
        Some(number) if figure < 10_000.0 && factor <= 1.0 => count(number),
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between 10^4 and 10^15"
        )]
        _ if large => count(figure.round() as u64),
        _ => significant(figure, 4),
    };
    whole(shown).with(figure)
}

/// A value of JSON as text: strings without quotes, null as nothing, the rest as JSON.
#[must_use]
pub fn words(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Null => String::new(),
        Value::Bool(_) | Value::Number(_) | Value::Array(_) | Value::Object(_) => value.to_string(),
    }
}

/// A value of JSON as a cell with its words.
#[must_use]
pub fn plain(value: &Value) -> Cell {
    text(words(value))
}

/// The items of an array; none if it is not an array.
#[must_use]
pub fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}
