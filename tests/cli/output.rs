//! Output files: whole or not at all, whatever ends the run.

use crate::run::{names, tapline, tapline_in};

#[test]
fn a_bad_output_path_fails_at_once_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("file"), "x").unwrap();
    // 16384x4096 pixels would take minutes.
    let big = ["--size", "16384x4096"];
    for args in [
        &["compare", "sphere", "--json", "none/x.json", "--out", "new/deep"][..],
        &["compare", "sphere", "--json", ".", "--out", "new"],
        &["compare", "sphere", "--out", "file"],
        &["compare", "sphere", "--out", "file/deep"],
        &["render", "sphere", "--engine", "rtl", "-o", "none/x.png"],
        &["render", "sphere", "--engine", "rtl", "-o", "."],
        &["render", "sphere", "--engine", "rtl", "-o", "x.jpg"],
        &["render", "sphere", "--engine", "rtl", "-o", ""],
    ] {
        let mut args = args.to_vec();
        args.extend(big);
        let ran = tapline_in(folder.path(), &args);
        ran.refused(&[]);
        assert!(!ran.stderr.contains(".tmp"), "{}", ran.stderr);
        assert_eq!(names(folder.path()), ["file"], "{args:?}");
    }
}

#[test]
fn a_run_that_fails_later_leaves_nothing_and_keeps_what_was_there() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("old")).unwrap();
    std::fs::write(folder.path().join("old/rtl.png"), "mine").unwrap();
    for out in ["old", "new/deep"] {
        tapline_in(
            folder.path(),
            &["compare", "sphere", "--env", "none.exr", "--out", out, "--json", "x.json"],
        )
        .refused(&["none.exr"]);
        tapline_in(folder.path(), &["compare", "nosuch", "--out", out]).refused(&["nosuch"]);
    }
    assert_eq!(names(folder.path()), ["old"]);
    assert_eq!(names(&folder.path().join("old")), ["rtl.png"]);
    assert_eq!(std::fs::read(folder.path().join("old/rtl.png")).unwrap(), b"mine");
}

#[test]
fn other_files_of_the_output_folder_stay() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("o");
    std::fs::create_dir(&out).unwrap();
    std::fs::write(out.join("notes.txt"), "mine").unwrap();
    let args = [
        "compare",
        "sphere",
        "--size",
        "8x8",
        "--engines",
        "rtl,f64",
        "--out",
        "o",
        "--json",
        "o/r.json",
    ];
    for _ in 0..2 {
        tapline_in(folder.path(), &args).done();
    }
    assert_eq!(
        names(&out),
        [
            "f64.exr",
            "f64.png",
            "notes.txt",
            "r.json",
            "report.html",
            "row.png",
            "rtl-f64.png",
            "rtl.exr",
            "rtl.png"
        ]
    );
    // The JSON file may lie in a folder that the run makes.
    let args = [
        "compare",
        "sphere",
        "--size",
        "8x8",
        "--engines",
        "rtl",
        "--out",
        "n/m",
        "--json",
        "n/m/r.json",
    ];
    tapline_in(folder.path(), &args).done();
    assert!(folder.path().join("n/m/r.json").exists());
}

#[test]
fn an_output_may_replace_its_own_input() {
    let folder = tempfile::tempdir().unwrap();
    let run = |args: &[&str]| tapline_in(folder.path(), args).done();
    run(&["render", "sphere", "--engine", "rtl", "--size", "32x16", "-o", "a.png"]);
    run(&[
        "render", "sphere", "--engine", "rtl", "--size", "32x16", "--env", "a.png", "-o", "a.png",
    ]);
    run(&["diff", "a.png", "a.png", "--out", "a.png"]);
    assert_eq!(names(folder.path()), ["a.png"]);
    tapline(&["unit", "check"]).done();
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_an_error_and_not_a_panic() {
    let full = || std::fs::File::options().write(true).open("/dev/full").unwrap();
    for args in [
        &["unit", "show"][..],
        &["scenes"],
        &["tables", "show", "log2"],
        &["scenes", "--json", "-"],
    ] {
        let output = crate::run::command().args(args).stdout(full()).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{args:?}");
        assert!(String::from_utf8_lossy(&output.stderr).contains("output: expected"));
    }
    tapline(&["scenes", "--json", "/dev/full"]).refused(&["/dev/full"]);
    let output = crate::run::command().args(["compare", "nosuch"]).stderr(full()).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
}

#[test]
#[cfg(unix)]
fn a_run_leaves_nothing_until_it_is_done_so_that_a_signal_may_end_it() {
    use std::time::Duration;
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("keep"), "x").unwrap();
    // This takes a minute.
    let mut child = crate::run::command()
        .args(["compare", "sphere", "--size", "2048x2048", "--out", "a/b", "--json", "a/b/r.json"])
        .current_dir(folder.path())
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    std::thread::sleep(Duration::from_secs(1));
    assert_eq!(names(folder.path()), ["keep"]);
    assert!(child.try_wait().unwrap().is_none(), "ended early");
    child.kill().unwrap();
    child.wait().unwrap();
    assert_eq!(names(folder.path()), ["keep"]);
}

#[test]
#[cfg(target_os = "linux")]
fn memory_that_is_not_there_is_status_2_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    // 900 MB for a picture of 8192x4096 pixels, whose fragments alone take more.
    let words =
        "ulimit -v 900000; exec \"$0\" render sphere --engine f64 --size 8192x4096 -o out.exr";
    let ran: crate::run::Ran = std::process::Command::new("sh")
        .args(["-c", words, env!("CARGO_BIN_EXE_tapline")])
        .current_dir(folder.path())
        .output()
        .unwrap()
        .into();
    ran.refused(&["memory", "--size"]);
    assert!(names(folder.path()).is_empty());
}

#[test]
fn without_a_window_system_the_list_of_adapters_has_no_complaint_before_it() {
    let out = crate::run::command()
        .args(["gpu", "list"])
        .env_remove("XDG_RUNTIME_DIR")
        .env_remove("NODEVICE_SELECT")
        .output()
        .unwrap();
    assert!(!String::from_utf8_lossy(&out.stderr).contains("XDG_RUNTIME_DIR"));
}

#[test]
fn a_picture_goes_to_stdout_and_a_map_comes_from_stdin() {
    use std::io::Write as _;
    use std::process::Stdio;
    let folder = tempfile::tempdir().unwrap();
    let render = |input: &str, output: &str, bytes: &[u8]| -> Vec<u8> {
        let args = ["render", "sphere", "--engine", "rtl", "--size", "16x16", "--face-size", "16"];
        let mut child = crate::run::command()
            .args(args)
            .args(["--env", input, "-o", output])
            .current_dir(folder.path())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        child.stdin.take().unwrap().write_all(bytes).unwrap();
        let out = child.wait_with_output().unwrap();
        assert!(out.status.success());
        out.stdout
    };
    let lat_long = ["render", "sphere", "--engine", "f64", "--size", "64x32", "-o", "map.exr"];
    assert_eq!(tapline_in(folder.path(), &lat_long).status, Some(0));
    let map = std::fs::read(folder.path().join("map.exr")).unwrap();
    assert!(render("map.exr", "file.exr", b"").is_empty());
    let file = std::fs::read(folder.path().join("file.exr")).unwrap();
    assert_eq!(render("-", "-", &map), file);
}
