//! Figures that are there only where a study names them.

use std::fs;

use crate::run::{command, tapline};
use serde_json::{Map, Value};

/// The header and the rows of a study.
fn run(text: &str) -> (Value, Vec<Map<String, Value>>) {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("s.toml"), text).unwrap();
    let output =
        command().current_dir(folder.path()).args(["study", "s.toml", "--out", "r"]).output();
    let output = output.unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let results = fs::read_to_string(folder.path().join("r/results.jsonl")).unwrap();
    let mut lines = results.lines().map(|l| serde_json::from_str::<Value>(l).unwrap());
    let header = lines.next().unwrap();
    let rows = lines.map(|row| row["metrics"].as_object().unwrap().clone()).collect();
    (header, rows)
}

/// A number of a row.
fn figure(row: &Map<String, Value>, name: &str) -> f64 {
    row.get(name).and_then(Value::as_f64).unwrap_or_else(|| panic!("no {name} in {row:?}"))
}

const ROOM: &str = r#"
scenes = ["room"]
size = "24x24"
face_sizes = [64]
[set]
"hit.method" = "secant"
[[axis]]
path = "hit.iterations"
list = [1, 8]
"#;

#[test]
fn a_study_has_the_usual_figures_unless_it_names_others() {
    let (header, rows) = run(ROOM);
    let columns = header["columns"].as_array().unwrap();
    let named = |part: &str| columns.iter().any(|c| c["name"].as_str().unwrap().contains(part));
    assert!(named("direction_p95_deg") && rows[0].contains_key("direction_p95_deg"));
    for asked in ["march_", "surface_", "f64_", "footprint_", "direction_p99"] {
        assert!(!named(asked) && rows[0].keys().all(|k| !k.contains(asked)), "{asked}");
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.toml");
    fs::write(&path, format!("metrics = [\"marsh_*\"]\n{ROOM}")).unwrap();
    tapline(&["study", path.to_str().unwrap()]).refused(&["line 1", "`marsh_*`"]);
}

#[test]
fn searches_are_measured_against_the_impostors_surface_and_a_march() {
    let metrics =
        r#"metrics = ["*direction_*", "*surface_*", "*look_ups*", "*hit_colour*", "*far*"]"#;
    let (_, rows) = run(&format!("{metrics}\n{ROOM}"));
    for row in &rows {
        // 38 look-ups at most, and the last step halved six times.
        let march = figure(row, "march_look_ups_per_ray");
        assert!(march > 7.0 && march < 38.0);
        assert!(figure(row, "march_surface_median_deg") < 0.05);
        // The default words follow the float reference: by less than 0.1° of 99 rays in 100, as tests/hit/room.rs holds.
        let [mine, theirs] =
            ["surface_p95_deg", "f64_surface_p95_deg"].map(|name| figure(row, name));
        assert!(mine > 0.0 && (mine - theirs).abs() < 0.1, "{mine} {theirs}");
    }
    // One look-up is worse than the march, eight by the secant are better.
    for name in ["surface_p95_deg", "surface_p99_deg", "direction_p95_deg", "hit_colour_lsb8"] {
        let march = figure(&rows[0], &format!("march_{name}"));
        let [short, long] = [&rows[0], &rows[1]].map(|row| figure(row, name));
        assert!(short > march && march > long && long > 0.0, "{name}: {short} {march} {long}");
    }
}

#[test]
fn the_differential_of_the_hit_is_the_best_footprint_in_a_room() {
    let (_, rows) = run(&format!("metrics = [\"footprint_*\"]\nsamples = 64\n{ROOM}"));
    let of = |kind: &str| figure(&rows[0], &format!("footprint_{kind}_psnr_db"));
    assert!(of("differential") > of("plane") && of("plane") > of("disc"));
    assert!(of("disc") > of("mirror") && of("mirror") > 15.0, "{rows:?}");
    assert!(figure(&rows[0], "footprint_rays_lsb8") < 4.0);
    assert_eq!(rows[0], rows[1], "no unit changes them");
}

const CONES: &str = r#"
scenes = ["vases"]
size = "16x16"
face_sizes = [128]
bounces = ["0", "1-8"]
metrics = ["requests", "texture_*", "cone_*", "tiles"]
mode = "zip"
[[axis]]
path = "cone.format"
list = ["f32", "f16", "bf16", "bf16"]
[[axis]]
path = "cone.rounding"
list = ["rne", "rne", "rne", "truncate"]
"#;

#[test]
fn shorter_cones_are_worse_at_every_bounce_and_truncation_is_worst() {
    let (_, rows) = run(CONES);
    assert_eq!(rows.len(), 8);
    for part in rows.chunks(4) {
        for name in ["cone_lod_p95", "cone_width_p95"] {
            let errors: Vec<f64> = part.iter().map(|row| figure(row, name)).collect();
            assert!(errors[0] > 0.0 && errors.is_sorted_by(|a, b| a < b), "{name}: {errors:?}");
        }
        // Truncation takes from the width, so that levels are too fine.
        assert!(figure(&part[3], "cone_lod_bias") < 0.0);
        let of = |name: &str| figure(&part[0], name);
        assert!(of("texture_requests") > 0.0 && of("texture_requests") <= of("requests"));
        assert!(of("texture_tiles") > 0.0 && of("texture_tiles") <= of("tiles"));
        assert!(of("texture_tiles_level_0") <= of("texture_tiles"));
    }
    let deeper = rows[0]["cone_lod_max"].as_f64() < rows[4]["cone_lod_max"].as_f64();
    assert!(deeper, "errors add up from bounce to bounce");
}

#[test]
fn a_row_of_some_bounces_says_so_and_its_command_gives_it_again() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("s.toml"), CONES.replace("metrics", "# ")).unwrap();
    let args = ["study", "s.toml", "--out", "r"];
    assert!(command().current_dir(folder.path()).args(args).output().unwrap().status.success());
    let csv = fs::read_to_string(folder.path().join("r/results.csv")).unwrap();
    assert!(csv.starts_with("row,point,scene,width,height,env,face_size,bounces,"));
    let results = fs::read_to_string(folder.path().join("r/results.jsonl")).unwrap();
    let row: Value = serde_json::from_str(results.lines().last().unwrap()).unwrap();
    assert_eq!(row["bounces"], "1-8");
    let words: Vec<&str> = row["command"].as_str().unwrap().split(' ').skip(1).collect();
    assert!(words.windows(2).any(|w| w == ["--bounces", "1-8"]), "{words:?}");
    let json = tapline(&[&words[..], &["--json", "-"]].concat()).done().json();
    assert_eq!(json["pairs"][0]["psnr_db"], row["metrics"]["psnr_db"]);
    let path = folder.path().join("t.toml");
    for (from, to, parts) in [
        ("\"vases\"", "\"room\"", &["line 2", "ray cones", "`room`"][..]),
        ("1-8", "8-1", &["line 5", "`8-1`"]),
    ] {
        fs::write(&path, CONES.replace(from, to)).unwrap();
        tapline(&["study", path.to_str().unwrap()]).refused(parts);
    }
}

