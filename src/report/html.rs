//! `report.html`: one file with the tables and pictures of a `compare` run, readable without a network.
//!
//! Input is the object that `compare --json` prints, and PNG files as bytes. Whatever the object
//! lacks is left out. Every text that comes from outside is escaped; pictures are data URIs.

use maud::{Markup, html};
use serde_json::Value;

use super::page::{facts, figure, list, plain, png, section, words};
use super::table::{Table, text, whole};

/// A picture: its name, and the bytes of its PNG file.
type Image = (String, Vec<u8>);

/// The page of one run.
///
/// `run` has the keys of `compare --json` (`scene size unit engines pairs registers flags skipped
/// adapter`) and may have `version`, `unit_hash` and `seed`. `images` are (name, PNG): a name that is a
/// key of `engines` is that engine's picture, `a-b` of a pair is its error map, others come last.
#[must_use]
pub fn page(run: &Value, images: &[Image]) -> String {
    let title = format!("tapline: {}", words(&run["scene"]));
    let unit = knobs(&run["unit"]);
    let body = html! {
        (run_facts(run))
        (section("Inputs", &inputs(run).html(false)))
        (section("Ladder", &ladder(run).html(false)))
        (section("Flicker: motions against those of the truth", &motions(run).html(false)))
        (pictures(run, images))
        (section("Engines", &engines(run).html(true)))
        (section("Registers, rtl against f64", &registers(run).html(true)))
        (section("Stages, gpu against f64", &stages(run).html(true)))
        (section("Flags", &flags(run).html(true)))
        (section("Skipped engines", &skipped(run).html(false)))
        @if !unit.is_empty() { details { summary { "Unit" } (unit.html(true)) } }
    };
    super::page::page(&title, &title, &body, include_str!("html.js"))
}

/// Scene, size, unit, version and seed: the data needed to repeat the run.
fn run_facts(run: &Value) -> Markup {
    let sides: Vec<String> = list(&run["size"]).iter().map(words).collect();
    let size = if sides.is_empty() { words(&run["size"]) } else { sides.join(" × ") };
    facts(&[
        ("scene", words(&run["scene"])),
        ("size", size),
        ("unit", words(&run["unit_hash"])),
        ("version", words(&run["version"])),
        ("seed", words(&run["seed"])),
        ("adapter", words(&run["adapter"])),
    ])
}

/// What each input file was taken for.
fn inputs(run: &Value) -> Table {
    Table::of(
        list(&run["inputs"]),
        &[
            ("option", "", &|i| plain(&i["option"])),
            ("file", "", &|i| plain(&i["file"])),
            ("taken for", "", &|i| plain(&i["kind"])),
            ("from", "", &|i| plain(&i["from"])),
            ("transfer", "", &|i| plain(&i["transfer"])),
            ("window", "", &|i| plain(&i["window"])),
            ("remarks", "", &|i| {
                text(list(&i["remarks"]).iter().map(words).collect::<Vec<_>>().join("; "))
            }),
            ("decided by", "", &|i| {
                text(list(&i["decided_by"]).iter().map(words).collect::<Vec<_>>().join(" "))
            }),
        ],
    )
}

fn ladder(run: &Value) -> Table {
    let with_flip = list(&run["pairs"]).iter().any(|pair| pair["flip"].is_number());
    Table::of(
        list(&run["pairs"]),
        &[
            ("pair", "", &|p| text(format!("{} – {}", words(&p["a"]), words(&p["b"])))),
            ("PSNR (dB)", "", &|p| {
                // Sorts above every finite figure.
                let none = p["psnr_db"].is_null();
                if none { whole("identical").with(f64::MAX) } else { figure(&p["psnr_db"], 1.0) }
            }),
            ("max (8-bit steps)", "", &|p| figure(&p["max_abs"], 255.0)),
            ("RMSE (0…1)", "", &|p| figure(&p["rmse"], 1.0)),
            ("relative MSE", "", &|p| figure(&p["rel_mse"], 1.0)),
            ("over 1 step (%)", "", &|p| figure(&p["share_over_1_lsb8"], 100.0)),
            (if with_flip { "FLIP (0…1)" } else { "" }, "", &|p| figure(&p["flip"], 1.0)),
        ],
    )
}

fn motions(run: &Value) -> Table {
    Table::of(
        list(&run["motions"]),
        &[
            ("pair", "", &|m| text(format!("{} – {}", words(&m["a"]), words(&m["b"])))),
            ("flicker (dB)", "", &|m| {
                let none = m["flicker_db"].is_null();
                if none { whole("identical").with(f64::MAX) } else { figure(&m["flicker_db"], 1.0) }
            }),
            ("act", "", &|m| figure(&m["act"], 1.0)),
            ("fragments", "", &|m| figure(&m["fragments"], 1.0)),
        ],
    )
}

