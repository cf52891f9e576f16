//! `vectors` and `conform` as a user calls them.

use crate::run::{tapline, tapline_fed};

fn fed(args: &[&str], input: &str) -> crate::run::Ran {
    tapline_fed(args, input.as_bytes())
}

#[test]
fn generated_vectors_pass_both_judges_and_a_wrong_bit_is_status_1() {
    for format in ["hex", "jsonl", "readmemh"] {
        let args = ["vectors", "gen", "eigen", "--count", "200", "--format", format];
        let vectors = tapline(&args).done().stdout;
        for against in ["rtl", "f64"] {
            let args = ["vectors", "check", "eigen", "--format", format, "--against", against];
            let out = fed(&args, &vectors);
            assert_eq!(out.status, Some(0), "{}", out.stderr);
            assert!(out.stderr.contains("200 cases, 0 wrong"));
        }
    }
    let args = ["vectors", "gen", "eigen", "--count", "60"];
    let vectors = tapline(&args).done().stdout;
    let last = vectors.trim_end().lines().last().unwrap();
    let tokens: Vec<&str> = last.split(' ').collect();
    // The root is the fifth number: K, its fraction bits, then the outputs.
    let wrong = format!(
        "{:0width$x}",
        u64::from_str_radix(tokens[4], 16).unwrap() ^ 0x100,
        width = tokens[4].len()
    );
    let line = [&tokens[..4], &[wrong.as_str()], &tokens[5..]].concat().join(" ");
    for against in ["rtl", "f64"] {
        let out = fed(&["vectors", "check", "eigen", "--against", against], &line);
        assert_eq!(out.status, Some(1), "{}", out.stderr);
        let shown = out.stdout;
        assert!(shown.contains(" => stage eigen, root[0]: "), "{shown}");
        assert!(shown.contains(" expected "), "{shown}");
    }
}

#[test]
fn a_run_that_lost_cases_is_status_1_with_both_counts() {
    let args = ["vectors", "gen", "eigen", "--count", "60", "--format", "readmemh"];
    let vectors = tapline(&args).done().stdout;
    let (all_but_one, _) = vectors.trim_end().rsplit_once('\n').unwrap();
    for (text, found) in [(all_but_one.to_string(), 59), (vectors.clone() + all_but_one, 119)] {
        let out = fed(&["vectors", "check", "eigen"], &text);
        assert_eq!(out.status, Some(1), "{}", out.stderr);
        let said = if found == 59 { 60 } else { 120 };
        let words = format!("the header says {said} cases of eigen, found {found}");
        assert!(out.stderr.contains(&words), "{}", out.stderr);
    }
    // An address that leaves words out, without a header that would tell.
    let cases: Vec<&str> = vectors.lines().filter(|line| !line.starts_with('/')).collect();
    let out = fed(&["vectors", "check", "eigen"], &format!("@7\n{}\n@a\n{}", cases[0], cases[1]));
    assert_eq!(out.status, Some(1));
    assert!(out.stderr.contains("addresses leave 2 cases"), "{}", out.stderr);
    assert!(out.stderr.contains("no header says how many cases"), "{}", out.stderr);
}

