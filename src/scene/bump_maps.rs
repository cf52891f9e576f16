//! The two built-in bump maps: scratched steel and water. Both repeat without a seam.

use rayon::prelude::*;

use super::bump::BumpMap;
use crate::base::random::{Random, mixed, share};

/// Texels along a side of both maps.
pub const SIZE: usize = 1024;
const SIDE: f64 = 1024.0;

/// A map from numbers made here, which always fill it.
fn from_heights(heights: &[f64]) -> BumpMap {
    #[expect(clippy::cast_possible_truncation, reason = "rounding to single is meant")]
    let values: Vec<f32> = heights.iter().map(|h| *h as f32).collect();
    match BumpMap::from_height(SIZE, SIZE, &values, 1.0) {
        Ok(map) => map,
        Err(error) => unreachable!("the map is complete: {error}"),
    }
}

/// Steel: three brushed areas and 350 straight grooves in three main directions.
///
/// Grooves are V-shaped, 1.6 to 7 texels wide, with flanks of slope 0.3 to 5; where they cross, the
/// deeper one wins. Offsets reach several units at the hard ones and are zero between grooves.
#[must_use]
pub fn scratches() -> BumpMap {
    let mut heights = vec![0.0; SIZE * SIZE];
    brush(&mut heights);
    let mut random = Random::new(7);
    for _ in 0..350 {
        let family = [0.26, 1.25, 2.3][whole(random.within(0.0, 3.0)).clamp(0, 2).unsigned_abs()];
        let angle = family + random.within(-0.12, 0.12);
        let length = random.within(0.05, 0.8);
        let groove = Groove {
            from: [random.within(0.0, SIDE), random.within(0.0, SIDE)],
            along: [libm::cos(angle), libm::sin(angle)],
            length: SIDE * length * length,
            half_width: random.within(0.8, 3.5),
            // Mostly shallow, a few hard.
            slope: 0.3 + 4.7 * libm::pow(random.within(0.0, 1.0), 4.0),
        };
        groove.cut(&mut heights);
    }
    from_heights(&heights)
}

/// One scratch.
struct Groove {
    from: [f64; 2],
    along: [f64; 2],
    length: f64,
    half_width: f64,
    slope: f64,
}

impl Groove {
    /// Lowers every texel near the segment to the groove's flank.
    fn cut(&self, heights: &mut [f64]) {
        // Walk along the steeper coordinate; across it a diagonal groove is at most √2 wider.
        let major = usize::from(self.along[1].abs() > self.along[0].abs());
        let minor = 1 - major;
        let ends = [0.0, self.length].map(|t| self.from[major] + t * self.along[major]);
        let reach = self.half_width + 1.0;
        let first = whole(ends[0].min(ends[1]) - reach);
        let last = whole(ends[0].max(ends[1]) + reach);
        let tilt = self.along[minor] / self.along[major];
        let across = whole(reach * std::f64::consts::SQRT_2) + 1;
        for m in first..=last {
            let step = m as f64 - self.from[major];
            let middle = whole(self.from[minor] + step * tilt);
            for n in middle - across..=middle + across {
                let mut place = [0.0; 2];
                place[major] = step;
                place[minor] = n as f64 - self.from[minor];
                let t = place[0] * self.along[0] + place[1] * self.along[1];
                let t = t.clamp(0.0, self.length);
                let (x, y) = (place[0] - t * self.along[0], place[1] - t * self.along[1]);
                let depth = self.slope * (self.half_width - (x * x + y * y).sqrt());
                let mut texel = [0; 2];
                texel[major] = wrapped(m);
                texel[minor] = wrapped(n);
                let height = &mut heights[texel[1] * SIZE + texel[0]];
                *height = height.min(-depth);
            }
        }
    }
}

