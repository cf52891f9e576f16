//! The SystemVerilog example, compiled with Verilator: a register in RTL in lockstep with the model.
use std::path::Path;
use std::process::Command;

use tapline::Unit;
use tapline::conformance::header::{Language, declare};
use tapline::conformance::subject::Subject;
use tapline::conformance::{Build, Device as _, harness};
use tapline::stage::Stage;

/// Whether Verilator is there. `TAPLINE_REQUIRE_SV=1`, as in CI, makes a missing one a failure.
fn has_verilator() -> bool {
    let found = Command::new("verilator").arg("--version").output().is_ok();
    let required = std::env::var("TAPLINE_REQUIRE_SV").is_ok_and(|value| value == "1");
    assert!(found || !required, "`verilator` is missing: apt-get install verilator");
    found
}

/// Lints, builds and runs a test bench of `n_dot_v`; whether it passed, and what it printed.
fn run(
    (folder, library): (&Path, &Path),
    design: &str,
    bench: &str,
    with: &[&str],
) -> (bool, String) {
    std::fs::write(folder.join("n_dot_v.sv"), design).unwrap();
    let files = ["tapline_dpi_pkg.sv", "tapline_reflect_pkg.sv", "n_dot_v.sv"];
    let built = Command::new("verilator")
        .args(["--binary", "-Wall", "-Wno-MULTITOP"])
        .args(files)
        .arg(format!("{bench}.sv"))
        .args(["--top-module", bench, "--Mdir", bench, "-LDFLAGS"])
        .arg(format!("-L{} -ltapline_dpi -Wl,-rpath,{0}", library.display()))
        .current_dir(folder)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&built.stderr).into_owned();
    assert!(built.status.success() && said.is_empty(), "{said}");
    let program = folder.join(bench).join(format!("V{bench}"));
    let ran = Command::new(program).args(with).current_dir(folder).output().unwrap();
    (ran.status.success(), String::from_utf8_lossy(&ran.stdout).into_owned())
}

#[test]
fn the_lockstep_example_is_lint_clean_passes_and_notices_a_wrong_rounding() {
    let (true, Some(library)) = (has_verilator(), crate::library()) else {
        eprintln!("not checked: no `verilator`, or no shared library beside the test");
        return;
    };
    let dpi = Path::new(env!("CARGO_MANIFEST_DIR"));
    let work = std::env::temp_dir().join(format!("tapline-dpi-sv-{}", std::process::id()));
    std::fs::create_dir_all(&work).unwrap();
    for file in
        ["include/tapline_dpi_pkg.sv", "examples/n_dot_v_tb.sv", "examples/n_dot_v_dpi_tb.sv"]
    {
        let from = dpi.join(file);
        std::fs::copy(&from, work.join(from.file_name().unwrap())).unwrap();
    }
    let unit = Unit::default();
    let subject = Subject::Stage(Stage::Reflect);
    let model = harness(&unit, subject, Build::default()).unwrap();
    let package = declare(Language::Sv, subject, model.shape(), &unit);
    std::fs::write(work.join("tapline_reflect_pkg.sv"), package).unwrap();

    let right = std::fs::read_to_string(dpi.join("examples/n_dot_v.sv")).unwrap();
    let (passed, said) = run((&work, &library), &right, "n_dot_v_dpi_tb", &["+cases=100000"]);
    assert!(passed && said.contains("100000 cases, 0 wrong"), "{said}");
    // Half up in place of half to even: only ties tell.
    let wrong =
        right.replace("rest[Shift-1] && (rest[Shift-2:0] != 0 || kept[0])", "rest[Shift-1]");
    assert_ne!(wrong, right);
    let wrong = wrong
        .replace("module n_dot_v\n", "/* verilator lint_off UNUSEDSIGNAL */\nmodule n_dot_v\n");
    let (passed, said) = run((&work, &library), &wrong, "n_dot_v_dpi_tb", &["+cases=100000"]);
    assert!(!passed && said.contains("wrong"), "{said}");
    std::fs::remove_dir_all(&work).unwrap();
}
