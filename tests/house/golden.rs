//! The comparison with goldens is itself tested.

use std::fs;
use support::golden;

#[test]
fn a_golden_passes_fails_and_is_written_as_the_documents_say() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("hashes.txt");
    let said = |actual: &str, bless| golden::compare(&path, actual, bless).unwrap_err();

    assert!(said("a\n", false).contains(golden::BLESS), "missing: says how to write it");
    assert!(said("a\nb\n", true).contains("written"), "a writing run fails");
    assert_eq!(golden::compare(&path, "a\nb\n", false), Ok(()));
    let changed = said("a\nc\n", false);
    assert!(changed.contains(":2\nexpected b\nfound    c\n"), "{changed}");
    assert!(said("a\nb\nc\n", false).contains("expected (end)"));
    assert!(said("a\n", false).contains("found    (end)"));

    fs::write(&path, "a\r\nb\r\n").unwrap();
    assert_eq!(golden::compare(&path, "a\nb\n", false), Ok(()), "other line ends");
    assert!(said("a\nb", false).contains("(end)"), "a missing last line end");
    assert!(said("", true).contains("0 bytes"));
    assert!(said(&"x".repeat(70_000), true).contains("70000 bytes"));
    assert!(fs::read_to_string(&path).unwrap().starts_with('a'), "refused texts are not written");
}

#[test]
#[should_panic(expected = "tests/golden")]
fn a_golden_that_nobody_committed_fails() {
    golden::check("no-such-golden.txt", "x\n");
}
