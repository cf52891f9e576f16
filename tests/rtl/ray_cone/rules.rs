//! OptiX Toolkit's rules, cameras, triangles, and the knobs that choose between them.

use rtl_model::Config;
use rtl_model::cone::{ConeFormat, Dyadic, StoreRounding};
use rtl_model::fx::Flags;
use rtl_model::policy::{ConeRules, SetDiffuse};
use rtl_model::stages::ray_cone::{self as rtl, Cfg, Larger, camera};
use tapline::reference::ray_cone::{self as float, Step};

use super::formats::{value, word};
use super::operations::{both, cfg, operands};

fn otk(set_diffuse: SetDiffuse) -> Cfg {
    let mut config = Config::default();
    config.policy.cone.rules = ConeRules::Otk;
    config.policy.cone.set_diffuse = set_diffuse;
    config.policy.cone.rounding = StoreRounding::Truncate;
    Cfg::new(&config)
}

fn step_otk(set_diffuse: SetDiffuse, angle: f64, width: f64, step: Step) -> [f64; 2] {
    let cfg = otk(set_diffuse);
    let ours = both(&cfg, angle, width, step).0;
    let theirs = float::ray_cone(
        float::Cone { angle: float::Angle(angle), width: float::Width(width) },
        step,
        ConeRules::Otk,
        set_diffuse,
    );
    for (a, b) in ours.into_iter().zip([theirs.angle.0, theirs.width.0]) {
        assert!((a - b).abs() <= b.abs() / 128.0, "{ours:?} {theirs:?}");
    }
    ours
}

#[test]
fn otk_leaves_wide_cones_alone_and_narrow_ones_follow_the_note() {
    for step in [Step::Reflect(1.0), Step::Scatter(1.0)] {
        assert_eq!(step_otk(SetDiffuse::Angle, 0.25, 1.0, step), [0.25, 1.0]);
    }
    assert_eq!(step_otk(SetDiffuse::Angle, 0.125, 1.0, Step::Reflect(1.0)), [2.125, 1.0]);
    // The limit is one of α, not of |α|.
    assert_eq!(step_otk(SetDiffuse::Angle, -0.5, 1.0, Step::Reflect(1.0)), [1.5, 1.0]);
}

#[test]
fn otk_scatters_away_from_zero_and_ends_diffuse_with_or_without_the_exchange() {
    let away = step_otk(SetDiffuse::Angle, -0.0625, 1.0, Step::Scatter(1.0));
    assert!(away[0] < -0.0625 && away[1] == 1.0);
    for angle in [-0.125, 0.125] {
        let step = Step::Scatter(0.0);
        assert_eq!(step_otk(SetDiffuse::Angle, angle, -3.0, step), [0.25, 3.0]);
        assert_eq!(step_otk(SetDiffuse::Exchanged, angle, -3.0, step), [3.0, 0.25]);
    }
    // By the note the two never meet: angle stays angle, width stays width.
    assert_eq!(both(&cfg(ConeFormat::Bf16), 0.125, -3.0, Step::Scatter(0.0)).0, [0.375, -3.0]);
}