/// Brushed areas: noise that varies fast across the brush and slowly along it, under a soft window.
fn brush(heights: &mut [f64]) {
    // Centre, half sizes, direction and height of the three areas.
    let areas = [
        ([300.0, 300.0], [230.0, 150.0], 0.0, 0.8),
        ([720.0, 620.0], [180.0, 260.0], 1.1, 0.5),
        ([180.0, 820.0], [140.0, 140.0], 2.4, 1.4),
    ];
    heights.par_chunks_mut(SIZE).enumerate().for_each(|(y, row)| {
        for (x, height) in row.iter_mut().enumerate() {
            for (key, (centre, half, angle, strength)) in (0u64..).zip(areas) {
                // The nearest repetition of the area.
                let near = |p: usize, c: f64| {
                    let d = p as f64 - c;
                    d - SIDE * (d / SIDE + 0.5).floor()
                };
                let (dx, dy) = (near(x, centre[0]), near(y, centre[1]));
                let (u, v) = (dx / half[0], dy / half[1]);
                let window = (1.0 - (u * u + v * v)).max(0.0);
                if window > 0.0 {
                    let (c, s) = (libm::cos(angle), libm::sin(angle));
                    let noise = streaks((dx * c + dy * s) / 90.0, (dy * c - dx * s) / 2.0, key);
                    *height += strength * window.min(0.3) / 0.3 * (noise - 0.5);
                }
            }
        }
    });
}

/// Bilinear value noise in 0…1.
fn streaks(along: f64, across: f64, key: u64) -> f64 {
    let corner = |i: f64, j: f64| {
        // Both are whole and within ±2000: shifted to be positive, they do not overlap.
        let cell = whole((i + 4096.0) * 8192.0 + (j + 4096.0));
        share(mixed(cell.unsigned_abs() as u64 ^ (key << 40)))
    };
    let (i, j) = (along.floor(), across.floor());
    let (f, g) = (along - i, across - j);
    let first = corner(i, j) + (corner(i, j + 1.0) - corner(i, j)) * g;
    let second = corner(i + 1.0, j) + (corner(i + 1.0, j + 1.0) - corner(i + 1.0, j)) * g;
    first + (second - first) * f
}

/// The whole number at or below; every number here is within ±2³⁰.
#[expect(clippy::cast_possible_truncation, reason = "within ±2^30")]
fn whole(value: f64) -> isize {
    value.floor() as isize
}

/// A texel of the repeating map.
fn wrapped(place: isize) -> usize {
    // The mask keeps the low ten bits, which is the remainder of the division by 1024.
    place.cast_unsigned() & (SIZE - 1)
}

/// Water: 36 sine waves in six octaves, mostly running towards the viewer (down the rows).
///
/// Each wave is a cosine of whole periods across the map, so its slope is exact and the map repeats.
/// The slope's root mean square is about 0.12.
#[must_use]
pub fn waves() -> BumpMap {
    let mut random = Random::new(11);
    let mut waves = Vec::new();
    for octave in 0..6u8 {
        for _ in 0..6 {
            let length = 3.0 * f64::from(1u32 << octave) * random.within(0.75, 1.4);
            let angle = random.within(-0.9, 0.9);
            let k = [length * libm::sin(angle), length * libm::cos(angle)].map(|c| whole(c + 0.5));
            let phase = random.within(0.0, 2.0 * std::f64::consts::PI);
            let [kx, ky] = k.map(|c| c as f64);
            let size = (kx * kx + ky * ky).sqrt();
            let slope = 0.04 * libm::pow(0.87, f64::from(octave));
            let sines: Vec<f64> = (0..SIZE)
                .map(|m| libm::sin(2.0 * std::f64::consts::PI * m as f64 / SIDE + phase))
                .collect();
            // height = A cos θ: b1 = A kx sin θ, b2 = −A ky sin θ with A|k| = slope.
            waves.push((k, [slope * kx / size, -slope * ky / size], sines));
        }
    }
    #[expect(clippy::cast_possible_truncation, reason = "rounding to single is meant")]
    let values: Vec<[f32; 2]> = (0..SIZE * SIZE)
        .into_par_iter()
        .map(|index| {
            let (x, y) = ((index % SIZE).cast_signed(), (index / SIZE).cast_signed());
            let mut b = [0.0; 2];
            for (k, slope, sines) in &waves {
                let sine = sines[wrapped(k[0] * x + k[1] * y)];
                b[0] += slope[0] * sine;
                b[1] += slope[1] * sine;
            }
            b.map(|c| c as f32)
        })
        .collect();
    match BumpMap::from_offsets(SIZE, SIZE, &values) {
        Ok(map) => map,
        Err(error) => unreachable!("the map is complete: {error}"),
    }
}