fn engines(run: &Value) -> Table {
    Table::of(
        run["engines"].as_object().into_iter().flatten(),
        &[
            ("engine", "", &|(name, _)| text(name)),
            ("time (s)", "", &|(_, e)| figure(&e["seconds"], 1.0)),
            ("fragments/s", "", &|(_, e)| figure(&e["fragments_per_second"], 1.0)),
            ("texels/fragment", "", &|(_, e)| figure(&e["texels_per_fragment"], 1.0)),
            ("probes/fragment", "", &|(_, e)| figure(&e["probes_per_fragment"], 1.0)),
        ],
    )
}

fn registers(run: &Value) -> Table {
    Table::of(
        list(&run["registers"]),
        &[
            ("stage", "", &|r| plain(&r["stage"])),
            ("register", "", &|r| plain(&r["register"])),
            ("worst (LSB)", "", &|r| figure(&r["worst_lsb"], 1.0)),
            ("mean (LSB)", "", &|r| figure(&r["mean_lsb"], 1.0)),
            ("worst at pixel", "", &|r| {
                let pixel: Vec<String> = list(&r["pixel"]).iter().map(words).collect();
                text(pixel.join(","))
            }),
        ],
    )
}

/// The registers of a device's stages, each stage at the reference's operands.
fn stages(run: &Value) -> Table {
    Table::of(
        list(&run["stages"]["registers"]),
        &[
            ("stage", "", &|r| plain(&r["stage"])),
            ("register", "", &|r| plain(&r["register"])),
            ("compared", "", &|r| figure(&r["compared"], 1.0)),
            ("worst (of tolerance)", "", &|r| figure(&r["worst_share"], 1.0)),
            ("undecided", "", &|r| figure(&r["undecided"], 1.0)),
            ("no bound", "", &|r| figure(&r["unbounded"], 1.0)),
            ("unexplained", "", &|r| figure(&r["unexplained"], 1.0)),
        ],
    )
}

fn flags(run: &Value) -> Table {
    Table::of(
        run["flags"].as_object().into_iter().flatten(),
        &[("flag", "", &|(name, _)| text(name)), ("count", "", &|(_, n)| figure(n, 1.0))],
    )
}

fn skipped(run: &Value) -> Table {
    Table::of(
        list(&run["skipped"]),
        &[("engine", "", &|s| plain(&s["engine"])), ("why", "", &|s| plain(&s["why"]))],
    )
}

/// Every knob of the unit.
fn knobs(unit: &Value) -> Table {
    let mut knobs = Vec::new();
    flatten("", unit, &mut knobs);
    Table::of(
        knobs,
        &[("path", "", &|(path, _)| text(path)), ("value", "", &|(_, value)| text(value))],
    )
}

fn flatten(path: &str, value: &Value, out: &mut Vec<(String, String)>) {
    if let Value::Object(fields) = value {
        for (key, field) in fields {
            let dot = if path.is_empty() { "" } else { "." };
            flatten(&format!("{path}{dot}{key}"), field, out);
        }
    } else if !value.is_null() {
        out.push((path.to_owned(), words(value)));
    }
}

/// The viewer (shown where scripts run), then the engines' pictures, the error maps and whatever else there is.
fn pictures(run: &Value, images: &[Image]) -> Markup {
    let pair = |p: &Value| format!("{}-{}", words(&p["a"]), words(&p["b"]));
    let maps: Vec<String> = list(&run["pairs"]).iter().map(pair).collect();
    let (shown, rest): (Vec<&Image>, Vec<_>) =
        images.iter().partition(|(name, _)| run["engines"].get(name).is_some());
    let (maps, others): (Vec<_>, Vec<_>) =
        rest.into_iter().partition(|(name, _)| maps.contains(name));
    let viewed: Vec<&str> = shown.iter().chain(&maps).map(|(name, _)| name.as_str()).collect();
    html! {
        @if viewed.len() > 1 { (viewer(&viewed)) }
        (section("Pictures", &figures(&shown, true)))
        (section("Error maps: largest channel difference in 8-bit steps", &figures(&maps, true)))
        (section("More pictures", &figures(&others, false)))
    }
}

/// Two pictures over each other, to wipe and to blink.
fn viewer(names: &[&str]) -> Markup {
    let select = |part: &str, chosen: usize| {
        html! {
            select data-part=(part) {
                @for (at, name) in names.iter().enumerate() { option value=(at) selected[at == chosen] { (name) } }
            }
        }
    };
    let buttons = [("wipe", "Wipe"), ("blink", "Blink"), ("a", "Only A"), ("b", "Only B")];
    html! {
        section.viewer {
            h2 { "Compare" }
            div.bar {
                label { "A " (select("a", 0)) }
                label { "B " (select("b", 1)) }
                @for (mode, title) in buttons { button type="button" data-mode=(mode) { (title) } }
                label { "Zoom " select data-part="zoom" {
                    @for zoom in [1, 2, 4, 8] { option value=(zoom) { (zoom) "×" } }
                } }
            }
            div.stage { div.sheet data-part="sheet" {
                img alt=""; img.top alt=""; div.rule data-part="rule" {}
            } }
            p.readout data-part="readout" {}
        }
    }
}

fn figures(images: &[&Image], view: bool) -> Markup {
    html! {
        @if !images.is_empty() {
            div.pictures { @for (name, bytes) in images { (png(name, bytes, view)) } }
        }
    }
}
