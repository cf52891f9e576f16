//! The expected registers of `address` and `filter`, probe by probe, from the device's own earlier ones.

use super::{Bounded, EPSILON, Expected, exactly, expect, number, own};
use crate::base::num;
use crate::cube::{direction, face_uv, major_face};
use crate::policy::Wrap;
use crate::reference::Texture;
use crate::reference::planar::{PlanarTexture, wrapped};
use crate::reference::real::{Narrow as _, Real as _};

/// centre + (2·index + 1 − probes)·step; `operands` start with the centre.
pub(super) fn place(operands: &[u32], index: u32, probes: u32) -> [Bounded; 2] {
    // Whole numbers below 2²⁴: exact.
    let offset = Bounded::exact(2.0 * f64::from(index) + 1.0 - f64::from(probes));
    [0, 1].map(|c| own(operands[c]) + offset * own(operands[2 + c]))
}

/// The expected results of `address`: place, then face, place on it and texel coordinates from the device's own.
pub(super) fn address_expected(operands: &[u32], results: &[u32]) -> Vec<Expected> {
    let face = operands[0] as usize;
    let [u, v] = place(&operands[1..], operands[5], operands[6]);
    let mut out = vec![expect(u), expect(v)];
    let (face, on_face) = readdressed(face, [number(results[0]), number(results[1])]);
    out.push(exactly(face));
    out.extend(on_face.map(expect));
    for size in &operands[7..9] {
        for word in &results[3..5] {
            out.push(expect(texel_coordinate(own(*word), *size as usize)));
        }
    }
    out
}

/// Face and coordinates of an f32 place on the plane of a face.
pub(super) fn readdressed(face: usize, [u, v]: [f64; 2]) -> (u32, [Bounded; 2]) {
    let small = |face: usize| num::u32(face);
    if u.abs() <= 1.0 && v.abs() <= 1.0 {
        return (small(face), [u, v].map(Bounded::exact));
    }
    let d = direction(face, u, v);
    let (other, u, v) = face_uv(d);
    let ma = Bounded::exact(d[major_face(d) / 2].abs());
    // The quotients' numerators are components of d: exact.
    let of = |value: f64| {
        let quotient = Bounded::exact(value * ma.value) / ma;
        Bounded { value, error: quotient.error }
    };
    (small(other), [of(u), of(v)])
}

/// (u + 1)/2·N − ½ as the kernels compute it.
pub(super) fn texel_coordinate(u: Bounded, size: usize) -> Bounded {
    let [one, two, half] = [1.0, 2.0, 0.5].map(Bounded::exact);
    (u + one) / two * Bounded::exact(size as f64) - half
}

/// The cell of a coordinate: the lower tap, and the weight of the upper one.
pub(super) fn cell(u: Bounded, size: usize) -> (i64, Bounded) {
    let s = texel_coordinate(u, size);
    let bound = size as f64 - 0.5;
    let s = Bounded { value: s.value.clamp(-0.5, bound), error: s.error };
    let low = s.floor();
    #[expect(clippy::cast_possible_truncation, reason = "a whole number from -1 to the size")]
    let index = low.value as i64;
    (index, s - low)
}

pub(super) fn mix(a: Bounded, b: Bounded, f: Bounded) -> Bounded {
    a + (b - a) * f
}

/// The bilinear value between taps.
pub(super) fn bilinear(
    at: [Bounded; 2],
    size: [usize; 2],
    tap: impl Fn(i64, i64) -> [Bounded; 3],
) -> [Bounded; 3] {
    let ((x, fx), (y, fy)) = (cell(at[0], size[0]), cell(at[1], size[1]));
    let [lt, rt] = [tap(x, y), tap(x + 1, y)];
    let [lb, rb] = [tap(x, y + 1), tap(x + 1, y + 1)];
    [0, 1, 2].map(|c| mix(mix(lt[c], rt[c], fx), mix(lb[c], rb[c], fx), fy))
}

/// The expected words of a probe on a cube, at the device's own address.
pub(super) fn cube_probe(
    texture: &Texture<'_>,
    words: &[u32],
    levels: [usize; 2],
) -> Vec<Expected> {
    let face = (words[0] as usize).min(5);
    let at = [own(words[1]), own(words[2])];
    // Face and place are registers of `address`, checked there.
    let mut out = vec![None; 3];
    for level in levels {
        let size = texture.level_size(level);
        let n = num::i64(size);
        let value = bilinear(at, [size; 2], |x, y| {
            let corner = (x < 0 || x >= n) && (y < 0 || y >= n);
            let index = |t: i64| num::usize((t + 1).clamp(0, n + 1));
            let [x, y] = [index(x), index(y)];
            texture.tap(level, face, x, y).map(|value| {
                if corner {
                    // Two sums and a quotient of texels that are not negative.
                    let error = 4.5 * EPSILON * value.abs();
                    Bounded { value, error }
                } else {
                    Bounded::exact(value)
                }
            })
        });
        out.extend(value.map(expect));
    }
    out
}

/// The expected words of a probe on a 2-D texture; the probe is one of so many at a case's operands.
pub(super) fn planar_probe(
    texture: &PlanarTexture<'_>,
    wrap: [Wrap; 2],
    (operands, index, probes): (&[u32], u32, u32),
    words: &[u32],
    levels: [usize; 2],
) -> Vec<Expected> {
    let plane = place(operands, index, probes);
    let mut out = Vec::new();
    for (u, wrap) in plane.into_iter().zip(wrap) {
        let value = wrapped(u.value, wrap);
        // The remainder's product is exact; the difference is rounded once.
        let moved = (value - u.value).abs();
        let error = u.error + EPSILON * (value.abs() + u.error) * f64::from(u8::from(moved > 0.0));
        // Where the texture begins anew a device may be on the other side.
        let inside = Bounded { value: value.abs(), error };
        let _ = inside <= Bounded::exact(1.0);
        out.push(Some((value, error)));
    }
    let at = [own(words[0]), own(words[1])];
    for level in levels {
        let size = texture.level_size(level);
        let tap = |x, y| texture.texel(level, [x, y]).map(Bounded::exact);
        out.extend(bilinear(at, size, tap).map(expect));
    }
    out
}

/// The colour from the device's own bilinear values.
pub(super) fn color<'w>(
    lod: f64,
    weights: &[f64],
    probes: impl Iterator<Item = &'w [u32]>,
) -> Vec<Expected> {
    let fraction = Bounded::exact(lod - lod.floor());
    let zero = Bounded::exact(0.0);
    let mut sums = [[zero; 3]; 2];
    let mut total = zero;
    for (weight, words) in weights.iter().zip(probes) {
        let weight = Bounded::from_f64(*weight);
        total = total + weight;
        for (level, sum) in sums.iter_mut().enumerate() {
            for (channel, sum) in sum.iter_mut().enumerate() {
                *sum = *sum + weight * own(words[3 * level + channel]);
            }
        }
    }
    (0..3)
        .map(|channel| {
            let [low, high] = sums.map(|sum| sum[channel] / total);
            expect(if fraction.value > 0.0 { mix(low, high, fraction) } else { low })
        })
        .collect()
}
