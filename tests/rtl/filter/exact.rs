//! The filter against exact rational arithmetic.

use rtl_model::fx::{Flags, Format, Overflow, Rounding};
use rtl_model::policy::{FootprintPolicy, Weights};
use rtl_model::stages::filter::weights::weights;
use rtl_model::stages::{Roms, Sink, address, filter};
use rtl_model::{Config, NoTap, Reg, TexelFormat, Texture};
use support::model::{Record, Rng, limit, round_ratio};

use super::{Levels, any_texel, build, chain, texel};

fn any_format(rng: &mut Rng, signed: bool, int: (u32, u32), frac: (u32, u32)) -> Format {
    Format {
        signed,
        int: rng.bits(int.0, int.1),
        frac: rng.bits(frac.0, frac.1),
        rounding: rng.pick(Rounding::ALL),
        overflow: rng.pick(Overflow::ALL),
    }
}

/// A filter drawn at random; `None` where it does not fit.
fn any_filter(rng: &mut Rng) -> Option<(Config, filter::Cfg, address::Cfg)> {
    let mut config = Config::default().with(|p| {
        p.footprint.max_probes = rng.bits(1, 64);
        p.footprint.weights = rng.pick(Weights::ALL);
        p.footprint.weight_bits = rng.bits(1, 12);
        p.filter.weight_bits = rng.bits(1, 8);
        p.filter.lod_bits = rng.bits(1, 8);
        p.texel.format = rng.pick(TexelFormat::ALL);
    });
    if rng.one_in(2) {
        config.policy.texel.int = rng.bits(10, 17);
        config.policy.texel.frac = rng.bits(4, 24);
    }
    let mut set = |reg: Reg, format: Format| config.formats[reg.index()] = format;
    set(Reg::FilterColor, any_format(rng, false, (8, 17), (0, 30)));
    if rng.one_in(2) {
        let signed = rng.one_in(3);
        set(Reg::FilterBilinear, any_format(rng, signed, (4, 17), (0, 40)));
    }
    set(Reg::AddrS, any_format(rng, true, (6, 16), (0, 12)));
    let filter = filter::Cfg::new(&config).ok()?;
    let address = address::Cfg::new(&config).ok()?;
    Some((config, filter, address))
}

fn any_line(rng: &mut Rng, config: &Config, size: i64) -> filter::In {
    let one = 1i64 << 24;
    let reach = rng.pick(&[0, one / (4 * size), one / 8, one]);
    filter::In {
        line: address::In {
            face: usize::try_from(rng.range(0, 5)).expect("a face"),
            center: [rng.range(-one, one), rng.range(-one, one)],
            step: [rng.range(-reach, reach), rng.range(-reach, reach)],
            step_frac: 24,
            count: rng.range(1, config.policy.footprint.max_probes.into()),
        },
        lod: if rng.one_in(3) { rng.range(0, 4) << 8 } else { rng.range(0, 6 << 8) },
    }
}

fn filtered(
    parts: &(Config, filter::Cfg, address::Cfg),
    roms: &Roms,
    texture: &Texture,
    line: &filter::In,
) -> ([i64; 3], Flags) {
    let mut flags = Flags::default();
    let mut sink = Sink { lane: 0, flags: &mut flags, tap: &mut NoTap };
    let out = filter::filter(&parts.1, &parts.2, roms, texture, line, &mut sink);
    (out.color, flags)
}

/// First texel and weight of the second one, from u or v with 24 fraction bits.
fn tap(config: &Config, uv: i64, size: i64) -> (i64, i128) {
    let format = config.format(Reg::AddrS);
    // (u + 1)/2·N − ½ in LSBs of the register.
    let p = (i128::from(uv + (1 << 24)) * i128::from(size) - (1 << 24)) << format.frac;
    let (code, _) = limit(round_ratio(p, 1 << 25, format.rounding), format);
    let one = 1i128 << format.frac;
    let (whole, part) = (code.div_euclid(one), code.rem_euclid(one));
    let whole = i64::try_from(whole).expect("small");
    let full = 1i128 << config.policy.filter.weight_bits;
    let weight = round_ratio(part * full, one, Rounding::HalfUp);
    match whole {
        w if w < -1 => (-1, 0),
        w if w >= size => (size - 1, full),
        w => (w, weight),
    }
}

