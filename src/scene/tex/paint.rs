//! Procedural textures: fine detail on every level of the chain, hard edges and smooth shades.

use crate::base::num;
use rayon::prelude::*;

use crate::base::random::stirred;
use crate::mips::build_planar_mips;
use crate::planar::{PlanarLevel, PlanarMap};

/// The pattern of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Paint {
    /// A floor like a map: tinted fields with borders, a grid, fine marks.
    Fields,
    /// Glazed stoneware: bands, leaves, speckles.
    Glaze,
}

impl Paint {
    /// The texture of `size` × `size` texels with its chain; each texel is the colour of its centre.
    #[must_use]
    pub fn texture(self, size: usize) -> PlanarMap {
        let texels = (0..size * size)
            .into_par_iter()
            .map(|i| {
                let at = |n: usize| (2 * n + 1) as f64 / (2 * size) as f64;
                let colour = match self {
                    Self::Fields => fields(at(i % size), at(i / size)),
                    Self::Glaze => glaze(at(i % size), at(i / size)),
                };
                colour.map(num::f32)
            })
            .collect();
        build_planar_mips(PlanarLevel { size: [size; 2], texels })
    }
}

/// 0…1 from two whole numbers.
fn noise(x: f64, y: f64) -> f64 {
    let bits = |v: f64| {
        #[expect(
            clippy::cast_possible_truncation,
            reason = "whole numbers below 2^20 in magnitude"
        )]
        let whole = v as i64;
        whole.cast_unsigned()
    };
    let h =
        bits(x).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ bits(y).wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
    (stirred(h) >> 40) as f64 / 16_777_216.0
}

fn odd(x: f64) -> bool {
    x.floor().rem_euclid(2.0) >= 1.0
}

fn fields(s: f64, t: f64) -> [f64; 3] {
    // 16 × 16 fields, each with a tint of its own, chequered inside by eight.
    let (x, y) = (16.0 * s, 16.0 * t);
    let tint =
        [0, 1, 2].map(|c: u8| 0.25 + 0.7 * noise(x.floor() + 40.0 * f64::from(c), y.floor()));
    let [fx, fy] = [x - x.floor(), y - y.floor()];
    if fx.min(fy) < 0.02 || fx.max(fy) > 0.98 {
        return [0.04, 0.04, 0.05];
    }
    let light = if odd(8.0 * fx) == odd(8.0 * fy) { 1.0 } else { 0.55 };
    let soft = 0.8 + 0.2 * libm::cos(6.3 * fx) * libm::cos(6.3 * fy);
    // Marks one or a few texels wide at 2048 × 2048.
    let fine = 0.75 + 0.5 * noise((1024.0 * s).floor(), (1024.0 * t).floor());
    tint.map(|c| (c * light * soft * fine).min(1.0))
}

fn glaze(s: f64, t: f64) -> [f64; 3] {
    let wave = 0.02 * libm::sin(2.0 * std::f64::consts::PI * 12.0 * s);
    let band = odd(24.0 * (t + wave));
    let [u, v] = [24.0 * s, 24.0 * t].map(|x| 2.0 * (x - x.floor()) - 1.0);
    let leaf = u * u + 4.0 * v * v < 0.7;
    let base = match (band, leaf) {
        (true, true) => [0.85, 0.80, 0.66],
        (true, false) => [0.16, 0.30, 0.55],
        (false, true) => [0.60, 0.20, 0.12],
        (false, false) => [0.80, 0.74, 0.60],
    };
    let fine = 0.8 + 0.4 * noise((768.0 * s).floor() + 7.0, (768.0 * t).floor());
    base.map(|c: f64| (c * fine).min(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn textures_have_detail_on_their_finest_level_and_a_full_chain() {
        for paint in [Paint::Fields, Paint::Glaze] {
            let map = paint.texture(256);
            assert_eq!(map.levels.len(), 9);
            assert_eq!(map.levels[8].size, [1, 1]);
            let level = &map.levels[0];
            assert!(level.texels.iter().flatten().all(|c| (0.0..=1.0).contains(c)));
            let steps = level
                .texels
                .windows(2)
                .filter(|pair| (pair[0][0] - pair[1][0]).abs() > 0.05)
                .count();
            assert!(steps > 256 * 256 / 20, "{paint:?}: {steps} edges");
        }
    }
}
