//! A test program links the whole library, so there are few of them.

use support::house;

#[test]
fn every_test_lies_in_the_folder_of_a_program() {
    for tests in ["tests", "rtl_model/tests", "dpi/tests"] {
        let tests = house::root(tests);
        let loose = house::files(&tests, "rs").into_iter().filter(|path| {
            let folder = path.parent().expect("below the root");
            folder == tests
        });
        let loose: Vec<_> = loose.collect();
        assert!(loose.is_empty(), "a program each, put them into a folder's main.rs: {loose:?}");
    }
}

#[test]
fn every_program_stands_in_the_document_and_every_file_belongs_to_one() {
    let page = house::read(&house::root("docs/testing.md"));
    let tests = house::root("tests");
    let mut programs = 0;
    for path in house::files(&tests, "rs") {
        let inside = path.strip_prefix(&tests).expect("found below the folder");
        let name = path.file_stem().expect("a file has a name").to_string_lossy();
        let folder = path.parent().expect("below the root");
        if name == "main" {
            programs += 1;
            let row = format!("\n| `{}` |", folder.file_name().expect("named").to_string_lossy());
            assert!(page.contains(&row), "docs/testing.md has no row{row}");
        } else if name != "lib" {
            // `a/b.rs` is declared by `a/main.rs`, `a/b/mod.rs` by the file above it.
            let (module, above) = match &*name {
                "mod" => (folder.file_name().map(|n| n.to_string_lossy()), folder.parent()),
                _ => (Some(name), Some(folder)),
            };
            let (module, above) = (module.expect("named"), above.expect("below the root"));
            let parents = ["main.rs", "mod.rs", "lib.rs"].map(|file| above.join(file));
            let parent = parents.iter().find(|file| file.is_file());
            let parent = parent.unwrap_or_else(|| panic!("{}: no program", inside.display()));
            let declared = house::read(parent).contains(&format!("mod {module};"));
            assert!(declared, "{} is not compiled", inside.display());
        }
    }
    assert!(programs >= 8, "only {programs} programs found");
}
