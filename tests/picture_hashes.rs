//! Hashes of every built-in scene's picture: the same on every machine, in debug and release.

mod golden;
mod rtl_support;

use std::fmt::Write as _;

use tapline::engine::Engine;
use tapline::engine::float::F64Engine;
use tapline::report::hash::{hash_text, picture_hash};
use tapline::scene::SCENES;
use tapline::unit::{ReferenceAxis, UnitSpec};

#[test]
fn pictures_of_every_scene_have_the_golden_hashes() {
    let mut lines = String::new();
    let mut seen = Vec::new();
    for preset in UnitSpec::PRESETS {
        let spec = UnitSpec::preset(preset).expect("a preset");
        for info in SCENES {
            let subject = rtl_support::subject(info.name, 64, &spec);
            let rtl = rtl_support::engine(&spec, &subject);
            let f64_engine = F64Engine {
                settings: spec.settings(ReferenceAxis::Exact),
            };
            for engine in [&rtl as &dyn Engine, &f64_engine] {
                let picture = engine.render(&subject, &|_| {}).picture;
                let hash = picture_hash(&picture);
                // The float reference of a scene without roughness knows no difference of presets.
                if engine.rung() == tapline::engine::Rung::Rtl {
                    let twin = seen.contains(&hash);
                    // D = 0 leaves nothing for the angle table or the scale to change.
                    assert_eq!(
                        twin,
                        // `otk` is about ray cones alone.
                        preset == "otk" || preset == "schilling" && info.name == "parabola",
                        "{preset} {}",
                        info.name
                    );
                    seen.push(hash);
                }
                let name = engine.rung().name();
                // Writing to a String cannot fail.
                let _ = writeln!(lines, "{preset} {} {name} {}", info.name, hash_text(hash));
            }
        }
    }
    golden::check("picture_hashes.txt", &lines);
}
