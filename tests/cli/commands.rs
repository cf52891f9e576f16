//! Commands, flags, exit statuses, JSON keys.

use crate::run::{Ran, command, tapline};
use serde_json::Value;

const SMALL: [&str; 4] = ["compare", "sphere", "--size", "24x24"];

fn compare(more: &[&str]) -> Ran {
    let mut args = SMALL.to_vec();
    args.extend(more);
    tapline(&args)
}

fn keys(value: &Value) -> Vec<&str> {
    value.as_object().unwrap().keys().map(String::as_str).collect()
}

#[test]
fn distances_are_refused_where_no_scene_reads_them() {
    // ENV scenes have no distances.
    for flag in ["--distance"] {
        for args in [
            &["compare", "sphere", flag, "x"][..],
            &["render", "sphere", "--engine", "rtl", "-o", "x.png", flag, "x"],
            &["compare", flag],
        ] {
            tapline(args).refused(&[flag, "no distances"]);
        }
    }
}

#[test]
fn commands_that_are_gone_name_what_is_there() {
    for (words, now) in [
        (&["impostor", "study", "room"][..], "hit.md"),
        (&["cones", "tiles", "--size", "9x9"], "cones.md"),
        (&["cones", "formats"], "cones.md"),
        (&["cones", "cube"], "cones.md"),
        (&["cones"], "cones.md"),
        (&["conform", "extremes"], "extremes.md"),
    ] {
        let ran = tapline(words);
        ran.refused(&["removed", &format!("docs/studies/{now}")]);
        assert!(ran.stdout.is_empty());
    }
}

#[test]
fn impostor_says_what_it_needs() {
    tapline(&["impostor"]).refused(&["a scene", "impostor room -o"]);
    tapline(&["impostor", "room"]).refused(&["-o"]);
    tapline(&["impostor", "room", "-o", "x.png"]).refused(&["x.png", ".exr"]);
    tapline(&["impostor", "sphere", "-o", "x.exr"]).refused(&["room, columns, doorway"]);
}

#[test]
fn scenes_of_rays_are_compared_rendered_and_traced() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let out = path("out");
    let small = ["--size", "40x40", "--face-size", "32", "--samples", "16"];
    let engines = ["--engines", "rtl,f64,ewa,truth"];
    let mut args = vec!["compare", "room", "--json", "-", "--out", &out];
    args.extend(small);
    args.extend(engines);
    let value = tapline(&args).done().json();
    let rays = value["fragments"].as_u64().unwrap();
    assert!(rays > 400, "{rays}");
    for engine in ["rtl", "f64"] {
        let hit = &value["engines"][engine]["hit"];
        let status = hit["status"].as_object().unwrap();
        let sum: u64 = status.values().map(|n| n.as_u64().unwrap()).sum();
        assert_eq!(sum, rays);
        assert!(hit["look_ups_per_ray"].as_f64().unwrap() > 1.0);
    }
    let registers = value["registers"].as_array().unwrap();
    for name in ["d", "l", "ratio"] {
        let is = |r: &&Value| r["stage"] == "hit" && r["register"] == name;
        let row = registers.iter().find(is).unwrap_or_else(|| panic!("{name}"));
        assert!(row["worst_lsb"].as_f64().unwrap() > 0.0);
    }
    let pairs = value["pairs"].as_array().unwrap();
    let names: Vec<_> = pairs.iter().map(|p| (p["a"].as_str(), p["b"].as_str())).collect();
    let ladder = ladder(&value);
    let adjacent = ladder.windows(2).map(|w| (Some(w[0]), Some(w[1])));
    assert_eq!(names, adjacent.collect::<Vec<_>>());
    for name in ["classic.png", "views.png", "iterations.png", "truth.exr", "report.html"] {
        assert!(folder.path().join("out").join(name).is_file(), "{name}");
    }
    let out = path("glass");
    let mut args = vec!["compare", "glass", "--engines", "rtl,f64", "--json", "-", "--out", &out];
    args.extend(small);
    let value = tapline(&args).done().json();
    let caustic = &value["caustic"];
    for engine in ["rtl", "f64", "truth"] {
        let by = &caustic["engines"][engine];
        assert!(by["landed"].as_u64() > Some(3000), "{by}");
        let green = |key: &str| by[key][1].as_f64().unwrap();
        let [landed, arrived] = ["power_of_the_landed", "power_on_the_walls"].map(green);
        // 3000 photons of some 80 texels, each term rounded a few times.
        assert!((arrived / landed - 1.0).abs() < 3000.0 * 80.0 * f64::EPSILON);
    }
    assert!(caustic["pairs"][0]["relative_rms"].as_f64() > Some(0.0));
    assert!(folder.path().join("glass/lightmap.png").is_file());
    let picture = path("a.exr");
    let render = ["render", "columns", "--engine", "rtl", "-o", &picture, "--size", "24x24"];
    tapline(&render).done();
    let line =
        tapline(&["trace", "room", "--pixel", "20,20", "--size", "40x40", "--face-size", "32"])
            .done()
            .json();
    assert_eq!(line["op"], "hit");
    assert!(line["out"]["registers"]["hit.d"].is_array());
    // What other files bring takes the place of the impostor's own.
    let analytic = tapline(&[
        "trace",
        "room",
        "--pixel",
        "20,20",
        "--size",
        "40x40",
        "--face-size",
        "32",
        "--distance",
        "sphere:9",
    ])
    .done()
    .json();
    assert_ne!(analytic["out"]["d"], line["out"]["d"]);
    for (flag, file) in [("--bump", "x.png"), ("--mesh", "x.obj"), ("--distance", "none.exr")] {
        tapline(&["compare", "room", flag, file]).refused(&[file.trim_end_matches(".obj")]);
    }
}

