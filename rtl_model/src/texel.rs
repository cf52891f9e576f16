//! Texel formats: binary32 words to stored texels to the datapath's fixed point.
//!
//! Texels are finite and not negative when they come here; NaN, negative numbers and −∞ become 0 and
//! +∞ the largest code, so that any word is defined.

use crate::config::Config;
use crate::policy::TexelFormat;

/// m · 2^e of a non-negative binary32 word; negative and NaN are 0, +∞ is `None`.
fn unpack(word: u32) -> Option<(u64, i32)> {
    let biased = (word >> 23) & 0xff;
    let fraction = u64::from(word & 0x7f_ffff);
    match (word >> 31, biased) {
        (0, 0xff) if fraction == 0 => None,
        (1, _) | (_, 0xff) => Some((0, 0)),
        (_, 0) => Some((fraction, -149)),
        (_, _) => Some((fraction | 1 << 23, i32::try_from(biased).unwrap_or(0) - 150)),
    }
}

/// m · 2^e rounded to the nearest integer, ties to even; `None` where it exceeds 62 bits.
fn round(m: u64, e: i32) -> Option<u64> {
    nearest(m, e, false)
}

/// Like [`round`]; ties go up where `ties_up`.
fn nearest(m: u64, e: i32, ties_up: bool) -> Option<u64> {
    if m == 0 {
        return Some(0);
    }
    if e >= 0 {
        let shift = e.unsigned_abs();
        return (shift < 62 && m.leading_zeros() > shift + 2).then(|| m << shift);
    }
    let s = e.unsigned_abs();
    if s > 63 {
        return Some(0);
    }
    let half = 1u64 << (s - 1);
    let odd = (m >> s.min(63)) & u64::from(s < 64);
    // m < 2^62: the sum cannot wrap.
    Some((m + (half - 1) + (odd & 1 | u64::from(ties_up))) >> s)
}

/// A non-negative binary32 word as a binary16 word, ties to even, saturating at 65504.
#[must_use]
pub fn to_half(word: u32) -> u16 {
    const MAX: u16 = 0x7bff;
    let Some((m, e)) = unpack(word) else {
        return MAX;
    };
    if m == 0 {
        return 0;
    }
    // The leading bit's weight; below 2^−14 the spacing stays 2^−24.
    let top = 63 - i32::try_from(m.leading_zeros()).unwrap_or(0) + e;
    let lsb = (top - 10).max(-24);
    let Some(code) = round(m, e - lsb) else {
        return MAX;
    };
    // code counts LSBs: 1024…2048 for a normal number, and 2048 carries into the exponent.
    let exponent = u64::from((lsb + 24).unsigned_abs());
    let bits = if lsb == -24 { code } else { (exponent << 10) + code };
    u16::try_from(bits.min(u64::from(MAX))).unwrap_or(MAX)
}

/// A finite, non-negative binary16 word with 24 fraction bits: exact.
#[inline(always)]
#[must_use]
pub fn half_to_q24(word: u16) -> i64 {
    let m = i64::from(word & 0x3ff);
    let e = i64::from((word >> 10) & 0x1f);
    if e == 0 { m } else { (m | 0x400) << (e - 1) }
}

/// Bits of a packed channel's mantissa, which comes first, and of its shift.
pub const PACKED_MANTISSA: u32 = 11;
/// Bits of a packed channel's shift.
pub const PACKED_SHIFT: u32 = 5;
/// First bits of the channels of a packed texel.
pub const PACKED_STARTS: [u32; 3] = [0, 16, 32];

/// Three finite, non-negative binary16 words in one word of memory, each as its 11-bit mantissa and
/// 5-bit shift: value = mantissa·2^shift·2^−24. As many bits as the halves, none of them lost.
///
/// 0x3c00 (1.0) is mantissa 0x400, shift 14: 0x7400.
#[must_use]
pub fn pack(halves: [u16; 3]) -> u64 {
    let mut word = 0;
    for (half, start) in halves.into_iter().zip(PACKED_STARTS) {
        let e = u64::from(half >> 10) & 0x1f;
        let normal = u64::from(e != 0);
        let mantissa = u64::from(half & 0x3ff) | normal << 10;
        word |= (mantissa | (e - normal) << PACKED_MANTISSA) << start;
    }
    word
}

/// The channels of a packed texel with 24 fraction bits: exact.
#[must_use]
pub fn unpack_q24(word: u64) -> [i64; 3] {
    PACKED_STARTS.map(|start| {
        let mantissa = (word >> start) & ((1 << PACKED_MANTISSA) - 1);
        let shift = (word >> (start + PACKED_MANTISSA)) & ((1 << PACKED_SHIFT) - 1);
        (mantissa << shift).cast_signed()
    })
}

