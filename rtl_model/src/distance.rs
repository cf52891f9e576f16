//! Distance memory, which HIT looks up, in units of one power of two for the whole map.
//!
//! The largest finite distance lies in [1, 2)·2^scale (half of that where it would round up to 2), so that a room of a
//! millimetre and one of a kilometre use the same registers. A box or a sphere is an ideal memory: the distance of the very direction, correctly rounded to the
//! register `hit.distance`.

use alloc::format;
use alloc::vec;
use alloc::vec::Vec;

use crate::config::{Config, ConfigError};
use crate::fx::{Overflow, Quantizer};
use crate::port;
use crate::regs::Reg;
use crate::texture::{AcrossEdge, corner_texels};

/// Code of an infinite distance.
pub const INFINITE: u32 = u32::MAX;
/// Code of a finite distance beyond a register that saturates.
pub const BEYOND: u32 = u32::MAX - 1;
/// Fraction bits of a box's half edges.
pub const HALF_EDGE_FRAC: i64 = 30;

/// Where the codes come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Six faces with a border of one texel, row by row; a corner is the mean of the three texels that meet there.
    Cube {
        /// Texels along an edge, without the border.
        size: usize,
        /// 6·(size + 2)² codes.
        codes: Vec<u32>,
    },
    /// Half edges with [`HALF_EDGE_FRAC`] bits.
    Box([i64; 3]),
    /// One code for every direction.
    Sphere(u32),
}

/// The memory of one map.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DistanceMemory {
    /// A distance is code·2^(scale − frac).
    pub scale: i64,
    /// The codes.
    pub kind: Kind,
    /// Texels beyond the register.
    pub beyond: u64,
}

/// No wall anywhere: every ray escapes.
impl Default for DistanceMemory {
    fn default() -> Self {
        Self { scale: 0, kind: Kind::Sphere(INFINITE), beyond: 0 }
    }
}

/// The register write of `hit.distance`, refused where codes would not fit a memory word.
fn register(config: &Config) -> Result<Quantizer, ConfigError> {
    let format = config.format(Reg::HitDistance);
    if format.magnitude_bits() > 30 || format.frac > 27 {
        return Err(ConfigError {
            path: "registers.hit.distance".into(),
            expected: "at most 30 bits, of them at most 27 of the fraction".into(),
            found: format!("{} bits, {} of the fraction", format.width(), format.frac),
        });
    }
    Ok(Quantizer::new(format, 0))
}

/// A distance m·2^e (not negative) as a code.
fn encode(q: &Quantizer, m: i64, e: i64, scale: i64) -> u32 {
    let shift = scale - e - i64::from(q.format.frac);
    let (code, over) = q.write_shifted(m, shift);
    let saturates = matches!(q.format.overflow, Overflow::Saturate | Overflow::SaturateSymmetric);
    if over && saturates {
        return BEYOND;
    }
    u32::try_from(code).unwrap_or(0)
}

/// A binary32 word as m·2^e; `None` where it is infinite. NaN and negative words are infinite, too.
fn single(word: u32) -> Option<(i64, i64)> {
    let biased = i64::from(word >> 23 & 0xff);
    let fraction = i64::from(word & 0x7f_ffff);
    if biased == 0xff || (word >> 31 == 1 && word << 1 != 0) {
        None
    } else if biased == 0 {
        Some((fraction, -149))
    } else {
        Some((fraction | 1 << 23, biased - 150))
    }
}

/// The power of two that puts m·2^e into [1, 2), or one more where it rounds up to 2.
fn scale_for(q: &Quantizer, m: i64, e: i64) -> i64 {
    let scale = top(m, e);
    let frac = i64::from(q.format.frac);
    let code = q.round(m, (scale - e - frac).min(62));
    scale + i64::from(code >= 2 << frac)
}

/// Position of the leading one of m·2^e.
fn top(m: i64, e: i64) -> i64 {
    e + 63 - i64::from(m.leading_zeros())
}

