//! Every slip that docs/errata.md lists names the test that proves it, and that test exists.
//!
//! The last cell of each row of a table has the names between backticks. A row that belongs to
//! a stage which is not built yet says instead: no test yet, `stage`.

use super::markdown::{quoted, rows};
use std::collections::BTreeSet;
use support::house;

use tapline::stage::Stage;

/// Names of the functions that carry `#[test]`, also inside proptest!'s braces.
fn tests_in(source: &str) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    let mut armed = false;
    for line in source.lines().map(str::trim) {
        if line == "#[test]" {
            armed = true;
        } else if armed && !line.starts_with("#[") {
            let name = line.strip_prefix("fn ").and_then(|rest| rest.split('(').next());
            names.extend(name.map(str::to_owned));
            armed = name.is_none() && line.starts_with("//");
        }
    }
    names
}

/// What is wrong with a row, if anything.
fn problem(row: &[String], tests: &BTreeSet<String>) -> Option<String> {
    let last = row.last().map_or("", String::as_str);
    let names = quoted(last);
    if last.starts_with("no test yet") {
        let built = |name: &&str| Stage::ALL.iter().any(|stage| stage.name() == *name);
        return match names.iter().find(|name| built(name)) {
            Some(name) => Some(format!("stage {name} is built, the row needs its test")),
            None if names.is_empty() => Some("names no stage that is still to come".to_owned()),
            None => None,
        };
    }
    if names.is_empty() {
        return Some("names no test".to_owned());
    }
    let unknown = names.iter().find(|name| !tests.contains(**name))?;
    Some(format!("there is no test {unknown}"))
}

#[test]
fn every_row_of_the_errata_names_a_test_that_exists() {
    let mut tests = BTreeSet::new();
    for folder in ["src", "tests", "rtl_model"] {
        for path in house::files(&house::root(folder), "rs") {
            tests.extend(tests_in(&house::read(&path)));
        }
    }
    let rows = rows(&house::read(&house::root("docs/errata.md")));
    // The paper's slips that were known when the unit was specified.
    assert!(rows.len() >= 15, "only {} rows found", rows.len());
    let problems: Vec<String> = rows
        .iter()
        .filter_map(|row| problem(row, &tests).map(|what| format!("{}: {what}", row[0])))
        .collect();
    assert!(problems.is_empty(), "docs/errata.md:\n{}", problems.join("\n"));
}

#[test]
fn rows_without_a_proof_are_found() {
    let source = "#[test]\nfn k_is_d_dt() {}\n#[test]\n#[ignore]\nfn slow() {}\nfn helper() {}";
    let tests = tests_in(source);
    assert_eq!(tests, ["k_is_d_dt", "slow"].map(str::to_owned).into());
    let table = "| says | right | proof |\n|:---|---|---|\n\
                 | a | b | `k_is_d_dt` and `slow` |\n\
                 | \\|l\\| | b | `helper` |\n\
                 | c | d | believe me |\n\
                 | e | f | no test yet: `caustics` |\n\
                 | g | h | no test yet: `eigen` |\n\
                 | i | j | no test yet |\n";
    let rows = rows(table);
    let found: Vec<bool> = rows.iter().map(|row| problem(row, &tests).is_some()).collect();
    assert_eq!(found, [false, true, true, false, true, true]);
    assert_eq!(rows[1][0], "|l|");
}
