//! Batches in vector loops have the bits of one cone at a time.

use rtl_model::Config;
use rtl_model::cone::{Angle, Cone, ConeFormat, SmallFloat, StoreRounding, Width, fast};
use rtl_model::fx::Flags;
use rtl_model::stages::ray_cone::{self, Cfg};
use tapline::base::random::Random;
use tapline::engine::cones::propagate_batch;
use tapline::engine::dispatch::Level;

fn low(x: u64) -> u32 {
    u32::try_from(x & 0xffff_ffff).unwrap()
}

fn value(format: SmallFloat, code: u32) -> f64 {
    tapline::engine::tex::value(format.unpack(code).0)
}

/// Cones and distances: random codes, near and exact cancellation, zeros, all exponents. `odd` lets in subnormals,
/// infinities and NaN.
fn cases(format: SmallFloat, n: u64, odd: bool) -> (Vec<Cone>, Vec<u32>) {
    let codes = u64::from(format.sign()) * 2;
    let finite = |code: u32| {
        let raw = code & (format.sign() - 1);
        if odd || raw == 0 {
            return code;
        }
        // Into the normal numbers.
        let least = 1 << format.mantissa_bits;
        let span = format.largest() - least + 1;
        (code & format.sign()) | (least + raw % span)
    };
    let mut cones = Vec::new();
    let mut distances = Vec::new();
    for i in 0..n {
        let mut random = Random::new(i);
        let bits = random.word();
        let angle = finite(low(bits % codes));
        let width = finite(low((bits >> 20) % codes));
        let (angle, width) = match i % 16 {
            0 => (0, width),
            1 => (angle, 0),
            2 => (format.sign(), width),
            _ => (angle, width),
        };
        let exact = -value(format, width) / value(format, angle);
        #[expect(clippy::cast_possible_truncation, reason = "any distance will do")]
        let near = (exact as f32).to_bits();
        let d = match i % 4 {
            0 => near,
            1 => near.wrapping_add(low(bits >> 40) % 5).wrapping_sub(2),
            2 => low(bits >> 32) & 0x80ff_ffff | (100 + low(bits >> 3) % 60) << 23,
            _ => low(random.word()),
        };
        let raw = d & 0x7fff_ffff;
        let normal = (0x0080_0000..0x7f80_0000).contains(&raw) || raw == 0;
        cones.push(Cone { angle: Angle(angle), width: Width(width) });
        distances.push(if odd || normal { d } else { 0x3f80_0000 });
    }
    (cones, distances)
}

#[test]
fn blocks_have_the_bits_of_one_cone_at_a_time() {
    let mut saturated = 0;
    let mut turned = 0;
    for format in [ConeFormat::Bf16, ConeFormat::F16] {
        for rounding in StoreRounding::ALL {
            let mut config = Config::default();
            config.policy.cone.format = format;
            config.policy.cone.rounding = *rounding;
            let cfg = Cfg::new(&config);
            for odd in [false, true] {
                // Not a whole number of blocks.
                let (cones, distances) = cases(cfg.format, 200_013, odd);
                let want: Vec<Cone> = cones
                    .iter()
                    .zip(&distances)
                    .zip(7u64..)
                    .map(|((cone, d), ray)| {
                        let (d, _) = SmallFloat::F32.unpack(*d);
                        let mut flags = Flags::default();
                        let dither = &mut cfg.dither(ray);
                        let out = ray_cone::propagate(&cfg, *cone, d, dither, &mut flags);
                        saturated += u64::from(!flags.is_empty());
                        turned += u64::from(out.angle != cone.angle);
                        out
                    })
                    .collect();
                for level in Level::available() {
                    let mut got = cones.clone();
                    propagate_batch(level, &cfg, &mut got, &distances, 7);
                    for (i, (got, want)) in got.iter().zip(&want).enumerate() {
                        assert_eq!(
                            got, want,
                            "{format:?} {rounding:?} {level:?}: {:?} by {:#x}",
                            cones[i], distances[i]
                        );
                    }
                }
            }
        }
    }
    assert!(saturated > 1000 && turned > 1000);
}

#[test]
fn a_block_with_a_strange_number_is_left_as_it_is() {
    let start = [Cone { angle: Angle(0x3f80), width: Width(0x4000) }; fast::BLOCK];
    let distances = [0x3f80_0000; fast::BLOCK];
    let random = [0; fast::BLOCK];
    let run = |cones: &mut [Cone; fast::BLOCK], d: &[u32; fast::BLOCK]| {
        fast::propagate_block(SmallFloat::BF16, StoreRounding::Rne, &random, cones, d)
    };
    let mut plain = start;
    assert!(run(&mut plain, &distances));
    assert_eq!(plain[5].width, Width(0x4040));
    // The least subnormal, ∞, NaN: in any of the three places.
    for code in [1u32, 0x7f80, 0x7fc0] {
        let mut angle = start;
        angle[9].angle = Angle(code);
        let mut width = start;
        width[9].width = Width(code);
        let mut d = distances;
        d[9] = code << 16 | 1;
        for (cones, d) in [(angle, distances), (width, distances), (start, d)] {
            let mut after = cones;
            assert!(!run(&mut after, &d), "{code:#x}");
            assert_eq!(after, cones);
        }
    }
}