#[test]
fn cameras_and_the_choice_of_two_cones() {
    let v = |x: [f64; 3]| x.map(word);
    let frame = camera::Frame {
        u: v([3.0, 4.0, 0.0]),
        v: v([0.0, 0.0, 5.0]),
        w: v([0.0, 8.0, 6.0]),
        size: [100, 50],
    };
    let d = v([0.0, 0.8, 0.6]);
    let cfg = cfg(ConeFormat::F32);
    let (mut dither, mut flags) = (cfg.dither(0), Flags::default());
    let near = |code: u32, x: f64| {
        let got = value(cfg.format, code);
        assert!((got - x).abs() <= x.abs() / f64::from(1 << 23), "{got} for {x}");
    };
    // |U|/100 = 0.05 is the smaller; ⟨D, W⟩/⟨W, W⟩ = 0.1.
    let pinhole = camera::pinhole(&cfg, &frame, &d, &mut dither, &mut flags);
    near(pinhole.angle.0, 0.01);
    assert_eq!(pinhole.width.0, 0);
    let lens =
        camera::thin_lens(&cfg, &frame, &d, camera::pixel_width(&frame), &mut dither, &mut flags);
    near(lens.angle.0, -0.01);
    near(lens.width.0, 0.1);
    let flat = camera::orthographic(&cfg, &frame, &mut dither, &mut flags);
    assert_eq!(flat.angle.0, 0);
    near(flat.width.0, 0.1);
    assert!(flags.is_empty());
    assert_eq!(rtl::choose(&cfg, [pinhole, lens], Larger::Width, false), lens);
    assert_eq!(rtl::choose(&cfg, [pinhole, lens], Larger::Width, true), pinhole);
    assert_eq!(rtl::choose(&cfg, [pinhole, flat], Larger::Angle, false), pinhole);
}

#[test]
fn a_triangles_curvature_is_its_flattest_edges_or_zero_where_signs_mix() {
    let v = |x: [f64; 3]| x.map(word);
    let points = [v([0.0, 0.0, 0.0]), v([1.0, 0.0, 0.0]), v([0.0, 2.0, 0.0])];
    let [a, b, c] = &points;
    // Normals of slope p·x and q·y: edges have curvatures p, q and their mean weighted by length².
    let normals = |p: f64, q: f64| [v([0.0, 0.0, 1.0]), v([p, 0.0, 1.0]), v([0.0, 2.0 * q, 1.0])];
    for (p, q, expected) in
        [(0.5, 0.25, 0.25), (-0.5, -0.25, -0.25), (0.5, -0.25, 0.0), (0.5, 0.0, 0.0)]
    {
        let n = normals(p, q);
        let k: Dyadic = camera::triangle_curvature([a, b, c], [&n[0], &n[1], &n[2]]);
        let k = super::formats::real(k);
        assert!((k - expected).abs() < 1e-15, "{p} {q}: {k}");
    }
    // An edge without length has no curvature.
    assert!(camera::edge_curvature([a, a], [b, c]).is_zero());
}

#[test]
fn no_knob_of_the_cones_is_dead() {
    use tapline::unit::UnitSpec;
    use tapline::unit::knobs::Value;
    let text = |t: &str| Value::Text(t.into());
    let run = |spec: &UnitSpec| {
        let cfg = Cfg::new(&spec.config);
        let (mut dither, mut flags) = (cfg.dither(0), Flags::default());
        let mut words = Vec::new();
        for start in [[0.01f64, 0.3], [-0.17, 0.9]] {
            let mut cone = cfg.load(start.map(f64::to_bits), &mut dither, &mut flags);
            for step in
                [Step::Propagate(0.7), Step::Reflect(0.3), Step::Scatter(0.9), Step::Scatter(0.2)]
            {
                cone = rtl::ray_cone(&cfg, cone, operands(step), &mut dither, &mut flags);
                words.push(cone.pack(cfg.format, cfg.order));
            }
        }
        words
    };
    for (path, values, enable) in [
        ("cone.format", vec![text("f16"), text("f32")], None),
        ("cone.rounding", vec![text("truncate"), text("stochastic")], None),
        ("cone.lane_order", vec![text("width-low")], None),
        (
            "cone.seed",
            vec![Value::Integer(1), Value::Integer(4_294_967_295)],
            Some(("cone.rounding", "stochastic")),
        ),
        ("cone.rules", vec![text("otk")], None),
        ("cone.set_diffuse", vec![text("exchanged")], Some(("cone.rules", "otk"))),
    ] {
        let mut base = UnitSpec::default();
        if let Some((other, value)) = enable {
            base.set(other, &text(value)).unwrap();
        }
        for value in values {
            let mut changed = base.clone();
            changed.set(path, &value).unwrap();
            assert_ne!(run(&changed), run(&base), "{path} = {value}");
        }
    }
}
