//! The mip chain of a cube map or a 2-D texture: box filter over exact footprints.

use crate::base::num;
use crate::cube::{CubeLevel, CubeMap};
use crate::planar::{PlanarLevel, PlanarMap};
use rayon::prelude::*;

/// Builds the chain down to 1×1; level L has max(1, ⌊size/2^L⌋) texels along an edge.
///
/// Each level is the area-weighted mean of the one before over the texel's footprint: 2×2 for even
/// sizes, up to 3×3 with fractional ends for odd ones, so that no texel is dropped. Sums in f64 in
/// row order, one rounding to f32 per level; a constant stays exactly constant.
#[must_use]
pub fn build_mips(level0: CubeLevel) -> CubeMap {
    let mut levels = vec![level0];
    while let Some(last) = levels.last()
        && last.size > 1
    {
        let next = halve(last);
        levels.push(next);
    }
    CubeMap { levels }
}

/// The source texels under each destination texel along one axis: first index and whole weights,
/// which sum to the same number for every destination texel.
fn footprints(from: usize, to: usize) -> Vec<(usize, Vec<u32>)> {
    // In units of 1/(from·to) of the edge a source texel is `to` wide and a destination `from`.
    let divisor = gcd(from, to);
    let (src, dst) = (to / divisor, from / divisor);
    (0..to)
        .map(|i| {
            let (start, end) = (i * dst, (i + 1) * dst);
            let first = start / src;
            let weights = (first..)
                .take_while(|j| j * src < end)
                .map(|j| {
                    let overlap = end.min((j + 1) * src) - start.max(j * src);
                    num::u32(overlap)
                })
                .collect();
            (first, weights)
        })
        .collect()
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// The chain of a 2-D texture down to 1×1, made in the same way; level L has max(1, ⌊size/2^L⌋) columns and rows.
#[must_use]
pub fn build_planar_mips(level0: PlanarLevel) -> PlanarMap {
    let mut levels = vec![level0];
    while let Some(last) = levels.last()
        && last.size != [1, 1]
    {
        let (size, texels) = shrink(last.size, 1, |_, x, y| last.texel(x, y));
        levels.push(PlanarLevel { size, texels });
    }
    PlanarMap { levels }
}

fn halve(source: &CubeLevel) -> CubeLevel {
    let (size, texels) = shrink([source.size; 2], 6, |face, x, y| source.texel(face, x, y));
    CubeLevel { size: size[0], texels }
}

/// The next level of faces of `from` columns and rows.
fn shrink(
    from: [usize; 2],
    faces: usize,
    texel: impl Fn(usize, usize, usize) -> [f32; 3] + Sync,
) -> ([usize; 2], Vec<[f32; 3]>) {
    let [columns, rows] = from.map(|n| (n / 2).max(1));
    let spans = [footprints(from[0], columns), footprints(from[1], rows)];
    let sums = [0, 1].map(|i: usize| spans[i][0].1.iter().copied().map(f64::from).sum::<f64>());
    let area = sums[0] * sums[1];
    let texel = &texel;
    let texels = (0..faces * rows)
        .into_par_iter()
        .flat_map_iter(|row| {
            let (face, y) = (row / rows, row % rows);
            let spans = &spans;
            (0..columns).map(move |x| {
                let mut total = [0.0f64; 3];
                let ((y0, wy), (x0, wx)) = (&spans[1][y], &spans[0][x]);
                for (j, &wy) in wy.iter().enumerate() {
                    for (i, &wx) in wx.iter().enumerate() {
                        let weight = f64::from(wx) * f64::from(wy);
                        for (t, c) in total.iter_mut().zip(texel(face, x0 + i, y0 + j)) {
                            *t += weight * f64::from(c);
                        }
                    }
                }
                total.map(|t| num::f32(t / area))
            })
        })
        .collect();
    ([columns, rows], texels)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn level(size: usize, mut texel: impl FnMut(usize) -> [f32; 3]) -> CubeLevel {
        CubeLevel { size, texels: (0..6 * size * size).map(&mut texel).collect() }
    }

    #[test]
    fn sizes_halve_rounding_down_to_one() {
        for (size, sizes) in [
            (1, vec![1]),
            (2, vec![2, 1]),
            (5, vec![5, 2, 1]),
            (12, vec![12, 6, 3, 1]),
            (16, vec![16, 8, 4, 2, 1]),
        ] {
            let map = build_mips(level(size, |_| [0.5; 3]));
            assert_eq!(map.levels.iter().map(|l| l.size).collect::<Vec<_>>(), sizes);
        }
    }

    #[test]
    fn a_constant_stays_exactly_constant_at_every_size() {
        let colour = [0.1, 65504.0, 1.0e-7];
        for size in 1..=33 {
            let map = build_mips(level(size, |_| colour));
            for l in &map.levels {
                assert!(l.texels.iter().all(|t| t.map(f32::to_bits) == colour.map(f32::to_bits)));
            }
        }
    }

    #[test]
    fn even_sizes_take_the_mean_of_two_by_two() {
        let map = build_mips(level(4, |i| {
            let v = u16::try_from(i % 16).unwrap();
            [f32::from(v), f32::from(v * v), 1.0]
        }));
        // Texels 0, 1, 4, 5 of a face: mean 2.5; squares 0, 1, 16, 25: mean 10.5.
        assert_eq!(
            map.levels[1].texel(3, 0, 0).map(f32::to_bits),
            [2.5f32, 10.5, 1.0].map(f32::to_bits)
        );
    }

    #[test]
    fn odd_sizes_weigh_texels_by_the_area_they_share() {
        // 5 → 2: each half covers 2.5 texels, weights 2 2 1 and 1 2 2 (of 5).
        assert_eq!(footprints(5, 2), [(0, vec![2, 2, 1]), (2, vec![1, 2, 2])]);
        assert_eq!(footprints(3, 1), [(0, vec![1, 1, 1])]);
        assert_eq!(footprints(8, 4)[3], (6, vec![1, 1]));
        for from in 2..200 {
            let to = from / 2;
            let spans = footprints(from, to);
            let mut seen = vec![0u32; from];
            for (first, weights) in &spans {
                for (k, w) in weights.iter().enumerate() {
                    seen[first + k] += w;
                }
            }
            assert!(seen.iter().all(|w| *w == seen[0] && *w > 0), "{from}");
        }
    }

    #[test]
    fn the_mean_over_a_face_is_kept_through_odd_levels() {
        let source = level(21, |i| {
            let v = u16::try_from(i * 7919 % 1000).unwrap();
            [f32::from(v), 0.0, 0.0]
        });
        let mean = |l: &CubeLevel, face: usize| {
            let n = l.size * l.size;
            let sum: f64 = l.texels[face * n..(face + 1) * n].iter().map(|t| f64::from(t[0])).sum();
            sum / f64::from(u32::try_from(n).unwrap())
        };
        let map = build_mips(source);
        for face in 0..6 {
            let first = mean(&map.levels[0], face);
            for l in &map.levels {
                // One rounding to f32 per level: at most 4 roundings of relative 2⁻²⁴ each.
                assert!((mean(l, face) - first).abs() <= first * 4.0 * 6.0e-8);
            }
        }
    }
}
