//! No floating-point value, literal or type in the integer model, and none hidden from the lints.
//!
//! Clippy's lints miss expressions that consist of literals only; this scan of the sources sees
//! the words `f16 f32 f64 f128` and decimal literals anywhere outside comments and strings.

use super::code::code_only;
use support::house;
/// The floating-point words and literals of a source, each with its line number.
fn floats(source: &str) -> Vec<(usize, String)> {
    let code = code_only(source);
    let mut found = Vec::new();
    for (line, text) in code.lines().enumerate() {
        for word in words(text) {
            if is_float(&word) {
                found.push((line + 1, word));
            }
        }
    }
    found
}

/// Maximal runs of letters, digits, `_`, and points that belong to a number.
///
/// A point belongs to a number after digits unless a second point (a range), a letter (a method of
/// an integer) or `_` follows; after `word.` (a tuple's field, `pair.0.1`) numbers are fields.
fn words(text: &str) -> Vec<String> {
    let chars: Vec<char> = text.chars().collect();
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let (mut out, mut at) = (Vec::new(), 0);
    while at < chars.len() {
        if !is_word(chars[at]) {
            at += 1;
            continue;
        }
        let start = at;
        let field = start > 0 && chars[start - 1] == '.' && !(start > 1 && chars[start - 2] == '.');
        while at < chars.len() && is_word(chars[at]) {
            at += 1;
        }
        let number = chars[start].is_ascii_digit() && !field;
        let after = chars.get(at + 1).copied();
        if number
            && chars.get(at) == Some(&'.')
            && !after.is_some_and(|c| c == '.' || c.is_alphabetic() || c == '_')
        {
            at += 1;
            while at < chars.len() && is_word(chars[at]) {
                at += 1;
            }
        }
        // The sign of an exponent ends the run (1e-3): the part before it, `1e`, is enough.
        if !(field && chars[start].is_ascii_digit()) {
            out.push(chars[start..at].iter().collect());
        }
    }
    out
}

fn is_float(word: &str) -> bool {
    let types = ["f16", "f32", "f64", "f128"];
    if types.contains(&word) {
        return true;
    }
    if !word.starts_with(|c: char| c.is_ascii_digit()) {
        return false;
    }
    let radix = ["0x", "0b", "0o"].iter().any(|prefix| word.starts_with(prefix));
    let suffixed = types.iter().any(|suffix| word.ends_with(suffix));
    !radix && (suffixed || word.contains(['.', 'e', 'E']) && !ends_in_size(word))
}

/// `usize` and `isize` hold an e: 7usize is an integer.
fn ends_in_size(word: &str) -> bool {
    ["usize", "isize"].iter().any(|suffix| word.ends_with(suffix))
}

#[test]
fn the_integer_model_has_no_floating_point_word_or_literal() {
    let sources = house::files(&house::root("rtl_model/src"), "rs");
    assert!(sources.len() >= 2, "the scan found no sources: {sources:?}");
    let mut problems = Vec::new();
    for path in sources {
        for (line, word) in floats(&house::read(&path)) {
            problems.push(format!("{}:{line}: {word}", path.display()));
        }
    }
    assert!(problems.is_empty(), "floats in the integer model:\n{}", problems.join("\n"));
}

#[test]
fn the_scan_finds_every_form_of_a_float() {
    for bad in [
        "let x: f32 = y;",
        "fn g(x: f64) {}",
        "x as f64",
        "const HALF: f16 = h;",
        "f64::from(1)",
        "1.0",
        "let x = 1.;",
        "let x = [1., 2];",
        "1e5",
        "1E5",
        "1e-3",
        "2.5e+3",
        "1_000.5",
        "3f32",
        "3_f64",
        "0.5f32",
        "f(0.25)",
        "x * 1.5 // half as much again",
        "let c = '\"'; let x = 0.5; // \"",
        "let s = \"a\\\"b\"; let x = 0.5;",
        "let s = r#\"a\"b\"#; let x = 0.5;",
        "/* a /* b */ c */ let x = 0.5;",
        "fn f<'a>(s: &'a str) { let x = 0.5; }",
        "let c = '\\''; let x = 0.5;",
        "..0.5",
        "0..1.5",
    ] {
        assert!(!floats(bad).is_empty(), "missed in: {bad}");
    }
}

#[test]
fn the_scan_leaves_integers_comments_and_strings_alone() {
    for good in [
        "let x = 0..10; let y = 0..=10; let z = 1..;",
        "pair.0.1 + tuple.0",
        "self.table[3].1",
        "0xf32 + 0b1 + 0o7 + 0x1e5",
        "7usize + 9isize + 1_000u64",
        "1.max(2)",
        "let f32x = of64; // f32 and 1.5 here",
        "//! rounds 0.5 to 1.0 as f64 would",
        "/* 0.5 /* f32 */ 1.5 */",
        "\"0.5 f64 \\\" 1.5\"",
        "r\"0.5\" r#\"f32 \" 1.5\"# b\"1.5\"",
        "let c = '.'; let q = '\\''; let d = '\\u{1F600}';",
        "fn f<'f64_like>(x: &'f64_like str) {}",
        "version_1e5",
    ] {
        assert!(floats(good).is_empty(), "{:?} found in: {good}", floats(good));
    }
}

#[test]
fn the_scan_names_the_line() {
    assert_eq!(floats("/* a\nb */\nlet x = 0.5;"), [(3, "0.5".to_owned())]);
}
