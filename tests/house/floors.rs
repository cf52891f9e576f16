//! The floors of docs/architecture.md: each part knows only what lies below it, and nothing that its row forbids.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::code::code_only;
use super::markdown::{quoted, rows};
use support::house;

/// A row of the table of parts.
#[derive(Debug)]
struct Row {
    floor: u32,
    forbidden: BTreeSet<String>,
}

/// The parts of `src`, by name, from the table whose rows start with a floor's number.
fn table(markdown: &str) -> BTreeMap<String, Row> {
    let mut parts = BTreeMap::new();
    for row in rows(markdown) {
        let [floor, names, _, forbidden] = &row[..] else { continue };
        let Ok(floor) = floor.parse() else { continue };
        for path in quoted(names) {
            let Some(name) = path.strip_prefix("src/") else { continue };
            let name = name.trim_end_matches(".rs").to_owned();
            let forbidden = quoted(forbidden).into_iter().map(str::to_owned).collect();
            let before = parts.insert(name, Row { floor, forbidden });
            assert!(before.is_none(), "{path} stands in two rows");
        }
    }
    parts
}

/// The first names of all paths of a source that start with `crate::`.
fn imports(code: &str) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for (at, start) in code.match_indices("crate::") {
        let rest = &code[at + start.len()..];
        let Some(group) = rest.strip_prefix('{') else {
            names.extend(first_name(rest));
            continue;
        };
        let (mut depth, mut begin) = (0usize, true);
        for (at, c) in group.char_indices() {
            match c {
                '{' => depth += 1,
                '}' if depth == 0 => break,
                '}' => depth -= 1,
                ',' if depth == 0 => begin = true,
                _ if begin && !c.is_whitespace() => {
                    names.extend(first_name(&group[at..]));
                    begin = false;
                }
                _ => {}
            }
        }
    }
    names
}

/// The name that a text starts with.
fn first_name(text: &str) -> Option<String> {
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len());
    (end > 0).then(|| text[..end].to_owned())
}

/// Whether a source names a crate in a path.
fn names_crate(code: &str, name: &str) -> bool {
    let path = format!("{name}::");
    code.match_indices(&path).any(|(at, _)| {
        let before = code[..at].chars().next_back();
        !before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == ':')
    })
}

/// What is wrong with the imports of one file.
fn problems(part: &str, code: &str, table: &BTreeMap<String, Row>) -> Vec<String> {
    let Some(row) = table.get(part) else {
        return vec!["is in no row of docs/architecture.md".to_owned()];
    };
    let imports = imports(code);
    let floor = |name: &str| table.get(name).map(|other| other.floor);
    let up = imports.iter().filter(|name| *name != part && floor(name) >= Some(row.floor));
    let up = up.map(|name| format!("imports {name}, which is not below it"));
    let forbidden = row.forbidden.iter();
    let forbidden = forbidden.filter(|name| imports.contains(*name) || names_crate(code, name));
    up.chain(forbidden.map(|name| format!("imports {name}, which its row forbids"))).collect()
}

/// The part that a file of `src` belongs to; the crate's own two files stand above all.
fn part(inside: &Path) -> Option<String> {
    let first = Path::new(inside.components().next()?.as_os_str());
    let name = first.with_extension("").display().to_string();
    (!["lib", "main"].contains(&name.as_str())).then_some(name)
}

#[test]
fn no_part_imports_what_is_not_on_a_lower_floor_or_what_its_row_forbids() {
    let table = table(&house::read(&house::root("docs/architecture.md")));
    let src = house::root("src");
    let mut found = Vec::new();
    let mut seen = BTreeSet::new();
    for path in house::files(&src, "rs") {
        let inside = path.strip_prefix(&src).expect("found below the folder");
        let Some(part) = part(inside) else { continue };
        for problem in problems(&part, &code_only(&house::read(&path)), &table) {
            found.push(format!("src/{}: {problem}", inside.display()));
        }
        seen.insert(part);
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
    let gone: Vec<_> = table.keys().filter(|name| !seen.contains(*name)).collect();
    assert!(gone.is_empty(), "docs/architecture.md has rows without a file: {gone:?}");
}

#[test]
fn an_arrow_up_a_circle_and_a_forbidden_crate_are_found() {
    let table = table(
        "| floor | part | knows | does not know |\n|--:|---|---|---|\n\
         | 0 | `model` | integers | floats |\n\
         | 1 | `src/base` `src/cube.rs` | numbers | anything |\n\
         | 2 | `src/mesh` | files | `serde_json`, `cube` |\n\
         | 2 | `src/scene` | all | engines |\n",
    );
    assert_eq!(table.keys().collect::<Vec<_>>(), ["base", "cube", "mesh", "scene"]);
    let count = |part: &str, code: &str| problems(part, code, &table).len();
    for (part, code) in [
        ("base", "use crate::mesh::Mesh;"),
        ("base", "use crate::cube::Cube;"),
        ("mesh", "fn f(x: crate::scene::Scene) {}"),
        ("mesh", "use crate::{base::num, scene::{a, b}};"),
        ("mesh", "use crate::cube::Cube;"),
        ("mesh", "let x = serde_json::Value::Null;"),
        ("cellar", ""),
    ] {
        assert_eq!(count(part, code), 1, "{part}: {code}");
    }
    for (part, code) in [
        ("mesh", "use crate::base::{num, scene};"),
        ("mesh", "use crate::mesh::part; use my_serde_json::x; use a::serde_json::x;"),
        ("scene", "use crate::{base, cube::{self, mesh}};"),
    ] {
        assert_eq!(count(part, code), 0, "{part}: {code}");
    }
}
