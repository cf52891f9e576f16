//! The packages of `vectors header` before the tools that read them: Verilator's lints, Icarus, Yosys.

use std::path::Path;
use std::process::Command;

use tapline::conformance::header::{Language, declare};
use tapline::conformance::subject::Subject;
use tapline::conformance::{Build, Device as _, harness};
use tapline::unit::UnitSpec;

/// Whether a tool is there. `TAPLINE_REQUIRE_SV=1`, as in CI, makes a missing one a failure.
fn has(tool: &str) -> bool {
    let found = Command::new(tool).arg("-V").output().is_ok();
    let required = std::env::var("TAPLINE_REQUIRE_SV").is_ok_and(|value| value == "1");
    assert!(found || !required, "`{tool}` is missing: apt-get install verilator iverilog yosys");
    if !found {
        eprintln!("not checked: no `{tool}`");
    }
    found
}

/// Runs a tool that must accept its files and say nothing.
fn accepts(folder: &Path, tool: &str, args: &[&str]) {
    let ran = Command::new(tool).args(args).current_dir(folder).output().unwrap();
    let said = [ran.stdout, ran.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
    assert!(ran.status.success() && said.concat().trim().is_empty(), "{tool} {args:?}: {said:?}");
}

#[test]
fn packages_of_every_subject_are_read_together_by_verilator_icarus_and_yosys() {
    let narrow = UnitSpec::default().with("registers.jacobian.d.frac=20").unwrap();
    let floor = narrow.clone().with("registers.eigen.root.rounding=floor").unwrap();
    for spec in [UnitSpec::default(), UnitSpec::preset("schilling").unwrap(), floor] {
        let folder = tempfile::tempdir().unwrap();
        let mut files = Vec::new();
        // Every package at once in one scope: no name may be in two of them.
        let mut imports = String::new();
        let mut uses = String::new();
        for subject in Subject::all() {
            let own = harness(&spec, subject, Build::default()).unwrap();
            let name = subject.name().replace('-', "_");
            let file = format!("tapline_{name}_pkg.sv");
            let text = declare(Language::Sv, subject, own.shape(), &spec);
            std::fs::write(folder.path().join(&file), text).unwrap();
            files.push(file);
            imports += &format!("  import tapline_{name}_pkg::*;\n");
            let bits = format!("{}_VECTOR_BITS", name.to_uppercase());
            uses +=
                &format!("  initial if ($bits({name}_vector_t) != {bits}) $display(\"{name}\");\n");
        }
        let top = format!("module top;\n{imports}{uses}endmodule\n");
        std::fs::write(folder.path().join("top.sv"), top).unwrap();
        files.push("top.sv".into());
        let files: Vec<&str> = files.iter().map(String::as_str).collect();
        if has("verilator") {
            accepts(folder.path(), "verilator", &[&["--lint-only", "-Wall"], &files[..]].concat());
        }
        if has("iverilog") {
            accepts(folder.path(), "iverilog", &[&["-g2012", "-o", "top"], &files[..]].concat());
            accepts(folder.path(), "./top", &[]);
        }
        if has("yosys") {
            for file in &files[..files.len() - 1] {
                let script = format!("read_verilog -sv {file}");
                accepts(folder.path(), "yosys", &["-q", "-p", &script]);
            }
        }
    }
}

/// The vectors of `vectors gen` in the example's test bench.
#[cfg(feature = "files")]
#[test]
fn the_example_test_bench_passes_on_vectors_of_reflect() {
    use tapline::conformance::text::{Format, Header, line};
    use tapline::{Vector, vectors};

    if !has("verilator") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("dpi/examples");
    for file in ["n_dot_v.sv", "n_dot_v_tb.sv"] {
        std::fs::copy(examples.join(file), folder.path().join(file)).unwrap();
    }
    let unit = UnitSpec::default();
    let subject = Subject::parse("reflect").unwrap();
    let cases = vectors(&unit, "reflect", 1).unwrap().with_cases(400);
    let shape = cases.shape().clone();
    let package = declare(Language::Sv, subject, &shape, &unit);
    std::fs::write(folder.path().join("tapline_reflect_pkg.sv"), package).unwrap();
    let build = Build::default();
    let header = Header { subject, unit: unit.hash(), build, level: 1, seed: 1, count: 400 };
    let mut text = header.text(&shape, Format::Readmemh);
    for Vector { input, output } in cases {
        text += &line(&shape, Format::Readmemh, &input, &output);
        text.push('\n');
    }
    std::fs::write(folder.path().join("reflect.hex"), text).unwrap();
    let files = ["tapline_reflect_pkg.sv", "n_dot_v.sv", "n_dot_v_tb.sv"];
    let options = ["--binary", "-Wall", "--top-module", "n_dot_v_tb"];
    let built = Command::new("verilator")
        .args([&options[..], &files].concat())
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(built.status.success() && built.stderr.is_empty(), "{built:?}");
    let ran = Command::new(folder.path().join("obj_dir/Vn_dot_v_tb"))
        .current_dir(folder.path())
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&ran.stdout);
    assert!(ran.status.success() && said.contains("400 vectors, 0 wrong"), "{said}");
}
