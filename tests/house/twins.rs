//! A stage has one name everywhere: the enum, the model, the reference and the documents agree.

use std::collections::BTreeSet;
use support::house;

use tapline::stage::Stage;

/// The names of the stages that have a file in a folder. Helpers are no stages; what lies in a
/// folder of its own, `<stage>/part.rs`, belongs to that stage.
fn named(folder: &str, extension: &str, helpers: &[&str]) -> BTreeSet<String> {
    let folder = house::root(folder);
    let names = house::files(&folder, extension).into_iter().map(|path| {
        let inside = path.strip_prefix(&folder).expect("found below the folder");
        let first = inside.components().next().expect("a file has a name");
        let first = std::path::Path::new(first.as_os_str());
        first.with_extension("").display().to_string()
    });
    names.filter(|name| !helpers.contains(&name.as_str())).collect()
}

/// What is missing and what is too much, or nothing.
fn differences(expected: &BTreeSet<String>, found: &BTreeSet<String>) -> Vec<String> {
    let missing = expected.difference(found).map(|name| format!("missing {name}"));
    let extra = found.difference(expected).map(|name| format!("extra {name}"));
    missing.chain(extra).collect()
}

fn stages() -> BTreeSet<String> {
    Stage::ALL.iter().map(|stage| stage.name().to_owned()).collect()
}

#[test]
fn every_stage_has_its_file_in_the_model_the_reference_and_the_documents() {
    // (folder, extension, files there that are no stages)
    let places: [(&str, &str, &[&str]); 4] = [
        ("rtl_model/src/stages", "rs", &[]),
        (
            "src/gpu/shaders",
            "wgsl",
            &["policy", "vector", "cube", "texture", "planar", "distances", "kernels"],
        ),
        (
            "src/reference",
            "rs",
            &[
                "mod",
                "angle",
                "distances",
                "env",
                "ewa",
                "flags",
                "planar",
                "prepared",
                "real",
                "tap",
                "tex",
                "texture",
                "vector",
                "weights",
                "wide",
            ],
        ),
        ("docs/stages", "md", &["README"]),
    ];
    let mut problems = Vec::new();
    for (folder, extension, helpers) in places {
        for difference in differences(&stages(), &named(folder, extension, helpers)) {
            problems.push(format!("{folder}: {difference}.{extension}"));
        }
    }
    assert!(problems.is_empty(), "twins differ:\n{}", problems.join("\n"));
}

#[test]
fn every_stage_file_defines_a_function_of_its_own_name() {
    let mut problems = Vec::new();
    for folder in ["rtl_model/src/stages", "src/reference"] {
        for name in stages() {
            let path = house::root(folder).join(format!("{name}.rs"));
            let text = house::read(&path);
            let defined = [format!("fn {name}("), format!("fn {name}<")];
            if !defined.iter().any(|start| text.contains(start)) {
                problems.push(format!("{folder}/{name}.rs has no fn {name}"));
            }
        }
    }
    // `filter` is a reserved word of WGSL: its two forms say what they read.
    for name in stages() {
        let path = house::root("src/gpu/shaders").join(format!("{name}.wgsl"));
        let text = house::read(&path);
        let function = if name == "filter" { "filter_cube" } else { &name };
        if !text.contains(&format!("\nfn {function}(")) {
            problems.push(format!("src/gpu/shaders/{name}.wgsl has no fn {function}"));
        }
    }
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

#[test]
fn every_page_of_a_stage_links_its_three_twins() {
    let mut problems = Vec::new();
    for name in stages() {
        let page = house::read(&house::root("docs/stages").join(format!("{name}.md")));
        for twin in [
            format!("../../rtl_model/src/stages/{name}.rs"),
            format!("../../src/reference/{name}.rs"),
            format!("../../src/gpu/shaders/{name}.wgsl"),
        ] {
            if !page.contains(&format!("({twin})")) {
                problems.push(format!("docs/stages/{name}.md has no link to {twin}"));
            }
        }
    }
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

#[test]
fn the_list_of_stages_has_each_stage_once_and_in_pipeline_order() {
    assert_eq!(stages().len(), Stage::ALL.len());
    assert!(Stage::ALL.is_sorted());
}

#[test]
fn the_comparison_names_what_is_missing_and_what_is_extra() {
    let set = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect();
    let found = differences(&set(&["bump", "eigen"]), &set(&["eigen", "frobnicate"]));
    assert_eq!(found, ["missing bump", "extra frobnicate"]);
    assert!(differences(&set(&["bump"]), &set(&["bump"])).is_empty());
}
