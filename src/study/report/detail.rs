//! The HTML of a chosen row and its drawings.

use maud::{Markup, html};
use serde_json::Value;

use super::footprint::draw;
use super::svg::{label, n, svg};
use super::{drawing, setting};
use crate::report::page::{list, picture, words};
use crate::report::table::{Table, digits, missing, text};

/// The HTML of a row's details, and its drawings.
pub(super) fn section(detail: &Value) -> (Markup, Vec<(String, String)>) {
    let row = words(&detail["row"]);
    let bars = bars(&detail["attribution"]);
    let views = list(&detail["footprints"]).iter().map(|view| (view, draw(view)));
    let views: Vec<(&Value, String)> = views.collect();
    let ladder = Table::of(
        list(&detail["ladder"]),
        &[
            ("pair", "", &|p| text(format!("{} – {}", words(&p["a"]), words(&p["b"])))),
            ("PSNR (dB)", "", &|p| number(&p["psnr_db"], 4, 1.0)),
            ("largest (8-bit steps)", "", &|p| number(&p["max_lsb8"], 4, 1.0)),
            ("beyond one step (%)", "", &|p| number(&p["share_over_1_lsb8"], 3, 100.0)),
        ],
    );
    let part = html! {
        section id={ "detail-" (row) } {
            h2 { "Row " (row) ": " (words(&detail["scene"])) ", " (setting(detail)) }
            pre { (words(&detail["command"])) }
            div.pictures.small {
                @for p in list(&detail["pictures"]) { (picture(&words(&p["name"]), &words(&p["png"]), None, false)) }
            }
            h3 { "Ladder" }
            (ladder.html(false))
            (drawing(&bars, "Where accuracy is lost: PSNR against f64 if the registers of one stage alone had up to eight more \
                bits, or a table alone were large. A stage without a bar is not what limits this unit."))
            @for (view, svg) in &views {
                (drawing(svg, &format!(
                    "The footprint of pixel {},{} over the texels of level {}: the ellipse whose axes are λ1 and λ2, the exact \
                     axis in green, the unit's in red.", view["pixel"][0], view["pixel"][1], view["level"])))
            }
        }
    };
    let mut files = vec![(format!("attribution-{row}.svg"), bars)];
    let file = |(view, svg): (&Value, String)| {
        (format!("footprint-{row}-{}.svg", words(&view["id"])), svg)
    };
    files.extend(views.into_iter().map(file));
    (part, files)
}

/// A figure of a pair; two pictures that do not differ have no PSNR.
fn number(value: &Value, places: usize, factor: f64) -> crate::report::table::Cell {
    value.as_f64().map_or(missing("equal"), |x| digits(factor * x, places))
}

/// Bars: the gain of each part if it alone were longer.
fn bars(parts: &Value) -> String {
    let db = |row: &Value| row["psnr_db"].as_f64();
    let base = parts.get(0).and_then(db).unwrap_or(0.0);
    let gain = |row: &Value| db(row).map_or(0.0, |reached| reached - base);
    let rows = list(parts).get(1..).unwrap_or(&[]);
    let most = rows.iter().fold(0.1f64, |most, row| most.max(gain(row).abs()));
    let body = html! {
        @for (i, row) in rows.iter().enumerate() {
            @let (y, gain) = (10.0 + 24.0 * i as f64, gain(row));
            @let length = 240.0 * gain.max(0.0) / most + 1.0;
            (label([118.0, y + 13.0], "e", &words(&row["part"])))
            rect.bar x="124" y=(y) width=(n(length)) height="16" {}
            // No minus in front of nothing.
            (label([132.0 + length, y + 13.0], "s", &format!(
                "{:+.2} dB, to {:.2}", if gain.abs() < 0.005 { 0.0 } else { gain }, base + gain)))
        }
    };
    svg(
        [560.0, 24.0 * rows.len() as f64 + 16.0],
        "what longer words of each stage would buy",
        &body,
    )
}