/// The filter by definition: every sum exact, the registers' roundings and nothing else.
fn defined(
    config: &Config,
    probes: &[address::Probe],
    levels: &Levels,
    lod: i64,
) -> ([i128; 3], bool) {
    let last = levels.len() - 1;
    let lod_one = 1i128 << config.policy.filter.lod_bits;
    let (whole, part) = (lod >> 8, i128::from(lod & 255));
    let whole = usize::try_from(whole).expect("not negative");
    let (first, between) = if whole >= last {
        (last, 0)
    } else {
        (whole, round_ratio(part * lod_one, 256, Rounding::HalfUp))
    };
    let count = u32::try_from(probes.len()).expect("at most 64");
    let (probe_weights, total) = match config.policy.footprint.weights {
        Weights::Box => (vec![1; probes.len()], i128::from(count)),
        Weights::Gaussian | Weights::Bell => {
            (weights(count, &config.policy.footprint), 1 << config.policy.footprint.weight_bits)
        }
    };
    let exact_frac = config.policy.texel.frac + 2 * config.policy.filter.weight_bits;
    let register = config.format(Reg::FilterBilinear);
    let narrowed = register.frac < exact_frac || register.int < config.policy.texel.int;
    let sum_frac = if narrowed { register.frac } else { exact_frac };
    let mut color = [0; 3];
    let mut over = false;
    for (c, out) in color.iter_mut().enumerate() {
        let mut sum = 0i128;
        for (probe, &weight) in probes.iter().zip(&probe_weights) {
            for (l, part) in [(0, lod_one - between), (1, between)] {
                if part == 0 {
                    continue;
                }
                let level = &levels[first + l];
                let size = i64::try_from(level.0).expect("small");
                let [(x, wx), (y, wy)] = probe.uv.map(|uv| tap(config, uv, size));
                let full = 1i128 << config.policy.filter.weight_bits;
                let mut bilinear = 0;
                for (dx, fx) in [(0, full - wx), (1, wx)] {
                    for (dy, fy) in [(0, full - wy), (1, wy)] {
                        let t = texel(config, level, probe.face, x + dx, y + dy)[c];
                        bilinear += fx * fy * i128::from(t);
                    }
                }
                if narrowed {
                    let lsbs =
                        round_ratio(bilinear << register.frac, 1 << exact_frac, register.rounding);
                    bilinear = limit(lsbs, register).0;
                }
                sum += bilinear * part * i128::from(weight);
            }
        }
        let format = config.format(Reg::FilterColor);
        let divisor = total << (sum_frac + config.policy.filter.lod_bits);
        let (code, outside) =
            limit(round_ratio(sum << format.frac, divisor, format.rounding), format);
        *out = code;
        over |= outside;
    }
    (color, over)
}

#[test]
fn the_filter_is_exact_up_to_its_registers() {
    let (mut compared, mut grey, mut saturated) = (0, 0, 0);
    let roms = Roms::new(&Config::default()).expect("the default tables");
    for seed in 0..2500 {
        let mut rng = Rng(seed ^ 0xf117_e200);
        let Some(parts) = any_filter(&mut rng) else {
            continue;
        };
        let size = rng.pick(&[1usize, 2, 4, 8, 5]);
        let levels = chain(&mut rng, size, any_texel);
        let texture = build(&parts.0, &levels);
        for _ in 0..3 {
            let line = any_line(&mut rng, &parts.0, i64::try_from(size).expect("small"));
            let mut flags = Flags::default();
            let mut sink = Sink { lane: 0, flags: &mut flags, tap: &mut NoTap };
            let probes: Vec<address::Probe> = (0..line.line.count)
                .map(|k| address::address(&parts.2, &roms, &line.line, k, &mut sink))
                .collect();
            let (want, over) = defined(&parts.0, &probes, &levels, line.lod);
            let (got, flags) = filtered(&parts, &roms, &texture, &line);
            assert_eq!(got.map(i128::from), want, "seed {seed}, {line:?}");
            assert_eq!(flags.has(Reg::FilterColor), over, "seed {seed}");
            compared += 1;
            grey += usize::from(got[0] == got[1]);
            saturated += usize::from(over);
            let wide = filtered(&parts, &roms, &texture.widened(), &line);
            assert_eq!(wide, (got, flags), "seed {seed}: decoded texels give other bits");
        }
    }
    assert!(compared > 1000, "{compared}");
    assert!(grey < compared / 2 && saturated < compared / 2, "{grey} {saturated} of {compared}");
}

