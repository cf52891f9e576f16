//! Every built-in scene on the device: the picture of the float reference, and every register of every stage explained.

use serde_json::Value;
use tapline::gpu::Gpu;
use tapline::scene::REGISTRY;

use support::gpu::on_gpu;

fn compare(arguments: &[&str]) -> (Value, String) {
    let out = std::process::Command::new(env!("CARGO_BIN_EXE_tapline"))
        .arg("compare")
        .args(arguments)
        .args(["--engines", "gpu,f64", "--json", "-"])
        .output()
        .expect("the command runs");
    let words = String::from_utf8_lossy(&out.stderr).into_owned();
    assert!(out.status.success(), "{arguments:?}: {words}");
    (serde_json::from_slice(&out.stdout).expect("one JSON object"), words)
}

/// Single precision leaves 60 dB at the very least; a wrong line of a shader does not.
fn check(scene: &str, more: &[&str]) {
    let size = [scene, "--size", "40x40", "--face-size", "64"];
    let (found, _) = compare(&[&size[..], more].concat());
    let pair = &found["pairs"][0];
    assert_eq!((pair["a"].as_str(), pair["b"].as_str()), (Some("gpu"), Some("f64")));
    let psnr = pair["psnr_db"].as_f64().unwrap_or(f64::INFINITY);
    assert!(psnr >= 60.0, "{scene}: {psnr} dB");
    let stages = &found["stages"];
    assert!(stages["first_difference"].is_null(), "{scene}: {}", stages["first_difference"]);
    assert!(stages["fragments"].as_u64() > Some(500), "{scene} has fragments");
    let rows = stages["registers"].as_array().expect("rows");
    assert!(rows.len() > 15, "{scene}: {} registers", rows.len());
    assert!(found["adapter"].is_string());
}

/// One test for all: the device runs one kernel at a time anyway.
#[test]
fn every_scene_agrees_with_the_float_reference_and_has_no_unexplained_register() {
    on_gpu(|_: &Gpu| {
        for scene in REGISTRY.into_iter().flatten() {
            check(scene.name, &[]);
        }
    });
}

/// Policies that only a scene can show: the cones of a path, and the axis of the angle table.
#[test]
fn cones_along_paths_wraps_and_the_table_s_axis_follow_their_policies() {
    on_gpu(|_: &Gpu| {
        for (scene, policy) in [
            ("thin-lens", ["--set", "cone.count=1"]),
            ("vases", ["--set", "cone.metric=distance"]),
            ("vases-lined", ["--unit", "preset:otk"]),
            ("convex", ["--set", "address.wrap_s=mirror"]),
            ("scratches", ["--reference-axis", "table"]),
        ] {
            check(scene, &policy);
        }
    });
}

#[test]
fn pairs_follow_the_ladder_and_a_bounded_pair_is_there_though_it_is_not_adjacent() {
    on_gpu(|_: &Gpu| {
        let out = std::process::Command::new(env!("CARGO_BIN_EXE_tapline"))
            .args(["compare", "sphere", "--size", "32x32", "--engines", "f64,rtl,gpu"])
            .args(["--min-psnr", "rtl:f64=30", "--json", "-"])
            .output()
            .expect("the command runs");
        assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
        let found: Value = serde_json::from_slice(&out.stdout).expect("one JSON object");
        let pairs = found["pairs"].as_array().expect("pairs");
        let names: Vec<String> = pairs
            .iter()
            .map(|p| format!("{}:{}", p["a"].as_str().unwrap_or(""), p["b"].as_str().unwrap_or("")))
            .collect();
        assert_eq!(names, ["rtl:gpu", "gpu:f64", "rtl:f64"]);
    });
}

#[test]
fn a_map_beyond_the_limits_is_refused_with_the_limit_s_name() {
    on_gpu(|gpu| {
        use tapline::cube::{CubeLevel, CubeMap};
        use tapline::gpu::maps::Maps;
        use tapline::gpu::policy::Tables;
        use tapline::settings::Settings;
        let size = 8193;
        let texels = vec![[0.0f32; 3]; size];
        // Only the edge counts: the map is refused before a texel is read.
        let map = CubeMap { levels: vec![CubeLevel { size, texels }] };
        let (settings, tables) = (Settings::default(), Tables::default());
        let maps = Maps::new(gpu, &settings, &tables).expect("a device");
        let refused = maps.with_cube(&map).err().map(|e| e.to_string());
        let words = refused.unwrap_or_default();
        assert!(words.contains("maxTextureDimension2D"), "{words}");
    });
}