#[test]
fn what_simulators_print_is_read_and_an_unknown_digit_is_a_wrong_case() {
    let args = ["vectors", "gen", "eigen", "--count", "3", "--format", "readmemh"];
    let vectors = tapline(&args).done().stdout;
    let cases: Vec<&str> = vectors.lines().filter(|line| !line.starts_with('/')).collect();
    let joined = |k: usize| cases[k].replace('_', "");
    // No separators, capitals, tabs, comments over lines, two words a line, an address, CRLF.
    let printed = format!(
        "/* a memory\r\n @9 of words */\t{}\r\n@1 // the rest\r\n\t{}  {}\r\n",
        joined(0).to_uppercase(),
        joined(1),
        cases[2]
    );
    for (args, text) in [
        (&["vectors", "check", "eigen"][..], printed.as_str()),
        (&["vectors", "check", "eigen", "--format", "readmemh"], &printed),
        (&["vectors", "check", "eigen", "--format", "hex"], &joined(2)),
    ] {
        let out = fed(args, text);
        assert_eq!(out.status, Some(0), "{}", out.stderr);
    }
    let mut unknown = joined(1);
    unknown.replace_range(unknown.len() - 1.., "X");
    let text = format!("{}\n{unknown}\n{}\n", joined(0), joined(2));
    let out = fed(&["vectors", "check", "eigen"], &text);
    assert_eq!(out.status, Some(1), "{}", out.stderr);
    assert!(out.stdout.contains("line 2, flags[0]: "), "{}", out.stdout);
    assert!(out.stderr.contains("3 cases, 1 wrong"), "{}", out.stderr);
    // A word that a dying simulation cut off is no case.
    assert_eq!(fed(&["vectors", "check", "eigen"], &joined(0)[..40]).status, Some(2));
}

#[test]
fn malformed_vectors_are_status_2_with_line_and_column() {
    let args = ["vectors", "gen", "bump", "--count", "3"];
    let vectors = tapline(&args).done().stdout;
    let lines = vectors.lines().count();
    let broken = format!("{vectors}012 34\n");
    let out = fed(&["vectors", "check", "bump"], &broken);
    assert_eq!(out.status, Some(2));
    let error = out.stderr;
    assert!(error.contains(&format!("line {}, column 1", lines + 1)), "{error}");
    let other_unit = ["--set", "footprint.max_probes=8"];
    let args = [&["vectors", "check", "bump"][..], &other_unit].concat();
    let other = fed(&args, &vectors);
    assert_eq!(other.status, Some(2), "another unit's vectors");
    assert!(other.stderr.contains("line 1, column 1: expected unit "));
    assert_eq!(tapline(&["vectors", "check", "bump"]).status, Some(2));
    assert_eq!(tapline(&["vectors", "gen", "bmup"]).status, Some(2));
}

#[test]
fn conform_passes_a_slice_of_every_suite() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("failures");
    let json = folder.path().join("conform.json");
    let args = [
        "conform",
        "--engines",
        "rtl,f64",
        "--range",
        "0",
        "6",
        "--out",
        out.to_str().unwrap(),
        "--json",
        json.to_str().unwrap(),
    ];
    let result = tapline(&args);
    assert_eq!(result.status, Some(0), "{}", result.stdout);
    assert!(!out.exists());
    let value: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(json).unwrap()).unwrap();
    let suites = value["suites"].as_array().unwrap();
    assert!(suites.len() >= 250);
    assert!(suites.iter().all(|s| s["cases"] == 6 && s["failed"] == 0));
    let no_such = ["conform", "--engines", "gpu", "--adapter", "no such adapter"];
    assert_eq!(tapline(&no_such).status, Some(2));
    assert_eq!(tapline(&["conform", "--suite", "nothing"]).status, Some(2));
    assert_eq!(tapline(&["conform", "--range", "5", "5"]).status, Some(2));
}

#[test]
fn budgets_and_attributions_are_printed_with_their_parts() {
    let json = tapline(&["budget", "--cases", "5", "--quick", "--json", "-"]).done().json();
    let rows = json["registers"].as_array().unwrap();
    assert!(rows.len() > 80);
    assert!(rows.iter().all(|r| r["exceeded"] == 0));
    let args = [
        "budget",
        "--attribution",
        "sphere",
        "--size",
        "24x24",
        "--face-size",
        "32",
        "--json",
        "-",
    ];
    let json = tapline(&args).done().json();
    let parts = json["parts"].as_array().unwrap();
    let sum: f64 = parts.iter().map(|p| p["share"].as_f64().unwrap()).sum();
    assert!((sum - 1.0).abs() < 1e-9 && parts.len() > 12, "{json}");
    assert!(json["rmse"].as_f64().unwrap() > 0.0);
}
