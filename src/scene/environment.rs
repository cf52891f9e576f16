//! The procedural environment: smooth parts, hard edges, fine lines and a bright sun.

use rayon::prelude::*;

use crate::base::num;
use crate::base::random::stirred;
use crate::cube::{CubeLevel, direction};

/// Samples along each side of a texel.
const SAMPLES: usize = 4;

/// Unit vector to the sun, above and behind the straight camera: (4, 5, 6) normalised.
const SUN: [f64; 3] = [4.0, 5.0, 6.0];

/// Level 0 of the built-in environment: linear RGB, every texel the mean of 4 × 4 points.
///
/// Up is +y. Towards +y a sky gradient with clouds of light around a sun of 300; around the horizon
/// towers with lit windows; below it a ground of checkers of three sizes with thin lines, fading
/// with distance; at +z a sign with letters to be read in a mirror, at −z one to be read directly.
#[must_use]
pub fn procedural(face_size: usize) -> CubeLevel {
    let rows: Vec<Vec<[f32; 3]>> = (0..6 * face_size)
        .into_par_iter()
        .map(|row| {
            let (face, y) = (row / face_size, row % face_size);
            (0..face_size).map(|x| texel(face_size, face, x, y)).collect()
        })
        .collect();
    CubeLevel { size: face_size, texels: rows.concat() }
}

/// The mean of the texel's samples, each at the centre of its sub-texel.
fn texel(size: usize, face: usize, x: usize, y: usize) -> [f32; 3] {
    let place = |texel: usize, sample: usize| {
        let samples = (SAMPLES * size) as f64;
        ((2 * (SAMPLES * texel + sample) + 1) as f64 - samples) / samples
    };
    let mut sum = [0.0; 3];
    for j in 0..SAMPLES {
        for i in 0..SAMPLES {
            let colour = radiance(direction(face, place(x, i), place(y, j)));
            for (sum, c) in sum.iter_mut().zip(colour) {
                *sum += c;
            }
        }
    }
    sum.map(|c| num::f32(c / (SAMPLES * SAMPLES) as f64))
}

/// Linear RGB seen in a direction of any length but zero.
#[must_use]
pub fn radiance(d: [f64; 3]) -> [f64; 3] {
    let length = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
    let d = d.map(|c| c / length);
    if let Some(colour) = sign(d) {
        return colour;
    }
    if let Some(colour) = tower(d) {
        return colour;
    }
    if d[1] >= 0.0 { sky(d) } else { ground(d) }
}

/// Haze at the horizon, which sky and ground share.
const HAZE: [f64; 3] = [0.80, 0.72, 0.62];

fn mix(a: [f64; 3], b: [f64; 3], share: f64) -> [f64; 3] {
    [0, 1, 2].map(|i| a[i] + (b[i] - a[i]) * share)
}

fn sky(d: [f64; 3]) -> [f64; 3] {
    let up = d[1].sqrt();
    let gradient = mix(HAZE, [0.10, 0.22, 0.62], up);
    let sun_length = (SUN[0] * SUN[0] + SUN[1] * SUN[1] + SUN[2] * SUN[2]).sqrt();
    let cosine = (d[0] * SUN[0] + d[1] * SUN[1] + d[2] * SUN[2]) / sun_length;
    // 1 − cos of the angle from the sun: 0.0006 is 2°.
    let away = 1.0 - cosine;
    if away < 0.0006 {
        return [310.0, 290.0, 250.0];
    }
    let glow = 4.0 * libm::exp(-away / 0.004) + 0.6 * libm::exp(-away / 0.08);
    // Soft bands of cloud; smooth everywhere.
    let band = 0.5 + 0.5 * libm::sin(9.0 * d[0] + 4.0 * libm::sin(3.0 * d[2]) + 6.0 * up);
    let cloud = 0.35 * band * band * up * (1.0 - up);
    [0, 1, 2].map(|i| gradient[i] + cloud + glow * [1.0, 0.85, 0.6][i])
}

fn ground(d: [f64; 3]) -> [f64; 3] {
    // The point of the plane one unit below.
    let (x, z) = (d[0] / -d[1], d[2] / -d[1]);
    let distance = (x * x + z * z).sqrt();
    // Fine checkers ahead on the left, coarse ones behind on the right, middling elsewhere.
    let size = match (x < 0.0, z < 0.0) {
        (true, true) => 0.125,
        (false, false) => 1.0,
        (true, false) | (false, true) => 0.5,
    };
    let odd = |c: f64| (c / size).floor().rem_euclid(2.0) >= 1.0;
    let bright = odd(x) != odd(z);
    let colour = if bright { [0.75, 0.70, 0.60] } else { [0.06, 0.10, 0.07] };
    // Rings one unit apart, and the two axes: thin lines.
    let ring = (distance - (distance + 0.5).floor()).abs() < 0.012 && distance > 0.5;
    let axis = x.abs() < 0.015 || z.abs() < 0.015;
    let colour = if ring || axis { [0.85, 0.12, 0.05] } else { colour };
    mix(colour, HAZE, 1.0 - 1.0 / (1.0 + distance * distance / 400.0))
}

/// Sectors of towers around the horizon.
const SECTORS: f64 = 48.0;

