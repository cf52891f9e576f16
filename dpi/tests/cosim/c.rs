//! The C example, compiled against the header and the library, has the model's bits.
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};

use tapline::conformance::cases::{Schedule, fill};
use tapline::conformance::header::{Language, declare};
use tapline::conformance::subject::Subject;
use tapline::conformance::{Build, Device as _, harness};
use tapline::stage::Stage;
use tapline::unit::UnitSpec;

#[test]
fn a_c_program_gets_the_bits_of_the_model() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".into());
    let has_compiler = Command::new(&compiler).arg("--version").output().is_ok();
    let (true, Some(library)) = (has_compiler, crate::library()) else {
        eprintln!("not checked: no C compiler `{compiler}`, or no shared library beside the test");
        return;
    };
    let subject = Subject::Stage(Stage::Reflect);
    let mut own = harness(&UnitSpec::default(), subject, Build::default()).unwrap();
    let shape = own.shape().clone();
    let work = std::env::temp_dir().join(format!("tapline-dpi-{}", std::process::id()));
    std::fs::create_dir_all(&work).unwrap();
    let header = declare(Language::C, subject, &shape, &UnitSpec::default());
    std::fs::write(work.join("reflect.h"), header).unwrap();
    let program = work.join("reflect");
    let status = Command::new(&compiler)
        .args(["-std=c99", "-Wall", "-Wextra", "-Werror", "-I"])
        .arg(folder.join("include"))
        .arg("-I")
        .arg(&work)
        .arg(folder.join("examples/reflect.c"))
        .arg("-L")
        .arg(&library)
        .arg("-ltapline_dpi")
        .arg(format!("-Wl,-rpath,{}", library.display()))
        .arg("-o")
        .arg(&program)
        .status()
        .unwrap();
    assert!(status.success());

    let schedule = Schedule::new(&own, subject, 1, 4);
    let mut input = vec![0; shape.input_len()];
    let mut output = vec![0; shape.output_len()];
    let (mut lines, mut want) = (String::new(), String::new());
    let text = |numbers: &[i64]| {
        let words: Vec<String> = numbers.iter().map(i64::to_string).collect();
        words.join(" ") + "\n"
    };
    for k in (0..schedule.cases()).step_by(7) {
        fill(&mut own, subject, schedule.place(k), &mut input);
        own.run(&input, &mut output);
        lines += &text(&input);
        want += &text(&output);
    }
    let mut child =
        Command::new(&program).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let feeder = std::thread::spawn(move || stdin.write_all(lines.as_bytes()).unwrap());
    let ran = child.wait_with_output().unwrap();
    feeder.join().unwrap();
    std::fs::remove_dir_all(&work).unwrap();
    assert!(ran.status.success());
    assert!(want.lines().count() > 100 && want.bytes().any(|b| b != b'0'));
    assert_eq!(String::from_utf8(ran.stdout).unwrap(), want);
}

#[test]
fn wrong_calls_are_words_and_not_crashes() {
    use std::ffi::CStr;
    let open = |subject: &CStr| {
        // SAFETY: strings that end with a zero byte.
        unsafe { tapline_dpi::tapline_open(subject.as_ptr(), std::ptr::null(), 0, 8) }
    };
    let words = || {
        // SAFETY: the library's own string.
        unsafe { CStr::from_ptr(tapline_dpi::tapline_error()) }.to_str().unwrap().to_string()
    };
    assert!(open(c"nothing").is_null());
    assert!(words().contains("local_frame"), "{}", words());
    let bench = open(c"bump");
    assert!(!bench.is_null());
    // SAFETY: an open bench, one thread.
    unsafe {
        assert_eq!(tapline_dpi::tapline_eval(bench), 0);
        tapline_dpi::tapline_set(bench, 0, i64::MAX);
        assert_eq!(tapline_dpi::tapline_eval(bench), -1);
        assert!(words().contains("input 0"), "{}", words());
        tapline_dpi::tapline_set(bench, -1, 3);
        assert_eq!(tapline_dpi::tapline_get(bench, 100_000), 0);
        tapline_dpi::tapline_close(bench);
        assert_eq!(tapline_dpi::tapline_eval(std::ptr::null_mut()), -1);
        assert_eq!(tapline_dpi::tapline_inputs(std::ptr::null()), 0);
        tapline_dpi::tapline_close(std::ptr::null_mut());
    }
}
