//! Cube maps stored as pictures: strips, crosses and OpenEXR's own arrangement.

use super::resample::{mix, real, split};
use crate::base::num;
use crate::cube::{CubeLevel, across_edge};

/// How six faces of a side lie in a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Arrangement {
    /// OpenEXR: stacked vertically, faces mirrored (±X, ±Z left-right, ±Y top-bottom).
    OpenExr,
    /// Six faces below each other, as a GPU stores them.
    Column,
    /// Six faces side by side.
    Row,
    /// 4:3: `. +y . .` over `-x +z +x -z` over `. -y . .`.
    WideCross,
    /// 3:4: as the wide cross, with −z below −y, turned by half a turn.
    TallCross,
    /// The same with −z upright.
    UprightCross,
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
            Self::UprightCross if face == 5 => ([1, 3], [false; 2]),
            Self::TallCross | Self::UprightCross => (CROSS[face], [false; 2]),
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
    let inside = |t: i64| num::usize(t).min(cube.size - 1);
    let tap = |x, y| cube.texel(face, inside(x), inside(y)).map(f64::from);
    let line = |y| mix(tap(x0, y), tap(x0 + 1, y), fx);
    mix(line(y0), line(y0 + 1), fy)
}

/// Bilinear look-up with half-texel centres: taps beyond an edge come from the neighbour face, a
/// corner's missing tap is the mean of the other three.
pub(super) fn lookup_at_halves(cube: &CubeLevel, face: usize, u: f64, v: f64) -> [f64; 3] {
    let n = real(cube.size);
    let ((x0, fx), (y0, fy)) = (split((u + 1.0) / 2.0 * n - 0.5), split((v + 1.0) / 2.0 * n - 0.5));
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cube::direction;
    use crate::image::resample::centres;

    /// The direction of a pixel in OpenEXR's cube, as that format defines it: per face the signs of
    /// (column, row) along two axes, samples at the ends.
    fn openexr_direction(face: usize, column: usize, row: usize, size: usize) -> [f64; 3] {
        let last = real(size - 1);
        let (a, b) = (2.0 * real(column) / last - 1.0, 2.0 * real(row) / last - 1.0);
        match face {
            0 => [1.0, -b, a],
            1 => [-1.0, -b, -a],
            2 => [a, 1.0, -b],
            3 => [a, -1.0, b],
            4 => [-a, -b, 1.0],
            _ => [a, -b, -1.0],
        }
    }

    #[test]
    fn openexr_cubes_are_unmirrored_and_sampled_on_their_edges() {
        // The stored picture holds each pixel's own direction (major component ±1), which is linear
        // in the face's coordinates: bilinear look-ups are exact but for f32 storage, 2⁻²⁴.
        let size = 9;
        let mut texels = Vec::new();
        for row in 0..6 * size {
            for column in 0..size {
                texels.push(openexr_direction(row / size, column, row % size, size).map(num::f32));
            }
        }
        let cube = cut(&texels, size, size, Arrangement::OpenExr);
        for face in 0..6 {
            for v in centres(7, 3) {
                for u in centres(7, 3) {
                    let got = lookup_on_edges(&cube, face, u, v);
                    for (g, d) in got.into_iter().zip(direction(face, u, v)) {
                        assert!((g - d).abs() <= 6.0e-8, "{face} {u} {v}: {got:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn strips_and_crosses_give_the_same_faces() {
        let size = 3;
        let value = |face: usize, x: usize, y: usize| [real(face), real(x), real(y)].map(num::f32);
        let picture =
            |columns: usize, rows: usize, cells: [[usize; 2]; 6], turned: Option<usize>| {
                let mut texels = vec![[-1.0f32; 3]; columns * rows * size * size];
                for (face, [column, row]) in cells.into_iter().enumerate() {
                    for (y, x) in (0..9).map(|i| (i / 3, i % 3)) {
                        let (sx, sy) = if turned == Some(face) { (2 - x, 2 - y) } else { (x, y) };
                        texels[(row * 3 + sy) * columns * 3 + column * 3 + sx] = value(face, x, y);
                    }
                }
                texels
            };
        let cross = [[2, 1], [0, 1], [1, 0], [1, 2], [1, 1], [3, 1]];
        let mut tall = cross;
        tall[5] = [1, 3];
        let line = [0, 1, 2, 3, 4, 5];
        for (arrangement, columns, rows, cells, turned) in [
            (Arrangement::Column, 1, 6, line.map(|f| [0, f]), None),
            (Arrangement::Row, 6, 1, line.map(|f| [f, 0]), None),
            (Arrangement::WideCross, 4, 3, cross, None),
            (Arrangement::TallCross, 3, 4, tall, Some(5)),
        ] {
            let texels = picture(columns, rows, cells, turned);
            let cube = cut(&texels, columns * size, size, arrangement);
            for face in 0..6 {
                for (y, x) in (0..9).map(|i| (i / 3, i % 3)) {
                    let (got, expected) = (cube.texel(face, x, y), value(face, x, y));
                    assert_eq!(
                        got.map(f32::to_bits),
                        expected.map(f32::to_bits),
                        "{arrangement:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn crosses_are_continuous_where_faces_meet_in_the_picture() {
        // Across every seam of the picture the neighbours in the picture are neighbours on the cube.
        let (n, columns) = (4usize, 4usize);
        let cells = [[2, 1], [0, 1], [1, 0], [1, 2], [1, 1], [3, 1]];
        let at = |face: usize, x: usize, y: usize| {
            let [column, row]: [usize; 2] = cells[face];
            (column * n + x, row * n + y)
        };
        let mut seams = 0;
        for face in 0..6 {
            for t in 0..n {
                for (x, y, ox, oy) in [(n - 1, t, 1i64, 0i64), (t, n - 1, 0, 1)] {
                    let (px, py) = at(face, x, y);
                    let Some(next) = (0..6).find(|f| {
                        let (fx, fy) = at(*f, 0, 0);
                        let (qx, qy) = (px + usize::from(ox == 1), py + usize::from(oy == 1));
                        (fx..fx + n).contains(&qx) && (fy..fy + n).contains(&qy)
                    }) else {
                        continue;
                    };
                    assert!(px < columns * n && next != face);
                    let as_i64 = |t: usize| i64::try_from(t).unwrap();
                    let found = across_edge(n, face, as_i64(x) + ox, as_i64(y) + oy).unwrap();
                    let expected = if ox == 1 { (next, 0, t) } else { (next, t, 0) };
                    assert_eq!(found, expected);
                    seams += 1;
                }
            }
        }
        // Three seams in the belt, one above and one below +z, n texels each.
        assert_eq!(seams, 5 * n);
    }

    #[test]
    fn a_gpu_cube_lookup_is_constant_on_a_constant_and_the_mean_of_three_at_a_corner() {
        let cube = CubeLevel { size: 1, texels: (0..6u8).map(|f| [f32::from(f); 3]).collect() };
        // At +x, u = v = 1 the faces +x, −y and −z meet: (0 + 3 + 5)/3.
        let got = lookup_at_halves(&cube, 0, 1.0, 1.0)[0];
        assert!((got - 8.0 / 3.0).abs() < 1e-12, "{got}");
        let even = CubeLevel { size: 2, texels: vec![[0.3; 3]; 24] };
        for v in centres(2, 4) {
            let got = lookup_at_halves(&even, 2, -1.0, v);
            assert!(got.iter().all(|c| (c - f64::from(0.3f32)).abs() < 1e-15));
        }
    }
}
