//! No knob of `hit` is dead: each path, set to another legal value, changes a register or a result of some ray.

use std::collections::BTreeMap;

use rtl_model::Tap;
use rtl_model::regs::Reg;
use tapline::distance::{Distance, DistanceCube};
use tapline::engine::hit::{HitF64, HitResult, HitRtl, words};
use tapline::fragment::HitFragment;
use tapline::unit::knobs::Value;
use tapline::unit::{ReferenceAxis, UnitSpec};

use super::{ROOM, ray, rays};
use support::knobs::{Enables, Sight, assert_none_dead};

/// What must be set for a path to count.
const ENABLES: &Enables = &[
    ("registers.hit.halved", &[("hit.method", "\"illinois\"")]),
    ("registers.hit.inv_normal", &[("hit.footprint", "\"plane\"")]),
    ("registers.hit.normal", &[("hit.footprint", "\"plane\"")]),
    ("registers.hit.cosine", &[("hit.footprint", "\"plane\"")]),
    ("registers.hit.inv_cosine", &[("hit.footprint", "\"plane\"")]),
    ("registers.hit.along", &[("hit.footprint", "\"plane\"")]),
    ("registers.hit.slope", &[("hit.footprint", "\"plane\"")]),
    // Long steps are those of rays that start outside.
    ("registers.hit.step", &[("hit.outside", "\"hlsl\"")]),
    ("registers.hit.d", &[("hit.outside", "\"hlsl\"")]),
];

/// Registers that hold nothing below the symmetric range.
const NEVER_BELOW: &[Reg] = &[
    Reg::HitUv,
    Reg::HitS,
    Reg::HitDistance,
    Reg::HitRadius,
    Reg::HitLength,
    Reg::HitRatio,
    Reg::HitHalved,
];

/// Values (not codes) of every register, by ray.
#[derive(Default)]
struct Values(BTreeMap<(Reg, usize), (i64, i64)>);

impl Tap for Values {
    fn put(&mut self, _: usize, reg: Reg, component: usize, raw: i64, frac: i64) {
        let zeros = if raw == 0 { 0 } else { i64::from(raw.trailing_zeros()) };
        let frac = if raw == 0 { 0 } else { frac - zeros };
        self.0.insert((reg, component), (raw >> zeros, frac));
    }
}

/// A cube with a step in it, an infinite texel and texels of 0.
fn stepped() -> Distance {
    let size = 16;
    let mut texels = vec![2.9f32; 6 * size * size];
    for (i, texel) in texels.iter_mut().enumerate() {
        if i % 7 == 0 {
            *texel = 1.3;
        }
        if i % 97 == 0 {
            *texel = f32::INFINITY;
        }
        if i % 89 == 0 {
            *texel = 0.0;
        }
    }
    DistanceCube::cleaned(size, texels).map_or(ROOM, |(cube, _)| Distance::Cube(cube))
}

fn corpus() -> Vec<HitFragment> {
    let mut out = rays(160);
    // Directions of more bits than their register.
    for ray in &mut out {
        ray.r = ray.r.map(|c| c / 3.0);
    }
    for r in [
        [1.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, -1.0, 0.0],
        [0.0, 0.0, -1.0],
        [-1.0, -1.0, -1.0],
        [-1.0, 1e-3, 0.0],
    ] {
        out.push(ray([0.5, 0.25, -0.125], r));
        out.push(ray([-0.5, -0.25, 0.125], r));
        out.push(ray([3.9, 2.9, 2.4], r));
        out.push(ray([-7.0, -5.0, -4.0], r));
        out.push(ray([-70.0, 0.0, 50.0], r));
        out.push(ray([70.0, 0.0, -50.0], r));
        out.push(ray([0.0; 3], r));
    }
    for ray in &mut out {
        ray.cone = Some([0.002, 0.02]);
    }
    out
}

#[derive(PartialEq)]
struct Run {
    registers: Vec<BTreeMap<(Reg, usize), (i64, i64)>>,
    results: Vec<HitResult>,
}

struct Rays {
    maps: [Distance; 2],
    rays: Vec<HitFragment>,
}

impl Sight for Rays {
    type Seen = Run;

    fn enables(&self) -> &Enables {
        ENABLES
    }

    fn never_below(&self) -> &[Reg] {
        NEVER_BELOW
    }

    fn see(&self, spec: &UnitSpec) -> Option<Run> {
        let mut out = Run { registers: Vec::new(), results: Vec::new() };
        for map in &self.maps {
            let engine = HitRtl::new(spec, map, None, 64).ok()?;
            for ray in &self.rays {
                let mut values = Values::default();
                let (block, results) = engine.lanes::<1, _>(&[words(ray)], &mut values);
                out.registers.push(values.0);
                out.results.push(engine.result(&block, &results, 0));
            }
        }
        Some(out)
    }

    fn differs(&self, base: &Run, other: &UnitSpec) -> Option<bool> {
        self.see(other).map(|other| other != *base)
    }

    fn saturated(&self, seen: &Run, reg: Reg) -> bool {
        let flag = format!("hit.{}.saturated", reg.info().name);
        seen.results.iter().any(|r| r.flags.contains(&flag))
    }
}

#[test]
fn no_knob_of_hit_is_dead() {
    let rays = Rays { maps: [ROOM, stepped()], rays: corpus() };
    let ours = |path: &str| path.starts_with("hit.") || path.starts_with("registers.hit.");
    assert_none_dead(&rays, ours, 91);
}

#[test]
fn f64_honours_every_policy_of_hit() {
    let maps = [ROOM, stepped()];
    let rays = corpus();
    let results = |spec: &UnitSpec| -> Vec<HitResult> {
        let settings = spec.settings(ReferenceAxis::Exact);
        let all = maps.iter().flat_map(|map| {
            let engine = HitF64::new(&settings, map, None, 64);
            engine.filter(&rays, &|_| {})
        });
        all.collect()
    };
    let base = results(&UnitSpec::default());
    for (path, values) in [
        ("hit.method", &["secant", "illinois"][..]),
        ("hit.lookup", &["nearest"]),
        ("hit.outside", &["hlsl"]),
        ("hit.tolerance_bits", &["off"]),
    ] {
        for value in values {
            let mut spec = UnitSpec::default();
            let text = Value::Text((*value).into());
            spec.set(path, &text).expect("a legal setting");
            assert_ne!(results(&spec), base, "{path} = {value}");
        }
    }
    let mut spec = UnitSpec::default();
    spec.set("hit.iterations", &Value::Integer(3)).expect("legal");
    assert_ne!(results(&spec), base);
    // The footprint's shape shows in D.
    let mut plane = UnitSpec::default();
    let shape = Value::Text("plane".into());
    plane.set("hit.footprint", &shape).expect("legal");
    let d = |spec: &UnitSpec| {
        let settings = spec.settings(ReferenceAxis::Exact);
        let engine = HitF64::new(&settings, &ROOM, None, 64);
        let both = engine.trace(&rays[0], &mut tapline::reference::NoTap);
        both.env.map(|env| env.d)
    };
    assert_ne!(d(&plane), d(&UnitSpec::default()));
}
