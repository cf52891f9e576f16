//! A unit that runs from kept results gives the bits of a lone run.

use support::knobs::others;
use tapline::cube::CubeMap;
use tapline::engine::{EngineKind, EnvJob, HitJob, Job, Rendering, Setup, TexJob};
use tapline::mips::build_mips;
use tapline::report::hash::picture_hash;
use tapline::scene::{SceneOptions, build, hit, tex};
use tapline::study::cost::CostModel;
use tapline::study::sweep::{Measuring, Sweep};
use tapline::truth::TruthOptions;
use tapline::unit::{ReferenceAxis, UnitSpec, check};

fn options() -> SceneOptions {
    SceneOptions { width: 10, height: 10, face_size: Some(32), ..SceneOptions::default() }
}

fn reflections(name: &str) -> EnvJob {
    let settings = UnitSpec::default().settings(ReferenceAxis::Exact);
    let scene = build(name, &options(), &settings).unwrap();
    let map = build_mips(scene.environment());
    EnvJob::new(scene, map, &settings)
}

fn rays() -> HitJob {
    HitJob::built_in(hit::build("room", &options()).unwrap())
}

fn cones() -> TexJob {
    let scene = tex::build("convex", &options(), None).unwrap();
    let sky: CubeMap = build_mips(tapline::scene::environment::procedural(16));
    TexJob::new(scene, sky)
}

/// A lone run, as `compare` makes it.
fn lone(job: &Job, spec: &UnitSpec) -> Rendering {
    let settings = &spec.settings(ReferenceAxis::Exact);
    let setup = Setup { spec, settings, truth: TruthOptions::default(), gpu: None };
    job.render(EngineKind::Rtl, &setup, &|_| {}).unwrap()
}

/// Sets every knob of the unit to another value, one after the other, and compares each run with a lone one. A few
/// combinations switch on what is off by default.
fn every_knob_gives_the_bits_of_a_lone_run(job: Job) {
    let mut bench = Sweep::new(job);
    let mut bases = vec![UnitSpec::default()];
    for sets in [
        &[
            ("footprint.weights", "gaussian"),
            ("footprint.count", "feline"),
            ("hit.method", "secant"),
        ][..],
        &[("jacobian.dnmod", "frame"), ("eigen.minor", "det"), ("hit.footprint", "plane")],
    ] {
        let mut base = UnitSpec::default();
        for (path, value) in sets {
            base.set(path, &tapline::unit::knobs::Value::Text((*value).into())).unwrap();
        }
        bases.push(base);
    }
    let (mut tried, mut kept, mut changed) = (0, 0, 0);
    for base in &bases {
        let plain = picture_hash(&lone(bench.job(), base).picture);
        for knob in base.knobs() {
            // What these change is the scene, not the unit.
            if knob.path.starts_with("roughness.interpolate")
                || knob.path.starts_with("roughness.curvature")
            {
                continue;
            }
            let legal = |value: &tapline::unit::knobs::Value| {
                let mut spec = base.clone();
                (spec.set(&knob.path, value).is_ok() && check(&spec).is_ok()).then_some(spec)
            };
            // On the second and third base one knob out of four is enough.
            tried += 1;
            if !std::ptr::eq(base, &raw const bases[0]) && tried % 4 != 0 {
                continue;
            }
            let Some(spec) =
                others(&knob.path, &knob.value, &knob.legal).iter().rev().find_map(legal)
            else {
                continue;
            };
            // The distances' memory has limits that no check of a unit knows.
            let Ok((mine, _, saved)) = bench.render(&spec, true) else {
                assert!(knob.path.starts_with("registers.hit.distance."), "{}", knob.path);
                continue;
            };
            let alone = lone(bench.job(), &spec);
            let place = &knob.path;
            assert_eq!(mine.picture, alone.picture, "{place}: picture");
            assert_eq!((mine.probes, mine.texels), (alone.probes, alone.texels), "{place}");
            assert_eq!(mine.flags, alone.flags, "{place}: flags");
            let searches = |r: &Rendering| {
                r.searches.as_ref().map(|s| (s.status.clone(), s.iterations.clone()))
            };
            assert_eq!(searches(&mine), searches(&alone), "{place}: searches");
            let tiles = |r: &Rendering| r.texture_use.as_ref().map(|u| u.tiles.clone());
            assert_eq!(tiles(&mine), tiles(&alone), "{place}: tiles");
            kept += usize::from(saved.kept > 0);
            changed += usize::from(picture_hash(&mine.picture) != plain);
        }
    }
    assert!(kept > 50, "only {kept} runs found something to keep");
    assert!(changed > 30, "only {changed} knobs changed the picture");
}

#[test]
fn reflections_from_kept_steps_equal_a_lone_run_for_every_knob() {
    every_knob_gives_the_bits_of_a_lone_run(Job::Env(Box::new(reflections("scratches"))));
}

#[test]
fn rays_from_kept_steps_equal_a_lone_run_for_every_knob() {
    every_knob_gives_the_bits_of_a_lone_run(Job::Hit(Box::new(rays())));
}

#[test]
fn textures_from_kept_steps_equal_a_lone_run_for_every_knob() {
    every_knob_gives_the_bits_of_a_lone_run(Job::Tex(Box::new(cones())));
}

#[test]
fn figures_with_and_without_reuse_are_the_same() {
    for scene in [
        || Job::Env(Box::new(reflections("sphere"))),
        || Job::Hit(Box::new(rays())),
        || Job::Tex(Box::new(cones())),
    ] {
        let how = |reuse| Measuring {
            against: vec![EngineKind::F64, EngineKind::Ewa],
            truth: TruthOptions::default(),
            exposure: 0.0,
            cost: CostModel::default(),
            reuse,
            figures: Vec::new(),
        };
        let (mut keeps, mut forgets) = (Sweep::new(scene()), Sweep::new(scene()));
        let mut seen = Vec::new();
        for (path, value) in [
            ("filter.weight_bits", 6),
            ("footprint.max_probes", 4),
            ("registers.footprint.width.frac", 6),
            ("filter.weight_bits", 6),
            ("registers.address.s.frac", 5),
        ] {
            let mut spec = UnitSpec::default();
            spec.set(path, &tapline::unit::knobs::Value::Integer(value)).unwrap();
            let settings = spec.settings(ReferenceAxis::Exact);
            let a = keeps.measure(&spec, &settings, &how(true)).unwrap();
            let b = forgets.measure(&spec, &settings, &how(false)).unwrap();
            assert_eq!(a.measures, b.measures, "{path}");
            assert!(a.measures.get("mean_lsb8").unwrap() > 0.0);
            assert!(a.measures.get("tiles").unwrap() > 0.0);
            seen.push(format!("{:?}", a.measures));
        }
        seen.sort();
        seen.dedup();
        assert_eq!(seen.len(), 4, "different units must have different figures");
        assert!(keeps.saved[0] > 0 && forgets.saved[0] == 0);
    }
}
