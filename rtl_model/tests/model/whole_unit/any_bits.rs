//! Any bits in, defined bits out: random legal units and random words never panic (the test profile
//! checks overflows), and the number of lanes changes nothing.

use crate::common::{NEEDS, Record, Rng, any_config, any_words};
use rtl_model::fx::{Flags, Overflow, Rounding};
use rtl_model::unit::{EnvBlock, Memory, Needs, Operation as _, Results, Unit, Words};
use rtl_model::{Config, NoTapStandard, Reg, Tap, Texture, texture::Source};

/// A mip chain whose texels are any words.
fn any_texture(rng: &mut Rng, config: &Config, size: usize) -> Option<Texture> {
    let mut chain = Vec::new();
    let mut n = size;
    loop {
        let texels: Vec<[u32; 3]> = (0..6 * n * n)
            .map(|_| {
                [0; 3].map(|_: u32| {
                    let any = rng.word().to_le_bytes();
                    u32::from_le_bytes([any[0], any[1], any[2], any[3]])
                })
            })
            .collect();
        chain.push((n, texels));
        if n == 1 {
            break;
        }
        n /= 2;
    }
    let sources: Vec<Source<'_>> =
        chain.iter().map(|(size, words)| Source { size: *size, words }).collect();
    // Any neighbour will do here: borders are tested with the real one elsewhere.
    let across = |size: usize, face: usize, x: i64, y: i64| {
        let inside = |t: i64| usize::try_from(t.clamp(0, i64::try_from(size).ok()? - 1)).ok();
        Some(((face + 1) % 6, inside(x)?, inside(y)?))
    };
    Texture::new(config, &sources, &across).ok()
}

struct Run {
    registers: Vec<Vec<(rtl_model::Reg, usize, i64, i64)>>,
    results: Vec<([i64; 3], i64, u64, rtl_model::fx::Flags)>,
}

fn run<const N: usize>(unit: &Unit, texture: Option<Texture>, words: &[Words]) -> Run {
    let mut out = Run { registers: Vec::new(), results: Vec::new() };
    let memory = Memory { texture, ..Memory::default() };
    for chunk in words.chunks(N) {
        let mut record = Record::default();
        let (mut block, mut results) = (EnvBlock::<N>::default(), Results::default());
        unit.load(chunk, &mut block);
        unit.run(&memory, &mut block, &mut results, &mut record);
        for lane in 0..chunk.len() {
            out.registers.push(record.lane(lane));
            out.results.push((
                results.color[lane],
                results.probes[lane],
                results.texels[lane],
                results.flags[lane],
            ));
        }
    }
    out
}

/// Draws units and runs them; returns how many were legal and how many were refused.
fn sweep(seeds: std::ops::Range<u64>, spread: i64) -> (usize, usize) {
    let (mut legal, mut refused) = (0, 0);
    for seed in seeds {
        let mut rng = Rng(seed);
        let wild = rng.one_in(2);
        let config = any_config(&mut rng, spread, wild);
        let needs = rng.pick(&NEEDS);
        let textured = rng.one_in(2);
        let size = if textured { 1 << rng.bits(0, 4) } else { rng.bits(1, 16384) };
        let unit = match Unit::new(&config, needs, size) {
            Ok(unit) => unit,
            Err(error) => {
                assert!(!error.path.is_empty() && !error.found.is_empty());
                refused += 1;
                continue;
            }
        };
        let texture = textured
            .then(|| any_texture(&mut rng, &config, usize::try_from(size).expect("small")))
            .flatten();
        let words: Vec<Words> = (0..9).map(|_| any_words(&mut rng)).collect();
        let result = std::panic::catch_unwind(|| run::<32>(&unit, texture, &words));
        assert!(result.is_ok(), "seed {seed}, spread {spread}");
        legal += 1;
    }
    (legal, refused)
}

#[test]
fn random_words_never_panic_in_units_near_the_default() {
    let (legal, _) = sweep(0..4000, 3);
    assert!(legal > 1000, "{legal} legal units are too few to say anything");
}

#[test]
fn random_words_never_panic_in_units_of_any_widths() {
    let (legal, refused) = sweep(1 << 32..(1 << 32) + 12000, 24);
    assert!(legal > 500, "{legal} legal units are too few to say anything");
    assert!(refused > 100, "{refused} refused units: the limits were not reached");
}

