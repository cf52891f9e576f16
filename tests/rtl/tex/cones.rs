//! Cones at cameras and along paths; bare cones on cube maps.

use glam::dvec3;
use rtl_model::fx::Flags;
use tapline::distance::Distance;
use tapline::engine::cones::{Asked, Cones, FloatCones, Larger, RtlCones, walk};
use tapline::engine::hit::HitF64;
use tapline::engine::tex::value;
use tapline::fragment::HitFragment;
use tapline::policy::{ConeEnv, ConeMetric, ConePolicy, ConeRules, SetDiffuse};
use tapline::reference::NoTap;
use tapline::reference::ray_cone::Step;
use tapline::scene::tex::camera::{Camera, Lens};
use tapline::scene::tex::path::{Event, Look, Path};
use tapline::settings::Settings;
use tapline::unit::UnitSpec;

use super::{Random, request, unit};

fn camera(lens: Lens) -> Camera {
    Camera::looking(dvec3(0.3, 1.0, 5.0), dvec3(0.0, 0.4, 0.0), 0.4, [320, 200], lens)
}

/// Half an ulp of the format and 2^−58 of the value, as the model's set-ups promise.
#[test]
fn cameras_agree_within_half_an_ulp() {
    let mut numbers = Random::new(12);
    for format in rtl_model::cone::ConeFormat::ALL {
        let mut spec = UnitSpec::default();
        spec.config.policy.cone.format = *format;
        let cfg = rtl_model::stages::ray_cone::Cfg::new(&spec.config);
        let bits = i32::try_from(format.float().mantissa_bits).unwrap();
        for _ in 0..200 {
            let camera = camera(Lens::Thin { width: 0.3 });
            let mut registers = RtlCones::new(&cfg, &camera);
            let mut doubles = FloatCones::new(&camera, ConeRules::Note, SetDiffuse::Angle);
            let d = unit([0.3 * numbers.signed(), 0.3 * numbers.signed(), -1.0]);
            let pairs = [
                (registers.pinhole(d), doubles.pinhole(d)),
                (registers.thin_lens(d, 0.3), doubles.thin_lens(d, 0.3)),
                (registers.orthographic(), doubles.orthographic()),
            ];
            for (mine, theirs) in pairs {
                for (got, want) in [
                    (value(cfg.angle(mine.angle)), theirs.angle.0),
                    (value(cfg.width(mine.width)), theirs.width.0),
                ] {
                    let half = libm::ldexp(want.abs(), -bits - 1);
                    assert!((got - want).abs() <= half * (1.0 + 1e-9), "{format:?} {got} {want}");
                }
            }
            assert!((registers.pixel_width() - doubles.pixel_width()).abs() < 1e-15);
        }
    }
}

#[test]
fn a_thin_lens_cone_vanishes_in_focus_and_a_pinhole_s_is_a_pixel_wide_there() {
    let camera = camera(Lens::Thin { width: 0.3 });
    let mut doubles = FloatCones::new(&camera, ConeRules::Note, SetDiffuse::Angle);
    let d = unit(camera.w.into());
    let distance = camera.w.length();
    let lens = doubles.thin_lens(d, 0.3);
    let there = doubles.step(lens, Step::Propagate(distance));
    assert!(there.width.0.abs() < 1e-15);
    let pinhole = doubles.pinhole(d);
    let there = doubles.step(pinhole, Step::Propagate(distance));
    assert!((there.width.0 / doubles.pixel_width() - 1.0).abs() < 1e-12);
}

