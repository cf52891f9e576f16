//! Cube maps stored as pictures: strips, crosses and OpenEXR's own arrangement.

use super::resample::{mix, real, split};
use crate::cube::{CubeLevel, across_edge};

/// How six faces of a side lie in a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Arrangement {
    /// OpenEXR: stacked vertically, faces mirrored (±X, ±Z left-right, ±Y top-bottom).
    OpenExr,
    /// Six faces below each other, as a GPU stores them.
    Column,
    /// Six faces beside each other.
    Row,
    /// 4:3: `. +y . .` over `-x +z +x -z` over `. -y . .`.
    WideCross,
    /// 3:4: as the wide cross, with −z below −y, turned by half a turn.
    TallCross,
}

impl Arrangement {
    /// The face's cell (column, row) and whether its columns and rows run backwards.
    fn cell(self, face: usize) -> ([usize; 2], [bool; 2]) {
        const CROSS: [[usize; 2]; 6] = [[2, 1], [0, 1], [1, 0], [1, 2], [1, 1], [3, 1]];
        match self {
            Self::OpenExr => {
                let vertical = face == 2 || face == 3;
                ([0, face], [!vertical, vertical])
            }
            Self::Column => ([0, face], [false; 2]),
            Self::Row => ([face, 0], [false; 2]),
            Self::WideCross => (CROSS[face], [false; 2]),
            Self::TallCross if face == 5 => ([1, 3], [true; 2]),
            Self::TallCross => (CROSS[face], [false; 2]),
        }
    }
}

/// Cuts the faces out of a picture `width` pixels wide, each turned the way `cube.rs` has it.
pub(super) fn cut(
    texels: &[[f32; 3]],
    width: usize,
    size: usize,
    arrangement: Arrangement,
) -> CubeLevel {
    let mut out = Vec::with_capacity(6 * size * size);
    for face in 0..6 {
        let ([column, row], [mirror_x, mirror_y]) = arrangement.cell(face);
        for y in 0..size {
            let y = row * size + if mirror_y { size - 1 - y } else { y };
            for x in 0..size {
                let x = column * size + if mirror_x { size - 1 - x } else { x };
                out.push(texels[y * width + x]);
            }
        }
    }
    CubeLevel { size, texels: out }
}

/// Bilinear look-up with samples ON the faces' edges (OpenEXR: scale size − 1).
pub(super) fn lookup_on_edges(cube: &CubeLevel, face: usize, u: f64, v: f64) -> [f64; 3] {
    let last = real(cube.size - 1);
    let ((x0, fx), (y0, fy)) = (split((u + 1.0) / 2.0 * last), split((v + 1.0) / 2.0 * last));
    let inside = |t: i64| usize::try_from(t).unwrap_or(0).min(cube.size - 1);
    let tap = |x, y| cube.texel(face, inside(x), inside(y)).map(f64::from);
    let line = |y| mix(tap(x0, y), tap(x0 + 1, y), fx);
    mix(line(y0), line(y0 + 1), fy)
}

/// Bilinear look-up with half-texel centres: taps beyond an edge come from the neighbour face, a
/// corner's missing tap is the mean of the other three.
pub(super) fn lookup_at_halves(cube: &CubeLevel, face: usize, u: f64, v: f64) -> [f64; 3] {
    let n = real(cube.size);
    let ((x0, fx), (y0, fy)) = (
        split((u + 1.0) / 2.0 * n - 0.5),
        split((v + 1.0) / 2.0 * n - 0.5),
    );
    let taps = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| {
        across_edge(cube.size, face, x0 + i, y0 + j)
            .map(|(face, x, y)| cube.texel(face, x, y).map(f64::from))
    });
    let mut mean = [0.0; 3];
    for tap in taps.iter().flatten() {
        for (m, t) in mean.iter_mut().zip(tap) {
            *m += t;
        }
    }
    let mean = mean.map(|m| m / 3.0);
    let [a, b, c, d] = taps.map(|tap| tap.unwrap_or(mean));
    mix(mix(a, b, fx), mix(c, d, fx), fy)
}
