//! Which texels a look-up reads, and with what weights: a texture that is 1 at one texel and 0 elsewhere returns this texel's
//! weight; four at a time, one in each channel. No assumption is made.

use crate::error::InputError;
use crate::sampler::{Image, Query, Shape, Source, State, TextureUnit, alone, finest};

/// Every texel that a look-up reads, with its weight.
#[derive(Clone, Debug)]
pub struct Transfer {
    /// Texels along an edge of level 0.
    pub size: usize,
    /// Weights of each level, laid out like an [`Image`]'s texels.
    pub levels: Vec<Vec<f32>>,
}

impl Transfer {
    /// Sum of a level's weights.
    #[must_use]
    pub fn level(&self, level: usize) -> f64 {
        self.levels[level].iter().map(|w| f64::from(*w)).sum()
    }

    /// The level with the largest weight.
    #[must_use]
    pub fn main_level(&self) -> usize {
        (0..self.levels.len()).max_by(|a, b| self.level(*a).total_cmp(&self.level(*b))).unwrap_or(0)
    }

    /// Texels with weight.
    #[must_use]
    pub fn texels(&self) -> usize {
        self.levels.iter().flatten().filter(|w| **w != 0.0).count()
    }

    /// Centroid of a planar level's weights, relative to a place in texels, and the lengths of boxes with the same variance along
    /// a direction and across it.
    #[must_use]
    pub fn moments(&self, level: usize, at: [f64; 2], axis: [f64; 2]) -> ([f64; 2], [f64; 2]) {
        let side = (self.size >> level).max(1);
        let points = || {
            self.levels[level].iter().enumerate().map(|(i, w)| {
                let place = [i % side, i / side].map(|c| c as f64 + 0.5);
                (f64::from(*w), [place[0] - at[0], place[1] - at[1]])
            })
        };
        let total = points().map(|(w, _)| w).sum::<f64>().max(f64::MIN_POSITIVE);
        let mean = [0, 1].map(|i| points().map(|(w, p)| w * p[i]).sum::<f64>() / total);
        let spread = [axis, [-axis[1], axis[0]]].map(|axis| {
            let off = |p: [f64; 2]| (p[0] - mean[0]) * axis[0] + (p[1] - mean[1]) * axis[1];
            let variance = points().map(|(w, p)| w * off(p) * off(p)).sum::<f64>() / total;
            libm::sqrt(12.0 * variance)
        });
        (mean, spread)
    }
}

/// Measures the transfer of look-ups on a texture of `size` with `levels` levels.
pub fn transfer(
    unit: &mut dyn TextureUnit,
    (shape, size, levels): (Shape, usize, usize),
    state: State,
    source: Source,
    queries: &[Query],
) -> Result<Vec<Transfer>, InputError> {
    let format = finest(unit);
    let count = |level: usize| shape.faces() * (size >> level).max(1).pow(2);
    let empty = Transfer { size, levels: (0..levels).map(|l| vec![0.0; count(l)]).collect() };
    let mut found = vec![empty; queries.len()];
    let mut image = Image::new(shape, format, size, levels, |_, _, _, _| [0.0; 4]);
    for level in 0..levels {
        for first in (0..count(level)).step_by(4) {
            let four = first..(first + 4).min(count(level));
            for (channel, texel) in four.clone().enumerate() {
                image.levels[level][texel][channel] = 1.0;
            }
            let seen = alone(unit, &image, state, source, queries)?;
            for (transfer, color) in found.iter_mut().zip(seen) {
                for (channel, texel) in four.clone().enumerate() {
                    transfer.levels[level][texel] = color[channel];
                }
            }
            image.levels[level][four].fill([0.0; 4]);
        }
    }
    Ok(found)
}
