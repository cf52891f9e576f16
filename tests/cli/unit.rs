//! Unit files and `--set`: every refusal says where, what was expected, what was found.

use crate::run::{tapline, tapline_fed, tapline_in};

fn check(text: &[u8]) -> crate::run::Ran {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("u.toml"), text).unwrap();
    tapline_in(folder.path(), &["unit", "check", "u.toml"])
}

#[test]
fn bad_unit_files_are_refused_with_their_place() {
    let big = vec![b'#'; 2 << 20];
    let deep = format!("a={}", "[".repeat(100_000));
    let long = format!("[footprint]\ncount=\"{}\"", "x".repeat(5000));
    let cases: Vec<(&[u8], &[&str])> = vec![
        (b"[footprint\nmax_probes=8", &["line 1, column 11"]),
        (
            b"[footprint]\nmax_probes=\"8\"",
            &["line 2, column 12, footprint.max_probes", "1 to 64", "found \"8\""],
        ),
        (b"[footprint]\nmax_probes=true", &["line 2, column 12", "found true"]),
        (b"[footprint]\nmax_probes=8.0", &["line 2", "found 8.0"]),
        (b"[footprint]\nmax_probes=65", &["line 2", "found 65"]),
        (b"[footprint]\nmax_probes=999999999999999999999999", &["line 2", "too large"]),
        (b"[footprint]\nmax_probes=8\nmax_probes=9", &["line 3, column 1", "duplicate key"]),
        (b"[foot]\nx=1", &["line 2, column 1, foot.x", "unknown path"]),
        (b"[foot]\n", &["line 1, column 2, foot", "unknown path"]),
        (b"[hit]\niterations=65", &["line 2, column 12, hit.iterations", "found 65"]),
        (b"\n[surface]\n", &["line 2, column 2, surface", "unknown path"]),
        (b"footprint=3", &["line 1, column 11, footprint", "expected a table"]),
        (b"[[footprint]]\nmax_probes=8", &["footprint", "expected a table"]),
        (b"[footprint.max_probes]\nx=1", &["footprint.max_probes.x", "unknown path"]),
        (b"[registers.nope.axis]\nint=0", &["line 2", "unknown path"]),
        (
            b"[registers.eigen.axis]\nint=30\nfrac=40",
            &["line 3, column 6, registers.eigen.axis.frac", "58 bits", "found 70"],
        ),
        (b"[tables.recip]\nentries=100", &["line 2", "power of two"]),
        (b"[eigen]\nentries=32\n[tables.eigen]\nentries=10", &["line 4", "both"]),
        (b"[roughness]\nscale=nan", &["line 2", "0 to 8"]),
        (b"[transform]\nrotation=[1,0,0,0,1]", &["line 2", "nine numbers"]),
        (b"[roughness]\nscale=1\n#\xe9\n", &["line 3, column 2", "UTF-8", "0xe9"]),
        (b"[\"a\\u001b[31mb\"]\nx=1", &["\\u{1b}"]),
        (&big, &["u.toml", "1 MiB"]),
        (deep.as_bytes(), &["line 1", "recurs"]),
        (long.as_bytes(), &["line 2", "xxx…"]),
        (
            b"[registers.footprint.line]\nint=20\nfrac=38",
            &["line 3, column 6, registers.footprint.line.frac", "at registers.footprint.step"],
        ),
    ];
    for (text, parts) in cases {
        let ran = check(text);
        ran.refused(parts);
        assert!(ran.stderr.starts_with("tapline: u.toml"), "{}", ran.stderr);
        assert!(ran.stderr.contains("expected") && ran.stderr.contains("; "), "{}", ran.stderr);
        assert!(ran.stderr.len() < 600, "{}", ran.stderr);
        assert!(!ran.stderr.contains('\u{1b}'));
        assert_eq!(ran.stdout, "");
    }
}

