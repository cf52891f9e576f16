//! Hashes of every built-in scene's picture: the same on every machine, in debug and release.

use std::fmt::Write as _;
use support::golden;

use tapline::base::hash::hash_text;
use tapline::engine::float::F64Engine;
use tapline::engine::hit::HitRtl;
use tapline::engine::{Engine, EnvJob, HitJob};
use tapline::report::hash::picture_hash;
use tapline::scene::hit::{self, HIT_SCENES};
use tapline::scene::{SCENES, SceneOptions};
use tapline::unit::{ReferenceAxis, UnitSpec};

fn hit_subject(name: &str) -> HitJob {
    let options =
        SceneOptions { width: 64, height: 64, face_size: Some(128), ..SceneOptions::default() };
    let scene = hit::build(name, &options).expect("a built-in scene");
    HitJob::built_in(scene)
}

#[test]
fn pictures_of_every_scene_have_the_golden_hashes() {
    let mut lines = String::new();
    let mut seen = Vec::new();
    for preset in UnitSpec::PRESETS {
        let spec = UnitSpec::preset(preset).expect("a preset");
        for info in SCENES {
            let subject = support::rtl::subject(info.name, 64, &spec);
            let rtl = support::rtl::engine(&spec, &subject);
            let f64_engine = F64Engine { settings: spec.settings(ReferenceAxis::Exact) };
            for (name, engine) in [("rtl", &rtl as &dyn Engine<EnvJob>), ("f64", &f64_engine)] {
                let picture = engine.render(&subject, &|_| {}).unwrap().picture;
                let hash = picture_hash(&picture);
                // The float reference of a scene without roughness knows no difference of presets.
                if name == "rtl" {
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
                // Writing to a String cannot fail.
                let _ = writeln!(lines, "{preset} {} {name} {}", info.name, hash_text(hash));
            }
        }
    }
    let spec = UnitSpec::default();
    for info in HIT_SCENES {
        let subject = hit_subject(info.name);
        let engine =
            HitRtl::new(&spec, &subject.distance, Some(&subject.map), 1).expect("the default unit");
        let rtl = engine.render(&subject, &|_| {}).unwrap();
        let settings = spec.settings(ReferenceAxis::Exact);
        let float = F64Engine { settings }.render(&subject, &|_| {}).unwrap();
        for (name, rendering) in [("rtl", rtl), ("f64", float)] {
            let searches = rendering.searches.expect("rays are searched for");
            assert!(searches.status.len() > 1 && searches.look_ups() > 1.0);
            let hash = hash_text(picture_hash(&rendering.picture));
            let _ = writeln!(lines, "default {} {name} {hash}", info.name);
        }
    }
    golden::check("picture_hashes.txt", &lines);
}
