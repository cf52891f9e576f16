//! The integer model's hits in the built-in worlds, beside the float reference's.

use tapline::base::vector::degrees;
use tapline::distance::Distance;
use tapline::engine::hit::{HitF64, HitRtl};
use tapline::impostor::Impostor;
use tapline::scene::SceneOptions;
use tapline::scene::hit::build;
use tapline::unit::{ReferenceAxis, UnitSpec};

/// The bound that the word lengths were chosen for: 0.1° for 99 of 100 rays.
#[test]
fn rtl_hits_within_a_tenth_of_a_degree_of_f64_at_the_99th_percentile() {
    let spec = UnitSpec::default();
    for name in ["room", "columns", "doorway"] {
        let options = SceneOptions { width: 96, height: 96, ..SceneOptions::default() };
        let scene = build(name, &options).expect("a built-in scene");
        let impostor = Impostor::build(&scene.view.world, glam::DVec3::ZERO, scene.face_size);
        let distance = Distance::Cube(impostor.distance);
        let rays: Vec<_> = scene.rays.iter().map(|ray| ray.fragment).collect();
        let rtl = HitRtl::new(&spec, &distance, None, 256).expect("the default unit");
        let float = HitF64::new(&spec.settings(ReferenceAxis::Exact), &distance, None, 256);
        let (here, there) = (rtl.filter(&rays, &|_| {}), float.filter(&rays, &|_| {}));
        let mut errors: Vec<f64> =
            here.iter().zip(&there).map(|(a, b)| degrees(a.l, b.l)).collect();
        errors.sort_by(f64::total_cmp);
        let p99 = errors[errors.len() * 99 / 100];
        println!("{name}: {} rays, p99 {p99:.5} degrees", errors.len());
        assert!(errors.len() > 5000 && p99 > 0.0);
        assert!(p99 < 0.1, "{name}: {p99} degrees");
    }
}
