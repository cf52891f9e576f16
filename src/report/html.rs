//! `report.html`: one file with the tables and pictures of a `compare` run, readable without a network.
//!
//! Input is the object that `compare --json` prints, and PNG files as bytes. Whatever the object
//! lacks is left out. Every text that comes from outside is escaped; pictures are data URIs.

use serde_json::Value;

use super::escape::{base64, escape};
use cells::{Cell, Column, list, number, object, plain, table, text};

mod cells;

/// The page of one run.
///
/// `run` has the keys of `compare --json` (`scene size unit engines pairs registers flags skipped
/// adapter`) and may have `version`, `unit_hash` and `seed`. `images` are (name, PNG): a name that is a
/// key of `engines` is that engine's picture, `a-b` of a pair is its error map, others come last.
#[must_use]
pub fn page(run: &Value, images: &[(String, Vec<u8>)]) -> String {
    let scene = text(&run["scene"]);
    let mut out =
        String::from("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n");
    out += "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n";
    out += &format!("<title>tapline: {}</title>\n", escape(&scene));
    out += &format!("<style>\n{}</style>\n</head>\n<body>\n", include_str!("html/page.css"));
    out += &format!("<h1>tapline: {}</h1>\n", escape(&scene));
    out += &facts(run);
    out += &section("Ladder", &ladder(run));
    out += &pictures(run, images);
    out += &section("Engines", &engines(run));
    out += &section("Registers, rtl against f64", &registers(run));
    out += &section("Stages, gpu against f64", &stages(run));
    out += &section("Flags", &flags(run));
    out += &section("Skipped engines", &skipped(run));
    out += &unit(run);
    out += &format!("<script>\n{}</script>\n</body>\n</html>\n", include_str!("html/page.js"));
    out
}

fn section(title: &str, body: &str) -> String {
    if body.is_empty() {
        return String::new();
    }
    format!("<section>\n<h2>{title}</h2>\n{body}</section>\n")
}

/// Scene, size, unit, version and seed: what it takes to repeat the run.
fn facts(run: &Value) -> String {
    let sides: Vec<String> = list(&run["size"]).iter().map(text).collect();
    let size = if sides.is_empty() { text(&run["size"]) } else { sides.join(" × ") };
    let facts = [
        ("scene", text(&run["scene"])),
        ("size", size),
        ("unit", text(&run["unit_hash"])),
        ("version", text(&run["version"])),
        ("seed", text(&run["seed"])),
        ("adapter", text(&run["adapter"])),
    ];
    let mut out = String::from("<dl class=\"run\">\n");
    for (name, value) in facts.iter().filter(|(_, value)| !value.is_empty()) {
        out += &format!("<div><dt>{name}</dt><dd>{}</dd></div>\n", escape(value));
    }
    out + "</dl>\n"
}

fn ladder(run: &Value) -> String {
    let with_flip = list(&run["pairs"]).iter().any(|pair| pair["flip"].is_number());
    let mut columns: Vec<Column> = vec![
        ("pair", false),
        ("PSNR (dB)", true),
        ("max (8-bit steps)", true),
        ("RMSE (0…1)", true),
        ("relative MSE", true),
        ("over 1 step (%)", true),
    ];
    if with_flip {
        columns.push(("FLIP (0…1)", true));
    }
    let rows = list(&run["pairs"]).iter().map(|pair| {
        let psnr = if pair["psnr_db"].is_null() {
            // Sorts above every finite figure.
            Cell { text: "identical".to_owned(), value: Some(f64::MAX) }
        } else {
            number(&pair["psnr_db"], 1.0)
        };
        let mut cells = vec![
            plain(format!("{} – {}", text(&pair["a"]), text(&pair["b"]))),
            psnr,
            number(&pair["max_abs"], 255.0),
            number(&pair["rmse"], 1.0),
            number(&pair["rel_mse"], 1.0),
            number(&pair["share_over_1_lsb8"], 100.0),
        ];
        if with_flip {
            cells.push(number(&pair["flip"], 1.0));
        }
        cells
    });
    table(&columns, rows, false)
}

fn engines(run: &Value) -> String {
    let columns = [
        ("engine", false),
        ("time (s)", true),
        ("fragments/s", true),
        ("texels/fragment", true),
        ("probes/fragment", true),
    ];
    let rows = object(&run["engines"]).into_iter().map(|(name, engine)| {
        let keys =
            ["seconds", "fragments_per_second", "texels_per_fragment", "probes_per_fragment"];
        let figures = keys.map(|key| number(&engine[key], 1.0));
        std::iter::once(plain(name.clone())).chain(figures).collect()
    });
    table(&columns, rows, true)
}

fn registers(run: &Value) -> String {
    let columns = [
        ("stage", false),
        ("register", false),
        ("worst (LSB)", true),
        ("mean (LSB)", true),
        ("worst at pixel", false),
    ];
    let rows = list(&run["registers"]).iter().map(|row| {
        let pixel = list(&row["pixel"]).iter().map(text).collect::<Vec<_>>();
        vec![
            plain(text(&row["stage"])),
            plain(text(&row["register"])),
            number(&row["worst_lsb"], 1.0),
            number(&row["mean_lsb"], 1.0),
            plain(pixel.join(",")),
        ]
    });
    table(&columns, rows, true)
}

