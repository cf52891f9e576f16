//! The changelog keeps its promise about changed bits.

use support::house;
/// The versions' headings, each with the text below it.
fn versions(text: &str) -> Vec<(&str, &str)> {
    let parts = text.split("\n## [").skip(1);
    parts.filter_map(|part| part.split_once(']')).collect()
}

#[test]
fn every_version_says_which_bits_changed() {
    let text = house::read(&house::root("CHANGELOG.md"));
    let versions = versions(&text);
    assert!(!versions.is_empty(), "no version found");
    for (version, body) in versions {
        let (_, below) = body
            .split_once("### Bit-visible\n")
            .unwrap_or_else(|| panic!("version {version} has no heading Bit-visible"));
        let list = below.split("\n#").next().unwrap_or("").trim();
        assert!(!list.is_empty(), "version {version}: say \"Nothing.\" or what changed");
    }
}

#[test]
fn the_citation_names_the_packages_version() {
    let citation = house::read(&house::root("CITATION.cff"));
    let version = format!("\nversion: {}\n", env!("CARGO_PKG_VERSION"));
    assert!(citation.contains(&version), "CITATION.cff should have{version}");
}
