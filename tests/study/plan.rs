//! Study files: what they mean, and where they are wrong.

use std::path::Path;

use tapline::error::InputError;
use tapline::study::plan::Plan;
use tapline::study::points::{order, points};
use tapline::unit::knobs::Value;

fn parse(text: &str) -> Result<Plan, InputError> {
    Plan::parse("s.toml", text, Path::new(""))
}

fn sets(text: &str) -> Vec<Vec<String>> {
    let plan = parse(text).unwrap();
    let text = |(path, value): &(String, Value)| format!("{path}={value}");
    points(&plan).iter().map(|p| p.sets.iter().map(text).collect()).collect()
}

const AXES: &str = r#"
scenes = ["sphere"]
[[axis]]
path = "filter.weight_bits"
list = [4, 8]
[[axis]]
path = ["registers.jacobian.d.frac", "registers.jacobian.numerator.frac"]
range = { from = 18, to = 20 }
"#;

#[test]
fn points_come_from_axes_by_the_mode() {
    let grid = sets(AXES);
    assert_eq!(grid.len(), 6);
    assert_eq!(
        grid[1],
        [
            "filter.weight_bits=4",
            "registers.jacobian.d.frac=19",
            "registers.jacobian.numerator.frac=19"
        ]
    );
    let alone = sets(&format!("mode = \"one-at-a-time\"\n{AXES}"));
    assert_eq!(alone.len(), 6);
    assert!(alone[0].is_empty(), "the unit itself first");
    assert_eq!(alone[2], ["filter.weight_bits=8"]);
    let drawn = format!("mode = \"random\"\ncount = 40\nseed = 7\n{AXES}");
    assert_eq!(sets(&drawn), sets(&drawn));
    assert_ne!(sets(&drawn), sets(&drawn.replace("seed = 7", "seed = 8")));
    let zip = AXES.replace("[4, 8]", "[4, 6, 8]");
    assert_eq!(sets(&format!("mode = \"zip\"\n{zip}"))[2][0], "filter.weight_bits=8");
    let spans = r#"
scenes = ["sphere"]
[[axis]]
path = "eigen.entries"
range = { from = 4, to = 256, factor = 4 }
[[axis]]
path = "roughness.scale"
grid = { from = 1.0, to = 4.0, count = 3 }
[[axis]]
path = "footprint.max_probes"
random = { from = 1, to = 3, count = 5 }
"#;
    let spans = sets(spans);
    assert_eq!(spans.len(), 4 * 3 * 5);
    assert_eq!(spans[0][0], "eigen.entries=4");
    assert_eq!(spans.last().unwrap()[0], "eigen.entries=256");
    assert_eq!(spans[5][1], "roughness.scale=2.5");
}

#[test]
fn points_that_differ_in_late_stages_follow_each_other() {
    let plan = parse(AXES).unwrap();
    let points = points(&plan);
    let order = order(&plan, &points);
    // The register of `jacobian` is the slow axis although the file has it last.
    let fracs: Vec<&Value> = order.iter().map(|i| &points[*i].sets[1].1).collect();
    assert_eq!(fracs, [18, 18, 19, 19, 20, 20].map(Value::Integer).iter().collect::<Vec<_>>());
    let mut sorted = order.clone();
    sorted.sort_unstable();
    assert_eq!(sorted, (0..6).collect::<Vec<_>>());
}

#[test]
fn what_is_wrong_is_named_with_its_line_and_column() {
    let axis = "[[axis]]\npath = \"filter.weight_bits\"\nlist = [4]\n";
    for (text, parts) in [
        (format!("scenes = [\"sphere\"]\nsize = \"9\"\n{axis}"), &["line 2, column 8", "WIDTHxHEIGHT", "`9`"][..]),
        (format!("scene = \"sphere\"\n{axis}"), &["line 1, column 1, scene", "unknown key"]),
        (format!("scenes = [\"sphre\"]\n{axis}"), &["line 1, column 11", "`sphre`"]),
        ("scenes = [\"sphere\"]\n[[axis]]\npath = \"eigen.entris\"\nlist = [4]".into(), &["line 3, column 8, eigen.entris", "unknown path"]),
        ("scenes = [\"sphere\"]\n[[axis]]\npath = \"eigen.entries\"\nlist = [4, 5]".into(), &["line 4, column 12", "even"]),
        ("scenes = [\"sphere\"]\n[[axis]]\npath = \"eigen.entries\"\nlist = [4]\nrange = { from = 2, to = 4 }".into(), &["list and range"]),
        ("scenes = [\"sphere\"]\n[[axis]]\npath = \"eigen.entries\"\nrange = { from = 8, to = 4 }".into(), &["line 4", "at least 8"]),
        (format!("scenes = [\"sphere\"]\n{axis}{axis}"), &["line 5", "each path on one axis"]),
        (format!("scenes = [\"sphere\"]\nmetrics = [\"psnr\"]\n{axis}"), &["line 2, column 12", "`psnr`"]),
        (format!("scenes = [\"sphere\"]\nmode = \"random\"\n{axis}"), &["count", "none"]),
        ("scenes = [\"sphere\"]".into(), &["[[axis]]", "none"]),
        (format!("scenes = [\"sphere\"]\n{axis}[set]\n\"texel.int\" = 99\n"), &["line 6, column 15, texel.int"]),
        (format!("scenes = [\"sphere\"]\nunit = \"preset:none\"\n{axis}"), &["preset"]),
        ("scenes = [".into(), &["line 1"]),
    ] {
        let error = parse(&text).unwrap_err().to_string();
        for part in parts {
            assert!(error.contains(part), "no `{part}` in `{error}`\n{text}");
        }
    }
}
