//! Units at the limits of the model's integers: each is refused by name, or exact and free of panics.
//!
//! The test profile checks sums and products; every case here once was, or could be taken for, a way
//! past the checks of `Unit::new`.

use super::run_one;
use crate::common::{NEEDS, Record, Rng, any_words};
use rtl_model::fx::{Format, Overflow, Rounding};
use rtl_model::policy::{Axis, Count, Dnmod};
use rtl_model::stages::address::{self, Probe};
use rtl_model::stages::{Roms, Sink, eigen, footprint};
use rtl_model::texture::Source;
use rtl_model::unit::{Needs, Unit};
use rtl_model::{Config, ConfigError, NoTap, Reg, Texture};

const ALL: Needs = NEEDS[3];

fn set(config: &mut Config, reg: Reg, int: u32, frac: u32) {
    let format = &mut config.formats[reg.index()];
    (format.int, format.frac) = (int, frac);
}

fn path(result: Result<Unit, ConfigError>) -> String {
    match result {
        Ok(_) => "legal".to_owned(),
        Err(error) => error.path,
    }
}

/// 1000 fragments, wild ones included, through a unit.
fn drive(unit: &Unit) {
    let mut rng = Rng(7);
    for _ in 0..1000 {
        run_one(unit, &any_words(&mut rng));
    }
}

#[test]
fn a_rotation_beyond_one_is_refused() {
    for entry in [(1 << 24) + 1, -(1 << 24) - 1, i64::MAX, i64::MIN] {
        let mut rotation = [[0; 3]; 3];
        rotation[1][2] = entry;
        let config = Config { rotation: Some(rotation), ..Config::default() };
        assert_eq!(path(Unit::new(&config, ALL, 64)), "transform.rotation", "{entry}");
    }
    let one = 1 << 24;
    let config =
        Config { rotation: Some([[one; 3], [-one; 3], [one, -one, one]]), ..Config::default() };
    drive(&Unit::new(&config, ALL, 64).expect("entries of 1 are legal"));
}

#[test]
fn a_roughness_scale_beyond_its_word_is_refused() {
    for scale in [-1, 16 << 20, i64::MAX, i64::MIN] {
        let config = Config { roughness_scale: scale, ..Config::default() };
        assert_eq!(path(Unit::new(&config, ALL, 64)), "roughness.scale", "{scale}");
    }
    let config = Config { roughness_scale: (16 << 20) - 1, ..Config::default() };
    drive(&Unit::new(&config, ALL, 64).expect("just below 16 is legal"));
}

#[test]
fn formats_of_absurd_widths_are_refused_and_never_wrap() {
    for (int, frac) in [(u32::MAX, 1), (1, u32::MAX), (u32::MAX, u32::MAX), (59, 0), (0, 0)] {
        for &reg in Reg::ALL {
            let mut config = Config::default();
            set(&mut config, reg, int, frac);
            let expected = format!("registers.{reg}");
            assert_eq!(path(Unit::new(&config, ALL, 64)), expected);
        }
    }
}

#[test]
fn a_wide_e2_against_h_is_refused_where_the_frame_turns() {
    let mut config = Config::default().with(|p| p.jacobian.dnmod = Dnmod::Frame);
    set(&mut config, Reg::BumpB, 5, 1);
    set(&mut config, Reg::JacTurn, 9, 1);
    set(&mut config, Reg::JacDnPerp, 7, 1);
    set(&mut config, Reg::JacDe, 9, 2);
    set(&mut config, Reg::FrameH, 1, 29);
    set(&mut config, Reg::FrameE2, 2, 40);
    let needs = NEEDS[1];
    match Unit::new(&config, needs, 64) {
        Ok(unit) => drive(&unit),
        Err(error) => assert_eq!(error.path, "registers.jacobian.turn"),
    }
    config.formats[Reg::FrameE2.index()].frac = 27;
    assert_eq!(path(Unit::new(&config, needs, 64)), "legal");
}

#[test]
fn a_wide_integer_part_of_e1_counts_in_the_turning_frame() {
    let mut config = Config::default().with(|p| p.jacobian.dnmod = Dnmod::Frame);
    // |turn·e| < 2^(9 + 24) beside a common fraction of 22 + 22 bits: 77 bits and more.
    set(&mut config, Reg::BumpB, 5, 2);
    set(&mut config, Reg::FrameE1, 24, 22);
    set(&mut config, Reg::JacTurn, 9, 20);
    set(&mut config, Reg::JacPerpDotE, 6, 4);
    set(&mut config, Reg::JacDnPerp, 7, 4);
    set(&mut config, Reg::JacDe, 9, 10);
    let unit = Unit::new(&config, NEEDS[1], 64);
    assert_eq!(path(unit), "registers.jacobian.de");
}

