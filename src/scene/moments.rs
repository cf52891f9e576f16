//! Means, covariances and trends of a bump map's offsets over the texels of one level.
//!
//! Level L has max(1, ⌊size/2^L⌋) texels along each side; a texel covers an equal share of the map, for
//! a power of two exactly 2^L × 2^L texels, otherwise with parts of texels at its border. Means and
//! covariances come from ALL covered texels of level 0, about the mean (two passes: nothing cancels).

use rayon::prelude::*;

use super::bump::BumpMap;
use crate::policy::Curvature;

/// The content of a texel of the pyramid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    /// Mean of b1, b2.
    pub mean: [f64; 2],
    /// Covariance a, b, c of b1, b2; under [`Curvature::Surface`] about the linear trend, not the mean.
    pub covariance: [f64; 3],
    /// Least-squares slope of b1, b2 by column (first) and row, per texel of level 0.
    pub trend: [[f64; 2]; 2],
}

/// One level of the pyramid.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// Texels along a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Row by row from the top.
    pub texels: Vec<Moments>,
    /// Variance of the position inside each column and each row, in square texels of level 0.
    pub(super) spread: [Vec<f64>; 2],
}

/// Builds one level straight from level 0.
pub(super) fn build_level(
    map: &BumpMap,
    width: usize,
    height: usize,
    curvature: Curvature,
) -> Level {
    let columns: Vec<Vec<Piece>> = (0..width).map(|i| pieces(i, width, map.width())).collect();
    let texels = (0..height)
        .into_par_iter()
        .flat_map_iter(|j| {
            let rows = pieces(j, height, map.height());
            columns
                .iter()
                .map(move |columns| moments(map, columns, &rows, curvature))
                .collect::<Vec<_>>()
        })
        .collect();
    let rows = (0..height).map(|j| spread(&pieces(j, height, map.height())));
    Level {
        width,
        height,
        texels,
        spread: [columns.iter().map(|c| spread(c)).collect(), rows.collect()],
    }
}

/// A texel of level 0, or a part of one, inside a texel of a level, along one side.
#[derive(Clone, Copy, Debug)]
struct Piece {
    index: usize,
    /// Share of the level's texel; the shares sum to 1.
    share: f64,
    /// The piece's centre from the centre of the level's texel, in texels of level 0.
    offset: f64,
}

/// The pieces of texel `i` of `count` along a side of `size` texels, in integers of 1/count texel.
fn pieces(i: usize, count: usize, size: usize) -> Vec<Piece> {
    let (start, end) = (i * size, (i + 1) * size);
    (start / count..end.div_ceil(count))
        .map(|index| {
            let (from, to) = ((index * count).max(start), ((index + 1) * count).min(end));
            let twice = |a: usize, b: usize| (a + b) as f64;
            Piece {
                index,
                share: (to - from) as f64 / size as f64,
                offset: (twice(from, to) - twice(start, end)) / (2.0 * count as f64),
            }
        })
        .collect()
}

/// The sum of a value over a texel, weighted by area. It runs along rows first, so that rounding grows
/// with the texel's sides, not with its area.
fn total<const K: usize>(
    columns: &[Piece],
    rows: &[Piece],
    value: impl Fn(&Piece, &Piece) -> [f64; K],
) -> [f64; K] {
    let mut sums = [0.0; K];
    for row in rows {
        let mut in_row = [0.0; K];
        for column in columns {
            for (sum, value) in in_row.iter_mut().zip(value(column, row)) {
                *sum += column.share * value;
            }
        }
        for (sum, value) in sums.iter_mut().zip(in_row) {
            *sum += row.share * value;
        }
    }
    sums
}

/// The variance of the position along one side of a texel, in square texels of level 0.
fn spread(pieces: &[Piece]) -> f64 {
    pieces.iter().map(|p| p.share * p.offset * p.offset).sum()
}

/// Mean, covariance and trend of a texel.
fn moments(map: &BumpMap, columns: &[Piece], rows: &[Piece], curvature: Curvature) -> Moments {
    let mean = total(columns, rows, |c, r| map.texel(c.index, r.index));
    let about_mean = |c: &Piece, r: &Piece| {
        let b = map.texel(c.index, r.index);
        [b[0] - mean[0], b[1] - mean[1]]
    };
    let trend = match curvature {
        Curvature::Pyramid => [[0.0; 2]; 2],
        Curvature::Surface => {
            // The shares are a product of one for columns and one for rows, so the two slopes separate.
            let [x1, x2, y1, y2] = total(columns, rows, |c, r| {
                let [b1, b2] = about_mean(c, r);
                [c.offset * b1, c.offset * b2, r.offset * b1, r.offset * b2]
            });
            let slope = |products: [f64; 2], spread: f64| {
                products.map(|p| if spread > 0.0 { p / spread } else { 0.0 })
            };
            [slope([x1, x2], spread(columns)), slope([y1, y2], spread(rows))]
        }
    };
    let covariance = total(columns, rows, |c, r| {
        let b = about_mean(c, r);
        let [b1, b2] = [0, 1].map(|i| b[i] - (trend[0][i] * c.offset + trend[1][i] * r.offset));
        [b1 * b1, b1 * b2, b2 * b2]
    });
    Moments { mean, covariance, trend }
}