/// Three binary32 words as shared-exponent mantissas and exponent (EXT_texture_shared_exponent:
/// ⌊x + ½⌋, not ties to even).
#[must_use]
pub fn to_rgb9e5(words: [u32; 3]) -> ([u64; 3], i32) {
    let parts = words.map(unpack);
    let top = |(m, e): (u64, i32)| 63 - i32::try_from(m.leading_zeros()).unwrap_or(0) + e;
    let mut max = -16;
    for part in parts {
        max = max.max(part.map_or(16, |p| if p.0 == 0 { -16 } else { top(p) }));
    }
    // Mantissas are 0.9: value = m · 2^(exponent − 9), exponent = floor(log2 max) + 1 in −15…16.
    let quantize = |exponent: i32| {
        parts.map(|part| {
            part.map_or(511, |(m, e)| nearest(m, e - (exponent - 9), true).unwrap_or(512))
        })
    };
    let mut exponent = (max + 1).clamp(-15, 16);
    let mut codes = quantize(exponent);
    if codes.iter().any(|&c| c > 511) && exponent < 16 {
        exponent += 1;
        codes = quantize(exponent);
    }
    (codes.map(|c| c.min(511)), exponent)
}

/// One texel as the datapath sees it: `texel.frac` fraction bits, saturated at `texel.int` bits.
#[must_use]
pub fn decode(config: &Config, words: [u32; 3]) -> [i64; 3] {
    let frac = i32::try_from(config.policy.texel.frac).unwrap_or(0);
    let max = (1u64 << (config.policy.texel.int + config.policy.texel.frac)) - 1;
    let limit = |code: Option<u64>| code.unwrap_or(max).min(max).cast_signed();
    match config.policy.texel.format {
        TexelFormat::Q => words.map(|w| limit(unpack(w).and_then(|(m, e)| round(m, e + frac)))),
        TexelFormat::Half => words.map(|w| {
            let q24 = half_to_q24(to_half(w)).cast_unsigned();
            limit(round(q24, frac - 24))
        }),
        TexelFormat::Unorm8 => words.map(|w| {
            // clamp(x, 0, 1)·255 to nearest even, then c/255 with `frac` bits to nearest (no ties: 255
            // is odd).
            let code = unpack(w).map_or(255, |(m, e)| round(255 * m, e).unwrap_or(255).min(255));
            limit(Some((2 * (code << frac) + 255) / 510))
        }),
        TexelFormat::Rgb9e5 => {
            let (codes, exponent) = to_rgb9e5(words);
            codes.map(|m| limit(round(m, exponent - 9 + frac)))
        }
    }
}

/// Whether a binary32 word lies beyond the largest texel, which is stored in its place.
#[must_use]
pub fn saturates(config: &Config, word: u32) -> bool {
    let frac = i32::try_from(config.policy.texel.frac).unwrap_or(0);
    let max = (1u64 << (config.policy.texel.int + config.policy.texel.frac)) - 1;
    let Some((m, e)) = unpack(word) else {
        return true;
    };
    // The first words that round beyond the format: 65520 of halves, 65472 of shared exponents.
    let beyond = match config.policy.texel.format {
        TexelFormat::Q => false,
        TexelFormat::Half => word >= 0x477f_f000,
        TexelFormat::Rgb9e5 => word >= 0x477f_c000,
        TexelFormat::Unorm8 => round(255 * m, e).is_none_or(|code| code > 255),
    };
    m > 0 && (beyond || round(m, e + frac).is_none_or(|code| code > max))
}

/// Whether the datapath holds every finite half as it is, so that texels may stay halves in memory.
#[must_use]
pub fn keeps_half(config: &Config) -> bool {
    config.policy.texel.format == TexelFormat::Half
        && config.policy.texel.frac == 24
        && config.policy.texel.int >= 16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_saturates_where_a_larger_one_is_stored_alike_and_a_smaller_one_is_not() {
        // Per format: the last word that does not saturate, where 4 integer bits are there, and where 17 are.
        let word = f32_words();
        for (format, int, last, first) in [
            (TexelFormat::Q, 4, word[0], word[1]),
            (TexelFormat::Half, 17, word[2], word[3]),
            (TexelFormat::Rgb9e5, 17, word[4], word[5]),
            (TexelFormat::Unorm8, 17, word[6], word[7]),
        ] {
            let mut config = Config::default();
            (config.policy.texel.format, config.policy.texel.int) = (format, int);
            assert!(!saturates(&config, last) && saturates(&config, first), "{format:?}");
            let stored = |word: u32| decode(&config, [word, 0, 0]);
            assert_eq!(stored(first), stored(0x7f00_0000), "{format:?}");
            assert!(saturates(&config, 0x7f80_0000) && !saturates(&config, 0xff80_0000));
        }
    }

    /// 16 less an ulp, 16; 65520 less an ulp, 65520; 65472 less an ulp, 65472; 1, 1 and a 255th.
    fn f32_words() -> [u32; 8] {
        [
            0x417f_ffff,
            0x4180_0000,
            0x477f_efff,
            0x477f_f000,
            0x477f_bfff,
            0x477f_c000,
            0x3f80_0000,
            0x3f80_8080,
        ]
    }

    #[test]
    fn packed_halves_keep_every_finite_value() {
        assert_eq!(pack([0x3c00, 0, 0]), 0x7400);
        for half in 0..0x7c00 {
            for c in 0..3 {
                let mut halves = [0x3555, 0x7bff, 0x0001];
                halves[c] = half;
                assert_eq!(unpack_q24(pack(halves)), halves.map(half_to_q24));
            }
        }
    }
}