#[test]
fn usage_errors_have_status_2_and_name_what_is_wrong() {
    for (args, part) in [
        (&["compar"][..], "'compare'"),
        (&["compare", "nosuch"], "sphere, cylinder, parabola"),
        (&["compare", "--engines", "xx"], "rtl, gpu, sampler, f64, ewa, truth"),
        (&["compare", "--size", "0x5"], "WIDTHxHEIGHT"),
        (&["compare", "--size", "-1x5"], "WIDTHxHEIGHT"),
        (&["compare", "--size", "16385x1"], "16384"),
        (&["compare", "--size", "1000000x1000000"], "16384"),
        (&["compare", "--size", "99999999999999999999x1"], "WIDTHxHEIGHT"),
        (&["compare", "sphere", "--size", "2x0"], "WIDTHxHEIGHT"),
        (&["compare", "sphere", "--size", "1x4096"], "no fragment"),
        (&["compare", "--exposure", "nan"], "--exposure"),
        (&["compare", "--exposure", "1e9"], "--exposure"),
        (&["compare", "--threads", "-1"], "--threads"),
        (&["compare", "--threads", "2000"], "1024"),
        (&["compare", "--samples", "3"], "--samples"),
        (&["compare", "--face-size", "0"], "--face-size"),
        (&["compare", "--face-size", "-4"], "--face-size"),
        (&["compare", "--face-size", "17000"], "--face-size"),
        (&["compare", "--bump-scale", "3"], "--bump"),
        (&["compare", "--max-image-mb", "-1"], "--max-image-mb"),
        (&["compare", "--adapter", "x"], "adapter"),
        (&["compare", "--env", "none.exr"], "none.exr"),
        (&["compare", "--env", "."], "directory"),
        (&["compare", "--min-psnr", "rtl:f64"], "rtl:f64=50"),
        (&["compare", "--min-psnr", "rtl:f64=nan"], "rtl:f64=50"),
        (&["compare", "--engines", "rtl", "--min-psnr", "rtl:gpu=5"], "gpu"),
        (&["compare", "--engines", "rtl", "--max-lsb8", "rtl:f64=5"], "f64"),
        (&["render", "sphere", "--engine", "rtl", "-o", "x.gif"], ".png"),
        (&["tables", "show", "foo"], "recip"),
        (&["diff", "a.json", "b.json"], "result file"),
        (&["diff", "a.png", "b.png", "--min-psnr", "nan"], "--min-psnr"),
    ] {
        let ran = tapline(args);
        ran.refused(&[part]);
        assert_eq!(ran.stdout, "", "{args:?}");
    }
}

/// The engines of a run that names none: with an adapter the gpu is one, without one it is skipped.
fn ladder(value: &Value) -> Vec<&'static str> {
    let gpu = value["adapter"].is_string();
    let all = ["rtl", "gpu", "f64", "ewa", "truth"];
    all.into_iter().filter(|n| gpu || *n != "gpu").collect()
}

