//! The memories that vectors and suites read: defined by formulas, so that a device can hold the same.
//!
//! Texel (level, face, x, y, channel) of level 0 is `hash(face, y, x, channel)`, a number of 12 bits times 2^(e − 12)
//! with e from 0 to 3 by its low two bits: steep steps between texels, and a texel of the
//! next level is the mean of 2 × 2, rounded to binary16. A few texels hold its extremes: 0, 2⁻²⁴, 65504.

use crate::base::num;
use crate::cube::{CubeLevel, CubeMap, direction};
use crate::distance::{Distance, DistanceCube};
use crate::mips::{build_mips, build_planar_mips};
use crate::planar::{PlanarLevel, PlanarMap};

/// Avalanche of 32 bits.
fn hash(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// A texel's channel by its number.
fn channel(index: u32, channel: u32) -> f32 {
    let word = hash(index.wrapping_mul(4).wrapping_add(channel));
    match word >> 24 {
        0 => 0.0,
        1 => libm::ldexpf(1.0, -24),
        2 => 65504.0,
        _ => {
            let exponent = i32::from(num::u8(word & 3));
            let mantissa = f32::from(num::u16(word >> 2 & 0xfff));
            libm::ldexpf(mantissa, exponent - 12)
        }
    }
}

/// A texel by its number.
fn texel(index: usize) -> [f32; 3] {
    let index = num::u32(index);
    [0, 1, 2].map(|c| channel(index, c))
}

/// Rounds texels to binary16, which every engine holds exactly.
fn halved(texels: &mut [[f32; 3]]) {
    for channel in texels.iter_mut().flatten() {
        *channel = half::f16::from_f32(*channel).to_f32();
    }
}

/// The cube map of faces of `size` texels.
#[must_use]
pub fn cube(size: u32) -> CubeMap {
    let size = num::usize(size).max(1);
    let mut map = build_mips(CubeLevel { size, texels: (0..6 * size * size).map(texel).collect() });
    for level in &mut map.levels {
        halved(&mut level.texels);
    }
    map
}

/// The 2-D texture of `size` columns and half as many rows.
#[must_use]
pub fn planar(size: u32) -> PlanarMap {
    let columns = num::usize(size).max(1);
    let rows = (columns / 2).max(1);
    let mut map = build_planar_mips(PlanarLevel {
        size: [columns, rows],
        texels: (0..columns * rows).map(texel).collect(),
    });
    for level in &mut map.levels {
        halved(&mut level.texels);
    }
    map
}

/// Distances to a box of half edges 3, 2, 4 about the reference point, sampled at texel centres to single precision.
#[must_use]
pub fn room(size: u32) -> Distance {
    let n = num::usize(size).max(1);
    let place = |k: usize| {
        let (k, n) = (num::u32(k), size.max(1));
        f64::from(2 * k + 1) / f64::from(n) - 1.0
    };
    let mut texels = Vec::with_capacity(6 * n * n);
    for index in 0..6 * n * n {
        let (face, y, x) = (index / (n * n), index / n % n, index % n);
        let d = direction(face, place(x), place(y));
        let length = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
        let wall = [3.0, 2.0, 4.0]
            .iter()
            .zip(d)
            .map(|(half, c)| half / c.abs())
            .fold(f64::INFINITY, f64::min);
        #[expect(clippy::cast_possible_truncation, reason = "single precision is the file's")]
        texels.push((wall * length) as f32);
    }
    Distance::Cube(DistanceCube { size: n, texels })
}
