//! Borders of the unit's textures and the filter against exact rational arithmetic.

mod borders;
mod exact;

use half::f16;
use rtl_model::fx::Rounding;
use rtl_model::texel::{decode, half_to_q24, to_half};
use rtl_model::texture::Source;
use rtl_model::{Config, Texture};
use support::model::{Rng, round_ratio};
use tapline::cube::across_edge;

/// Unbordered levels: size and binary32 words.
type Levels = Vec<(usize, Vec<[u32; 3]>)>;

fn chain(rng: &mut Rng, size: usize, mut word: impl FnMut(&mut Rng) -> u32) -> Levels {
    let mut out = Levels::new();
    let mut n = size;
    loop {
        let texels = (0..6 * n * n).map(|_| [0; 3].map(|_: u32| word(rng)));
        out.push((n, texels.collect()));
        if n == 1 {
            return out;
        }
        n /= 2;
    }
}

/// Texels of many magnitudes: exponents 2^−12…2^15.
fn any_texel(rng: &mut Rng) -> u32 {
    rng.bits(115, 142) << 23 | rng.bits(0, 0x7f_ffff)
}

fn build(config: &Config, levels: &Levels) -> Texture {
    let sources: Vec<Source<'_>> =
        levels.iter().map(|(size, words)| Source { size: *size, words }).collect();
    Texture::new(config, &sources, &across_edge).expect("legal texels")
}

/// The texel at (x, y) of a face, one texel beyond its edges included, from the definitions.
fn texel(config: &Config, level: &(usize, Vec<[u32; 3]>), face: usize, x: i64, y: i64) -> [i64; 3] {
    let (size, words) = level;
    let last = i64::try_from(*size).expect("small") - 1;
    let word = |x: i64, y: i64| {
        let (face, x, y) = across_edge(*size, face, x, y).expect("at most one step outside");
        words[(face * size + y) * size + x]
    };
    let outside = |t: i64| t < 0 || t > last;
    if !(outside(x) && outside(y)) {
        return decode(config, word(x, y));
    }
    let (inner_x, inner_y) = (x.clamp(0, last), y.clamp(0, last));
    let three = [word(inner_x, inner_y), word(x, inner_y), word(inner_x, y)];
    let mut out = [0; 3];
    for (c, o) in out.iter_mut().enumerate() {
        *o = if rtl_model::texel::keeps_half(config) {
            let sum: f64 = three.iter().map(|t| f16::from_bits(to_half(t[c])).to_f64()).sum();
            half_to_q24(f16::from_f64(sum / 3.0).to_bits())
        } else {
            let sum: i64 = three.iter().map(|t| decode(config, *t)[c]).sum();
            i64::try_from(round_ratio(sum.into(), 3, Rounding::HalfEven)).expect("a mean")
        };
    }
    out
}
