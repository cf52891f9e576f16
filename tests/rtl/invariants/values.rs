//! The colour and the texels that it is made of.

use std::ops::RangeInclusive;

use proptest::prelude::*;
use rtl_model::regs::Reg;
use rtl_model::texture::Texture;
use tapline::cube::{CubeLevel, CubeMap, across_edge, direction};
use tapline::engine::encode;
use tapline::engine::probe::Code;
use tapline::fragment::Fragment;
use tapline::unit::{UnitSpec, file};

use support::reference::{Draw, PLAIN, Random, map, smaller};
use support::rtl::{Traced, lod, trace};
use tapline::conformance::extremes::straight;

/// A unit with these settings.
fn unit(sets: &[&str]) -> UnitSpec {
    let sets: Vec<String> = sets.iter().map(ToString::to_string).collect();
    file::load(None, &sets).unwrap().0
}

/// Every count, weight and axis that a footprint can have, with rounded and with exact weights.
fn units() -> Vec<UnitSpec> {
    let mut all = vec![];
    for count in ["ceil", "round", "pow2", "feline"] {
        for weights in ["box", "gaussian"] {
            for axis in ["eigen-table", "eigen-exact", "longer-derivative"] {
                for bits in [3, 8] {
                    all.push(unit(&[
                        &format!("footprint.count={count}"),
                        &format!("footprint.weights={weights}"),
                        &format!("footprint.axis={axis}"),
                        &format!("filter.weight_bits={bits}"),
                        &format!("filter.lod_bits={bits}"),
                    ]));
                }
            }
        }
    }
    all
}

/// Half floats of many magnitudes: the unit holds each exactly.
fn texel(random: &mut Random) -> f32 {
    half::f16::from_bits((random.word() % 0x7800) as u16).to_f32()
}

/// A map of texels at random on every level: no level is the mean of another.
fn noise(size: usize, random: &mut Random) -> CubeMap {
    let mut map = map(size, |_, _, _| [0.0; 3]);
    for level in &mut map.levels {
        level.texels.iter_mut().for_each(|t| *t = [0; 3].map(|_| texel(random)));
    }
    map
}

/// A fragment whose footprint is neither a point nor the whole sky.
fn fragment(random: &mut Random) -> Fragment {
    let scale = libm::exp2(-4.0 + 3.0 * random.signed());
    Fragment { h: None, ..smaller(&random.fragment(), scale) }
}

fn texture(spec: &UnitSpec, map: &CubeMap) -> Texture {
    encode::texture(&spec.config, map).unwrap()
}

/// The texels of a level under one probe, those of the faces beside it included; a corner stands for its three.
fn under(level: &CubeLevel, face: usize, s: Code, t: Code) -> Vec<[f32; 3]> {
    let taps = |c: Code| -> RangeInclusive<i64> {
        let low = c.raw >> c.frac;
        low..=low + i64::from(c.raw != low << c.frac)
    };
    let last = i64::try_from(level.size).unwrap() - 1;
    let mut texels = vec![];
    for y in taps(t) {
        for x in taps(s) {
            let (inner_x, inner_y) = (x.clamp(0, last), y.clamp(0, last));
            let places = if x != inner_x && y != inner_y {
                vec![(inner_x, inner_y), (x, inner_y), (inner_x, y)]
            } else {
                vec![(x, y)]
            };
            texels.extend(places.into_iter().map(|(x, y)| {
                let (face, x, y) = across_edge(level.size, face, x, y).unwrap();
                level.texel(face, x, y)
            }));
        }
    }
    texels
}

/// Every texel that a fragment's probes touch; `None` where a probe went to another face.
fn touched(map: &CubeMap, t: &Traced) -> Option<Vec<[f32; 3]>> {
    if t.flagged("address.other_face") {
        return None;
    }
    let first = lod(t).floor() as usize;
    let mut all = vec![];
    for probe in t.probe.get(Reg::AddrS).chunks(4) {
        for (level, st) in probe.chunks(2).enumerate() {
            if st[0].is_written() {
                let level = map.levels.get(first + level)?;
                all.extend(under(level, t.out.face, st[0], st[1]));
            }
        }
    }
    Some(all)
}

#[test]
fn a_constant_texture_is_that_constant_whatever_the_footprint() {
    let mut random = Random::new(31);
    let mut several = 0;
    for spec in units() {
        for _ in 0..40 {
            let color = [0; 3].map(|_| texel(&mut random));
            let texture = texture(&spec, &map(8, |_, _, _| color));
            let t = trace(&spec, &fragment(&mut random), 8, Some(&texture));
            assert_eq!(t.values(Reg::FilterColor), color.map(f64::from));
            several += u32::from(t.out.probes > 1);
        }
    }
    assert!(several > 300, "{several}");
}

#[test]
fn a_colour_lies_between_the_least_and_the_most_of_the_texels_touched() {
    let mut random = Random::new(32);
    let (mut seen, mut edges) = (0, 0);
    for spec in units() {
        let map = noise(16, &mut random);
        let texture = texture(&spec, &map);
        for _ in 0..60 {
            let t = trace(&spec, &fragment(&mut random), 16, Some(&texture));
            let Some(texels) = touched(&map, &t) else {
                continue;
            };
            for (c, found) in t.values(Reg::FilterColor).into_iter().enumerate() {
                let values = texels.iter().map(|t| f64::from(t[c]));
                let least = values.clone().fold(f64::INFINITY, f64::min);
                let most = values.fold(0.0, f64::max);
                // Exact: the sums are, texels have at most the 24 fraction bits of the colour, and what lies between
                // two numbers of a format rounds to one that does.
                assert!(least <= found && found <= most, "{least} {found} {most}");
            }
            seen += 1;
            edges += u32::from(texels.len() > 8);
        }
    }
    assert!(seen > 1000 && edges > 300, "{seen} {edges}");
}