#[test]
fn compare_json_has_the_keys_that_scripts_rely_on() {
    let value = compare(&["--samples", "4", "--json", "-"]).done().json();
    for key in [
        "version",
        "unit_hash",
        "seed",
        "scene",
        "size",
        "unit",
        "engines",
        "pairs",
        "registers",
        "flags",
        "skipped",
        "adapter",
    ] {
        assert!(value.get(key).is_some(), "{key}");
    }
    assert_eq!(value["scene"], "sphere");
    assert_eq!(value["size"], serde_json::json!([24, 24]));
    assert_eq!(value["unit"]["footprint"]["max_probes"], 16);
    assert_eq!(keys(&value["engines"]), ladder(&value));
    for engine in value["engines"].as_object().unwrap().values() {
        for key in ["seconds", "fragments_per_second", "texels_per_fragment", "probes_per_fragment"]
        {
            assert!(engine[key].as_f64().unwrap().is_finite(), "{key}");
        }
    }
    let pairs: Vec<_> = value["pairs"]
        .as_array()
        .unwrap()
        .iter()
        .map(|p| (p["a"].as_str().unwrap(), p["b"].as_str().unwrap()))
        .collect();
    let ladder = ladder(&value);
    let adjacent: Vec<_> = ladder.windows(2).map(|w| (w[0], w[1])).collect();
    assert_eq!(pairs, adjacent);
    for key in ["psnr_db", "max_abs", "rmse", "rel_mse", "share_over_1_lsb8"] {
        assert!(value["pairs"][0][key].is_number(), "{key}");
    }
    let register = &value["registers"][0];
    assert_eq!(keys(register), ["stage", "register", "worst_lsb", "mean_lsb", "pixel"]);
    if value["adapter"].is_string() {
        assert_eq!(value["skipped"], serde_json::json!([]));
        assert!(value["stages"]["first_difference"].is_null());
    } else {
        assert_eq!(value["skipped"][0]["engine"], "gpu");
        assert!(value["skipped"][0]["why"].is_string());
    }
}

/// Runs where the loader of Vulkan finds no driver.
fn without_a_driver(args: &[&str]) -> Ran {
    command()
        .args(args)
        .env("VK_DRIVER_FILES", "/nonexistent/driver.json")
        .env("VK_ICD_FILENAMES", "/nonexistent/driver.json")
        .stdin(std::process::Stdio::null())
        .output()
        .unwrap()
        .into()
}

#[test]
fn without_an_adapter_compare_goes_on_and_says_so_and_a_named_gpu_is_refused() {
    let small = ["compare", "sphere", "--size", "24x24", "--samples", "4"];
    let value = without_a_driver(&[&small[..], &["--json", "-"]].concat()).done().json();
    assert_eq!(keys(&value["engines"]), ["rtl", "f64", "ewa", "truth"]);
    assert_eq!(value["skipped"][0]["engine"], "gpu");
    let why = value["skipped"][0]["why"].as_str().unwrap();
    assert!(why.contains("no GPU adapter"), "{why}");
    assert!(value["adapter"].is_null());
    let words = without_a_driver(&small).done().stdout;
    assert!(words.contains("not checked: gpu (no GPU adapter"), "{words}");
    for named in [&["--engines", "rtl,gpu"][..], &["--adapter", "llvmpipe"]] {
        without_a_driver(&[&small[..], named].concat())
            .refused(&["no GPU adapter", "mesa-vulkan-drivers"]);
    }
    let render = ["render", "sphere", "--engine", "gpu", "-o", "/tmp/never.png"];
    without_a_driver(&render).refused(&["no GPU adapter"]);
}

#[test]
fn engines_come_in_the_order_of_the_ladder_however_they_are_named() {
    let value = compare(&["--engines", "ewa,rtl", "--json", "-"]).done().json();
    assert_eq!(keys(&value["engines"]), ["rtl", "ewa"]);
    assert_eq!(value["pairs"][0]["a"], "rtl");
    assert_eq!(value["pairs"][0]["b"], "ewa");
    assert_eq!(value["registers"], serde_json::json!([]));
    assert_eq!(value["skipped"], serde_json::json!([]));
}

#[test]
fn bounds_decide_between_status_0_and_1() {
    let run = |flag: &str, bound: &str| compare(&["--engines", "rtl,f64", flag, bound]);
    run("--min-psnr", "rtl:f64=20").done();
    run("--min-psnr", "f64:rtl=20").done();
    run("--max-lsb8", "rtl:f64=255").done();
    for (flag, bound) in [("--min-psnr", "rtl:f64=500"), ("--max-lsb8", "rtl:f64=0.0001")] {
        let ran = run(flag, bound);
        assert_eq!(ran.status, Some(1), "{ran:?}");
        assert!(ran.stderr.contains("rtl - f64"), "{}", ran.stderr);
        assert!(ran.stdout.contains("PSNR"));
    }
}

