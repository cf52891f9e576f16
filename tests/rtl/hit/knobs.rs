//! No knob of `hit` is dead: each path, set to another legal value, changes a register or a result of some ray.

use std::collections::BTreeMap;

use rtl_model::Tap;
use rtl_model::fx::Overflow;
use rtl_model::regs::{Kind, Reg};
use tapline::distance::{Distance, DistanceCube};
use tapline::engine::hit::{HitF64, HitResult, HitRtl, words};
use tapline::fragment::HitFragment;
use tapline::unit::knobs::Value;
use tapline::unit::{ReferenceAxis, UnitSpec};

use super::{ROOM, ray, rays};
use support::knobs::others;

/// What must be set for a path to count.
const ENABLES: &[(&str, &[(&str, &str)])] = &[
    ("registers.hit.halved", &[("hit.method", "illinois")]),
    ("registers.hit.inv_normal", &[("hit.footprint", "plane")]),
    ("registers.hit.normal", &[("hit.footprint", "plane")]),
    ("registers.hit.cosine", &[("hit.footprint", "plane")]),
    ("registers.hit.inv_cosine", &[("hit.footprint", "plane")]),
    ("registers.hit.along", &[("hit.footprint", "plane")]),
    ("registers.hit.slope", &[("hit.footprint", "plane")]),
    // Long steps are those of rays that start outside.
    ("registers.hit.step", &[("hit.outside", "hlsl")]),
    ("registers.hit.d", &[("hit.outside", "hlsl")]),
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

struct Run {
    registers: Vec<BTreeMap<(Reg, usize), (i64, i64)>>,
    results: Vec<HitResult>,
}

fn run(spec: &UnitSpec, maps: &[Distance], rays: &[HitFragment]) -> Option<Run> {
    let mut out = Run { registers: Vec::new(), results: Vec::new() };
    for map in maps {
        let engine = HitRtl::new(spec, map, None, 64).ok()?;
        for ray in rays {
            let mut values = Values::default();
            let (block, results) = engine.lanes::<1, _>(&[words(ray)], &mut values);
            out.registers.push(values.0);
            out.results.push(engine.result(&block, &results, 0));
        }
    }
    Some(out)
}

fn enabled(path: &str) -> UnitSpec {
    let mut spec = UnitSpec::default();
    for (prefix, settings) in ENABLES {
        if path.starts_with(&format!("{prefix}.")) {
            for (path, value) in *settings {
                let value = Value::Text((*value).into());
                spec.set(path, &value).expect("a legal setting");
            }
        }
    }
    spec
}

/// Overflow modes that show nowhere while the register is shortened bit by bit.
fn dead_modes(reg: Reg, maps: &[Distance], rays: &[HitFragment]) -> Vec<String> {
    let info = reg.info();
    let path = format!("registers.{}.{}", info.stage, info.name);
    let mut spec = enabled(&format!("{path}.overflow"));
    let flag = format!("{}.{}.saturated", info.stage, info.name);
    let mut left: Vec<Overflow> = Overflow::ALL
        .iter()
        .copied()
        .filter(|m| *m != Overflow::Saturate)
        .filter(|m| *m != Overflow::SaturateSymmetric || !NEVER_BELOW.contains(&reg))
        .collect();
    let widest = spec.config.format(reg).magnitude_bits();
    for bits in (1..=widest).rev() {
        // Integer bits first; below them the register keeps fewer of the fraction and none of the whole.
        let format = &mut spec.config.formats[reg.index()];
        format.int = format.int.saturating_sub(1);
        let _ = bits;
        let Some(base) = run(&spec, maps, rays) else {
            continue;
        };
        if base.results.iter().any(|r| r.flags.contains(&flag)) {
            left.retain(|mode| {
                let mut other = spec.clone();
                other.config.formats[reg.index()].overflow = *mode;
                run(&other, maps, rays).is_none_or(|o| o.registers == base.registers)
            });
        }
        if left.is_empty() || spec.config.format(reg).int == 0 {
            break;
        }
    }
    left.iter().map(|m| format!("{path}.overflow = {}", m.name())).collect()
}

#[test]
fn no_knob_of_hit_is_dead() {
    let maps = [ROOM, stepped()];
    let rays = corpus();
    let mut dead = Vec::new();
    let mut tried = 0;
    for knob in UnitSpec::default().knobs() {
        let path = knob.path.as_str();
        if !path.starts_with("hit.") && !path.starts_with("registers.hit.") {
            continue;
        }
        tried += 1;
        let reg = path
            .strip_prefix("registers.hit.")
            .and_then(|rest| Reg::find("hit", rest.split('.').next()?));
        if let (Some(reg), true) = (reg, path.ends_with(".overflow")) {
            assert_eq!(reg.info().kind, Kind::Fixed);
            dead.extend(dead_modes(reg, &maps, &rays));
            continue;
        }
        let spec = enabled(path);
        let base = run(&spec, &maps, &rays).expect("a legal unit");
        let value = spec.get(path).expect("a listed path");
        let each = matches!(value, Value::Text(_)) && reg.is_none();
        let mut shown = false;
        for value in others(&value, &knob.legal) {
            let mut other = spec.clone();
            if other.set(path, &value).is_err() {
                continue;
            }
            let Some(changed) = run(&other, &maps, &rays) else {
                continue;
            };
            let differs = changed.registers != base.registers || changed.results != base.results;
            shown |= differs;
            if each && !differs {
                dead.push(format!("{path} = {value}"));
            }
            if shown && !each {
                break;
            }
        }
        if !shown {
            dead.push(path.into());
        }
    }
    assert!(tried > 90, "only {tried} paths");
    assert!(dead.is_empty(), "{} dead of {tried}: {dead:#?}", dead.len());
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
