//! The lattices around the faces of a cube map, each point of them worked out once.
//!
//! All footprints of a face share the lattice of its plane. Outside the face a point costs a change of face and a
//! bilinear look-up, so it is kept, in tiles that are filled when a footprint first meets them.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::base::num;

/// Points along an edge of a tile.
const TILE: usize = 16;

/// Most tiles of a map, of 6 KiB each: 96 MiB. A map of 256² texels a face has 13,824 on its level 0.
const MOST_TILES: usize = 16_384;

/// The values of TILE² points, row by row.
type Tile = Box<[[f64; 3]]>;

/// The planes of one level from −3 to 3 both ways, face by face.
#[derive(Debug, Default)]
struct Level {
    tiles: OnceLock<Vec<OnceLock<Tile>>>,
}

/// Tiles of all levels of a map.
#[derive(Debug, Default)]
pub(in crate::reference) struct Planes {
    levels: Vec<Level>,
    filled: AtomicUsize,
}

impl Planes {
    /// No tiles yet of so many levels.
    pub(in crate::reference) fn new(levels: usize) -> Self {
        Self { levels: (0..levels).map(|_| Level::default()).collect(), ..Self::default() }
    }

    /// The points from column i on to the end of their tile, in row j of a face of n × n texels; `value` fills a
    /// tile. `None` beyond ±3 and where all tiles are in use.
    pub(super) fn row(
        &self,
        [level, face, n]: [usize; 3],
        [i, j]: [i64; 2],
        value: impl Fn(i64, i64) -> [f64; 3],
    ) -> Option<&[[f64; 3]]> {
        let from_edge = |t: i64| usize::try_from(t + num::i64(n)).ok().filter(|t| *t < 3 * n);
        let [x, y] = [from_edge(i)?, from_edge(j)?];
        let across = (3 * n).div_ceil(TILE);
        let tiles = self.levels[level]
            .tiles
            .get_or_init(|| (0..6 * across * across).map(|_| OnceLock::new()).collect());
        let slot = &tiles[(face * across + y / TILE) * across + x / TILE];
        if slot.get().is_none() && self.filled.fetch_add(1, Ordering::Relaxed) >= MOST_TILES {
            return None;
        }
        let [left, top] = [(i, x), (j, y)].map(|(t, from)| t - num::i64(from % TILE));
        let tile = slot.get_or_init(|| {
            let row = |y| (0..num::i64(TILE)).map(move |x| (left + x, top + y));
            (0..num::i64(TILE)).flat_map(row).map(|(i, j)| value(i, j)).collect()
        });
        let row = y % TILE * TILE;
        Some(&tile[row + x % TILE..row + TILE])
    }
}