#[test]
fn a_constant_texture_stays_constant_in_every_filter() {
    let roms = Roms::new(&Config::default()).expect("the default tables");
    let mut compared = 0;
    for seed in 0..2000 {
        let mut rng = Rng(seed ^ 0xc057_0000);
        let Some(mut parts) = any_filter(&mut rng) else {
            continue;
        };
        // The value must be one of the datapath's and of both registers': a multiple of 2^−4 below 8,
        // small enough for every format; unorm8 has only 0 and 1 in common with them.
        for reg in [Reg::FilterColor, Reg::FilterBilinear] {
            let format = &mut parts.0.formats[reg.index()];
            format.frac = format.frac.max(4);
        }
        let (Ok(filter), Ok(address)) = (filter::Cfg::new(&parts.0), address::Cfg::new(&parts.0))
        else {
            continue;
        };
        parts = (parts.0, filter, address);
        let sixteenths = match parts.0.policy.texel.format {
            TexelFormat::Unorm8 => rng.pick(&[0i64, 16]),
            TexelFormat::Q | TexelFormat::Half | TexelFormat::Rgb9e5 => rng.range(0, 127),
        };
        let word = if sixteenths == 0 {
            0
        } else {
            let e = sixteenths.ilog2();
            let fraction = (sixteenths.unsigned_abs() << (23 - e)) & 0x7f_ffff;
            (127 + e - 4) << 23 | u32::try_from(fraction).expect("23 bits")
        };
        let levels = chain(&mut rng, 8, |_| word);
        let texture = build(&parts.0, &levels);
        let want = sixteenths << (parts.0.format(Reg::FilterColor).frac - 4);
        for _ in 0..10 {
            let line = any_line(&mut rng, &parts.0, 8);
            let (color, flags) = filtered(&parts, &roms, &texture, &line);
            assert_eq!(color, [want; 3], "seed {seed}, {line:?}");
            assert!(!flags.has(Reg::FilterColor));
            compared += usize::from(want > 0);
        }
    }
    assert!(compared > 5000, "{compared}");
}

#[test]
fn division_by_every_count_is_exact_up_to_the_largest_sums() {
    // A texture of the largest texel next to one code less: sums near 2^56 with every remainder.
    let roms = Roms::new(&Config::default()).expect("the default tables");
    let mut config = Config::default().with(|p| {
        p.footprint.max_probes = 63;
        p.texel.format = TexelFormat::Q;
        p.filter.weight_bits = 4;
    });
    let color = &mut config.formats[Reg::FilterColor.index()];
    color.int = 17;
    let mut remainders = 0;
    for frac in [24, 27] {
        for &rounding in Rounding::ALL {
            let color = &mut config.formats[Reg::FilterColor.index()];
            (color.frac, color.rounding) = (frac, rounding);
            let parts = (
                config.clone(),
                filter::Cfg::new(&config).expect("58 bits and less"),
                address::Cfg::new(&config).expect("the default"),
            );
            let mut rng = Rng(9);
            // 131071 + 255/256: the largest binary32 below 2^17 and its neighbours.
            let levels = chain(&mut rng, 4, |rng| (143 << 23 | 0x7f_ffff) - rng.bits(0, 3));
            let texture = build(&config, &levels);
            for count in 1..=63 {
                let line = filter::In {
                    line: address::In {
                        face: usize::try_from(count % 6).expect("a face"),
                        center: [12_345 * count, -54_321 * count],
                        step: [77_777, 33_333],
                        step_frac: 24,
                        count,
                    },
                    lod: 100,
                };
                let mut flags = Flags::default();
                let mut sink = Sink { lane: 0, flags: &mut flags, tap: &mut NoTap };
                let probes: Vec<address::Probe> = (0..count)
                    .map(|k| address::address(&parts.2, &roms, &line.line, k, &mut sink))
                    .collect();
                let (want, _) = defined(&config, &probes, &levels, line.lod);
                let (got, _) = filtered(&parts, &roms, &texture, &line);
                assert_eq!(got.map(i128::from), want, "{count} probes, {}", rounding.name());
                remainders += usize::from(got[0] & 0xff != 0);
            }
        }
    }
    assert!(remainders > 400, "{remainders}");
}

