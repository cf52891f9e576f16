//! Pictures in linear RGB with a mask of the pixels that hold fragments.

use crate::base::num;

/// A picture in linear RGB, row by row from the top left.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Linear RGB of each pixel.
    pub rgb: Vec<[f64; 3]>,
    /// Whether the pixel holds a fragment; metrics count only those.
    pub covered: Vec<bool>,
}

impl Picture {
    /// A black picture without fragments.
    #[must_use]
    pub fn new(width: usize, height: usize) -> Self {
        Self {
            width,
            height,
            rgb: vec![[0.0; 3]; width * height],
            covered: vec![false; width * height],
        }
    }
    /// The place of a pixel, column and row, in `rgb` and `covered`.
    #[must_use]
    pub fn index(&self, [column, row]: [u32; 2]) -> usize {
        num::usize(row) * self.width + num::usize(column)
    }
}
