//! HIT and TEX: the integer model beside the float reference.

use std::hint::black_box;

use tapline::cube::direction;
use tapline::distance::{Distance, DistanceCube};
use tapline::engine::float::F64Engine;
use tapline::engine::hit::{HitF64, HitRtl};
use tapline::engine::job::Compile as _;
use tapline::engine::{Engine, TexJob};
use tapline::fragment::HitFragment;
use tapline::mips::build_mips;
use tapline::policy::LookUp;
use tapline::reference::Distances;
use tapline::scene::{SceneOptions, environment, tex};
use tapline::unit::{ReferenceAxis, UnitSpec};

use super::{Table, threads, time};

/// Rays in a box room: the search alone, and with a cone the footprint behind it.
pub(crate) fn hit(rounds: usize, table: &mut Table) {
    const RAYS: u32 = 16 * 1024;
    let spec = UnitSpec::default();
    let room = Distance::Box([4.0, 3.0, 2.5]);
    let settings = spec.settings(ReferenceAxis::Exact);
    let cube = distance_cube(128);
    let rays = |cone| -> Vec<HitFragment> {
        let place = |i: u32, by: u32| f64::from(i.wrapping_mul(by) >> 8) / 8_388_608.0 - 1.0;
        (0..RAYS)
            .map(|i| HitFragment {
                x: [2_654_435_769, 3_144_134_277, 1_640_531_527].map(|by| 2.0 * place(i, by)),
                r: [2_246_822_519, 3_266_489_917, 668_265_263].map(|by| place(i, by)),
                cone,
            })
            .collect()
    };
    let ideal = HitRtl::new(&spec, &room, None, 256).expect("the default unit");
    let mapped = HitRtl::new(&spec, &cube, None, 256).expect("the default unit");
    let float = HitF64::new(&settings, &cube, None, 256);
    table.head("HIT, ns a ray", &["rtl, cube", "rtl, box", "f64, cube", "f64 / rtl"]);
    for (name, cone) in [("search", None), ("search and footprint", Some([0.001, 0.01]))] {
        let rays = rays(cone);
        let mut seconds = [f64::INFINITY; 3];
        for _ in 0..rounds {
            threads(1, || {
                time(&mut seconds[0], || black_box(mapped.filter(&rays, &|_| {})));
                time(&mut seconds[1], || black_box(ideal.filter(&rays, &|_| {})));
                time(&mut seconds[2], || black_box(float.filter(&rays, &|_| {})));
            });
        }
        let [a, b, c] = seconds.map(|s| s * 1e9 / f64::from(RAYS));
        println!("| {name} | {a:.0} | {b:.0} | {c:.0} | **{:.2}** |", c / a);
    }
}

/// A path-traced scene of each kind: seconds of the engines without the paths.
pub(crate) fn tex(rounds: usize, table: &mut Table) {
    let spec = UnitSpec::default();
    let settings = spec.settings(ReferenceAxis::Exact);
    table.head("TEX whole, ns a request", &["rtl", "f64", "f64 / rtl"]);
    for info in tex::TEX_SCENES {
        let options = SceneOptions { width: 192, height: 192, ..SceneOptions::default() };
        let scene = tex::build(info.name, &options, None).expect("a built-in scene");
        let job = TexJob::new(scene, build_mips(environment::procedural(64)));
        let engine = job.rtl(&spec).expect("the default unit");
        let float = F64Engine { settings: settings.clone() };
        let mut seconds = [f64::INFINITY; 2];
        for _ in 0..rounds.min(5) {
            threads(1, || {
                let of = |engine: &dyn Engine<TexJob>| {
                    engine.render(&job, &|_| {}).map_or(f64::INFINITY, |r| r.seconds)
                };
                seconds[0] = seconds[0].min(of(&engine));
                seconds[1] = seconds[1].min(of(&float));
            });
        }
        let [a, b] = seconds.map(|s| s * 1e9 / job.requests as f64);
        println!("| {} | {a:.0} | {b:.0} | **{:.2}** |", info.name, b / a);
    }
}

/// The room's distances in a cube map.
fn distance_cube(size: usize) -> Distance {
    let ideal = Distances::new(&Distance::Box([4.0, 3.0, 2.5]));
    let place = |i: usize| (2 * i + 1) as f64 / size as f64 - 1.0;
    let texels = (0..6 * size * size)
        .map(|i| {
            let (face, x, y) = (i / (size * size), i % size, i / size % size);
            let q = direction(face, place(x), place(y));
            ideal.read(q, LookUp::Bilinear) as f32
        })
        .collect();
    Distance::Cube(DistanceCube { size, texels })
}