/// The registers of a device's stages, each stage at the reference's operands.
fn stages(run: &Value) -> String {
    let columns = [
        ("stage", false),
        ("register", false),
        ("compared", true),
        ("worst (of tolerance)", true),
        ("undecided", true),
        ("no bound", true),
        ("unexplained", true),
    ];
    let rows = list(&run["stages"]["registers"]).iter().map(|row| {
        let mut cells = vec![plain(text(&row["stage"])), plain(text(&row["register"]))];
        let keys = ["compared", "worst_share", "undecided", "unbounded", "unexplained"];
        cells.extend(keys.map(|key| number(&row[key], 1.0)));
        cells
    });
    table(&columns, rows, true)
}

fn flags(run: &Value) -> String {
    let rows = object(&run["flags"]).into_iter();
    let rows = rows.map(|(name, events)| vec![plain(name.clone()), number(events, 1.0)]);
    table(&[("flag", false), ("count", true)], rows, true)
}

fn skipped(run: &Value) -> String {
    let rows = list(&run["skipped"]).iter();
    let rows = rows.map(|row| vec![plain(text(&row["engine"])), plain(text(&row["why"]))]);
    table(&[("engine", false), ("why", false)], rows, false)
}

/// Every knob of the unit, folded away.
fn unit(run: &Value) -> String {
    let mut knobs = Vec::new();
    flatten("", &run["unit"], &mut knobs);
    if knobs.is_empty() {
        return String::new();
    }
    let rows = knobs.into_iter().map(|(path, value)| vec![plain(path), plain(value)]);
    let body = table(&[("path", false), ("value", false)], rows, true);
    format!("<details>\n<summary>Unit</summary>\n{body}</details>\n")
}

fn flatten(path: &str, value: &Value, out: &mut Vec<(String, String)>) {
    if let Value::Object(fields) = value {
        for (key, field) in fields {
            let dot = if path.is_empty() { "" } else { "." };
            flatten(&format!("{path}{dot}{key}"), field, out);
        }
    } else if !value.is_null() {
        out.push((path.to_owned(), text(value)));
    }
}

/// The viewer (shown where scripts run), then the engines' pictures, the error maps and whatever else there is.
fn pictures(run: &Value, images: &[(String, Vec<u8>)]) -> String {
    let is_engine = |name: &str| run["engines"].get(name).is_some();
    let is_map = |name: &str| {
        let pairs = list(&run["pairs"]).iter();
        let mut names = pairs.map(|pair| format!("{}-{}", text(&pair["a"]), text(&pair["b"])));
        names.any(|pair| pair == name)
    };
    let mut shown: Vec<&(String, Vec<u8>)> = Vec::new();
    let mut maps = Vec::new();
    let mut others = Vec::new();
    for image in images {
        match &image.0 {
            name if is_engine(name) => shown.push(image),
            name if is_map(name) => maps.push(image),
            _ => others.push(image),
        }
    }
    let viewed: Vec<_> = shown.iter().chain(&maps).copied().collect();
    let mut out = String::new();
    if viewed.len() > 1 {
        out += &viewer(&viewed);
    }
    out += &section("Pictures", &figures(&shown, true));
    let title = "Error maps: largest channel difference in 8-bit steps";
    out += &section(title, &figures(&maps, true));
    out + &section("More pictures", &figures(&others, false))
}

fn viewer(shown: &[&(String, Vec<u8>)]) -> String {
    let select = |part: &str, selected: usize| {
        let options = shown.iter().enumerate().map(|(at, (name, _))| {
            let mark = if at == selected { " selected" } else { "" };
            format!("<option value=\"{at}\"{mark}>{}</option>", escape(name))
        });
        let options: String = options.collect();
        format!("<select data-part=\"{part}\">{options}</select>")
    };
    let buttons = [("wipe", "Wipe"), ("blink", "Blink"), ("a", "Only A"), ("b", "Only B")];
    let buttons: String = buttons
        .map(|(mode, title)| {
            format!("<button type=\"button\" data-mode=\"{mode}\">{title}</button>\n")
        })
        .concat();
    let zooms: String =
        [1, 2, 4, 8].map(|zoom| format!("<option value=\"{zoom}\">{zoom}×</option>")).concat();
    format!(
        "<section class=\"viewer\">\n<h2>Compare</h2>\n<div class=\"bar\">\n<label>A {}</label>\n<label>B {}</label>\n{buttons}\
         <label>Zoom <select data-part=\"zoom\">{zooms}</select></label>\n</div>\n\
         <div class=\"stage\"><div class=\"sheet\" data-part=\"sheet\"><img alt=\"\">\
         <img alt=\"\" class=\"top\"><div class=\"rule\" data-part=\"rule\"></div></div></div>\n\
         <p class=\"readout\" data-part=\"readout\"></p>\n</section>\n",
        select("a", 0),
        select("b", 1),
    )
}

fn figures(images: &[&(String, Vec<u8>)], view: bool) -> String {
    if images.is_empty() {
        return String::new();
    }
    let view = if view { " data-view" } else { "" };
    let mut out = String::from("<div class=\"pictures\">\n");
    for (name, png) in images {
        let name = escape(name);
        let size = png_size(png).map_or_else(String::new, |(width, height)| {
            format!(" width=\"{width}\" height=\"{height}\"")
        });
        let data = base64(png);
        out += &format!(
            "<figure{view}><img alt=\"{name}\"{size} src=\"data:image/png;base64,{data}\">\
             <figcaption>{name}</figcaption></figure>\n"
        );
    }
    out + "</div>\n"
}

/// Columns and rows from a PNG's header, so that the page does not jump while it loads.
fn png_size(png: &[u8]) -> Option<(u32, u32)> {
    let header = png.strip_prefix(b"\x89PNG\r\n\x1a\n")?;
    let word = |at: usize| Some(u32::from_be_bytes(*header.get(at..)?.first_chunk()?));
    Some((word(8)?, word(12)?))
}