/// A path that is asked at the first hit, after a mirror, and by the sky.
fn path(d: [f64; 3]) -> Path {
    let look = |bounce| {
        Event::Look(Look {
            texture: 0,
            fragment: request(d, [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
            weight: 1.0,
            bounce,
        })
    };
    Path {
        direction: d,
        events: vec![
            Event::Step(Step::Propagate(3.0)),
            look(0),
            Event::Step(Step::Reflect(2.0)),
            Event::Step(Step::Propagate(2.0)),
            look(1),
            Event::Sky { direction: d, weight: 1.0 },
        ],
    }
}

fn asked(lens: Lens, policy: &ConePolicy) -> Vec<f64> {
    let camera = camera(lens);
    let mut doubles = FloatCones::new(&camera, ConeRules::Note, SetDiffuse::Angle);
    let mut out = Vec::new();
    walk(&mut doubles, policy, lens, &path(unit(camera.w.into())), &mut |asked, cone| {
        out.push(match asked {
            Asked::Look(_) => cone.width.0,
            Asked::Sky(..) => cone.angle.0,
        });
    });
    out
}

#[test]
fn the_wider_cone_counts_but_at_the_first_hit_of_a_pinhole() {
    let camera = camera(Lens::Pinhole);
    let doubles = FloatCones::new(&camera, ConeRules::Note, SetDiffuse::Angle);
    let pixel = doubles.pixel_width();
    let distance = camera.w.length();
    // At 3 of about 5 units the lens of one pixel's width is wider on the near side: 1 − 3/5 < 3/5, not here.
    let two = asked(Lens::Pinhole, &ConePolicy::default());
    let first = pixel * 3.0 / distance;
    assert!((two[0] / first - 1.0).abs() < 1e-12);
    // After the mirror: both by hand, k = 2.
    let pinhole_angle = pixel / distance + 4.0 * first;
    let lens_width = pixel - first;
    let lens_angle = -pixel / distance + 4.0 * lens_width;
    let want = (first + 2.0 * pinhole_angle).max((lens_width + 2.0 * lens_angle).abs());
    assert!((two[1] / want - 1.0).abs() < 1e-12, "{two:?} {want}");
    let one = asked(Lens::Pinhole, &ConePolicy { count: 1, ..ConePolicy::default() });
    assert!((one[1] / (first + 2.0 * pinhole_angle) - 1.0).abs() < 1e-12);
    // A thin lens has no exception: 0.3·(1 − 3/5) is far above a pixel.
    let lens = asked(Lens::Thin { width: 0.3 }, &ConePolicy::default());
    assert!((lens[0] / (0.3 * (1.0 - 3.0 / distance)) - 1.0).abs() < 1e-12);
    // An orthographic camera's first cone is a pixel wide everywhere.
    let flat = asked(Lens::Orthographic, &ConePolicy::default());
    assert!((flat[0] / pixel - 1.0).abs() < 1e-12);
}

#[test]
fn the_distance_metric_knows_nothing_of_mirrors() {
    let camera = camera(Lens::Pinhole);
    let doubles = FloatCones::new(&camera, ConeRules::Note, SetDiffuse::Angle);
    let distance = camera.w.length();
    let policy = ConePolicy { metric: ConeMetric::Distance, ..ConePolicy::default() };
    for lens in [Lens::Pinhole, Lens::Thin { width: 0.3 }] {
        let found = asked(lens, &policy);
        let per_unit = doubles.pixel_width() / distance;
        assert!((found[0] / (3.0 * per_unit) - 1.0).abs() < 1e-12);
        assert!((found[1] / (5.0 * per_unit) - 1.0).abs() < 1e-12);
    }
}

#[test]
fn registers_and_doubles_choose_alike() {
    let spec = UnitSpec::default();
    let cfg = rtl_model::stages::ray_cone::Cfg::new(&spec.config);
    let camera = camera(Lens::Pinhole);
    let registers = RtlCones::new(&cfg, &camera);
    let load = |angle: f64, width: f64| {
        let mut flags = Flags::default();
        cfg.load([angle, width].map(f64::to_bits), &mut cfg.dither(0), &mut flags)
    };
    let (a, b) = (load(-0.5, 0.25), load(0.25, -2.0));
    assert_eq!(registers.choose([a, b], Larger::Width, false), b);
    assert_eq!(registers.choose([a, b], Larger::Angle, false), a);
    assert_eq!(registers.choose([a, b], Larger::Width, true), a);
    // Equal magnitudes: the first.
    let (c, d) = (load(0.5, 2.0), load(-0.5, -2.0));
    assert_eq!(registers.choose([d, c], Larger::Width, false), d);
}

/// λ1/α and λ2/α of a cone of 0.01 rad at a place of face +z, as `cone.env` has it.
fn lambda(env: ConeEnv, [u, v]: [f64; 2]) -> [f64; 2] {
    const ANGLE: f64 = 0.01;
    let mut settings = Settings::default();
    settings.policy.cone.env = env;
    let nothing = Distance::nothing();
    let engine = HitF64::new(&settings, &nothing, None, 256);
    // Face +z: sc = x, tc = −y.
    let ray = HitFragment { x: [0.0; 3], r: [u, -v, 1.0], cone: Some([ANGLE, 0.0]) };
    engine.trace(&ray, &mut NoTap).env.unwrap().lambda.map(|l| l / ANGLE)
}

/// λ of a small cone at (u, v) is α(1 + u² + v²) along the radius and α√(1 + u² + v²) across; the constant is 4α/π.
#[test]
fn otk_s_constant_gradient_is_off_by_27_to_minus_58_per_cent() {
    let steps = (0..=4u8).map(|i| f64::from(i) / 4.0);
    let places = steps.clone().map(|u| [u, 0.0]).chain(steps.map(|u| [u, u]));
    for [u, v] in places {
        let (exact, constant) = (lambda(ConeEnv::Exact, [u, v]), lambda(ConeEnv::Otk, [u, v])[0]);
        let square = 1.0 + u * u + v * v;
        assert!((exact[0] / square - 1.0).abs() < 1e-12, "({u}, {v}) {exact:?}");
        assert!((exact[1] / square.sqrt() - 1.0).abs() < 1e-12);
        assert!((constant * std::f64::consts::PI / 4.0 - 1.0).abs() < 1e-12);
    }
    // The middle, an edge's middle, a corner, as docs/studies/cones.md has them.
    for (place, over) in [
        ([0.0, 0.0], 0.273_239_544_735),
        ([0.5, 0.0], 0.018_591_635_788),
        ([1.0, 0.0], -0.363_380_227_632),
        ([1.0, 1.0], -0.575_586_818_421),
    ] {
        let found = lambda(ConeEnv::Otk, place)[0] / lambda(ConeEnv::Exact, place)[0] - 1.0;
        assert!((found - over).abs() < 1e-9, "{place:?} {found}");
    }
}
