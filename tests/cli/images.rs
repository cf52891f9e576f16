//! Images through the binary: damaged and unusual ones end in status 0 or 2 with one message.

use crate::run::{names, shared, tapline, tapline_in};
use std::time::{Duration, Instant};

#[test]
fn odd_image_files_end_in_a_picture_or_one_message() {
    let Some(root) = shared("exr-odd") else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let mut seen = [0, 0];
    for kind in ["damaged", "valid"] {
        for name in names(&root.join(kind)) {
            let path = root.join(kind).join(&name);
            let start = Instant::now();
            let ran = tapline_in(
                folder.path(),
                &[
                    "render",
                    "sphere",
                    "--engine",
                    "rtl",
                    "--size",
                    "16x16",
                    "-o",
                    "x.png",
                    "--env",
                    path.to_str().unwrap(),
                    // Few have an environment's shape.
                    "--env-layout",
                    "lat-long",
                ],
            );
            // Most take 0.1 s; a machine that is busy takes longer, a hang for ever.
            assert!(start.elapsed() < Duration::from_secs(20), "{name}");
            match ran.status {
                Some(0) => {
                    seen[0] += 1;
                    std::fs::remove_file(folder.path().join("x.png")).unwrap();
                }
                _ => {
                    seen[1] += 1;
                    ran.refused(&[&name, "expected", "found"]);
                    assert_eq!(ran.stderr.lines().count(), 1, "{}", ran.stderr);
                }
            }
            assert!(kind == "valid" || ran.status == Some(2), "{name}: {ran:?}");
            assert!(names(folder.path()).is_empty(), "{name}");
        }
    }
    assert!(seen[0] >= 11 && seen[1] >= 26, "{seen:?}");
}

#[test]
fn the_limit_on_images_names_what_would_be_enough() {
    let Some(root) = shared("env") else { return };
    let folder = tempfile::tempdir().unwrap();
    let env = root.join("KernerEnvCube.exr");
    let run = |mb: &str| {
        tapline_in(
            folder.path(),
            &[
                "render",
                "sphere",
                "--engine",
                "rtl",
                "--size",
                "16x16",
                "-o",
                "x.png",
                "--env",
                env.to_str().unwrap(),
                "--max-image-mb",
                mb,
            ],
        )
    };
    run("0").refused(&["KernerEnvCube.exr", "--max-image-mb"]);
    for mb in ["1", "2"] {
        run(mb).refused(&["--max-image-mb 3"]);
    }
    run("3").done();
    run("18446744073709551615").done();
}

#[test]
fn bump_maps_of_both_kinds_render_and_others_are_refused() {
    let Some(root) = shared("bump") else { return };
    let folder = tempfile::tempdir().unwrap();
    let run = |name: &str, more: &[&str]| {
        let path = root.join(name);
        let mut args = vec![
            "render",
            "sphere",
            "--engine",
            "rtl",
            "--size",
            "16x16",
            "-o",
            "x.png",
            "--bump",
            path.to_str().unwrap(),
        ];
        args.extend(more);
        tapline_in(folder.path(), &args)
    };
    let picture = || std::fs::read(folder.path().join("x.png")).unwrap();
    run("oiio-bump.exr", &[]).done();
    let default = picture();
    // 128 texels wide: a 64th is 2.
    run("oiio-bump.exr", &["--bump-scale", "2"]).done();
    assert_eq!(picture(), default);
    run("oiio-bump.exr", &["--bump-scale", "-3"]).done();
    assert_ne!(picture(), default);
    run("oiio-normal.exr", &[]).done();
    let ran = run("oiio-bump.exr", &["--bump-scale", "60000"]).done();
    assert!(ran.stderr.contains("were shortened"), "{}", ran.stderr);
    run("oiio-bump.exr", &["--bump-scale", "nan"]).refused(&["--bump-scale"]);
    run("oiio-bumpslope.exr", &[]).refused(&["oiio-bumpslope.exr", "channels"]);
}

#[test]
fn a_flag_that_nothing_reads_is_an_error() {
    for args in [
        &["budget", "--env", "none.exr"][..],
        &["budget", "--mesh", "none.obj"],
        &["budget", "--face-size", "64"],
        &["trace", "--input", "-", "--bump", "none.png"],
        &["trace", "sphere", "--input", "-", "--mesh", "none.obj"],
    ] {
        tapline(args).refused(&["nothing that reads it"]);
    }
}
