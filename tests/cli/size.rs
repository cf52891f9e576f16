//! `size` keeps its bound, and no word can be shorter.

use std::fs;

use crate::run::{command, tapline};
use serde_json::Value;
use tapline::unit::file::from_toml;

/// Sizes a scene and checks everything that the result promises with `compare`.
fn sized(scene: &str, size: &str, bound: &[&str], check: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let unit = folder.path().join("unit.toml");
    let unit = unit.to_str().unwrap();
    let face = ["--face-size", "32"];
    let mut args = vec!["size", scene, "--size", size, "-o", unit, "--json", "-"];
    args.extend(face.iter().chain(bound));
    let found = tapline(&args).done().json();
    let gates = |key: &str| found[key]["cost"]["gates"].as_f64().unwrap();
    assert!(
        gates("sized") < 0.9 * gates("before"),
        "{scene}: {} {}",
        gates("sized"),
        gates("before")
    );
    let whole = found["before"]["all_operations"]["gates"].as_f64().unwrap();
    assert!(whole > gates("before"), "all operations cost more than those of one scene");

    // The bound holds when `compare` checks it.
    let mut args = vec![
        "compare",
        scene,
        "--size",
        size,
        "--engines",
        "rtl,f64",
        "--unit",
        unit,
        "--json",
        "-",
    ];
    args.extend(face.iter().chain(check));
    let compared = tapline(&args).done().json();
    for name in ["psnr_db", "max_lsb8", "share_over_1_lsb8"] {
        assert_eq!(compared["pairs"][0][name], found["sized"]["pair"][name], "{scene}: {name}");
    }

    // Every word's step breaks it or is refused; three of them are tried.
    let knobs = found["knobs"].as_array().unwrap();
    assert!(knobs.len() > 40, "{scene}: {} knobs", knobs.len());
    let says =
        |knob: &&Value, what: &str| knob["one_step_less"].as_str().unwrap().starts_with(what);
    let breaking: Vec<&Value> = knobs.iter().filter(|k| says(k, "breaks")).collect();
    assert!(breaking.len() > 10, "{scene}: {} words are tight", breaking.len());
    assert!(
        knobs.iter().all(|k| { ["breaks", "refused", "is the least"].iter().any(|w| says(&k, w)) })
    );
    let text = fs::read_to_string(unit).unwrap();
    let spec = from_toml("unit", &text).unwrap();
    for knob in breaking.iter().step_by(breaking.len() / 3) {
        let path = knob["path"].as_str().unwrap();
        let value = knob["sized"].as_u64().unwrap();
        assert_eq!(spec.get(path).map(|v| v.to_string()), Some(value.to_string()), "{path}");
        let less = if path.ends_with(".entries") && path.starts_with("tables") {
            value / 2
        } else if path == "eigen.entries" {
            value - 2
        } else {
            value - 1
        };
        let mut args =
            vec!["compare", scene, "--size", size, "--engines", "rtl,f64", "--unit", unit];
        let set = format!("{path}={less}");
        args.extend(["--set", &set]);
        args.extend(face.iter().chain(check));
        let output = command().args(&args).output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{scene}: {set} keeps the bound");
    }
}

#[test]
fn a_sized_unit_for_reflections_keeps_its_bound_and_no_word_can_be_shorter() {
    sized("sphere", "16x12", &["--max-lsb8", "2.5"], &["--max-lsb8", "rtl:f64=2.5"]);
}

#[test]
fn a_sized_unit_for_rays_keeps_its_bound_and_no_word_can_be_shorter() {
    sized("room", "12x10", &["--psnr", "50"], &["--min-psnr", "rtl:f64=50"]);
}

#[test]
fn a_sized_unit_for_textures_keeps_its_bound_and_no_word_can_be_shorter() {
    sized("convex", "12x10", &["--psnr", "45"], &["--min-psnr", "rtl:f64=45"]);
}

#[test]
fn size_refuses_what_it_cannot_do() {
    tapline(&["size", "sphere"]).refused(&["--max-lsb8", "bound"]);
    tapline(&["size", "spher", "--psnr", "50"]).refused(&["spher"]);
    tapline(&["size", "sphere", "--psnr", "nan"]).refused(&["numbers from 0 up"]);
    let beyond = tapline(&["size", "room", "--size", "8x8", "--face-size", "16", "--psnr", "250"]);
    assert_eq!(beyond.status, Some(1), "{beyond:?}");
    assert!(beyond.stderr.contains("no unit keeps the bound"), "{beyond:?}");
}
