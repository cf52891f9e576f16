//! The HTML of a chosen row and its drawings.

use super::footprint::draw;
use super::svg::Svg;
use super::{setting, text};
use crate::report::escape::escape;
use crate::report::table::significant;
use serde_json::Value;

/// The HTML of a row's details, and its drawings.
pub(super) fn section(detail: &Value) -> (String, Vec<(String, String)>) {
    let row = text(&detail["row"]);
    let mut files = Vec::new();
    let mut out = format!(
        "<section id=\"detail-{row}\"><h2>Row {row}: {}, {}</h2>\n<pre>{}</pre>\n<div class=\"pictures\">\n",
        escape(&text(&detail["scene"])),
        escape(&setting(detail)),
        escape(&text(&detail["command"]))
    );
    for picture in detail["pictures"].as_array().into_iter().flatten() {
        let name = escape(&text(&picture["name"]));
        out += &format!(
            "<figure><img alt=\"{name}\" src=\"data:image/png;base64,{}\"><figcaption>{name}</figcaption></figure>\n",
            text(&picture["png"])
        );
    }
    out += "</div>\n<h3>Ladder</h3>\n<table class=\"rows\"><thead><tr><th>pair</th><th>PSNR (dB)</th><th>largest (8-bit steps)</th><th>beyond one step (%)</th></tr></thead><tbody>\n";
    for pair in detail["ladder"].as_array().into_iter().flatten() {
        let number = |key: &str| pair[key].as_f64().map_or("equal".into(), |x| significant(x, 4));
        let share =
            pair["share_over_1_lsb8"].as_f64().map_or(String::new(), |x| significant(100.0 * x, 3));
        out += &format!(
            "<tr><td>{} – {}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{share}</td></tr>\n",
            text(&pair["a"]),
            text(&pair["b"]),
            number("psnr_db"),
            number("max_lsb8")
        );
    }
    out += "</tbody></table>\n";
    let bars = bars(&detail["attribution"]);
    out += &format!(
        "<figure>{bars}<figcaption>Where accuracy is lost: PSNR against f64 if the registers of one stage alone had up to eight more bits, or a table alone were large. A stage without a bar is not what limits this unit.</figcaption></figure>\n"
    );
    files.push((format!("attribution-{row}.svg"), bars));
    for view in detail["footprints"].as_array().into_iter().flatten() {
        let svg = draw(view);
        let pixel = format!("{},{}", view["pixel"][0], view["pixel"][1]);
        out += &format!(
            "<figure>{svg}<figcaption>The footprint of pixel {pixel} over the texels of level {}: the ellipse whose axes are λ1 and λ2, the exact axis in green, the unit's in red.</figcaption></figure>\n",
            view["level"]
        );
        files.push((format!("footprint-{row}-{}.svg", text(&view["id"])), svg));
    }
    (out + "</section>\n", files)
}

/// Bars: what each part would buy if it alone were longer.
fn bars(parts: &Value) -> String {
    let mut gains: Vec<(String, f64, f64)> = Vec::new();
    let db = |row: &Value| row["psnr_db"].as_f64();
    let base = parts.get(0).and_then(db).unwrap_or(0.0);
    for row in parts.as_array().into_iter().flatten().skip(1) {
        let reached = db(row).unwrap_or(base);
        gains.push((text(&row["part"]), reached - base, reached));
    }
    let most = gains.iter().fold(0.1f64, |most, g| most.max(g.1.abs()));
    let mut svg = Svg::new(560.0, 24.0 * gains.len() as f64 + 16.0);
    for (i, (part, gain, reached)) in gains.iter().enumerate() {
        let y = 10.0 + 24.0 * i as f64;
        let length = 240.0 * gain.max(0.0) / most + 1.0;
        svg.text([118.0, y + 13.0], "e", part);
        let width = super::svg::n(length);
        svg.raw(&format!(
            "<rect class=\"bar\" x=\"124\" y=\"{y}\" width=\"{width}\" height=\"16\"/>"
        ));
        // No minus in front of nothing.
        let gain = if gain.abs() < 0.005 { 0.0 } else { *gain };
        let label = format!("{gain:+.2} dB, to {reached:.2}");
        svg.text([132.0 + length, y + 13.0], "s", &label);
    }
    svg.finish("what longer words of each stage would buy")
}
