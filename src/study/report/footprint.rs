//! The footprint view: an ellipse, its axes and its probes over the texels that they meet.

use serde_json::Value;

use super::svg::Svg;

const SIDE: f64 = 360.0;

fn number(v: &Value) -> f64 {
    v.as_f64().unwrap_or(0.0)
}

fn pair(v: &Value) -> [f64; 2] {
    [number(&v[0]), number(&v[1])]
}

/// Draws a footprint as [`super::details`] describes it: everything in texels of the level that the view shows.
pub(super) fn draw(view: &Value) -> String {
    let texels: Vec<Vec<String>> = view["texels"]
        .as_array()
        .into_iter()
        .flatten()
        .map(|row| {
            row.as_array()
                .into_iter()
                .flatten()
                .map(|c| c.as_str().unwrap_or("#888").to_string())
                .collect()
        })
        .collect();
    let rows = texels.len().max(1) as f64;
    let first = pair(&view["first"]);
    let scale = SIDE / rows;
    let to = |p: [f64; 2]| [0, 1].map(|i| (p[i] - first[i]) * scale);
    let mut svg = Svg::new(SIDE + 150.0, SIDE);
    svg.raw(&format!("<clipPath id=\"c{}\"><rect width=\"{SIDE}\" height=\"{SIDE}\"/></clipPath><g clip-path=\"url(#c{})\">", view["id"], view["id"]));
    for (y, row) in texels.iter().enumerate() {
        for (x, colour) in row.iter().enumerate() {
            // A hair wider, so that no gap shows.
            svg.raw(&format!(
                "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"{colour}\"/>",
                super::svg::n(x as f64 * scale),
                super::svg::n(y as f64 * scale),
                super::svg::n(scale + 0.3),
                super::svg::n(scale + 0.3)
            ));
        }
    }
    let centre = pair(&view["centre"]);
    let [length, minor] = [number(&view["length"]), number(&view["minor"])];
    let axis = pair(&view["exact_axis"]);
    let at = to(centre);
    let turn = libm::atan2(axis[1], axis[0]).to_degrees();
    for class in ["ell", "ell2"] {
        svg.raw(&format!(
            "<ellipse class=\"{class}\" rx=\"{}\" ry=\"{}\" transform=\"translate({} {}) rotate({})\"/>",
            super::svg::n(length / 2.0 * scale), super::svg::n((minor / 2.0 * scale).max(0.5)),
            super::svg::n(at[0]), super::svg::n(at[1]), super::svg::n(turn)
        ));
    }
    for (key, class) in [("exact_axis", "exact"), ("table_axis", "table")] {
        let d = pair(&view[key]).map(|c| c * length / 2.0);
        svg.line(
            to([centre[0] - d[0], centre[1] - d[1]]),
            to([centre[0] + d[0], centre[1] + d[1]]),
            class,
        );
    }
    let width = number(&view["width"]) * scale / 2.0;
    for probe in view["exact_probes"].as_array().into_iter().flatten() {
        svg.dot(
            to(pair(probe)),
            width.max(2.0),
            "pe",
            "",
            "probe of f64, as wide as its level's texel",
        );
    }
    for probe in view["probes"].as_array().into_iter().flatten() {
        svg.dot(to(pair(probe)), 3.0, "pr", "", "probe of the unit");
    }
    svg.raw("</g>");
    let lines = [
        format!("level {}", view["level"]),
        format!(
            "{} probes, f64 {}",
            view["probes"].as_array().map_or(0, Vec::len),
            view["exact_probes"].as_array().map_or(0, Vec::len)
        ),
        format!("line {:.2} texels", length),
        format!("minor axis {minor:.2}"),
        format!("angle off {:.2}°", number(&view["off_degrees"])),
    ];
    for (i, line) in lines.iter().enumerate() {
        svg.text([SIDE + 10.0, 20.0 + 18.0 * i as f64], "s", line);
    }
    for (i, (class, name)) in
        [("exact", "exact axis"), ("table", "the unit's axis")].iter().enumerate()
    {
        let y = 130.0 + 20.0 * i as f64;
        svg.line([SIDE + 10.0, y], [SIDE + 34.0, y], class);
        svg.text([SIDE + 40.0, y + 4.0], "s", name);
    }
    svg.dot([SIDE + 22.0, 172.0], 3.0, "pr", "", "");
    svg.text([SIDE + 40.0, 176.0], "s", "the unit's probes");
    svg.dot([SIDE + 22.0, 192.0], 7.0, "pe", "", "");
    svg.text([SIDE + 40.0, 196.0], "s", "f64's, their width");
    svg.finish("footprint over texels")
}
