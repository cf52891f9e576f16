//! Result files: interrupted and split studies give the bytes of one that ran through.

use std::fs;
use std::path::Path;

use crate::run::{command, tapline};
use serde_json::Value;

const STUDY: &str = r#"
title = "small"
scenes = ["sphere", "room", "convex"]
size = "12x10"
face_sizes = [16]
against = ["ewa"]
[[axis]]
path = "filter.weight_bits"
list = [4, 8]
[[axis]]
path = "registers.jacobian.d.frac"
list = [22, 18, 50]
"#;

fn run(folder: &Path, args: &[&str]) {
    let output = command().current_dir(folder).arg("study").args(args).output().unwrap();
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
}

fn bytes(folder: &Path, name: &str) -> [Vec<u8>; 2] {
    ["jsonl", "csv"]
        .map(|ending| fs::read(folder.join(name).join(format!("results.{ending}"))).unwrap())
}

#[test]
fn a_study_that_was_stopped_or_split_gives_the_bytes_of_one_that_ran_through() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("s.toml"), STUDY).unwrap();
    run(folder, &["s.toml", "--out", "whole"]);
    let whole = bytes(folder, "whole");
    let text = String::from_utf8(whole[0].clone()).unwrap();
    let rows: Vec<Value> = text.lines().skip(1).map(|l| serde_json::from_str(l).unwrap()).collect();
    assert_eq!(rows.len(), 18);
    let refused = rows.iter().filter(|r| r["refused"].is_string()).count();
    assert_eq!(refused, 6, "a word of 58 bits does not fit, and the rows say so");
    assert!(rows.iter().all(|r| r["refused"].is_string() != r["metrics"].is_object()));

    // Stopped in the middle of a row: the journal has some rows and a torn line.
    fs::create_dir(folder.join("stopped")).unwrap();
    let journal: String = text.lines().take(8).map(|l| format!("{l}\n")).collect();
    let torn = &text.lines().nth(8).unwrap()[..40];
    fs::write(folder.join("stopped/results.part"), format!("{journal}{torn}")).unwrap();
    // The file has other line ends and a comment by now.
    let edited = format!("# as before\n{STUDY}").replace('\n', "\r\n");
    fs::write(folder.join("edited.toml"), edited).unwrap();
    run(folder, &["edited.toml", "--out", "stopped", "--resume"]);
    assert_eq!(bytes(folder, "stopped"), whole);
    assert!(!folder.join("stopped/results.part").exists());
    // Again: nothing is left to do, and nothing changes.
    run(folder, &["s.toml", "--out", "stopped", "--resume"]);
    assert_eq!(bytes(folder, "stopped"), whole);

    // Four parts.
    for part in 1..=4 {
        run(folder, &["s.toml", "--out", "parts", "--shard", &format!("{part}/4")]);
    }
    let parts: Vec<String> = (1..=4).map(|k| format!("parts/results-{k}-of-4.jsonl")).collect();
    let mut args = vec!["merge", "--out", "merged"];
    args.extend(parts.iter().rev().map(String::as_str));
    run(folder, &args);
    assert_eq!(bytes(folder, "merged"), whole);
    // One part is missing.
    let output = command()
        .current_dir(folder)
        .args(["study", "merge", "--out", "less", &parts[0], &parts[2], &parts[3]])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("missing"));
    assert!(!folder.join("less").exists());

    // Without reuse: the same figures.
    run(folder, &["s.toml", "--out", "lone", "--no-reuse"]);
    assert_eq!(bytes(folder, "lone"), whole);

    replay(folder, &rows);
    foreign(folder, &journal);
    replaced(folder, &whole);
}

