//! The commands as a user types them.

use crate::run::{tapline, tapline_fed};

const LINE: &str =
    r#"{"op":"tex","cone":[0.01,0.25],"d":[0,-1,0],"n":[0,1,0],"dp_ds":[2,0,0],"dp_dt":[0,0,2]}"#;

#[test]
fn trace_lines_are_answered_by_both_engines() {
    for engine in ["rtl", "f64"] {
        let args = ["trace", "--input", "-", "--engine", engine];
        let ran = tapline_fed(&args, format!("{LINE}\n").as_bytes()).done();
        let value = ran.json();
        let out = &value["out"];
        // w = ¼ on 2 world units and 256 texels: 32 texels either way, level 5.
        assert_eq!(out["probes"], 1, "{out}");
        assert!((out["lod"].as_f64().unwrap() - 5.0).abs() < 1e-9, "{out}");
        assert!((out["lambda"][0].as_f64().unwrap() - 32.0).abs() < 1e-4, "{out}");
        for key in ["dp_dx", "dp_dy", "ddx", "ddy", "K", "axis", "flags"] {
            assert!(out[key].is_array(), "{key} in {out}");
        }
    }
}

#[test]
fn trace_lines_take_the_texture_s_size() {
    let args = ["trace", "--input", "-", "--engine", "f64", "--face-size", "1024"];
    let ran = tapline_fed(&args, LINE.as_bytes()).done();
    assert!((ran.json()["out"]["lod"].as_f64().unwrap() - 7.0).abs() < 1e-9);
}

#[test]
fn bad_trace_lines_are_refused_by_line() {
    let cases = [
        (LINE.replace("\"n\":[0,1,0],", ""), "n"),
        (LINE.replace("[0.01,0.25]", "[0.01]"), "cone"),
        (LINE.replace("[0.01,0.25]", "[0.01,\"wide\"]"), "cone"),
        (LINE.replace("\"n\"", "\"m\""), "m"),
    ];
    for (text, key) in cases {
        let input = format!("{LINE}\n{text}\n");
        let ran = tapline_fed(&["trace", "--input", "-"], input.as_bytes());
        assert_eq!(ran.status, Some(2), "{ran:?}");
        assert!(ran.stderr.contains("line 2") && ran.stderr.contains(key), "{ran:?}");
        assert_eq!(ran.stdout.lines().count(), 1);
    }
}

#[test]
fn a_scene_s_pixel_is_traced_and_its_line_can_be_fed_back() {
    let small = ["--size", "32x32", "--face-size", "128"];
    let mut args = vec!["trace", "thin-lens", "--pixel", "16,28", "--lines"];
    args.extend(small);
    let ran = tapline(&args).done();
    let mut value = ran.json();
    assert_eq!(value["op"], "tex");
    let out = value["out"].take();
    value.as_object_mut().unwrap().remove("out");
    let args = ["trace", "--input", "-", "--face-size", "128"];
    let again = tapline_fed(&args, value.to_string().as_bytes()).done().json();
    for key in ["ddx", "ddy", "K", "lambda", "lod", "probes"] {
        assert_eq!(again["out"][key], out[key], "{key}");
    }
}

#[test]
fn compare_tells_tiles_and_takes_a_texture() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("floor.png");
    let file = std::fs::File::create(&path).unwrap();
    let mut encoder = png::Encoder::new(file, 48, 20);
    encoder.set_color(png::ColorType::Rgb);
    let pixels: Vec<u8> = (0..48 * 20 * 3u32).map(|i| u8::try_from(i * 7 % 251).unwrap()).collect();
    encoder.write_header().unwrap().write_image_data(&pixels).unwrap();
    let texture = path.display().to_string();
    let args = [
        "compare",
        "convex",
        "--size",
        "24x24",
        "--engines",
        "rtl,f64",
        "--texture",
        &texture,
        "--json",
        "-",
    ];
    let value = tapline(&args).done().json();
    let tiles = &value["engines"]["rtl"]["tiles"][0];
    // One tile a level, 48 × 20 down to 1 × 1.
    assert_eq!(tiles["by_level"].as_array().unwrap().len(), 6, "{tiles}");
    assert!(tiles["total"].as_u64().unwrap() >= 3);
    assert!(value["pairs"][0]["psnr_db"].as_f64().unwrap() > 50.0);
}

#[test]
fn a_shift_reports_the_motion_of_every_engine_against_the_truth() {
    for scene in ["sphere", "room", "convex"] {
        let run = |shift: &str| {
            let engines = ["--engines", "f64,truth", "--samples", "16", "--size", "24x24"];
            let shift = ["compare", scene, "--json", "-", "--shift", shift];
            tapline(&[&shift[..], &engines].concat()).done().json()["motions"].clone()
        };
        let moved = run("0.25");
        assert_eq!((&moved[0]["a"], &moved[0]["b"]), (&"f64".into(), &"truth".into()));
        assert!(moved[0]["act"].as_f64().unwrap() > 0.1, "{scene}: {moved}");
        assert!(moved[0]["flicker_db"].as_f64().unwrap() > 10.0, "{scene}: {moved}");
        let still = run("0");
        assert!(still[0]["act"].is_null() && still[0]["flicker_db"].is_null(), "{scene}: {still}");
    }
    tapline(&["compare", "sphere", "--engines", "f64", "--shift", "1"])
        .refused(&["--shift", "truth"]);
    tapline(&["compare", "sphere", "--shift", "nan"]).refused(&["--shift"]);
}

#[test]
fn what_scenes_with_cones_cannot_take_is_refused() {
    tapline(&["compare", "convex", "--texture", "no-such-file.png"]).refused(&["no-such-file.png"]);
    tapline(&["compare", "sphere", "--texture", "a.png"]).refused(&["--texture"]);
    tapline(&["compare", "convex", "--distance", "sphere:2"]).refused(&["--distance"]);
    tapline(&["compare", "convex", "--face-size", "0"]).refused(&["--face-size"]);
    tapline(&["compare", "convex", "--set", "cone.count=3"]).refused(&["cone.count"]);
    tapline(&["compare", "convex", "--set", "address.wrap_s=\"tile\""])
        .refused(&["address.wrap_s"]);
    tapline(&["compare", "sphere", "--bounces", "1"]).refused(&["--bounces"]);
    for wrong in ["3-2", "257", "x", "1-", ""] {
        tapline(&["compare", "convex", "--bounces", wrong]).refused(&["--bounces", "8-15"]);
    }
}

#[test]
fn light_of_chosen_bounces_is_all_that_a_scene_shows() {
    let render = |bounces: &[&str]| {
        let args = ["compare", "vases", "--size", "16x16", "--face-size", "64"];
        let more = ["--engines", "rtl,f64", "--json", "-"];
        let value = tapline(&[&args[..], &more, bounces].concat()).done().json();
        let rtl = &value["engines"]["rtl"];
        let probes = rtl["probes_per_fragment"].as_f64().unwrap();
        (probes * value["fragments"].as_f64().unwrap(), value["pairs"][0]["psnr_db"].as_f64())
    };
    let whole = render(&[]).0;
    // The scene's own 16 bounces in two parts: paths that weigh little go on, so that it takes no fewer probes.
    let [first, rest] = ["0", "1-16"].map(|part| render(&["--bounces", part]));
    assert!(first.0 > 0.0 && rest.0 > 0.0 && first.0 < whole);
    assert!(first.0 + rest.0 >= whole, "{first:?} {rest:?} {whole}");
    assert!(first.1.unwrap() > 50.0 && rest.1.unwrap() > 50.0);
}