#[test]
fn a_pair_without_any_difference_has_no_psnr() {
    // Seen from its focus the parabola sends every ray the same way.
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("a.exr");
    let path = picture.to_str().unwrap();
    tapline(&["render", "sphere", "--engine", "rtl", "-o", path, "--size", "16x16"]).done();
    let value = tapline(&["diff", path, path, "--json", "-"]).done().json();
    assert!(value["pairs"][0]["psnr_db"].is_null());
    tapline(&["diff", path, path, "--min-psnr", "200"]).done();
}

#[test]
fn two_result_files_differ_where_their_units_do() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let (a, b) = (path("a.json"), path("b.json"));
    let run = |target: &str, more: &[&str]| {
        let mut args = vec!["--engines", "rtl,f64", "--json", target];
        args.extend(more);
        compare(&args).done();
    };
    run(&a, &[]);
    run(&b, &["--set", "eigen.entries=10"]);
    let same = tapline(&["diff", &a, &a]).done();
    assert!(same.stdout.starts_with("no difference"), "{}", same.stdout);
    let value = tapline(&["diff", &a, &b, "--json", "-"]).done().json();
    let figure = |table: &str, entry: &str, figure: &str| {
        let rows = value["figures"].as_array().unwrap().iter();
        let found =
            rows.filter(|r| r["table"] == table && r["entry"] == entry && r["figure"] == figure);
        let found: Vec<_> = found.collect();
        assert_eq!(found.len(), 1, "{table} {entry} {figure}");
        (found[0]["a"].clone(), found[0]["b"].clone())
    };
    assert_eq!(figure("unit", "eigen.entries", ""), (32.into(), 10.into()));
    let (finer, coarser) = figure("pairs", "rtl - f64", "psnr_db");
    assert!(finer.as_f64().unwrap() > coarser.as_f64().unwrap());
    let (x, y) = figure("registers", "covariance.k", "worst_lsb");
    assert_eq!(x, y, "the angle table lies behind K");
    assert!(x.as_f64().unwrap() > 0.0);

    std::fs::write(&b, "{\"pairs\": [}").unwrap();
    tapline(&["diff", &a, &b]).refused(&[&b, "line 1, column 12"]);
    std::fs::write(&b, "{\"pairs\": [{\"a\": \"rtl\"}]}").unwrap();
    tapline(&["diff", &a, &b]).refused(&[&b, "pairs[0]"]);
    tapline(&["diff", &a, &a, "--min-psnr", "40"]).refused(&["--min-psnr"]);
}

#[test]
fn every_command_that_prints_a_table_has_it_as_json() {
    for args in
        [&["scenes"][..], &["unit", "show"], &["unit", "check"], &["tables", "show", "eigen"]]
    {
        let mut with = args.to_vec();
        with.extend(["--json", "-"]);
        let value = tapline(&with).done().json();
        assert!(value["version"].is_string(), "{args:?}");
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("x.json");
        let mut with = args.to_vec();
        with.extend(["--json", file.to_str().unwrap()]);
        assert!(!tapline(&with).done().stdout.is_empty());
        let text = std::fs::read_to_string(&file).unwrap();
        assert_eq!(serde_json::from_str::<Value>(&text).unwrap(), value);
        with.pop();
        with.push("none/x.json");
        tapline(&with).refused(&["none/x.json"]);
    }
}

#[test]
fn the_number_of_threads_and_repetition_change_no_bit() {
    let folder = tempfile::tempdir().unwrap();
    let mut pictures = Vec::new();
    for (i, threads) in ["1", "2", "2", "3"].into_iter().enumerate() {
        let out = folder.path().join(i.to_string());
        let ran = compare(&[
            "--samples",
            "4",
            "--threads",
            threads,
            "--engines",
            "rtl,f64,ewa,truth",
            "--out",
            out.to_str().unwrap(),
            "--json",
            "-",
        ]);
        let mut files = crate::run::names(&out);
        files.retain(|f| f != "report.html");
        let engines = ladder(&ran.done().json()).len();
        assert_eq!(files.len(), engines * 2 + (engines - 1) + 1, "{files:?}");
        let bytes: Vec<_> = files.iter().map(|f| std::fs::read(out.join(f)).unwrap()).collect();
        pictures.push((files, bytes));
    }
    assert!(pictures.windows(2).all(|w| w[0] == w[1]));
}

#[test]
fn a_reader_that_leaves_changes_neither_verdict_nor_files() {
    let folder = tempfile::tempdir().unwrap();
    let mut child = crate::run::command()
        .args(SMALL)
        .args(["--engines", "rtl,f64", "--min-psnr", "rtl:f64=500", "--out"])
        .arg(folder.path().join("o"))
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    drop(child.stderr.take());
    assert_eq!(child.wait().unwrap().code(), Some(1));
    assert!(folder.path().join("o/report.html").exists());
}