impl DistanceMemory {
    /// Encodes 6·size² binary32 distances, face-major, then row-major.
    pub fn cube(
        config: &Config,
        size: usize,
        words: &[u32],
        across: AcrossEdge<'_>,
    ) -> Result<Self, ConfigError> {
        let q = register(config)?;
        let whole = size.checked_mul(size).and_then(|n| n.checked_mul(6));
        if size == 0 || size > 16384 || whole != Some(words.len()) {
            return Err(ConfigError {
                path: "distance".into(),
                expected: "6·size² texels, size from 1 to 16384".into(),
                found: format!("{} texels of faces of {size}", words.len()),
            });
        }
        let finite = words.iter().filter_map(|w| single(*w));
        let scale =
            finite.filter(|(m, _)| *m != 0).map(|(m, e)| scale_for(&q, m, e)).max().unwrap_or(0);
        let plain: Vec<u32> = words
            .iter()
            .map(|w| single(*w).map_or(INFINITE, |(m, e)| encode(&q, m, e, scale)))
            .collect();
        let beyond = plain.iter().filter(|c| **c == BEYOND).map(|_| 1).sum();
        let at = |f: usize, x: usize, y: usize| {
            plain.get((f * size + y) * size + x).copied().unwrap_or(INFINITE)
        };
        let stride = size + 2;
        let mut codes = vec![0; 6 * stride * stride];
        let n = i64::try_from(size).unwrap_or(0);
        let mut next = codes.iter_mut();
        for face in 0..6 {
            for y in -1..=n {
                for x in -1..=n {
                    let corner = (x < 0 || x == n) && (y < 0 || y == n);
                    let code = if corner {
                        mean(corner_texels(size, face, x, y, across).map(|(f, x, y)| at(f, x, y)))
                    } else {
                        let (f, x, y) = across(size, face, x, y).unwrap_or((face, 0, 0));
                        at(f, x, y)
                    };
                    if let Some(slot) = next.next() {
                        *slot = code;
                    }
                }
            }
        }
        Ok(Self { scale, kind: Kind::Cube { size, codes }, beyond })
    }

    /// The inside of a box of those half edges (binary64 words, positive and finite).
    pub fn ideal_box(config: &Config, half_edges: [u64; 3]) -> Result<Self, ConfigError> {
        register(config)?;
        let parts = half_edges.map(port::unpack);
        let largest = parts.iter().filter(|p| p.0 > 0).map(|p| top(p.0, p.1)).max();
        // The corner's distance is below √3·2^(largest + 1), that is √3 units.
        let scale = largest.unwrap_or(0) + 1;
        let one = Quantizer::new(crate::fx::Format::unsigned(1, 30), 0);
        let edges = parts.map(|(m, e, _)| {
            one.write_shifted(m.max(0), (scale - e - HALF_EDGE_FRAC).min(62)).0.max(1)
        });
        Ok(Self { scale, kind: Kind::Box(edges), beyond: 0 })
    }

    /// The inside of a sphere of that radius (a binary64 word, positive and finite).
    pub fn sphere(config: &Config, radius: u64) -> Result<Self, ConfigError> {
        let q = register(config)?;
        let (m, e, _) = port::unpack(radius);
        let m = m.max(1);
        let scale = scale_for(&q, m, e);
        let code = encode(&q, m, e, scale);
        Ok(Self { scale, kind: Kind::Sphere(code), beyond: u64::from(code == BEYOND) })
    }
}

/// Mean of three codes to nearest; infinite or beyond where one of them is.
fn mean(c: [u32; 3]) -> u32 {
    let most = c.into_iter().max().unwrap_or(0);
    if most >= BEYOND {
        return most;
    }
    (2 * c.into_iter().sum::<u32>() + 3) / 6
}

/// The distance of a box in the direction of `q` (not zero, at most 31 bits), times 2^frac, as a whole number of
/// eighths whose last bit also tells whether anything is left.
#[must_use]
pub fn box_eighths(half_edges: [i64; 3], q: [i64; 3], frac: u32) -> i64 {
    let mut best: Option<(i64, i64)> = None;
    for (h, q) in half_edges.into_iter().zip(q) {
        let q = q.abs();
        // h/q against the best so far: products of at most 62 bits.
        if q > 0 && best.is_none_or(|(bh, bq)| h * bq < bh * q) {
            best = Some((h, q));
        }
    }
    let Some((h, major)) = best else { return 0 };
    let wide = |x: i64| u128::from(x.unsigned_abs());
    let squares: u128 = q.into_iter().map(|c| wide(c) * wide(c)).sum();
    let up = squares * wide(h) * wide(h);
    let down = (wide(major) * wide(major)) << (60 - 2 * (frac.min(27) + 2));
    let (quotient, rest) = (up / down, up % down);
    let root = quotient.isqrt();
    let inexact = rest != 0 || root * root != quotient;
    let eighths = (root << 1) | u128::from(inexact);
    i64::try_from(eighths).unwrap_or(i64::MAX >> 2)
}
