//! What every input was taken for: on stderr, in the header, in JSON and on the page; and what a unit cannot hold of it.

use std::path::Path;

use crate::run::{Ran, tapline_in};
use tapline::image::write_planes;

/// A 16 × 8 map of ones with some brighter texels.
fn map(folder: &Path, name: &str, bright: &[f32]) {
    let mut plane = vec![1.0f32; 16 * 8];
    plane[..bright.len()].copy_from_slice(bright);
    let planes = ["R", "G", "B"].map(|name| (name.to_owned(), plane.clone()));
    let mut file = std::fs::File::create(folder.join(name)).unwrap();
    write_planes(&mut file, [16, 8], planes.to_vec(), &[]).unwrap();
}

fn compare(folder: &Path, more: &[&str]) -> Ran {
    let plain = ["compare", "sphere", "--size", "24x24", "--engines", "rtl,f64"];
    tapline_in(folder, &[&plain[..], more].concat())
}

#[test]
fn the_same_words_are_on_stderr_in_the_header_in_json_and_on_the_page() {
    let folder = tempfile::tempdir().unwrap();
    map(folder.path(), "m.exr", &[]);
    std::fs::write(folder.path().join("m.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let inputs = ["--env", "m.exr", "--mesh", "m.obj"];
    let ran =
        compare(folder.path(), &[&inputs[..], &["--json", "r.json", "--out", "out"]].concat());
    let ran = ran.done();
    let text = std::fs::read_to_string(folder.path().join("r.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    let page = std::fs::read_to_string(folder.path().join("out/report.html")).unwrap();
    let listed = json["inputs"].as_array().unwrap();
    assert_eq!(listed.len(), 2);
    for input in listed {
        let line = input["line"].as_str().unwrap();
        assert!(ran.stderr.contains(line) && ran.stdout.contains(line), "{line}");
        assert!(page.contains(input["file"].as_str().unwrap()) && page.contains("taken for"));
    }
    assert!(ran.stderr.contains("lat-long, centres at half texels (16x8, by its shape)"));
    // A flag without its input is refused.
    for idle in [
        &["--env-layout", "strip"][..],
        &["--transfer", "srgb"],
        &["--fill", "0,0,0"],
        &["--bump-kind", "heights"],
        &["--bump-green", "down"],
        &["--mesh-up", "z"],
        &["--distance-far", "3"],
    ] {
        compare(folder.path(), idle).refused(&[idle[0]]);
    }
}

#[test]
fn texels_and_distances_that_a_unit_cannot_hold_are_flags_with_count_and_remedy() {
    let folder = tempfile::tempdir().unwrap();
    map(folder.path(), "sun.exr", &[70_000.0, 90_000.0, 300.0]);
    // The cube keeps the two texels' means within faces of 4; their number is that of the cube's texels.
    let run = |more: &[&str]| {
        let ran =
            compare(folder.path(), &[&["--env", "sun.exr", "--json", "-"], more].concat()).done();
        (ran.json()["flags"]["texel.saturated"].as_u64(), ran.stderr)
    };
    let (half, note) = run(&[]);
    assert!(note.contains("beyond 65504") || half.is_none(), "{note}");
    let (narrow, note) = run(&["--set", "texel.format=q", "--set", "texel.int=4"]);
    assert!(narrow > half, "{note}");
    assert!(note.contains("beyond 15.99") && note.contains("holds them"), "{note}");
    let held = note.split("; ").last().unwrap().to_owned();
    assert!(held.contains("texel.format=half") || held.contains("texel.int=17"), "{held}");

    let far = vec![1e10f32; 4];
    let mut plane = vec![3.0f32; 24];
    plane[..4].copy_from_slice(&far);
    let mut file = std::fs::File::create(folder.path().join("d.exr")).unwrap();
    write_planes(&mut file, [2, 12], vec![("Z".to_owned(), plane)], &[]).unwrap();
    let hit = |more: &[&str]| {
        let plain = ["compare", "room", "--size", "16x16", "--engines", "rtl,f64", "--json", "-"];
        let ran = tapline_in(folder.path(), &[&plain[..], &["--distance", "d.exr"], more].concat());
        let ran = ran.done();
        (ran.json()["flags"]["distance.below_lsb"].as_u64(), ran.stderr)
    };
    let (below, note) = hit(&[]);
    assert_eq!(below, Some(20), "{note}");
    assert!(note.contains("--distance-far"), "{note}");
    assert_eq!(hit(&["--distance-far", "1000"]).0, None);
}