#[test]
fn thin_ellipses_and_jumps_are_figures_of_a_unit() {
    let (_, rows) = run(r#"
scenes = ["sphere"]
size = "8x8"
metrics = ["minor_error_*", "thin_line_end_*", "jump_*"]
[set]
"footprint.axis" = "eigen-table"
[[axis]]
path = "eigen.entries"
list = [10, 32]
"#);
    let [coarse, fine] = rows.as_slice() else { panic!("{rows:?}") };
    // Half of the table's step, 90°/(2 · entries), at the end of half a line of 16 widths.
    for (row, entries) in [(coarse, 10.0), (fine, 32.0)] {
        let most = 8.0 * (std::f64::consts::FRAC_PI_4 / entries).sin();
        let end = figure(row, "thin_line_end_30");
        assert!(end > 0.9 * most && end < 1.1 * most, "{end} {most}");
    }
    // λ2 is lost in K's mantissas by and by.
    assert!(figure(fine, "minor_error_10") < 1e-4 && figure(fine, "minor_error_30000") > 0.1);
    let jump = |name: &str| figure(fine, &format!("jump_{name}_max_lsb8"));
    assert!(jump("table") > 1.0 && jump("f64_table") < 0.1);
    assert!(jump("equal") < 1.0 && jump("seam") > 1.0 && jump("f64_seam") > 1.0);
    assert!(figure(coarse, "jump_table_mean_lsb8") < figure(fine, "jump_table_mean_lsb8"));
}
