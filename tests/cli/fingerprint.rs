//! `tapline gpu list`, `tapline fingerprint` and the engine `sampler` on the command line.

use crate::run::tapline;

use support::gpu::device as gpu;

#[test]
fn gpu_list_prints_text_and_json_with_and_without_a_driver() {
    let text = tapline(&["gpu", "list"]).done().stdout;
    let value = tapline(&["gpu", "list", "--json", "-"]).done().json();
    let adapters = value["adapters"].as_array().expect("a list");
    if adapters.is_empty() {
        assert!(text.contains("no adapter"), "{text}");
    }
    for adapter in adapters {
        let name = adapter["name"].as_str().expect("a name");
        assert!(text.contains(name), "{text}");
        for key in ["backend", "driver", "driver_info", "type", "limits", "features"] {
            assert!(adapter.get(key).is_some(), "{key}");
        }
    }
    assert_eq!(value["used_limits"]["maxStorageBufferBindingSize"], 134_217_728);
}

#[test]
fn an_adapter_that_is_not_there_is_refused_with_the_list() {
    let ran = tapline(&["fingerprint", "--adapter", "no such thing"]);
    if gpu().is_some() {
        ran.refused(&["--adapter", "no such thing", "0: ", "gpu list"]);
    } else {
        ran.refused(&["no GPU adapter", "mesa-vulkan-drivers"]);
    }
}

#[test]
fn fingerprint_writes_picture_json_and_text() {
    let Some(gpu) = gpu() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("print");
    let name = out.display().to_string();
    let printed = tapline(&["fingerprint", "--out", &name]).done().stdout;
    assert!(printed.contains(&gpu.adapter().title()), "{printed}");
    let read = |file: &str| std::fs::read(out.join(file)).expect(file);
    assert_eq!(read("fingerprint.txt"), printed.as_bytes());
    assert!(read("fingerprint.png").starts_with(b"\x89PNG"));
    let value: serde_json::Value = serde_json::from_slice(&read("fingerprint.json")).expect("JSON");
    for key in
        ["version", "adapter", "weights", "levels", "gradients", "anisotropy", "cube", "checks"]
    {
        assert!(value.get(key).is_some(), "{key}");
    }
    let again = folder.path().join("alone.png");
    tapline(&["fingerprint", "--json", "-", "--out", &again.display().to_string()]).done().json();
    assert!(std::fs::metadata(again).expect("written").len() > 10_000);
}

#[test]
fn sampler_runs_only_where_it_is_named_and_refuses_tex_scenes() {
    if gpu().is_none() {
        tapline(&["compare", "sphere", "--engines", "sampler,f64"]).refused(&["no GPU adapter"]);
        return;
    }
    let size = ["--size", "24x24", "--json", "-"];
    for scene in ["sphere", "waves", "room"] {
        let args = [&["compare", scene, "--engines", "sampler,f64"][..], &size].concat();
        let value = tapline(&args).done().json();
        let pair = &value["pairs"][0];
        assert_eq!((&pair["a"], &pair["b"]), (&"sampler".into(), &"f64".into()));
        // The same map at the same places: another filter, not another picture.
        let psnr = pair["psnr_db"].as_f64().expect("a filter of its own");
        assert!((10.0..80.0).contains(&psnr), "{scene}: {psnr}");
    }
    let args = [&["compare", "sphere", "--samples", "4"][..], &size].concat();
    assert!(tapline(&args).done().json()["engines"].get("sampler").is_none());
    tapline(&["compare", "convex", "--engines", "sampler,f64", "--size", "24x24"]).refused(&[
        "sampler",
        "ENV and HIT",
        "a scene of TEX",
    ]);
}
