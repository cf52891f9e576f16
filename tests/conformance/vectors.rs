//! Vector files: every format holds the same numbers, and what is malformed is named by line and column.

use tapline::conformance::cases::{Schedule, fill};
use tapline::conformance::header::{Language, declare};
use tapline::conformance::read;
use tapline::conformance::subject::Subject;
use tapline::conformance::text::{self, Format, Header};
use tapline::conformance::{Build, Device as _, harness};
use tapline::unit::UnitSpec;

#[test]
fn every_format_of_every_subject_reads_back_what_was_written() {
    for subject in Subject::all() {
        for level in [1, 2] {
            let spec = UnitSpec::default();
            let mut own = harness(&spec, subject, Build::default()).unwrap();
            let schedule = Schedule::new(&own, subject, level, 3);
            let shape = own.shape().clone();
            let mut input = vec![0; shape.input_len()];
            let mut output = vec![0; shape.output_len()];
            let step = schedule.cases() / 20;
            let mut moving = false;
            for k in 0..20 {
                fill(&mut own, subject, schedule.place(k * step), &mut input);
                own.run(&input, &mut output);
                moving |= output.iter().any(|x| *x != 0);
                for format in Format::ALL {
                    let line = text::line(&shape, format, &input, &output);
                    let mut numbers = Vec::new();
                    let unknown = read::parse(&shape, format, &line, &mut numbers).unwrap();
                    assert_eq!(unknown, None);
                    assert_eq!(numbers[..input.len()], input, "{}", subject.name());
                    assert_eq!(numbers[input.len()..], output, "{}", subject.name());
                }
            }
            assert!(moving, "{}: every output is 0", subject.name());
        }
    }
}

#[test]
fn headers_say_what_was_run_and_notice_another_unit() {
    let spec = UnitSpec::default();
    let own = harness(&spec, Subject::Env, Build::default()).unwrap();
    let header = Header {
        subject: Subject::Env,
        unit: spec.hash(),
        build: Build::default(),
        level: 1,
        seed: 9,
        count: 12,
    };
    for format in Format::ALL {
        let text = header.text(own.shape(), format);
        let first = text.lines().next().unwrap();
        for word in [spec.hash().as_str(), "unit", "9", "12"] {
            assert!(first.contains(word), "{first}");
        }
        assert_eq!(header.contradiction(first), None);
        let other = Header { unit: "0123456789abcdef".into(), ..header.clone() };
        let (key, want, found) = other.contradiction(first).unwrap();
        assert_eq!((key, want.as_str(), found), ("unit", "0123456789abcdef", spec.hash()));
        let mut comments = read::Comments::default();
        let blank = |line: &str| comments.strip(line).trim().is_empty();
        assert!(format == Format::Jsonl || text.lines().all(blank));
    }
}

#[test]
fn malformed_lines_name_the_column() {
    let own =
        harness(&UnitSpec::default(), Subject::parse("bump").unwrap(), Build::default()).unwrap();
    let shape = own.shape();
    let zeros = |n: usize| vec![0; n];
    let line =
        text::line(shape, Format::Hex, &zeros(shape.input_len()), &zeros(shape.output_len()));
    let mut numbers = Vec::new();
    let mut column =
        |format, line: &str| read::parse(shape, format, line, &mut numbers).unwrap_err().column;
    assert_eq!(column(Format::Hex, &line.replacen('0', "g", 1)), 1);
    assert_eq!(column(Format::Hex, &line[..line.len() - 1]), line.rfind(' ').unwrap() + 2);
    assert_eq!(column(Format::Hex, &format!("{line} 00")), line.len() + 2);
    assert_eq!(column(Format::Jsonl, "{\"in\": 1"), 8);
    // A mantissa of −2^23 is no legal input: blocks are symmetric.
    assert_eq!(column(Format::Hex, &line.replacen("000000", "800000", 1)), 1);
}

#[test]
fn declarations_hold_every_field_of_every_subject() {
    for subject in Subject::all() {
        let spec = UnitSpec::default();
        let own = harness(&spec, subject, Build::default()).unwrap();
        let shape = own.shape();
        for language in [Language::C, Language::Sv] {
            let text = declare(language, subject, shape, &spec);
            for field in shape.inputs.iter().chain(&shape.outputs) {
                assert!(text.contains(&field.identifier()), "{}", field.name);
            }
        }
    }
}
