//! Committed results: compared as text, written only on demand.
//!
//! `TAPLINE_BLESS=1` writes them, and the run that writes fails, so that nothing goes green by
//! writing what it should check.

use std::fs;
use std::path::Path;

use crate::house::root;

/// The variable that asks for writing.
pub const BLESS: &str = "TAPLINE_BLESS";

/// The largest golden, in bytes: a person reads the difference of two.
const LARGEST: usize = 64 << 10;

/// Compares a text with the golden `tests/golden/<name>`, or writes it.
///
/// Lines end in \n on every system. Panics with the first line that differs.
pub fn check(name: &str, actual: &str) {
    let path = root("tests/golden").join(name);
    if let Err(message) = compare(&path, actual, std::env::var_os(BLESS).is_some()) {
        panic!("{message}");
    }
}

/// The comparison itself, with what should be said about a difference.
pub fn compare(path: &Path, actual: &str, bless: bool) -> Result<(), String> {
    let shown = path.display();
    if actual.is_empty() || actual.len() > LARGEST {
        return Err(format!("{shown}: {} bytes, a golden has 1 to {LARGEST}", actual.len()));
    }
    if bless {
        fs::write(path, actual).map_err(|error| format!("{shown}: {error}"))?;
        return Err(format!("{shown}: written; run again without {BLESS}"));
    }
    let accept = format!("if the new result is right: {BLESS}=1, see docs/testing.md");
    let expected =
        fs::read_to_string(path).map_err(|error| format!("{shown}: {error}; {accept}"))?;
    let expected = expected.replace("\r\n", "\n");
    if expected == actual {
        return Ok(());
    }
    let (mut old, mut new) = (expected.lines(), actual.lines());
    let mut line = 1;
    loop {
        match (old.next(), new.next()) {
            (a, b) if a == b && a.is_some() => line += 1,
            (a, b) => {
                let text = |side: Option<&str>| side.unwrap_or("(end)").to_owned();
                let (a, b) = (text(a), text(b));
                return Err(format!("{shown}:{line}\nexpected {a}\nfound    {b}\n{accept}"));
            }
        }
    }
}
