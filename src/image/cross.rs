//! What tells a cube cross from a photograph, and one cross from another: empty cells and seams.

use crate::base::num;
use crate::cube::{CubeLevel, across_edge};

/// Share of the texels of the empty cells that may differ from the rest, as a lossy file has them
/// along its faces.
const STRAY: f64 = 0.05;

/// Whether the cells of a cross that hold no face hold nothing: one colour, but for a few texels.
///
/// A step of an 8-bit picture or a 64th of the picture's mean is no difference.
pub(super) fn empty_cells(texels: &[[f32; 3]], width: usize, side: usize, tall: bool) -> bool {
    let columns = if tall { 3 } else { 4 };
    let is_face = |column: usize, row: usize| {
        column == 1 && (tall || row < 3) || row == 1 && column < columns
    };
    let mean = texels.iter().flatten().map(|c| f64::from(*c)).sum::<f64>()
        / (3 * texels.len().max(1)) as f64;
    let tolerance = (mean / 64.0).max(1.0 / 255.0);
    let empty = || {
        texels.iter().enumerate().filter_map(move |(i, texel)| {
            (!is_face(i % width / side, i / width / side)).then_some(texel)
        })
    };
    let mut middle = [0.0; 3];
    for (c, value) in middle.iter_mut().enumerate() {
        let mut all: Vec<f32> = empty().map(|t| t[c]).collect();
        let at = all.len() / 2;
        all.select_nth_unstable_by(at, f32::total_cmp);
        *value = f64::from(all[at]);
    }
    let (mut strays, mut count) = (0u32, 0u32);
    for texel in empty() {
        count += 1;
        let stray = texel.iter().zip(middle).any(|(c, m)| (f64::from(*c) - m).abs() > tolerance);
        strays += u32::from(stray);
    }
    f64::from(strays) <= STRAY * f64::from(count)
}

/// Mean difference across the twelve edges of a cube, per channel.
pub(super) fn seams(cube: &CubeLevel) -> f64 {
    let (n, last) = (cube.size, num::i64(cube.size) - 1);
    let (mut sum, mut count) = (0.0, 0u32);
    for face in 0..6 {
        for t in 0..=last {
            for ([x, y], [ox, oy]) in [
                ([0, t], [-1, t]),
                ([last, t], [last + 1, t]),
                ([t, 0], [t, -1]),
                ([t, last], [t, last + 1]),
            ] {
                let Some((other, u, v)) = across_edge(n, face, ox, oy) else { continue };
                let own = cube.texel(face, num::usize(x), num::usize(y));
                let next = cube.texel(other, u, v);
                sum += own.iter().zip(next).map(|(a, b)| f64::from((a - b).abs())).sum::<f64>();
                count += 3;
            }
        }
    }
    sum / f64::from(count.max(1))
}
