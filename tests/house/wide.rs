//! What runs under wide vector instructions is compiled for them: no function of the model that they call is not.

use std::path::PathBuf;
use std::process::Command;

/// The release binary beside the folder of this test; none where it was not built, or before the model's sources.
fn release() -> Option<PathBuf> {
    let binary = std::env::current_exe().ok()?.ancestors().nth(3)?.join("release/tapline");
    let built = binary.metadata().ok()?.modified().ok()?;
    let changed = |path: &str| support::house::root(path).metadata().ok()?.modified().ok();
    let newest = ["rtl_model/src/lanes.rs", "rtl_model/src/unit/run.rs", "crates/lanes/src/lib.rs"];
    newest.iter().all(|path| changed(path).is_some_and(|at| at < built)).then_some(binary)
}

#[test]
fn wide_code_calls_no_function_of_the_model_that_is_compiled_for_the_baseline() {
    let disassembly = release().and_then(|binary| {
        Command::new("objdump").args(["-d", "-C", "--no-show-raw-insn"]).arg(binary).output().ok()
    });
    let Some(disassembly) = disassembly.filter(|out| out.status.success()) else {
        eprintln!("skipped: needs objdump and a release binary that is newer than the model");
        return;
    };
    let text = String::from_utf8_lossy(&disassembly.stdout);
    let (mut wide, mut functions, mut wrong) = (false, 0, Vec::new());
    for line in text.lines() {
        if let Some(name) = line.strip_suffix(">:") {
            wide = name.contains("run_avx2") || name.contains("run_avx512");
            functions += u32::from(wide);
        } else if wide && let Some((_, named)) = line.split_once('<') {
            // Jumps within a function name it. Lanes that left the plain case and probes that left their face run one
            // by one.
            let right = ["run_avx", "one_by_one", "write_seldom", "other_face"];
            let of_model = named.contains("rtl_model::") || named.contains("lanes::");
            if of_model && !right.iter().any(|name| named.contains(name)) {
                wrong.push(named.trim_end_matches('>').to_owned());
            }
        }
    }
    wrong.sort();
    wrong.dedup();
    assert!(functions > 20, "{functions} wide functions: inlined, or named otherwise");
    assert!(wrong.is_empty(), "called from wide code:\n{}", wrong.join("\n"));
}