/// Finished results of another study stay; those of the same one may be written again.
fn replaced(folder: &Path, whole: &[Vec<u8>; 2]) {
    let out = folder.join("whole").display().to_string();
    let [s, t] = ["s.toml", "t.toml"].map(|f| folder.join(f).display().to_string());
    fs::write(&t, STUDY.replace("[4, 8]", "[5, 8]").replace("title = \"", "title = \"other "))
        .unwrap();
    tapline(&["study", &t, "--out", &out]).refused(&["results.jsonl", "`other ", "another --out"]);
    assert_eq!(bytes(folder, "whole"), *whole);
    run(folder, &["s.toml", "--out", "whole"]);
    assert_eq!(bytes(folder, "whole"), *whole);
    // A run that goes on holds its journal.
    let path = folder.join("other/results.part");
    let journal = fs::File::open(&path).unwrap();
    journal.lock().unwrap();
    let other = folder.join("other").display().to_string();
    tapline(&["study", &s, "--out", &other, "--resume"]).refused(&["no other run", "results.part"]);
}

/// The printed command gives the figures of the row.
fn replay(folder: &Path, rows: &[Value]) {
    let mut scenes = Vec::new();
    for row in rows.iter().filter(|r| r["metrics"].is_object()) {
        if scenes.contains(&&row["scene"]) {
            continue;
        }
        scenes.push(&row["scene"]);
        let mut words = row["command"].as_str().unwrap().split(' ');
        assert_eq!(words.next(), Some("tapline"));
        let output =
            command().current_dir(folder).args(words).args(["--json", "-"]).output().unwrap();
        let json: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(json["unit_hash"], row["unit_hash"]);
        let (pair, metrics) = (&json["pairs"][0], &row["metrics"]);
        assert_eq!((pair["a"].as_str(), pair["b"].as_str()), (Some("rtl"), Some("f64")));
        for name in ["psnr_db", "max_lsb8", "mean_lsb8", "share_over_1_lsb8"] {
            let figure = |v: &Value| v[name].as_f64();
            assert_eq!(figure(pair), figure(metrics), "{}: {name}", row["scene"]);
        }
        let rtl = &json["engines"]["rtl"];
        for name in ["probes_per_fragment", "texels_per_fragment"] {
            assert_eq!(rtl[name].as_f64(), metrics[name].as_f64(), "{name}");
        }
    }
    assert_eq!(scenes.len(), 3);
}

/// A journal that is there is not overwritten, and one of another study is not gone on with.
fn foreign(folder: &Path, journal: &str) {
    fs::create_dir(folder.join("other")).unwrap();
    fs::write(folder.join("other/results.part"), journal).unwrap();
    fs::write(folder.join("t.toml"), STUDY.replace("[4, 8]", "[5, 8]")).unwrap();
    let out = folder.join("other").display().to_string();
    let [s, t] = ["s.toml", "t.toml"].map(|f| folder.join(f).display().to_string());
    tapline(&["study", &s, "--out", &out]).refused(&["--resume"]);
    tapline(&["study", &t, "--out", &out, "--resume"]).refused(&["plan"]);
    assert_eq!(fs::read_to_string(folder.join("other/results.part")).unwrap(), journal);
}

#[test]
fn commands_refuse_what_is_wrong() {
    tapline(&["study"]).refused(&["FILE"]);
    tapline(&["study", "none.toml"]).refused(&["none.toml", "readable study file"]);
    tapline(&["study", "none.toml", "--shard", "5/4"]).refused(&["K/N"]);
    tapline(&["study", "table", "none.jsonl"]).refused(&["none.jsonl"]);
    tapline(&["cost", "unit", "spher"]).refused(&["`spher`"]);
    let shown = tapline(&["cost", "show"]).done().stdout;
    assert!(shown.contains("full_adder"), "{shown}");
    let sheet = tapline(&["cost", "unit", "vases", "--json", "-"]).done().json();
    let stages: Vec<&str> =
        sheet["stages"].as_array().unwrap().iter().map(|s| s["stage"].as_str().unwrap()).collect();
    assert!(stages.contains(&"ray_cone") && stages.contains(&"surface_footprint"), "{stages:?}");
    assert!(sheet["unmodelled"].as_array().unwrap().len() > 5);
    assert!(sheet["stages"].as_array().unwrap().iter().all(|s| s["gates"].as_f64().unwrap() > 0.0));
}
