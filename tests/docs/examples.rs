//! The examples of the documents run.
//!
//! In a document listed below, a fence `sh` has command lines that start with `tapline`. Standard
//! input is the fence `json in` before it; the fence `json out` or `text out` behind it is the
//! standard output, `text err` the last line on standard error of a command that ends with status 2.
//! `TAPLINE_BLESS=1` writes the outputs anew.

use std::io::Write as _;
use std::process::{Command, Output, Stdio};

use rtl_model::fx::{Format, Overflow, Quantizer, Rounding, block};
use rtl_model::port;
use support::{golden, house};

const DOCUMENTS: [&str; 2] = ["docs/trace-lines.md", "docs/number-formats.md"];

fn run(line: &str, input: &str) -> Output {
    let mut words = line.split_whitespace();
    assert_eq!(words.next(), Some("tapline"), "{line}");
    let mut child = Command::new(env!("CARGO_BIN_EXE_tapline"))
        .args(words)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // The command may end before it has read all.
    let _ = child.stdin.take().unwrap().write_all(input.as_bytes());
    child.wait_with_output().unwrap()
}

/// A document whose outputs are the command's, and how many it has.
fn regenerated(text: &str) -> (String, usize) {
    let mut parts = text.split("```");
    let mut out = parts.next().unwrap_or("").to_owned();
    let (mut input, mut last) = (String::new(), None);
    let mut outputs = 0;
    while let (Some(fence), Some(prose)) = (parts.next(), parts.next()) {
        let (info, body) = fence.split_once('\n').unwrap();
        let mut body = body.to_owned();
        match info {
            "json in" => input.clone_from(&body),
            "sh" => {
                for line in body.lines() {
                    last = Some(run(line, &input));
                }
            }
            "json out" | "text out" | "text err" => {
                let output: &Output = last.as_ref().expect("a command before its output");
                let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
                let errors = text(&output.stderr);
                if info == "text err" {
                    assert_eq!(output.status.code(), Some(2), "{errors}");
                    body = format!("{}\n", errors.lines().last().unwrap());
                } else {
                    assert!(output.status.success(), "{errors}");
                    body = text(&output.stdout).replace("\r\n", "\n");
                }
                outputs += 1;
            }
            _ => {}
        }
        out.push_str(&format!("```{info}\n{body}```{prose}"));
    }
    (out, outputs)
}

#[test]
fn every_example_of_the_documents_prints_what_they_say() {
    let bless = std::env::var_os(golden::BLESS).is_some();
    let mut problems = Vec::new();
    for name in DOCUMENTS {
        let path = house::root(name);
        let text = house::read(&path).replace("\r\n", "\n");
        let (new, outputs) = regenerated(&text);
        assert!(outputs > 0, "{name} has no example");
        if new != text {
            problems.extend(golden::compare(&path, &new, bless).err());
        }
    }
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

/// The cells of the table of docs/number-formats.md whose first header is `title`.
fn table(title: &str) -> Vec<Vec<String>> {
    let text = house::read(&house::root("docs/number-formats.md"));
    let start = format!("| {title} |");
    let rows: Vec<Vec<String>> = text
        .lines()
        .skip_while(|line| !line.starts_with(&start))
        .take_while(|line| line.starts_with('|'))
        .filter(|line| !line.starts_with("|--"))
        .map(|line| {
            let cells = line.trim_matches('|').split('|');
            cells.map(|cell| cell.trim().replace('`', "").replace('\u{2212}', "-")).collect()
        })
        .collect();
    assert!(rows.len() > 1, "no table {title}");
    rows
}

/// A cell's number as a multiple of 2^−frac.
fn code(cell: &str, frac: u32) -> i64 {
    let scaled = cell.parse::<f64>().unwrap() * f64::from(1u32 << frac);
    let whole = format!("{scaled:.0}").parse::<i64>().unwrap();
    assert_eq!(format!("{scaled}"), format!("{whole}"), "{cell} has more bits");
    whole
}

#[test]
fn all_eight_roundings_do_what_the_table_says() {
    let rows = table("rounding");
    let (header, rows) = rows.split_first().unwrap();
    assert_eq!(rows.len(), Rounding::ALL.len());
    for row in rows {
        let rounding = Rounding::parse(&row[0]).unwrap_or_else(|| panic!("{}", row[0]));
        let format = Format { rounding, ..Format::signed(7, 0) };
        for (value, expected) in header.iter().zip(row).skip(2) {
            let (got, over) = Quantizer::new(format, 2).write(code(value, 2));
            assert_eq!((got, over), (code(expected, 0), false), "{} {value}", row[0]);
        }
    }
}

#[test]
fn all_four_overflows_do_what_the_table_says() {
    let rows = table("overflow");
    let (header, rows) = rows.split_first().unwrap();
    assert_eq!(rows.len(), Overflow::ALL.len());
    for row in rows {
        let overflow = Overflow::parse(&row[0]).unwrap_or_else(|| panic!("{}", row[0]));
        let format = Format { overflow, ..Format::signed(2, 1) };
        for (value, cell) in header.iter().zip(row).skip(2) {
            let (got, over) = Quantizer::new(format, 1).write(code(value, 1));
            let star = if over { "*" } else { "" };
            let bits = format!("{:04b}", got & 15);
            let half = f64::from(i32::try_from(got).unwrap()) / 2.0;
            assert_eq!(*cell, format!("{bits} = {half}{star}"), "{} {value}", row[0]);
        }
    }
}

#[test]
fn a_block_shares_its_exponent_as_the_table_says() {
    let rows = table("block s1.4");
    let column = |k: usize| -> Vec<String> { rows[1..].iter().map(|r| r[k].clone()).collect() };
    let values: Vec<i64> = column(1).iter().map(|cell| code(cell, 4)).collect();
    let q = Quantizer::new(Format::signed(1, 4), 0);
    let got = block::normalize(false, &q, &<[i64; 3]>::try_from(values).unwrap(), 4);
    let codes: Vec<i64> = column(2).iter().map(|cell| cell.parse().unwrap()).collect();
    assert_eq!(got.m.to_vec(), codes);
    for (code, expected) in got.m.iter().zip(column(3)) {
        assert_eq!(expected, format!("{code} · 2^-{}", got.frac));
    }
}

#[test]
fn ports_take_doubles_as_the_table_says() {
    let rows = table("decimal");
    let q = Quantizer::new(Format::signed(3, 22), 0);
    for row in &rows[1..] {
        let value = match row[0].split_once('^') {
            Some(("2", power)) => libm::ldexp(1.0, power.parse().unwrap()),
            _ => row[0].parse::<f64>().unwrap(),
        };
        let (code, over, finite) = port::scalar(false, &q, value.to_bits(), 0);
        assert_eq!(code.to_string(), row[1], "{}", row[0]);
        let said = match (over, finite) {
            (_, false) if value.is_nan() => "not finite",
            (_, false) => "saturated, not finite",
            (true, _) => "saturated",
            (false, _) => "-",
        };
        assert_eq!(row[2], said, "{}", row[0]);
    }
}
