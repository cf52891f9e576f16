//! Tiles of 64 × 64 texels that requests touch, level by level: the tiles that a demand-loading system has to fetch.

use crate::base::num;
use crate::picture::Picture;
use crate::planar::PlanarMap;
use crate::policy::Wrap;

/// Texels along an edge of a tile.
pub const TILE: usize = 64;

/// One level's tiles.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Level {
    /// Columns and rows in texels.
    size: [usize; 2],
    /// Columns and rows of tiles.
    tiles: [usize; 2],
    touched: Vec<bool>,
}

/// Touched tiles of a texture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tiles {
    levels: Vec<Level>,
    wrap: [Wrap; 2],
}

impl Tiles {
    /// None yet.
    #[must_use]
    pub fn new(map: &PlanarMap, wrap: [Wrap; 2]) -> Self {
        let level = |size: [usize; 2]| {
            let tiles = size.map(|n| n.div_ceil(TILE));
            Level { size, tiles, touched: vec![false; tiles[0] * tiles[1]] }
        };
        Self { levels: map.levels.iter().map(|l| level(l.size)).collect(), wrap }
    }

    /// The four texels of a bilinear footprint whose first one stands at `corner` of the bordered level: −1, −1 is 0, 0.
    pub fn touch(&mut self, level: usize, corner: [usize; 2]) {
        let wrap = self.wrap;
        let Some(level) = self.levels.get_mut(level) else {
            return;
        };
        let place = |i: usize, beyond: usize| {
            let x = num::i64(corner[i] + beyond) - 1;
            wrap[i].texel(x, level.size[i]) / TILE
        };
        for y in [place(1, 0), place(1, 1)] {
            for x in [place(0, 0), place(0, 1)] {
                level.touched[y * level.tiles[0] + x] = true;
            }
        }
    }

    /// Adds another's tiles of the same texture.
    pub fn merge(&mut self, other: &Self) {
        for (a, b) in self.levels.iter_mut().zip(&other.levels) {
            for (a, b) in a.touched.iter_mut().zip(&b.touched) {
                *a |= b;
            }
        }
    }

    /// Touched tiles of each level.
    #[must_use]
    pub fn counts(&self) -> Vec<usize> {
        let count = |level: &Level| level.touched.iter().filter(|t| **t).count();
        self.levels.iter().map(count).collect()
    }

    /// Touched tiles of all levels.
    #[must_use]
    pub fn total(&self) -> usize {
        self.counts().iter().sum()
    }

    /// The levels that have more than one tile side by side, four pixels a tile: touched ones in the level's colour.
    #[must_use]
    pub fn picture(&self) -> Picture {
        const SIDE: usize = 4;
        let shown: Vec<(usize, &Level)> = self
            .levels
            .iter()
            .enumerate()
            .filter(|(i, level)| *i == 0 || level.tiles != [1, 1])
            .collect();
        let width: usize = shown.iter().map(|(_, l)| l.tiles[0] * SIDE + SIDE).sum();
        let height = shown.iter().map(|(_, l)| l.tiles[1] * SIDE).max();
        let mut out = Picture::new(width.max(1), height.unwrap_or(1));
        out.covered.fill(true);
        let mut left = 0;
        for (index, level) in shown {
            for y in 0..level.tiles[1] * SIDE {
                for x in 0..level.tiles[0] * SIDE {
                    let touched = level.touched[y / SIDE * level.tiles[0] + x / SIDE];
                    let edge = x % SIDE == 0 || y % SIDE == 0;
                    out.rgb[y * out.width + left + x] = match (touched, edge) {
                        (true, false) => level_colour(index as f64),
                        (true, true) => level_colour(index as f64).map(|c| 0.6 * c),
                        (false, _) => [0.03; 3],
                    };
                }
            }
            left += level.tiles[0] * SIDE + SIDE;
        }
        out
    }
}

/// A colour for a level of detail: red, orange, yellow, green, cyan, blue, violet, magenta, grey from level 0 on, mixed
/// in between.
#[must_use]
pub fn level_colour(lod: f64) -> [f64; 3] {
    const COLOURS: [[f64; 3]; 9] = [
        [0.90, 0.05, 0.04],
        [0.95, 0.35, 0.02],
        [0.90, 0.80, 0.05],
        [0.12, 0.65, 0.08],
        [0.05, 0.65, 0.70],
        [0.06, 0.15, 0.85],
        [0.35, 0.08, 0.75],
        [0.80, 0.10, 0.60],
        [0.50, 0.50, 0.50],
    ];
    let place = lod.clamp(0.0, 8.0);
    let mut low = 0;
    while low < 7 && place >= (low + 1) as f64 {
        low += 1;
    }
    let share = place - low as f64;
    let (a, b) = (COLOURS[low], COLOURS[low + 1]);
    [0, 1, 2].map(|c| a[c] + (b[c] - a[c]) * share)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mips::build_planar_mips;
    use crate::planar::PlanarLevel;

    #[test]
    fn a_footprint_on_a_tiles_corner_touches_four_and_one_on_the_edge_wraps() {
        let size = [200, 130];
        let map = build_planar_mips(PlanarLevel { size, texels: vec![[0.0; 3]; 200 * 130] });
        let mut tiles = Tiles::new(&map, [Wrap::Repeat, Wrap::Clamp]);
        // Texels 63, 64 in both directions: corner + 1.
        tiles.touch(0, [64, 64]);
        assert_eq!(tiles.counts()[0], 4);
        // Columns −1 and 0: the last and the first; row −1 is row 0.
        tiles.touch(0, [0, 0]);
        assert_eq!(tiles.counts()[0], 5, "columns 0 and 3 of row 0, the first known");
        // Level 2 has 50 × 32 texels: one tile.
        tiles.touch(2, [0, 0]);
        tiles.touch(2, [50, 32]);
        assert_eq!(tiles.counts()[2], 1);
        let mut other = Tiles::new(&map, [Wrap::Repeat, Wrap::Clamp]);
        other.touch(1, [1, 1]);
        tiles.merge(&other);
        assert_eq!(tiles.total(), 7);
    }
}