fn tower(d: [f64; 3]) -> Option<[f64; 3]> {
    if d[1] < 0.0 || d[1] > 0.3 {
        return None;
    }
    let turn = libm::atan2(d[0], d[2]) / (2.0 * std::f64::consts::PI) + 0.5;
    let place = turn * SECTORS;
    let sector = place.floor().rem_euclid(SECTORS);
    let across = place - place.floor();
    let random = hash(sector, 1.0);
    let top = 0.25 * random * random;
    let tangent = d[1] / (d[0] * d[0] + d[2] * d[2]).sqrt();
    if tangent > top || !(0.08..=0.92).contains(&across) {
        return None;
    }
    // Windows: columns and floors, some lit.
    let (column, floor) = (across * 8.0, tangent * 90.0);
    let inside = |c: f64| (0.25..0.75).contains(&(c - c.floor()));
    let wall = mix([0.22, 0.13, 0.10], [0.34, 0.36, 0.40], hash(sector, 2.0));
    if inside(column) && inside(floor) {
        let lit = hash(sector * 64.0 + column.floor(), 3.0 + floor.floor()) > 0.7;
        Some(if lit { [2.5, 1.9, 0.9] } else { [0.04, 0.05, 0.07] })
    } else {
        Some(wall)
    }
}

/// A number in 0…1 from two small whole numbers: the fraction of a large sine would lose its low bits,
/// so integers are mixed instead.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "both numbers are whole and below 2^20; a wrong one would only change a colour"
)]
fn hash(a: f64, b: f64) -> f64 {
    let a = (a as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let h = a.wrapping_add((b as u64).wrapping_mul(0xD1B5_4A32_D192_ED03));
    (stirred(h) & 0xFFFF) as f64 / 65536.0
}

/// Letters five columns wide and seven rows high, the leftmost column in the highest of five bits.
const LETTERS: [[u8; 7]; 7] = [
    [0b11111, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100], // T
    [0b01110, 0b10001, 0b10001, 0b11111, 0b10001, 0b10001, 0b10001], // A
    [0b11110, 0b10001, 0b10001, 0b11110, 0b10000, 0b10000, 0b10000], // P
    [0b10000, 0b10000, 0b10000, 0b10000, 0b10000, 0b10000, 0b11111], // L
    [0b01110, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110], // I
    [0b10001, 0b11001, 0b10101, 0b10011, 0b10001, 0b10001, 0b10001], // N
    [0b11111, 0b10000, 0b10000, 0b11110, 0b10000, 0b10000, 0b11111], // E
];

/// Two boards at z = ±1, 1.1 wide and 0.25 high, standing above the horizon.
fn sign(d: [f64; 3]) -> Option<[f64; 3]> {
    if d[2].abs() < 0.5 {
        return None;
    }
    let (x, y) = (d[0] / d[2].abs(), d[1] / d[2].abs());
    if x.abs() > 0.55 || !(0.12..=0.37).contains(&y) {
        return None;
    }
    // A grid of 44 × 9 cells with a margin of one. The eye looking along −z has +x on its right; a
    // mirror in front of it shows +z with +x on the right as well.
    let (column, row) = ((x + 0.55) * 40.0 - 1.0, (0.37 - y) * 36.0 - 1.0);
    Some(if ink(column, row) {
        [0.02, 0.02, 0.02]
    } else if d[2] > 0.0 {
        [0.95, 0.90, 0.25]
    } else {
        [0.90, 0.92, 0.95]
    })
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "both are checked to be within the letters"
)]
fn ink(column: f64, row: f64) -> bool {
    if !(0.0..42.0).contains(&column) || !(0.0..7.0).contains(&row) {
        return false;
    }
    let (column, row) = (column as usize, row as usize);
    let (letter, bit) = (column / 6, column % 6);
    bit < 5 && LETTERS[letter][row] >> (4 - bit) & 1 == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sky_is_up_ground_is_down_and_the_sun_is_bright() {
        let [r, _, b] = radiance([0.1, 1.0, 0.05]);
        assert!(b > 2.0 * r, "the zenith is blue");
        for x in [0.1, 0.6, 1.1, 1.6] {
            let [_, g, b] = radiance([x, -1.0, 0.3]);
            assert!(b <= g, "the ground is not");
        }
        assert!(radiance(SUN)[0] > 300.0);
        assert!(radiance(SUN.map(|c| -c))[0] < 2.0);
    }

    #[test]
    fn texels_are_finite_never_negative_and_of_high_range() {
        let level = procedural(64);
        assert_eq!(level.texels.len(), 6 * 64 * 64);
        let all = || level.texels.iter().flatten().copied();
        assert!(all().all(|c| (0.0..=310.0).contains(&c)));
        assert!(all().fold(0.0, f32::max) > 250.0);
        assert!(all().filter(|c| *c < 0.1).count() > 1000);
    }

    #[test]
    fn signs_read_from_left_to_right_ahead_and_in_a_mirror() {
        // The first letter is a T: its bar is dark to both sides of the stem, its foot is not. Columns
        // run with +x on both boards.
        for z in [1.0, -1.0] {
            let cell = |column: f64, row: f64| {
                let x = (column + 1.5) / 40.0 - 0.55;
                let y = 0.37 - (row + 1.5) / 36.0;
                radiance([x, y, z])[0] < 0.1
            };
            let rows = [0.0, 6.0].map(|row| [0.0, 2.0, 4.0].map(|column| cell(column, row)));
            assert_eq!(rows, [[true; 3], [false, true, false]]);
        }
    }

    #[test]
    fn a_texel_is_the_mean_of_its_sixteen_points() {
        // A one-texel face: 16 points at ±1/4 and ±3/4.
        let level = procedural(1);
        let points = [-0.75, -0.25, 0.25, 0.75];
        let mut sum = 0.0;
        for y in points {
            for x in points {
                sum += radiance(direction(3, x, y))[1];
            }
        }
        let got = f64::from(level.texel(3, 0, 0)[1]);
        assert!((got - sum / 16.0).abs() <= f64::from(f32::EPSILON) * got);
    }
}
