//! The footprint view: an ellipse, its axes and its probes over the texels that they meet.

use maud::html;
use serde_json::Value;

use super::svg::{dot, label, line, n, svg};
use crate::report::page::list;

const SIDE: f64 = 360.0;

fn number(v: &Value) -> f64 {
    v.as_f64().unwrap_or(0.0)
}

fn pair(v: &Value) -> [f64; 2] {
    [number(&v[0]), number(&v[1])]
}

/// Draws a footprint as [`super::details`] describes it: everything in texels of the level that the view shows.
pub(super) fn draw(view: &Value) -> String {
    let texels = list(&view["texels"]);
    let first = pair(&view["first"]);
    let scale = SIDE / texels.len().max(1) as f64;
    let to = |p: [f64; 2]| [0, 1].map(|i| (p[i] - first[i]) * scale);
    // A hair wider, so that no gap shows.
    let texel = n(scale + 0.3);
    let centre = pair(&view["centre"]);
    let [length, minor] = [number(&view["length"]), number(&view["minor"])];
    let axis = pair(&view["exact_axis"]);
    let turn = n(libm::atan2(axis[1], axis[0]).to_degrees());
    let [x, y] = to(centre).map(n);
    let half = |key: &str| pair(&view[key]).map(|c| c * length / 2.0);
    let ends = |[dx, dy]: [f64; 2]| {
        [to([centre[0] - dx, centre[1] - dy]), to([centre[0] + dx, centre[1] + dy])]
    };
    let width = (number(&view["width"]) * scale / 2.0).max(2.0);
    let [mine, exact] = ["probes", "exact_probes"].map(|key| list(&view[key]));
    let lines = [
        format!("level {}", view["level"]),
        format!("{} probes, f64 {}", mine.len(), exact.len()),
        format!("line {length:.2} texels"),
        format!("minor axis {minor:.2}"),
        format!("angle off {:.2}°", number(&view["off_degrees"])),
    ];
    let clip = format!("c{}", view["id"].as_str().unwrap_or(""));
    let key = SIDE + 10.0;
    let body = html! {
        clipPath id=(clip) { rect width=(SIDE) height=(SIDE) {} }
        g clip-path={ "url(#" (clip) ")" } {
            @for (y, row) in texels.iter().enumerate() { @for (x, colour) in list(row).iter().enumerate() {
                rect x=(n(x as f64 * scale)) y=(n(y as f64 * scale)) width=(texel) height=(texel)
                    fill=(colour.as_str().unwrap_or("#888")) {}
            } }
            @for class in ["ell", "ell2"] {
                ellipse class=(class) rx=(n(length / 2.0 * scale)) ry=(n((minor / 2.0 * scale).max(0.5)))
                    transform={ "translate(" (x) " " (y) ") rotate(" (turn) ")" } {}
            }
            @for (name, class) in [("exact_axis", "exact"), ("table_axis", "table")] {
                @let [from, end] = ends(half(name));
                (line(from, end, class))
            }
            @for p in exact { (dot(to(pair(p)), width, "pe", "", "probe of f64, as wide as its level's texel")) }
            @for p in mine { (dot(to(pair(p)), 3.0, "pr", "", "probe of the unit")) }
        }
        @for (i, text) in lines.iter().enumerate() { (label([key, 20.0 + 18.0 * i as f64], "s", text)) }
        @for (y, class, name) in [(130.0, "exact", "exact axis"), (150.0, "table", "the unit's axis")] {
            (line([key, y], [key + 24.0, y], class)) (label([key + 30.0, y + 4.0], "s", name))
        }
        (dot([key + 12.0, 172.0], 3.0, "pr", "", "")) (label([key + 30.0, 176.0], "s", "the unit's probes"))
        (dot([key + 12.0, 192.0], 7.0, "pe", "", "")) (label([key + 30.0, 196.0], "s", "f64's, their width"))
    };
    svg([SIDE + 150.0, SIDE], "footprint over texels", &body)
}