#[test]
fn a_point_sample_at_a_texels_centre_is_that_texel() {
    let mut random = Random::new(33);
    for (spec, size) in units().iter().zip([1, 2, 8, 16, 64].into_iter().cycle()) {
        let map = noise(size, &mut random);
        let texture = texture(spec, &map);
        for face in 0..6 {
            for _ in 0..12 {
                let [x, y] = [0; 2].map(|_| random.word() as usize % size);
                let [u, v] = [x, y].map(|i| (i as f64 + 0.5) / size as f64 * 2.0 - 1.0);
                let d = direction(face, u, v);
                let f = Fragment { v: d, n: d, ..straight([[0.0; 2]; 2]) };
                let t = trace(spec, &f, size as u32, Some(&texture));
                let want = map.levels[0].texel(face, x, y);
                assert_eq!(t.values(Reg::FilterColor), want.map(f64::from), "{face} {x} {y}");
            }
        }
    }
}

/// Fails where a colour falls from one fragment to the next; how many different colours there are.
fn rises(
    spec: &UnitSpec,
    texture: &Texture,
    size: u32,
    line: impl Iterator<Item = Fragment>,
) -> usize {
    let mut last = f64::NEG_INFINITY;
    let mut steps = 0;
    for f in line {
        let color = trace(spec, &f, size, Some(texture)).value(Reg::FilterColor, 0);
        assert!(color >= last, "{color} after {last}");
        steps += usize::from(color > last);
        last = color;
    }
    steps
}

#[test]
fn a_colour_rises_with_the_weight_of_the_larger_texel_in_every_step_of_the_weight() {
    for bits in 1..=8u32 {
        let spec =
            unit(&[&format!("filter.weight_bits={bits}"), &format!("filter.lod_bits={bits}")]);
        // Along u: columns that grow.
        let columns = texture(&spec, &map(4, |_, x, _| [x as f32; 3]));
        let along = (0..1024).map(|i| {
            let u = -0.75 + 1.5 * f64::from(i) / 1023.0;
            let d = [u, 0.0, 1.0];
            Fragment { v: d, n: d, ..PLAIN }
        });
        let point = |f: Fragment| Fragment { dv_dx: [0.0; 3], dv_dy: [0.0; 3], ..f };
        let steps = rises(&spec, &columns, 4, along.map(point));
        // Three texels' width in steps of 2^−bits; 1024 places meet each of the 3·2^bits + 1 where there are that many.
        assert_eq!(steps, 3 * (1 << bits) + 1, "{bits} bits");
        // From level to level: level 1 is larger than level 0.
        let mut two = map(4, |_, _, _| [0.0; 3]);
        two.levels[1].texels.fill([1.0; 3]);
        let levels = texture(&spec, &two);
        let wider = (0..800).map(|i| {
            let texels = libm::exp2(f64::from(i) / 800.0);
            straight([[texels / 2.0, 0.0], [0.0, texels / 2.0]])
        });
        let steps = rises(&spec, &levels, 4, wider);
        assert!((1 << bits) - 1 <= steps && steps <= (1 << bits) + 1, "{bits} bits: {steps}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// OpenImageIO's test of its anisotropic look-ups: whatever the eccentricity and the angle, the minor axis alone picks the
    /// levels until the probes run out, and the major axis from there on.
    #[test]
    fn ellipses_of_one_width_read_the_same_two_levels_at_every_angle_and_eccentricity(
        eccentricity in 1.0..32.0f64,
        angle in 0.0..std::f64::consts::TAU,
    ) {
        let spec = UnitSpec::default();
        // 2^2.5 texels of a face of 256 wide.
        let width = libm::exp2(2.5) / 128.0;
        let (sin, cos) = (libm::sin(angle), libm::cos(angle));
        let [long, wide] = [width * eccentricity, width];
        let f = straight([[long * cos, -wide * sin], [long * sin, wide * cos]]);
        let t = trace(&spec, &f, 256, None);
        let want = 2.5 + libm::log2((eccentricity / 16.0).max(1.0));
        // Half an LSB of the LOD for its rounding. D's rounding (2^−23) moves λ2² by at most 4·λ1·2^−23 up to the sixteenfold,
        // 16·4·2^−23/λ2 of itself: log2 m moves by 2^−12. The tables add less: a quarter LSB for both.
        prop_assert!((lod(&t) - want).abs() <= 0.75 / 256.0, "{} {want}", lod(&t));
        // M/m − 2^−8, of a ratio that moves by 2^−11 of itself.
        let ratio = eccentricity.min(16.0);
        let slack = 16.0 * libm::exp2(-11.0);
        let [low, high] = [ratio - slack, ratio + slack].map(|r| (r - 1.0 / 256.0).ceil().clamp(1.0, 16.0));
        prop_assert!((low..=high).contains(&(t.out.probes as f64)), "{} {eccentricity}", t.out.probes);
    }
}
