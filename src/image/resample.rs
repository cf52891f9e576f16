//! Supersampling of any source into the faces of a cube.

use crate::base::num;
use crate::cube::CubeLevel;
use rayon::prelude::*;

/// Samples along each side of a texel: 4, or more where the source is so fine that samples would
/// lie further apart than half a source texel.
///
/// `per_texel` is how many source texels one cube texel spans; with bilinear look-ups at that
/// spacing every source texel contributes, so strong reductions do not alias.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a small positive number: source widths are below 2^31"
)]
pub(super) fn samples_per_side(per_texel: f64) -> usize {
    ((2.0 * per_texel).ceil() as usize).max(4)
}

/// A small whole number as f64, exactly (sizes stay below 2^31).
pub(super) fn real(n: usize) -> f64 {
    f64::from(num::u32(n))
}

/// u or v of the centres of `side` steps in each of `size` texels, −1..1.
pub(super) fn centres(size: usize, side: usize) -> Vec<f64> {
    let steps = size * side;
    let centre = |k| (2.0 * real(k) + 1.0) / real(steps) - 1.0;
    (0..steps).map(centre).collect()
}

/// Fills a cube of `size`: each texel is the mean of `side`² look-ups at the centres of its
/// sub-squares. `lookup` takes face, u, v with u and v in −1..1.
pub(super) fn resample<F>(size: usize, side: usize, lookup: F) -> CubeLevel
where
    F: Fn(usize, f64, f64) -> [f64; 3] + Sync,
{
    let centres = centres(size, side);
    let count = real(side * side);
    let texels = (0..6 * size)
        .into_par_iter()
        .flat_map_iter(|row| {
            let (face, y) = (row / size, row % size);
            let (lookup, centres) = (&lookup, &centres);
            (0..size).map(move |x| {
                let mut total = [0.0; 3];
                for v in &centres[y * side..(y + 1) * side] {
                    for u in &centres[x * side..(x + 1) * side] {
                        let colour = lookup(face, *u, *v);
                        for (t, c) in total.iter_mut().zip(colour) {
                            *t += c;
                        }
                    }
                }
                total.map(|t| num::f32(t / count))
            })
        })
        .collect();
    CubeLevel { size, texels }
}

/// a + (b − a)·f per colour, which keeps equal colours equal.
pub(super) fn mix(a: [f64; 3], b: [f64; 3], f: f64) -> [f64; 3] {
    let mut out = a;
    for (o, b) in out.iter_mut().zip(b) {
        *o += (b - *o) * f;
    }
    out
}

/// A coordinate in texels, split into the texel below and the fraction above it.
#[expect(
    clippy::cast_possible_truncation,
    reason = "coordinates are within one texel of an image whose sides are below 2^31"
)]
pub(super) fn split(position: f64) -> (i64, f64) {
    let below = position.floor();
    (below as i64, position - below)
}
