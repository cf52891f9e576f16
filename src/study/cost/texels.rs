//! The demands of a unit on texel memory: distinct tiles of 64 × 64 texels, and the hits of a small cache.

use std::hash::{Hash as _, Hasher as _};

use rtl_model::stages::filter::Corner;
use rtl_model::{Config, TexelFormat};

use crate::base::num;
use crate::cube::CubeMap;
use crate::engine::reuse::StepHasher;
use crate::engine::tiles::TILE;
use crate::planar::PlanarMap;
use crate::policy::Wrap;

/// A cache of texels: set-associative, the line that was used longest ago goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Cache {
    /// Bytes in all.
    pub bytes: usize,
    /// Lines a set.
    pub ways: usize,
    /// Bytes a line: a square block of texels, or one twice as wide as high.
    pub line_bytes: usize,
}

impl Default for Cache {
    fn default() -> Self {
        Self { bytes: 16 << 10, ways: 4, line_bytes: 64 }
    }
}

impl Cache {
    /// Whether its sets can be addressed by bits.
    #[must_use]
    pub fn is_possible(&self) -> bool {
        let line = self.line_bytes.is_power_of_two() && (16..=1024).contains(&self.line_bytes);
        line && self.ways > 0
            && self.sets().is_power_of_two()
            && self.sets() * self.ways * self.line_bytes == self.bytes
    }

    fn sets(&self) -> usize {
        self.bytes / self.line_bytes.max(1) / self.ways.max(1)
    }
}

/// Bytes of a texel in memory, a power of two.
#[must_use]
pub fn texel_bytes(config: &Config) -> usize {
    match config.policy.texel.format {
        TexelFormat::Unorm8 | TexelFormat::Rgb9e5 => 4,
        TexelFormat::Half => 8,
        TexelFormat::Q => {
            let bits = 3 * (config.policy.texel.int + config.policy.texel.frac);
            usize::try_from(bits.div_ceil(8)).unwrap_or(16).next_power_of_two()
        }
    }
}

/// One level of a map.
#[derive(Clone, Debug)]
struct Level {
    size: [usize; 2],
    /// Tiles a row and tiles a face.
    tiles: [usize; 2],
    touched: Vec<bool>,
    /// First block of the level among all blocks.
    first_block: u64,
}

/// The maps of a scene, as their levels' sizes.
#[derive(Clone, Debug)]
pub struct Maps(Vec<(usize, Vec<[usize; 2]>, [Wrap; 2])>);

impl Maps {
    /// A cube map.
    #[must_use]
    pub fn cube(map: &CubeMap) -> Self {
        // A border texel counts as the nearest one of the same face.
        Self(vec![(6, map.levels.iter().map(|l| [l.size; 2]).collect(), [Wrap::Clamp; 2])])
    }

    /// 2-D textures, and behind them the environment.
    #[must_use]
    pub fn planar(textures: &[PlanarMap], wrap: [Wrap; 2], sky: &CubeMap) -> Self {
        let flat = textures.iter().map(|t| (1, t.levels.iter().map(|l| l.size).collect(), wrap));
        Self(flat.chain(Self::cube(sky).0).collect())
    }
}

/// The requests to memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TexelUse {
    /// Distinct tiles of 64 × 64 texels.
    pub tiles: u64,
    /// Lines asked for, each once a bilinear footprint.
    pub requests: u64,
    /// Lines that the cache had.
    pub hits: u64,
}

impl TexelUse {
    /// Share of requests that the cache had; 1 where there were none.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "counts become a share")]
    pub fn hit_share(&self) -> f64 {
        if self.requests == 0 { 1.0 } else { self.hits as f64 / self.requests as f64 }
    }
}

/// A walk over the bilinear footprints of a picture, in the order of its fragments.
#[derive(Debug)]
pub struct Walk {
    maps: Vec<(usize, Vec<Level>, [Wrap; 2])>,
    /// log2 of a block's columns and rows.
    block: [u32; 2],
    sets: Vec<u64>,
    ways: usize,
    found: TexelUse,
}

impl Walk {
    /// Nothing touched yet.
    #[must_use]
    pub fn new(maps: Maps, cache: &Cache, config: &Config) -> Self {
        let texels = (cache.line_bytes / texel_bytes(config)).max(1).ilog2();
        let block = [texels.div_ceil(2), texels / 2];
        let mut first_block = 1;
        let maps = maps
            .0
            .into_iter()
            .map(|(faces, sizes, wrap)| {
                let level = |size: [usize; 2]| {
                    let columns = size[0].div_ceil(TILE);
                    let tiles = [columns, columns * size[1].div_ceil(TILE)];
                    let blocks = [0, 1].map(|i| (size[i] >> block[i]) as u64 + 1);
                    let first = first_block;
                    first_block += blocks[0] * blocks[1] * faces as u64;
                    Level {
                        size,
                        tiles,
                        touched: vec![false; tiles[1] * faces],
                        first_block: first,
                    }
                };
                (faces, sizes.into_iter().map(level).collect(), wrap)
            })
            .collect();
        Self {
            maps,
            block,
            sets: vec![0; cache.bytes / cache.line_bytes],
            ways: cache.ways,
            found: TexelUse::default(),
        }
    }

