//! A 2-D texture prepared for bilinear look-ups beyond its edges.

use super::address::{Address, texel_coordinate};
use super::filter::Sampler;
use super::texture::mix;
use crate::planar::PlanarMap;
use crate::policy::Wrap;

/// A borrowed texture and its address modes.
#[derive(Clone, Copy, Debug)]
pub struct PlanarTexture<'a> {
    map: &'a PlanarMap,
    wrap: [Wrap; 2],
}

impl<'a> PlanarTexture<'a> {
    /// Prepares a texture whose levels are not empty.
    #[must_use]
    pub fn new(map: &'a PlanarMap, wrap: [Wrap; 2]) -> Self {
        Self { map, wrap }
    }

    /// Number of levels.
    #[must_use]
    pub fn levels(&self) -> usize {
        self.map.levels.len()
    }

    /// Columns and rows of a level; beyond the chain, of the last one.
    #[must_use]
    pub fn level_size(&self, level: usize) -> [usize; 2] {
        self.map.levels[level.min(self.levels() - 1)].size
    }

    /// The texel that stands at a column and a row, which may lie outside.
    #[must_use]
    pub fn texel(&self, level: usize, at: [i64; 2]) -> [f64; 3] {
        let level = &self.map.levels[level.min(self.levels() - 1)];
        let [x, y] = [0, 1].map(|i| self.wrap[i].texel(at[i], level.size[i]));
        level.texel(x, y).map(f64::from)
    }
}

/// A coordinate u = 2s − 1 that is left as it is from −1 to 1, brought back from beyond.
#[must_use]
pub fn wrapped(u: f64, wrap: Wrap) -> f64 {
    if u.abs() <= 1.0 {
        return u;
    }
    // Remainders are exact.
    match wrap {
        Wrap::Repeat => libm::remainder(u, 2.0),
        Wrap::Clamp => u.clamp(-1.0, 1.0),
        Wrap::Mirror => {
            let turn = libm::remainder(u, 4.0);
            if turn > 1.0 {
                2.0 - turn
            } else if turn < -1.0 {
                -2.0 - turn
            } else {
                turn
            }
        }
    }
}

impl Sampler for PlanarTexture<'_> {
    fn bilinear(&self, level: usize, at: Address) -> [f64; 3] {
        let size = self.level_size(level);
        let cell = |u: f64, n: usize| {
            let x = texel_coordinate(u, n);
            let low = x.floor();
            #[expect(
                clippy::cast_possible_truncation,
                reason = "a place on the texture, at most half a texel outside"
            )]
            let index = low as i64;
            (index, x - low)
        };
        let ((x, fx), (y, fy)) = (cell(at.u, size[0]), cell(at.v, size[1]));
        let [lt, rt, lb, rb] =
            [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]].map(|place| self.texel(level, place));
        [0, 1, 2].map(|c| mix(mix(lt[c], rt[c], fx), mix(lb[c], rb[c], fx), fy))
    }
}
