//! 2-D textures: addressing, mip chains, the shared back end.

use rtl_model::cone::Cone;
use tapline::engine::dispatch::Source;
use tapline::engine::tex::{TexRtl, words};
use tapline::fragment::TexFragment;
use tapline::mips::build_planar_mips;
use tapline::planar::{PlanarLevel, PlanarMap};
use tapline::policy::Wrap;
use tapline::reference::tex::tex;
use tapline::reference::{NoTap, PlanarTexture, Prepared};
use tapline::unit::{ReferenceAxis, UnitSpec};

use super::{Random, request};

/// Texels of few bits, so that the half format holds them.
fn texture(size: [usize; 2], seed: u64) -> PlanarMap {
    let mut numbers = Random::new(seed);
    let mut byte = || f32::from(u8::try_from(numbers.word() >> 56).unwrap_or(0)) / 256.0;
    let texels = (0..size[0] * size[1]).map(|_| [byte(), byte(), byte()]).collect();
    build_planar_mips(PlanarLevel { size, texels })
}

fn at(st: [f64; 2]) -> TexFragment {
    TexFragment {
        st,
        ..request([0.2, -1.0, 0.1], [0.0, 1.0, 0.0], [3.0, 0.0, 0.0], [0.4, 0.0, 2.0])
    }
}

fn spec(wrap: Wrap) -> UnitSpec {
    let mut spec = UnitSpec::default();
    let address = &mut spec.config.policy.address;
    (address.wrap_s, address.wrap_t) = (wrap, wrap);
    spec
}

/// Both engines' colours of a request with a width that bf16 holds.
fn colours(spec: &UnitSpec, map: &PlanarMap, fragment: &TexFragment, width: f64) -> [[f64; 3]; 2] {
    let engine = TexRtl::new(spec, map).unwrap();
    let cfg = &engine.unit.cone;
    let mut flags = rtl_model::fx::Flags::default();
    let cone = cfg.load([0, width.to_bits()], &mut cfg.dither(0), &mut flags);
    let mut rtl = [0.0; 3];
    engine.blocks(Source::Words(&[words(fragment, cone)]), &mut |block, out| {
        rtl = engine.result(block, out, 0).color;
    });
    let settings = spec.settings(ReferenceAxis::Table);
    let texture = PlanarTexture::new(map, settings.policy.address.wrap());
    let prepared = Prepared::new(&settings);
    let there = tex(&prepared, width, fragment, map.size(), Some(&texture), &mut NoTap);
    [rtl, there.color]
}

#[test]
fn a_point_sample_at_a_texel_centre_is_the_texel() {
    for size in [[1, 1], [5, 3], [16, 64], [31, 7]] {
        let map = texture(size, 3);
        for (i, texel) in map.levels[0].texels.iter().enumerate() {
            let [x, y] = [i % size[0], i / size[0]];
            let centre = |n: usize, of: usize| (2 * n + 1) as f64 / (2 * of) as f64;
            let fragment = at([centre(x, size[0]), centre(y, size[1])]);
            let [rtl, float] = colours(&spec(Wrap::Repeat), &map, &fragment, 0.0);
            for c in 0..3 {
                let want = f64::from(texel[c]);
                // s of 24 fraction bits misses a centre of 1/31 by 2^-25: less than half a sub-texel step of 2^-8.
                assert!((rtl[c] - want).abs() <= f64::EPSILON, "{size:?} {x} {y}");
                // Doubles miss it by 2^-53·31, times a step between texels of at most 1.
                assert!((float[c] - want).abs() < 1e-13);
            }
        }
    }
}

#[test]
fn beyond_the_edges_every_mode_shows_what_it_says() {
    let map = texture([8, 4], 9);
    let level = &map.levels[0];
    for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror] {
        for step in -24..=24 {
            let x = i64::from(step);
            let s = (x as f64 + 0.5) / 8.0;
            let inside = match wrap {
                Wrap::Repeat => x.rem_euclid(8),
                Wrap::Clamp => x.clamp(0, 7),
                Wrap::Mirror => {
                    let turn = x.rem_euclid(16);
                    if turn < 8 { turn } else { 15 - turn }
                }
            };
            let want = level.texel(usize::try_from(inside).unwrap(), 1);
            let [rtl, float] = colours(&spec(wrap), &map, &at([s, 0.375]), 0.0);
            for c in 0..3 {
                assert!((rtl[c] - f64::from(want[c])).abs() <= f64::EPSILON, "{wrap:?} {x}");
                assert!((float[c] - f64::from(want[c])).abs() < 1e-13, "{wrap:?} {x}");
            }
        }
    }
}