/// Widens registers at random for as long as the unit stays legal: many limits touched at once.
fn grown(rng: &mut Rng, needs: Needs) -> (Config, Unit) {
    let mut config = any_config(rng, 0, true);
    config.formats = Config::default().formats;
    // 64 box-weighted probes need 63 bits: refused by name with the default words.
    config.policy.footprint.max_probes = config.policy.footprint.max_probes.min(32);
    let mut unit =
        Unit::new(&config, needs, 16384).expect("default words with any policy are legal");
    for _ in 0..60 {
        let mut wider = config.clone();
        let reg = rng.pick(Reg::ALL);
        let format = &mut wider.formats[reg.index()];
        let (more, less) = (rng.bits(0, 12), rng.bits(0, 8));
        if rng.one_in(2) {
            format.int += more;
            format.frac = format.frac.saturating_sub(less);
        } else {
            format.frac += more;
            format.int = format.int.saturating_sub(less);
        }
        format.overflow = rng.pick(Overflow::ALL);
        format.rounding = rng.pick(Rounding::ALL);
        if let Ok(legal) = Unit::new(&wider, needs, 16384) {
            (config, unit) = (wider, legal);
        }
    }
    (config, unit)
}

#[test]
fn random_words_never_panic_in_units_grown_to_the_limits() {
    for seed in 0..400 {
        let mut rng = Rng(seed ^ 0x6120_0000);
        let needs = rng.pick(&NEEDS);
        let (config, unit) = grown(&mut rng, needs);
        let texture = any_texture(&mut rng, &config, 4);
        let words: Vec<Words> = (0..32).map(|_| any_words(&mut rng)).collect();
        let result = std::panic::catch_unwind(|| run::<32>(&unit, texture, &words));
        assert!(result.is_ok(), "seed {seed}");
    }
}

#[test]
fn one_and_thirty_two_lanes_give_the_same_registers_and_results() {
    let mut compared = 0;
    for seed in 0..200 {
        let mut rng = Rng(seed ^ 0xacce_55ed);
        let config = any_config(&mut rng, 2, true);
        let needs = rng.pick(&NEEDS);
        let Ok(unit) = Unit::new(&config, needs, 16) else {
            continue;
        };
        let texture = any_texture(&mut rng, &config, 16);
        let words: Vec<Words> = (0..45).map(|_| any_words(&mut rng)).collect();
        let one = run::<1>(&unit, texture.clone(), &words);
        let many = run::<32>(&unit, texture, &words);
        assert_eq!(one.results, many.results, "seed {seed}");
        assert!(one.registers == many.registers, "seed {seed}");
        let different = one.results.iter().any(|r| r != &one.results[0]);
        compared += usize::from(different);
    }
    assert!(compared > 50, "{compared} units gave results that differ at all");
}

/// What every lane of the stages before `address` hands on.
type Handed = (Flags, i64, i64, [i64; 2], i64, [i64; 2]);

fn handed<const N: usize>(unit: &Unit, words: &[Words], tap: &mut impl Tap) -> Vec<Handed> {
    let (mut out, mut results) = (Vec::new(), Results::<N>::default());
    let mut block = EnvBlock::<N>::default();
    for chunk in words.chunks(N) {
        unit.load(chunk, &mut block);
        unit.run(&Memory::default(), &mut block, &mut results, tap);
        for i in 0..chunk.len() {
            let (line, face) = (&block.env.line, &block.env.face);
            out.push((
                results.flags[i],
                results.probes[i],
                line.lod[i],
                [line.step[0][i], line.step[1][i]],
                face.face[i],
                [face.u[i], face.v[i]],
            ));
        }
    }
    out
}

#[test]
fn narrow_products_and_half_even_rounding_in_lanes_give_the_bits_of_the_general_circuit() {
    let (mut units, mut flagged) = (0, 0);
    for seed in 0..3000 {
        let mut rng = Rng(seed);
        let mut config = any_config(&mut rng, 3, false);
        for (format, reg) in config.formats.iter_mut().zip(Reg::ALL) {
            // Default words, some of them a few bits shorter: the codes at their ends are met often.
            *format = reg.info().format;
            if rng.one_in(3) && format.frac > 8 {
                format.frac -= rng.bits(0, 4);
            }
        }
        let needs = rng.pick(&NEEDS);
        let Ok(unit) = Unit::new(&config, needs, 1 << rng.bits(0, 14)) else {
            continue;
        };
        assert!(unit.is_standard(), "seed {seed}: no wider than the default");
        let words: Vec<Words> = (0..45).map(|_| any_words(&mut rng)).collect();
        let general = handed::<1>(&unit, &words, &mut Record::default());
        let lanes = handed::<32>(&unit, &words, &mut NoTapStandard);
        flagged += general.iter().filter(|lane| !lane.0.is_empty()).count();
        assert_eq!(general, lanes, "seed {seed}");
        units += 1;
    }
    assert!(units > 1000 && flagged > 1000, "{units} units, {flagged} flags");
}
