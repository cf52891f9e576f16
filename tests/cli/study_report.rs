//! The report is one file that needs nothing else, and shows what the JSON has.

use std::fs;

use crate::run::{command, tapline};

const STUDY: &str = r#"
title = "A <small> study"
scenes = ["sphere", "room", "convex"]
size = "20x16"
face_sizes = [32]
[[axis]]
path = "filter.weight_bits"
list = [3, 5, 8]
[[axis]]
path = "footprint.count"
list = ["ceil", "pow2"]
"#;

#[test]
fn a_report_has_frontier_details_and_footprints_and_asks_for_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("s.toml"), STUDY).unwrap();
    let run = |args: &[&str]| {
        let output = command().current_dir(folder).args(args).output().unwrap();
        assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    };
    run(&["study", "s.toml", "--out", "r"]);
    run(&["study", "report", "r"]);
    let plain = fs::read_to_string(folder.join("r/report.html")).unwrap();
    run(&["study", "report", "r", "--study", "s.toml"]);
    let whole = fs::read_to_string(folder.join("r/report.html")).unwrap();
    assert!(whole.len() > plain.len() + 10_000, "details add pictures");
    // From the JSON alone: the details stay, and the page is the same.
    run(&["study", "report", "r"]);
    assert_eq!(fs::read_to_string(folder.join("r/report.html")).unwrap(), whole);

    assert!(whole.contains("A &lt;small&gt; study") && !whole.contains("<small>"));
    // `xmlns` is a name, not a request.
    let links = whole.replace("http://www.w3.org/2000/svg", "");
    for outside in ["http:", "https:", "@import", "url(\"", "<link", "src=\"/"] {
        assert!(!links.contains(outside), "{outside}");
    }
    for part in [
        "class=\"f\"",
        "data-row=\"0\"",
        "Ladder",
        "difference, 8-bit steps",
        "look-ups, dark 0",
        "probes, dark 1",
        "levels of detail",
        "exact axis",
        "angle off",
        "surface_footprint",
        "tapline compare room",
    ] {
        assert!(whole.contains(part), "no {part}");
    }
    let figures: Vec<_> =
        fs::read_dir(folder.join("r/figures")).unwrap().map(|e| e.unwrap().path()).collect();
    assert!(figures.len() >= 12, "{figures:?}");
    for figure in &figures {
        let text = fs::read_to_string(figure).unwrap();
        assert!(text.starts_with("<svg") && text.ends_with("</svg>"), "{figure:?}");
        let open = text.matches("<g").count();
        assert_eq!(open, text.matches("</g>").count(), "{figure:?}");
    }

    // Another study's file, and rows that are not there.
    fs::write(folder.join("t.toml"), STUDY.replace("[3, 5, 8]", "[3, 8]")).unwrap();
    let [r, s, t] = ["r", "s.toml", "t.toml"].map(|f| folder.join(f).display().to_string());
    tapline(&["study", "report", &r, "--study", &t]).refused(&["the study file of these results"]);
    tapline(&["study", "report", &r, "--study", &s, "--rows", "99"]).refused(&["--rows", "99"]);
}
