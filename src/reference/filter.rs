//! Stage `filter`: trilinear probes and their weighted mean.

use super::address::Address;
use super::tap::{Tap, put};
use super::texture::{Texture, mix};
use crate::stage::Stage;

/// The two levels of a trilinear look-up and the weight of the second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Levels {
    /// ⌊LOD⌋ and the level after it, at most the last of the chain.
    pub index: [usize; 2],
    /// LOD − ⌊LOD⌋.
    pub fraction: f64,
}

impl Levels {
    /// Levels of an LOD from 0 to `levels` − 1.
    #[must_use]
    pub fn new(lod: f64, levels: usize) -> Self {
        let last = levels.saturating_sub(1);
        let low = lod.clamp(0.0, last as f64).floor();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a whole number from 0 to the last level"
        )]
        let index = low as usize;
        Self { index: [index, (index + 1).min(last)], fraction: lod - low }
    }
}

/// Memory that gives bilinear values.
pub trait Sampler {
    /// The bilinear value of a level at a place on a face; a level beyond the chain counts as the last.
    fn bilinear(&self, level: usize, at: Address) -> [f64; 3];
}

impl Sampler for Texture<'_> {
    #[inline]
    fn bilinear(&self, level: usize, at: Address) -> [f64; 3] {
        Texture::bilinear(self, level, at)
    }
}

/// Sums the bilinear values of both levels over the probes, each with its weight, divides by the
/// weights' sum and mixes the levels by the LOD's fraction. Integer weights keep a constant texture
/// exactly constant: sums of up to 2^29 equal floats are exact.
#[inline]
pub fn filter<M: Sampler, T: Tap>(
    texture: &M,
    levels: Levels,
    probes: impl Iterator<Item = (Address, u32)>,
    tap: &mut T,
) -> [f64; 3] {
    let mut sums = [[0.0f64; 3]; 2];
    let mut total = 0.0;
    for (i, (address, weight)) in probes.enumerate() {
        let weight = f64::from(weight);
        total += weight;
        // With a fraction of 0 the second level counts nothing; a trace shows it all the same.
        let used = if levels.fraction > 0.0 || T::ACTIVE { 2 } else { 1 };
        for (level, sum) in sums.iter_mut().enumerate().take(used) {
            let value = texture.bilinear(levels.index[level], address);
            for (channel, (sum, value)) in sum.iter_mut().zip(value).enumerate() {
                *sum += weight * value;
                if T::ACTIVE {
                    let component = i * 6 + level * 3 + channel;
                    tap.put(Stage::Filter, "bilinear", component, value);
                }
            }
        }
    }
    let color: [f64; 3] = std::array::from_fn(|channel| {
        let [low, high] = sums.map(|sum| sum[channel] / total);
        if levels.fraction > 0.0 { mix(low, high, levels.fraction) } else { low }
    });
    put(tap, Stage::Filter, "color", &color);
    color
}
