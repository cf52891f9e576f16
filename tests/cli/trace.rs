//! `trace`: the line format to the letter, hostile lines, streaming.

use crate::run::{command, tapline, tapline_fed};
use serde_json::Value;
use std::io::{BufRead as _, BufReader, Write as _};
use std::process::Stdio;

const LINE: &str = r#"{"op":"env","v":[0.1,0.2,1],"n":[0,0,1],"dv_dx":[-1,0,0],"dv_dy":[0,-1,0],"dn_dx":[0,0,0],"dn_dy":[0,0,0]}"#;

fn trace(input: &str, more: &[&str]) -> crate::run::Ran {
    let mut args = vec!["trace", "--input", "-"];
    args.extend(more);
    tapline_fed(&args, input.as_bytes())
}

/// The line with one more key.
fn with(more: &str) -> String {
    format!("{},{more}}}", &LINE[..LINE.len() - 1])
}

/// The line with another n.
fn normal(y: &str) -> String {
    LINE.replace("[0,0,1]", &format!("[0,{y},1]"))
}

#[test]
fn a_line_comes_back_letter_by_letter_with_out_as_its_last_key() {
    let line = r#"{"id":{"a":1.50,"a":[1E400, -0]},"out":"old","n":[-0,0.0,1E+0],"op":"env","v":[1.00e-1,0.2,1],"dv_dx":[-1,0,0],"dv_dy":[0,-1,0],"dn_dx":[0,0,0],"dn_dy":[0,0,0]}"#;
    let ran = trace(line, &[]).done();
    let before = line.replace(r#""out":"old","#, "");
    let expected = format!("{},\"out\":{{\"face\":\"+z\",\"u\":-", &before[..before.len() - 1]);
    assert!(ran.stdout.starts_with(&expected), "{}", ran.stdout);
    assert_eq!(ran.stdout.lines().count(), 1);
}

#[test]
fn out_has_the_keys_of_the_interface_in_their_order() {
    let keys = |more: &[&str]| -> Vec<String> {
        let value: Value = trace(LINE, more).done().json();
        value["out"].as_object().unwrap().keys().cloned().collect()
    };
    let bare = ["face", "u", "v", "D", "K", "lambda", "axis", "probes", "lod", "flags"];
    assert_eq!(keys(&[]), bare);
    assert_eq!(keys(&["--engine", "f64"]), bare);
    let mut coloured = bare.to_vec();
    coloured.insert(9, "color");
    assert_eq!(keys(&["sphere"]), coloured);
    assert_eq!(keys(&["sphere", "--engine", "f64"]), coloured);
}

#[test]
fn rtl_numbers_are_the_exact_values_of_the_raw_codes() {
    let plain = trace(LINE, &["sphere"]).done().json();
    let raw = trace(LINE, &["sphere", "--raw"]).done().json();
    let mut compared = 0;
    for key in ["u", "v", "D", "K", "lambda", "axis", "lod", "color"] {
        check(&plain["out"][key], &raw["out"][key], &mut compared);
    }
    assert_eq!(compared, 2 + 4 + 3 + 2 + 2 + 1 + 3);
}

fn check(plain: &Value, raw: &Value, compared: &mut usize) {
    if let (Value::Array(plain), Value::Array(raw)) = (plain, raw) {
        assert_eq!(plain.len(), raw.len());
        for (p, r) in plain.iter().zip(raw) {
            check(p, r, compared);
        }
        return;
    }
    let frac = raw["frac"].as_u64().unwrap();
    // value · 10^frac = code · 5^frac · 2^frac / 2^frac, in whole numbers.
    let text = plain.to_string();
    let (whole, fraction) = text.split_once('.').unwrap_or((&text, ""));
    let frac = usize::try_from(frac).unwrap();
    assert!(fraction.len() <= frac, "{text} has more digits than bits");
    let digits = format!("{whole}{fraction:0<frac$}");
    let code: num_bigint::BigInt = raw["raw"].to_string().parse().unwrap();
    let exact = code * num_bigint::BigInt::from(5).pow(u32::try_from(frac).unwrap());
    assert_eq!(digits.parse::<num_bigint::BigInt>().unwrap(), exact, "{text}");
    *compared += 1;
}

#[test]
fn malformed_lines_are_refused_with_their_number_and_earlier_lines_stand() {
    let n = "\"n\":[0,0,1]";
    let long = with(&format!("\"id\":\"{}\"", "x".repeat(1 << 20)));
    let deep = "[".repeat(100_000);
    let cases: Vec<(String, &str)> = vec![
        (with("\"foo\":1"), "`foo`"),
        (LINE.replace("\"n\":[0,0,1],", ""), "`n`: expected an array of 3 numbers, found nothing"),
        (LINE.replace(n, "\"n\":[0,0]"), "an array of 2"),
        (LINE.replace(n, "\"n\":[0,0,1,0]"), "an array of 4"),
        (LINE.replace(n, "\"n\":null"), "found null"),
        (LINE.replace(n, "\"n\":[true,0,1]"), "found true"),
        (LINE.replace(n, "\"n\":[[0],0,1]"), "found [0]"),
        (LINE.replace(n, "\"n\":{\"x\":1}"), "found {\"x\":1}"),
        (LINE.replace(n, r#""n":[0,0,{"$serde_json::private::Number":"1"}]"#), "`n`"),
        (with("\"h\":null"), "`h`"),
        (with("\"bump\":[1,2]"), "`h`"),
        (with("\"rough\":[1,2,3]"), "`h`"),
        (with("\"h\":[1,0,0],\"bump\":[1,2,3]"), "an array of 2 numbers, found an array of 3"),
        (with("\"n\":[0,0,1]"), "the key `n` twice"),
        (with("\"out\":1,\"out\":2"), "the key `out` twice"),
        (normal("NaN"), "column 36"),
        (normal("Infinity"), "not JSON"),
        (normal("\"NaN\""), "found \"NaN\""),
        (normal("\"infinity\""), "`n`"),
        (normal("01"), "not JSON"),
        (normal("1."), "not JSON"),
        (normal(".5"), "not JSON"),
        (normal("+1"), "not JSON"),
        (normal("0x10"), "not JSON"),
        (LINE.replace("\"env\"", "\"tex\""), "an unknown key"),
        (LINE.replace("\"env\"", "\"hit\""), "`v`"),
        (LINE.replace("\"env\"", "\"foo\""), "found \"foo\""),
        (LINE.replace("\"env\"", "3"), "found 3"),
        (LINE.replace("\"op\":\"env\",", ""), "found nothing"),
        (format!("{LINE}{LINE}"), "trailing characters"),
        (with(""), "not JSON"),
        (LINE[..LINE.len() - 1].to_string(), "unfinished"),
        ("# comment".into(), "not JSON"),
        ("[]".into(), "column 1"),
        ("3".into(), "integer"),
        (deep, "sequence"),
        (long, "1 MiB"),
        (format!("{LINE}\0"), "trailing"),
        (format!("\u{feff}{LINE}"), "byte-order mark"),
        (format!("\n{LINE}"), "empty line"),
    ];
    for (bad, part) in cases {
        let ran = trace(&format!("{LINE}\n{LINE}\n{bad}\n{LINE}\n"), &["--engine", "f64"]);
        ran.refused(&["standard input, line 3", part]);
        assert_eq!(ran.stdout.lines().count(), 2, "{part}");
    }
}

#[test]
fn bytes_that_are_not_utf_8_are_refused() {
    let mut bytes = LINE.as_bytes().to_vec();
    bytes.push(0xff);
    tapline_fed(&["trace", "--input", "-"], &bytes).refused(&["line 1", "UTF-8"]);
    let utf16: Vec<u8> = LINE.encode_utf16().flat_map(u16::to_le_bytes).collect();
    tapline_fed(&["trace", "--input", "-"], &utf16).refused(&["line 1"]);
}

#[test]
fn line_ends_of_every_kind_and_empty_ends_are_taken() {
    for (input, lines) in [
        (String::new(), 0),
        ("\n\n".into(), 0),
        (LINE.to_string(), 1),
        (format!("{LINE}\r\n{LINE}\r\n"), 2),
        (format!("{LINE}\n\n  \n"), 1),
    ] {
        assert_eq!(trace(&input, &[]).done().stdout.lines().count(), lines);
    }
}

#[test]
fn no_input_makes_either_engine_print_a_number_that_is_not_finite() {
    for value in [
        "\"inf\"",
        "\"-inf\"",
        "\"nan\"",
        "1e400",
        "-1e400",
        "1e-400",
        "-0",
        "1e300",
        "-1e-300",
        "5e-324",
        "1e99999999999999999999",
        "1.7976931348623157e308",
    ] {
        for engine in ["rtl", "f64"] {
            for line in [
                normal(value),
                LINE.replace("\"dn_dx\":[0,0,0]", &format!("\"dn_dx\":[{value},{value},0]")),
                LINE.replace("[0.1,0.2,1]", &format!("[{value},{value},{value}]")),
                with(&format!("\"h\":[{value},1,0],\"bump\":[{value},0],\"rough\":[0,0,{value}]")),
            ] {
                let ran = trace(&line, &["--engine", engine]).done();
                let out = ran.stdout.split("\"out\":").nth(1).unwrap().to_lowercase();
                assert!(!out.contains("nan") && !out.contains("null"), "{out}");
                assert!(!out.contains("\"inf") && !out.contains("\"-inf"), "{out}");
                let value: Value = serde_json::from_str(&ran.stdout).unwrap();
                assert!(value["out"]["u"].as_f64().unwrap().abs() <= 1.0);
            }
        }
    }
}

#[test]
fn an_answer_comes_before_the_next_question() {
    let mut child = command()
        .args(["trace", "--input", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let mut stdout = BufReader::new(child.stdout.take().unwrap());
    for _ in 0..3 {
        writeln!(stdin, "{LINE}").unwrap();
        let mut answer = String::new();
        stdout.read_line(&mut answer).unwrap();
        assert!(answer.contains("\"face\":\"+z\""));
    }
    drop(stdin);
    assert!(child.wait().unwrap().success());
}

#[test]
fn a_reader_that_leaves_ends_the_stream_quietly() {
    let mut child = command()
        .args(["trace", "--input", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let mut stdin = child.stdin.take().unwrap();
    let text = format!("{LINE}\n").repeat(1000);
    let _ = stdin.write_all(text.as_bytes());
    drop(stdin);
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert!(!String::from_utf8_lossy(&output.stderr).contains("panicked"));
}

#[test]
fn face_sizes_are_bounded_and_set_the_level() {
    let lod =
        |size: &str| trace(LINE, &["--face-size", size]).done().json()["out"]["lod"].to_string();
    // λ = 1 spans half the face: log2(N/2).
    assert_eq!(lod("1"), "0");
    assert_eq!(lod("256"), "7");
    assert_eq!(lod("16384"), "13");
    for bad in ["0", "16385", "-1", "x", "1.5"] {
        trace(LINE, &["--face-size", bad]).refused(&["--face-size"]);
    }
}

#[test]
fn the_wrong_combinations_of_flags_say_what_is_right() {
    trace(LINE, &["--raw", "--engine", "f64"]).refused(&["--raw", "rtl"]);
    trace(LINE, &["--distance", "box:1,1"]).refused(&["--distance", "box:HX,HY,HZ"]);
    trace(r#"{"op":"hit","x":[0,0,0],"r":[0,0,1]}"#, &[]).refused(&["--distance", "line 1"]);
    tapline(&["trace"]).refused(&["--input"]);
    tapline(&["trace", "sphere"]).refused(&["--pixel"]);
    tapline(&["trace", "--input", "."]).refused(&["folder"]);
    tapline(&["trace", "--input", "none"]).refused(&["none"]);
    let pixel = |p| tapline(&["trace", "sphere", "--size", "64x64", "--pixel", p]);
    pixel("64,0").refused(&["64x64"]);
    pixel("0,0").refused(&["background"]);
    pixel("-1,3").refused(&["COLUMN,ROW"]);
}

#[test]
fn a_traced_pixel_is_a_line_that_trace_takes_again() {
    let pixel = tapline(&["trace", "waves", "--size", "64x64", "--pixel", "30,50"]).done();
    let first = pixel.json();
    assert!(first["out"]["registers"].as_object().unwrap().len() > 20);
    let again = trace(&pixel.stdout, &["waves", "--size", "64x64"]).done().json();
    for key in ["face", "u", "v", "D", "K", "lambda", "axis", "probes", "lod", "color", "flags"] {
        assert_eq!(first["out"][key], again["out"][key], "{key}");
    }
}