#[test]
fn gaussian_weights_are_the_rounded_exponentials_with_the_residue_in_the_middle() {
    for bits in 1..=12u32 {
        for count in 1..=64u32 {
            let policy = FootprintPolicy {
                weights: Weights::Gaussian,
                weight_bits: bits,
                ..FootprintPolicy::default()
            };
            let got = weights(count, &policy);
            let n = f64::from(count);
            let raw: Vec<f64> = (0..count)
                .map(|i| libm::exp(-2.0 * libm::pow((2.0 * f64::from(i) + 1.0 - n) / n, 2.0)))
                .collect();
            let total: f64 = raw.iter().sum();
            let middle = (got.len() - 1) / 2;
            assert_eq!(got.iter().sum::<i64>(), 1 << bits);
            for (i, (&w, r)) in got.iter().zip(&raw).enumerate() {
                let want = r / total * f64::from(1 << bits);
                let got = f64::from(i32::try_from(w).expect("13 bits"));
                // libm and the series are both within 2^−40 of the weight.
                // Rounded down instead where the residue would make the middle one negative.
                let down = count > 36 && bits <= 6;
                assert!(
                    i == middle
                        || (down && (0.0..1.0).contains(&(want - got)))
                        || (got - want).abs() <= 0.5 + 0.5f64.powi(30),
                    "{count} {bits} {i}"
                );
            }
        }
    }
}

#[test]
fn a_trace_shows_the_sums_that_the_colour_is_made_of() {
    // One probe on a texel centre of level 0: the bilinear register holds that texel alone.
    let config = Config::default();
    let roms = Roms::new(&config).expect("tables");
    let parts = (
        config.clone(),
        filter::Cfg::new(&config).expect("the default"),
        address::Cfg::new(&config).expect("the default"),
    );
    let mut rng = Rng(5);
    let levels = chain(&mut rng, 4, any_texel);
    let texture = build(&config, &levels);
    let mut flags = Flags::default();
    let mut record = Record::default();
    let mut sink = Sink { lane: 0, flags: &mut flags, tap: &mut record };
    // Texel (2, 1) of 4: u = 2·2.5/4 − 1, v = 2·1.5/4 − 1.
    let line = filter::In {
        line: address::In {
            face: 3,
            center: [1 << 22, -(1 << 22)],
            step: [0, 0],
            step_frac: 24,
            count: 1,
        },
        lod: 0,
    };
    let out = filter::filter(&parts.1, &parts.2, &roms, &texture, &line, &mut sink);
    let want = texel(&config, &levels[0], 3, 2, 1);
    assert_eq!(out.color, want);
    assert_eq!(out.texels, 4);
    for (c, texel) in want.into_iter().enumerate() {
        assert!(record.0.contains(&(0, Reg::FilterBilinear, c, texel << 16, 40)));
        assert!(record.0.contains(&(0, Reg::FilterColor, c, texel, 24)));
    }
    assert!(record.0.contains(&(0, Reg::AddrS, 0, 2 << 8, 8)));
    assert!(record.0.contains(&(0, Reg::AddrS, 1, 1 << 8, 8)));
}