    /// A bilinear footprint of a map.
    pub fn touch(&mut self, map: usize, at: Corner) {
        let Some((_, levels, wrap)) = self.maps.get_mut(map) else {
            return;
        };
        let Some(level) = levels.get_mut(at.level) else {
            return;
        };
        let place = |i: usize, beyond: usize| {
            let x = num::i64(at.texel[i] + beyond) - 1;
            wrap[i].texel(x, level.size[i])
        };
        let (columns, rows) = ([place(0, 0), place(0, 1)], [place(1, 0), place(1, 1)]);
        let mut lines = [0u64; 4];
        let mut count = 0;
        for y in rows {
            for x in columns {
                level.touched[at.face * level.tiles[1] + y / TILE * level.tiles[0] + x / TILE] =
                    true;
                let [bx, by] = [x >> self.block[0], y >> self.block[1]].map(|b| b as u64);
                let blocks = [0, 1].map(|i| (level.size[i] >> self.block[i]) as u64 + 1);
                let line = level.first_block + (at.face as u64 * blocks[1] + by) * blocks[0] + bx;
                if !lines[..count].contains(&line) {
                    lines[count] = line;
                    count += 1;
                    // Neighbouring blocks lie in different sets: low bits of both coordinates, turned by level and face.
                    let set = (bx & 7) | ((by & 7) << 3) | ((bx >> 3 ^ by >> 3) << 6);
                    let turn = (at.level as u64 * 37) ^ (at.face as u64 * 11) ^ (map as u64 * 17);
                    Self::fetch(&mut self.sets, self.ways, &mut self.found, set ^ turn, line);
                }
            }
        }
    }

    /// Asks for a line: the first of a set is the one used last.
    fn fetch(sets: &mut [u64], ways: usize, found: &mut TexelUse, set: u64, line: u64) {
        let count = (sets.len() / ways) as u64;
        let start = num::usize(set % count) * ways;
        let set = &mut sets[start..start + ways];
        found.requests += 1;
        let place = set.iter().position(|l| *l == line);
        found.hits += u64::from(place.is_some());
        set[..=place.unwrap_or(ways - 1)].rotate_right(1);
        set[0] = line;
    }

    /// What was touched.
    #[must_use]
    pub fn finish(mut self) -> TexelUse {
        let levels = self.maps.iter().flat_map(|(_, levels, _)| levels);
        self.found.tiles = levels.flat_map(|l| &l.touched).filter(|t| **t).count() as u64;
        self.found
    }
}

/// Everything that the walk's result depends on: the probes, the addresses' registers, and the size of a texel in memory.
pub(in crate::study) fn key(probes: u64, config: &Config) -> u64 {
    use rtl_model::regs::Reg;
    let mut hasher = StepHasher::default();
    (probes, texel_bytes(config), config.policy.filter).hash(&mut hasher);
    [Reg::AddrU, Reg::AddrV, Reg::AddrS].map(|reg| config.format(reg)).hash(&mut hasher);
    // Probes beyond an edge come back through the reciprocal.
    (config.tables.recip, config.policy.address).hash(&mut hasher);
    hasher.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cube::CubeLevel;
    use crate::mips::build_mips;

    fn corner(level: usize, texel: [usize; 2]) -> Corner {
        Corner { face: 0, level, texel }
    }

    #[test]
    fn a_cache_hits_what_it_has_and_drops_what_was_used_longest_ago() {
        let map = build_mips(CubeLevel { size: 256, texels: vec![[0.0; 3]; 6 * 256 * 256] });
        // Two lines a set, one set: texels of 8 bytes, lines of 4 × 2.
        let cache = Cache { bytes: 128, ways: 2, line_bytes: 64 };
        assert!(cache.is_possible());
        let mut walk = Walk::new(Maps::cube(&map), &cache, &Config::default());
        // Inside one block: one request.
        walk.touch(0, corner(0, [1, 1]));
        assert_eq!(walk.found, TexelUse { tiles: 0, requests: 1, hits: 0 });
        walk.touch(0, corner(0, [2, 1]));
        assert_eq!(walk.found, TexelUse { tiles: 0, requests: 2, hits: 1 });
        // Two other blocks push it out.
        walk.touch(0, corner(0, [9, 1]));
        walk.touch(0, corner(0, [17, 1]));
        walk.touch(0, corner(0, [1, 1]));
        assert_eq!(walk.found, TexelUse { tiles: 0, requests: 5, hits: 1 });
        // Across a tile's corner: four tiles, the first one known.
        walk.touch(0, corner(0, [64, 64]));
        assert_eq!(walk.finish().tiles, 4);
        assert!(!Cache { bytes: 100, ..cache }.is_possible());
    }
}