#[test]
fn good_unit_files_of_every_style_are_taken() {
    let hash = |ran: crate::run::Ran| ran.done().stdout;
    let expected = hash(tapline(&["unit", "check", "--set", "footprint.max_probes=8"]));
    for text in [
        "[footprint]\nmax_probes=8",
        "\u{feff}[footprint]\r\nmax_probes = 8\r\n",
        "footprint.max_probes = 0x8",
        "footprint = { max_probes = 8 }",
        "[footprint]\n\"max_probes\" = 8 # eight\n[eigen]\n",
    ] {
        assert_eq!(hash(check(text.as_bytes())), expected, "{text}");
    }
    assert_ne!(hash(check(b"")), expected);
    // A register may be wide between two lines.
    check(b"[registers.cube_face.u]\nfrac=58\nint=0\n").refused(&["exact", "line 2, column 6"]);
    tapline(&[
        "unit",
        "check",
        "--set",
        "registers.cube_face.u.int=40",
        "--set",
        "registers.cube_face.u.frac=30",
    ])
    .refused(&["--set", "58 bits"]);
}

#[test]
fn a_shown_unit_is_the_same_unit_when_it_is_read_again() {
    for sets in [
        &[][..],
        &["--set", "footprint.count=feline", "--set", "roughness.scale=0.1"],
        &["--set", "transform.rotation=[0.6, 0.8, 0, -0.8, 0.6, 0, 0, 0, 1]"],
        &["--unit", "preset:schilling"],
    ] {
        let mut show = vec!["unit", "show", "--toml"];
        show.extend(sets);
        let mut direct = vec!["unit", "check"];
        direct.extend(sets);
        let text = tapline(&show).done().stdout;
        let piped = tapline_fed(&["unit", "check", "-"], text.as_bytes()).done();
        assert_eq!(piped.stdout, tapline(&direct).done().stdout);
    }
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("u.toml"), "footprint.max_probes=8").unwrap();
    let shown = tapline_in(
        folder.path(),
        &["unit", "show", "u.toml", "--toml", "--set", "eigen.entries=10"],
    );
    let shown = shown.done().stdout;
    assert!(shown.contains("max_probes = 8\n") && shown.contains("entries = 10\n"));
    tapline_in(folder.path(), &["unit", "show", "u.toml", "--unit", "preset:default"])
        .refused(&["one unit"]);
}

#[test]
fn set_takes_every_way_to_write_a_value_and_refuses_the_rest() {
    let set = |text: &str| tapline(&["unit", "check", "--set", text]);
    for good in [
        "footprint.count=pow2",
        "footprint.count=\"pow2\"",
        "footprint.count = 'pow2'",
        " footprint.max_probes =8",
        "roughness.scale=.5",
        "roughness.scale=2",
        "transform.rotation=[[1,0,0],[0,1,0],[0,0,1]]",
    ] {
        set(good).done();
    }
    for (bad, part) in [
        ("", "path=value"),
        ("footprint.max_probes", "path=value"),
        ("=3", "unknown path"),
        ("a.b=", "unknown path"),
        ("footprint=8", "unknown path"),
        ("footprint.max_probes=", "1 to 64"),
        ("footprint.max_probes=0", "found 0"),
        ("footprint.max_probes==8", "1 to 64"),
        ("footprint.max_probes=8\nx=1", "1 to 64"),
        ("footprint.count=\"pow2", "ceil"),
        ("roughness.scale=1e400", "0 to 8"),
        ("hit.iterations=65", "found 65"),
        ("cone.format=bf17", "bf16 | f16 | f32"),
        ("surface_footprint.max_anisotropy=65", "1 to 64"),
    ] {
        set(bad).refused(&["--set", part]);
    }
    tapline(&["unit", "check", "--unit", "preset:foo"]).refused(&["default, schilling, otk"]);
    tapline(&["unit", "check", "none.toml"]).refused(&["none.toml"]);
    tapline(&["unit", "check", "."]).refused(&["directory"]);
}