#[test]
fn between_texels_at_an_edge_the_border_counts_half() {
    let map = texture([8, 4], 9);
    let level = &map.levels[0];
    let mean = |a: [f32; 3], b: [f32; 3]| [0, 1, 2].map(|c| f64::from(a[c] + b[c]) / 2.0);
    let cases = [
        (Wrap::Repeat, mean(level.texel(7, 1), level.texel(0, 1))),
        (Wrap::Clamp, mean(level.texel(0, 1), level.texel(0, 1))),
        (Wrap::Mirror, mean(level.texel(0, 1), level.texel(0, 1))),
    ];
    for (wrap, want) in cases {
        let [rtl, float] = colours(&spec(wrap), &map, &at([0.0, 0.375]), 0.0);
        for c in 0..3 {
            assert!((rtl[c] - want[c]).abs() <= f64::EPSILON, "{wrap:?}: {rtl:?} {want:?}");
            assert!((float[c] - want[c]).abs() < 1e-13, "{wrap:?}: {float:?} {want:?}");
        }
    }
}

/// The integer model filters as the reference does up to its words.
///
/// The LOD has 8 bits after an error of ½ + 2^-8·… of its register, the bilinear weights 8 bits; a step between
/// neighbouring texels is at most 1. Two bilinear weights of ½·2^-8, one LOD weight of 2^-8 and a probe's place off by
/// ½·2^-8 texels in two directions: under 4·2^-8 of the largest step, which is below 1.
#[test]
fn filtered_colours_match_within_four_steps_of_the_weights() {
    let mut numbers = Random::new(77);
    let maps = [texture([64, 64], 1), texture([96, 33], 2), texture([7, 128], 3)];
    let mut largest = 0.0f64;
    for i in 0..600 {
        let map = &maps[i % 3];
        let wrap = [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror][i / 3 % 3];
        let st = [3.0 * numbers.signed(), 3.0 * numbers.signed()];
        let n = [0.1 * numbers.signed(), 1.0, 0.1 * numbers.signed()];
        let d = numbers.vector();
        let fragment = TexFragment { st, ..request(d, n, [3.0, 0.0, 0.0], [0.4, 0.0, 2.0]) };
        let width =
            f64::from(128 + u32::try_from(i % 128).unwrap()) * libm::exp2(-16.0 + (i % 9) as f64);
        let [rtl, float] = colours(&spec(wrap), map, &fragment, width);
        for c in 0..3 {
            let error = (rtl[c] - float[c]).abs();
            assert!(error <= 4.0 / 256.0, "{i} {wrap:?}: {rtl:?} {float:?}");
            largest = largest.max(error);
        }
    }
    assert!(largest > 1e-4, "words must show");
}

#[test]
fn a_constant_texture_stays_constant() {
    let colour = [0.3125, 2.0, 0.0625];
    for size in [[1, 1], [3, 5], [64, 16]] {
        let map = build_planar_mips(PlanarLevel { size, texels: vec![colour; size[0] * size[1]] });
        let mut numbers = Random::new(4);
        for _ in 0..100 {
            let fragment = at([9.0 * numbers.signed(), 9.0 * numbers.signed()]);
            let width = libm::exp2(8.0 * numbers.signed());
            for found in colours(&UnitSpec::default(), &map, &fragment, width) {
                for c in 0..3 {
                    assert!((found[c] - f64::from(colour[c])).abs() <= f64::EPSILON);
                }
            }
        }
    }
}

#[test]
fn whole_periods_do_not_count() {
    let map = texture([64, 16], 5);
    let spec = UnitSpec::default();
    for k in [-37.0, -1.0, 1.0, 200.0] {
        let here = colours(&spec, &map, &at([0.3125, 0.71875]), 0.125);
        let there = colours(&spec, &map, &at([0.3125 + k, 0.71875 - k]), 0.125);
        assert_eq!(here[0].map(f64::to_bits), there[0].map(f64::to_bits));
    }
}

#[test]
fn wide_texels_and_halves_give_the_same_bits() {
    let map = texture([32, 32], 8);
    let half = UnitSpec::default();
    let mut engine = TexRtl::new(&half, &map).unwrap();
    let request = [words(&at([0.4, 0.7]), Cone::default())];
    let mut found = Vec::new();
    for _ in 0..2 {
        engine.blocks(Source::Words(&request), &mut |_, out| found.push(out.color[0]));
        engine.memory.texture = engine.memory.texture.map(|t| t.widened());
    }
    assert_eq!(found[0], found[1]);
}
