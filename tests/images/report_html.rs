//! The HTML page holds what the run's JSON holds, and nothing from it can break out.

use serde_json::json;
use tapline::report::html::page;

fn run() -> serde_json::Value {
    json!({
        "scene": "sphere", "size": [64, 48], "version": "0.1.0", "unit_hash": "00000000000000ab", "seed": 7,
        "unit": {"footprint": {"max_probes": 16}},
        "engines": {
            "rtl": {"seconds": 0.25, "fragments_per_second": 1_000_000, "texels_per_fragment": 21.5, "probes_per_fragment": 2.7},
            "f64": {"seconds": 2.5, "fragments_per_second": 100_000, "texels_per_fragment": 21.5, "probes_per_fragment": 2.7}
        },
        "pairs": [
            {"a": "rtl", "b": "f64", "psnr_db": 54.321, "max_abs": 0.01, "rmse": 0.002, "rel_mse": 1e-6, "share_over_1_lsb8": 0.015},
            {"a": "f64", "b": "ewa", "psnr_db": null, "max_abs": 0, "rmse": 0, "rel_mse": 0, "share_over_1_lsb8": 0}
        ],
        "registers": [{"stage": "eigen", "register": "lambda1", "worst_lsb": 1.5, "mean_lsb": 0.25, "pixel": [3, 4]}],
        "flags": {"jacobian.d.saturated": 12},
        "skipped": [{"engine": "gpu", "why": "no adapter"}],
        "adapter": null
    })
}

/// Eight bytes of signature and a header of 3 × 2 pixels: enough for the page.
fn png() -> Vec<u8> {
    let mut png = b"\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR".to_vec();
    png.extend([0, 0, 0, 3, 0, 0, 0, 2]);
    png
}

#[test]
fn every_figure_of_the_run_is_on_the_page() {
    let images = ["rtl", "f64", "rtl-f64", "mosaic"].map(|name| (name.to_owned(), png()));
    let page = page(&run(), &images);
    for expected in [
        "sphere",
        "64 × 48",
        "00000000000000ab",
        "0.1.0",
        "rtl – f64",
        "54.32",
        "identical",
        "2.550",
        "1.500",
        "1 000 000",
        "lambda1",
        ">3,4<",
        "jacobian.d.saturated",
        ">12<",
        "no adapter",
        "footprint.max_probes",
        "width=\"3\" height=\"2\"",
        "<figcaption>mosaic</figcaption>",
    ] {
        assert!(page.contains(expected), "{expected} is not on the page");
    }
    assert_eq!(page.matches("<figure data-view>").count(), 3, "two engines and their error map");
    assert_eq!(page.matches("data:image/png;base64,iVBORw0KGgo").count(), 4);
}

#[test]
fn the_page_asks_no_server_for_anything() {
    let page = page(&run(), &[("rtl".to_owned(), png())]);
    for call in ["http:", "https:", "//cdn", "@import", "url(", "fetch(", "<link", "src=\"/"] {
        assert!(!page.contains(call), "{call} is on the page");
    }
}

#[test]
fn texts_from_outside_are_escaped_wherever_they_stand() {
    let evil = "</style></script><img src=x onerror=alert(1)>\"'&";
    let run = json!({
        "scene": evil, "size": evil, "version": evil, "unit_hash": evil, "seed": evil, "adapter": evil,
        "unit": {evil: {evil: evil}},
        "engines": {evil: {"seconds": evil, "fragments_per_second": [evil]}},
        "pairs": [{"a": evil, "b": evil, "psnr_db": evil, "flip": 0.5}],
        "registers": [{"stage": evil, "register": evil, "worst_lsb": evil, "pixel": [evil, evil]}],
        "flags": {evil: evil},
        "skipped": [{"engine": evil, "why": evil}]
    });
    let images = [evil.to_owned(), format!("{evil}-{evil}"), "x<y".to_owned()];
    let page = page(&run, &images.map(|name| (name, png())));
    assert!(!page.contains("<img src=x") && !page.contains("x<y"));
    assert_eq!(page.matches("</script>").count(), 1);
    assert_eq!(page.matches("</style>").count(), 1);
    assert!(page.matches("&lt;img src=x onerror=alert(1)&gt;&quot;'&amp;").count() > 15);
}

#[test]
fn a_run_that_lacks_everything_still_makes_a_page() {
    for run in [json!(null), json!({}), json!([1]), json!({"pairs": 3, "engines": [], "size": {}})]
    {
        let page = page(&run, &[("x".to_owned(), Vec::new())]);
        assert!(page.starts_with("<!DOCTYPE html>") && page.ends_with("</html>\n"));
        assert!(!page.contains("<section>\n<h2>Ladder"), "no empty tables");
    }
}