/// The axes of one ellipse straight into `footprint`: (count, M's code, m's code).
fn footprint_of(config: &Config, lambda: [i64; 2], exp: i64) -> Option<[i64; 3]> {
    let cfg = footprint::Cfg::new(config, 1 << 14).ok()?;
    let roms = Roms::new(config).expect("tables");
    let axes = eigen::Out { lambda, exp, axis: [1 << 20, 0] };
    let (mut record, mut flags) = (Record::default(), rtl_model::fx::Flags::default());
    let mut sink = Sink { lane: 0, flags: &mut flags, tap: &mut record };
    let out = footprint::footprint(&cfg, &roms, &axes, &mut sink);
    let code = |reg| record.0.iter().find(|r| r.1 == reg).map_or(0, |r| r.3);
    Some([out.count, code(Reg::FootLength), code(Reg::FootWidth)])
}

#[test]
fn unlike_fractions_of_length_and_width_do_not_break_the_count() {
    let mut ran = 0;
    for (length, width) in [
        ((45, 1), (2, 30)),
        ((2, 44), (31, 1)),
        ((30, 16), (2, 30)),
        ((19, 12), (1, 31)),
        ((19, 12), (20, 4)),
        ((30, 2), (19, 12)),
    ] {
        for exp in [-10, 0, 12, 30] {
            for minor in [1, 1 << 20, 1 << 27, 1 << 29] {
                let mut config = Config::default().with(|p| p.footprint.max_probes = 63);
                set(&mut config, Reg::FootLength, length.0, length.1);
                set(&mut config, Reg::FootWidth, width.0, width.1);
                let lambda = [(1 << 30) - 1, minor];
                let Some([count, m1, m2]) = footprint_of(&config, lambda, exp) else {
                    continue;
                };
                // ⌈M/m − 2⁻⁸⌉ of the codes.
                let p = (i128::from(m1) << width.1) * 256 - (i128::from(m2) << length.1);
                let q = (i128::from(m2) << length.1) * 256;
                let expected = -((-p).div_euclid(q));
                assert_eq!(
                    i128::from(count),
                    expected.clamp(1, 63),
                    "{length:?} {width:?} exponent {exp}, minor {minor}"
                );
                ran += 1;
            }
        }
    }
    assert!(ran >= 16, "{ran}");
}

#[test]
fn the_width_register_must_hold_one_texel() {
    let mut config = Config::default();
    set(&mut config, Reg::FootWidth, 0, 20);
    assert_eq!(path(Unit::new(&config, NEEDS[0], 64)), "registers.footprint.width");
}

#[test]
fn a_wrapped_lambda_does_not_overflow_the_feline_line() {
    for exp in [0, -60, 60, 12, 21, 33, 36] {
        let mut config = Config::default().with(|p| p.footprint.count = Count::Feline);
        set(&mut config, Reg::EigenLambda, 2, 37);
        config.formats[Reg::EigenLambda.index()].overflow = Overflow::Wrap;
        let cfg = footprint::Cfg::new(&config, 64);
        let Ok(cfg) = cfg else { panic!("the lambda register is legal: {cfg:?}") };
        let roms = Roms::new(&config).expect("tables");
        for lambda in [-(1i64 << 39), -(1 << 39) + 1, -1, 0, (1 << 39) - 1] {
            let axes = eigen::Out { lambda: [lambda, 0], exp, axis: [1 << 20, 0] };
            let mut flags = rtl_model::fx::Flags::default();
            let mut sink = Sink { lane: 0, flags: &mut flags, tap: &mut NoTap };
            let out = footprint::footprint(&cfg, &roms, &axes, &mut sink);
            assert!((1..=16).contains(&out.count));
        }
    }
}

#[test]
fn unlike_fractions_of_the_address_registers_are_refused_or_find_the_right_face() {
    for (u, v) in [((43, 1), (2, 42)), ((2, 42), (43, 1)), ((22, 22), (9, 24)), ((40, 4), (9, 24))]
    {
        let mut config = Config::default();
        set(&mut config, Reg::AddrU, u.0, u.1);
        set(&mut config, Reg::AddrV, v.0, v.1);
        set(&mut config, Reg::FootStep, 30, 20);
        let Ok(cfg) = address::Cfg::new(&config) else {
            continue;
        };
        let roms = Roms::new(&config).expect("tables");
        // Far along +u from face +Z: the look-up ends on +X.
        for step in [1i64 << 26, 1 << 32, (1 << 40) - 1, (1 << 50) - 1, 0x2_2222_2200_0000] {
            let line =
                address::In { face: 4, center: [0, 0], step: [step, 0], step_frac: 20, count: 2 };
            let mut flags = rtl_model::fx::Flags::default();
            let mut sink = Sink { lane: 0, flags: &mut flags, tap: &mut NoTap };
            let Probe { face, uv } = address::address(&cfg, &roms, &line, 1, &mut sink);
            assert_eq!(face, 0, "{u:?} {v:?} step {step}");
            assert!(uv[0] <= 0 && uv[1] == 0, "{uv:?}");
        }
    }
}

