//! 2-D textures with their mip chain.

use crate::base::num;

/// One level of a 2-D texture: linear RGB, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanarLevel {
    /// Columns and rows.
    pub size: [usize; 2],
    /// Index y·columns + x.
    pub texels: Vec<[f32; 3]>,
}

impl PlanarLevel {
    /// The texel in column `x` of row `y`.
    #[must_use]
    pub fn texel(&self, x: usize, y: usize) -> [f32; 3] {
        self.texels[y * self.size[0] + x]
    }
}

/// A 2-D texture with its mip chain down to 1×1: level L has max(1, ⌊size/2^L⌋) columns and rows.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanarMap {
    /// Level 0 first.
    pub levels: Vec<PlanarLevel>,
}

impl PlanarMap {
    /// Columns and rows of level 0.
    #[must_use]
    pub fn size(&self) -> [usize; 2] {
        self.levels[0].size
    }

    /// The same as whole numbers of 32 bits, which every texture's sides are.
    #[must_use]
    pub fn size_u32(&self) -> [u32; 2] {
        self.size().map(num::u32)
    }
}