/// A texture of one value everywhere.
fn constant(config: &Config, word: u32) -> Texture {
    let words = [[word; 3]; 24];
    let sources = [Source { size: 2, words: &words }, Source { size: 1, words: &words[..6] }];
    Texture::new(config, &sources, &|_, f, _, _| Some((f, 0, 0))).expect("legal texels")
}

#[test]
fn wrapped_negative_bilinear_sums_are_divided_without_a_panic() {
    for count in 1..=64 {
        let mut config = Config::default().with(|p| p.footprint.max_probes = 64);
        config.formats[Reg::FilterBilinear.index()] = Format {
            signed: true,
            int: 4,
            frac: 20,
            rounding: Rounding::HalfEven,
            overflow: Overflow::Wrap,
        };
        config.formats[Reg::FilterColor.index()].signed = true;
        // 65504 is 4094·16 − 0, 24 is −8 in Q4: negative sums.
        for (value, q4) in [(24u64, -8i64), (31, -1), (17, -15), (7, 7)] {
            let word = (127 + value.ilog2()) << 23
                | u32::try_from((value << (23 - value.ilog2())) & 0x7f_ffff).expect("a fraction");
            let texture = constant(&config, word);
            let color = filtered(&config, &texture, count);
            assert_eq!(color, [q4 << 24; 3], "{count} probes of {value}");
        }
    }
}

/// The colour of a line of `count` probes of no length.
fn filtered(config: &Config, texture: &Texture, count: i64) -> [i64; 3] {
    use rtl_model::stages::filter;
    let cfg = filter::Cfg::new(config).expect("a legal filter");
    let address_cfg = address::Cfg::new(config).expect("legal addresses");
    let roms = Roms::new(config).expect("tables");
    let input = filter::In {
        line: address::In { face: 4, center: [0, 0], step: [0, 0], step_frac: 24, count },
        lod: 77,
    };
    let mut flags = rtl_model::fx::Flags::default();
    let mut sink = Sink { lane: 0, flags: &mut flags, tap: &mut NoTap };
    filter::filter(&cfg, &address_cfg, &roms, texture, &input, &mut sink).color
}

#[test]
fn textures_without_levels_or_texels_are_refused() {
    let config = Config::default();
    let words = [[0u32; 3]; 6];
    let across = |_: usize, f: usize, _: i64, _: i64| Some((f, 0, 0));
    assert!(Texture::new(&config, &[], &across).is_err());
    assert!(Texture::new(&config, &[Source { size: 0, words: &[] }], &across).is_err());
    assert!(Texture::new(&config, &[Source { size: 1, words: &words[..5] }], &across).is_err());
    assert!(Texture::new(&config, &[Source { size: 1, words: &words }], &across).is_ok());
}

#[test]
fn every_register_at_its_widest_legal_size_survives_any_words() {
    // One register at a time is widened until `Unit::new` refuses it: the widest legal one runs.
    let mut ran = 0;
    for &reg in Reg::ALL {
        for grow_int in [true, false] {
            for (dnmod, count, axis) in [
                (Dnmod::Frame, Count::Feline, Axis::EigenExact),
                (Dnmod::Normal, Count::Pow2, Axis::LongerDerivative),
            ] {
                let mut widest = None;
                for extra in 1..58 {
                    let mut config = Config::default().with(|p| {
                        p.jacobian.dnmod = dnmod;
                        p.footprint.count = count;
                        p.footprint.axis = axis;
                    });
                    let format = &mut config.formats[reg.index()];
                    if grow_int {
                        format.int += extra;
                    } else {
                        format.frac += extra;
                    }
                    if let Ok(unit) = Unit::new(&config, ALL, 16384) {
                        widest = Some(unit);
                    }
                }
                if let Some(unit) = widest {
                    let mut rng = Rng(11);
                    for _ in 0..60 {
                        run_one(&unit, &any_words(&mut rng));
                    }
                    ran += 1;
                }
            }
        }
    }
    assert!(ran > 100, "{ran} registers could be widened");
}
