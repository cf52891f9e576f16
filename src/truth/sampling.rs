//! Stratified samples of a pixel and the estimate that they make.

use crate::base::random::hash;

/// Colours or, where the object is missed, nothing.
pub type Seen = Vec<Option<[f64; 3]>>;

/// Appends what is seen at image positions.
pub type Shade<'a> = dyn Fn(&[[f64; 2]], &mut Seen) + Sync + 'a;

/// How a round of samples covers a pixel: g rows of 2g strata, two samples in each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strata {
    rows: u32,
}

impl Strata {
    /// At least so many samples a round: 4·g² for the smallest whole g.
    #[must_use]
    pub fn new(samples: u32) -> Self {
        let mut rows = 1;
        while 4 * u64::from(rows) * u64::from(rows) < u64::from(samples) {
            rows += 1;
        }
        Self { rows }
    }

    /// Samples of a round.
    #[must_use]
    pub fn samples(&self) -> u64 {
        4 * u64::from(self.rows) * u64::from(self.rows)
    }

    /// Adds a round of a pixel's samples, a row of strata at a time.
    pub fn round(
        &self,
        seed: u64,
        pixel: [u32; 2],
        round: u64,
        shade: &Shade<'_>,
        sums: &mut Sums,
    ) {
        let key = hash(hash(seed ^ (u64::from(pixel[1]) << 32 | u64::from(pixel[0]))) ^ round);
        let corner = pixel.map(f64::from);
        let step = [0.5, 1.0].map(|c| c / f64::from(self.rows));
        let mut counter = 0;
        let (mut places, mut colours) = (Vec::new(), Vec::new());
        for row in 0..self.rows {
            places.clear();
            for column in 0..2 * self.rows {
                for _ in 0..2 {
                    let random = hash(key.wrapping_add(counter));
                    counter += 1;
                    let (x, y) = (unit(random >> 32), unit(random & 0xFFFF_FFFF));
                    places.push([
                        corner[0] + (f64::from(column) + x) * step[0],
                        corner[1] + (f64::from(row) + y) * step[1],
                    ]);
                }
            }
            colours.clear();
            shade(&places, &mut colours);
            let (pairs, _) = colours.as_chunks();
            pairs.iter().for_each(|pair| sums.add(*pair));
        }
    }
}

/// The middle of one of 2³² parts of 0…1.
fn unit(bits: u64) -> f64 {
    (2 * bits + 1) as f64 / 8_589_934_592.0
}

/// Sums over pairs of samples, from which mean and standard error follow.
///
/// The mean over the samples that hit is a ratio, Σ f / Σ 1. Its variance is, to first order, that of
/// Σ e / hits with e = f − mean for a hit and 0 for a miss; for two independent samples in each stratum
/// Σ (e_a − e_b)² is an unbiased estimate of the variance of Σ e.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sums {
    colour: [f64; 3],
    hits: u64,
    taken: u64,
    /// Σ (f_a − f_b)², Σ (f_a − f_b)(1_a − 1_b) per channel, and Σ (1_a − 1_b)².
    square: [f64; 3],
    mixed: [f64; 3],
    uneven: f64,
}

impl Sums {
    /// Adds the two samples of a stratum.
    pub fn add(&mut self, pair: [Option<[f64; 3]>; 2]) {
        self.taken += 2;
        let [a, b] = pair.map(|sample| sample.unwrap_or([0.0; 3]));
        let [hit_a, hit_b] = pair.map(|sample| if sample.is_some() { 1.0 } else { 0.0 });
        self.hits += pair.iter().flatten().count() as u64;
        for i in 0..3 {
            let difference = a[i] - b[i];
            self.colour[i] += a[i] + b[i];
            self.square[i] += difference * difference;
            self.mixed[i] += difference * (hit_a - hit_b);
        }
        self.uneven += (hit_a - hit_b) * (hit_a - hit_b);
    }

    /// Samples that were taken, hits and misses.
    #[must_use]
    pub fn taken(&self) -> u64 {
        self.taken
    }

    /// Mean colour of the hits and the standard error of each channel; `None` without a hit.
    #[must_use]
    pub fn estimate(&self) -> Option<([f64; 3], [f64; 3])> {
        if self.hits == 0 {
            return None;
        }
        let hits = self.hits as f64;
        let mean = self.colour.map(|c| c / hits);
        let error = [0, 1, 2].map(|i| {
            let m = mean[i];
            let square = self.square[i] - 2.0 * m * self.mixed[i] + m * m * self.uneven;
            square.max(0.0).sqrt() / hits
        });
        Some((mean, error))
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "where bits must be equal, that is what is tested")]
mod tests {
    use super::*;

    #[test]
    fn two_samples_fall_into_every_stratum_of_the_pixel() {
        for (samples, rows) in [(1, 1), (4, 1), (5, 2), (16, 2), (256, 8), (257, 9)] {
            let strata = Strata::new(samples);
            assert_eq!(strata.samples(), 4 * rows * rows);
            let counts = std::sync::Mutex::new(std::collections::BTreeMap::new());
            let mut sums = Sums::default();
            let shade = |places: &[[f64; 2]], colours: &mut Vec<_>| {
                for [x, y] in places {
                    let (x, y) = (x - 7.0, y - 3.0);
                    assert!((0.0..1.0).contains(&x) && (0.0..1.0).contains(&y));
                    let rows = rows as f64;
                    let key = format!("{} {}", (x * 2.0 * rows).floor(), (y * rows).floor());
                    *counts.lock().unwrap().entry(key).or_insert(0) += 1;
                    colours.push(None);
                }
            };
            strata.round(5, [7, 3], 0, &shade, &mut sums);
            let counts = counts.into_inner().unwrap();
            assert_eq!(counts.len() as u64, 2 * rows * rows);
            assert!(counts.values().all(|count| *count == 2));
            assert_eq!((sums.taken(), sums.estimate()), (4 * rows * rows, None));
        }
    }

    #[test]
    fn misses_do_not_count_and_their_chance_is_in_the_error() {
        let mut sums = Sums::default();
        let one = [1.0, 2.0, 4.0];
        sums.add([Some(one), None]);
        sums.add([Some(one), Some(one)]);
        let (mean, error) = sums.estimate().unwrap();
        // Equal colours: which of them hit does not matter.
        assert_eq!(mean, one);
        assert_eq!(error, [0.0; 3]);
        sums.add([Some([4.0, 2.0, 4.0]), None]);
        // Means 1.75, 2, 4 of four hits; e of the first channel: −0.75 alone, 0, 2.25 alone.
        let (mean, error) = sums.estimate().unwrap();
        assert_eq!(mean, [1.75, 2.0, 4.0]);
        // A square root of sums of a few numbers below 16.
        let want = (0.75f64 * 0.75 + 2.25 * 2.25).sqrt() / 4.0;
        assert!((error[0] - want).abs() <= 64.0 * f64::EPSILON);
        assert_eq!(error[1..], [0.0; 2]);
    }

    #[test]
    fn rounds_pixels_and_seeds_have_samples_of_their_own() {
        let first = |seed, pixel, round| {
            let places = std::sync::Mutex::new(Vec::new());
            let shade = |row: &[[f64; 2]], colours: &mut Vec<_>| {
                let inside = row.iter().map(|place| place.map(|x| (x - x.floor()).to_bits()));
                places.lock().unwrap().extend(inside);
                colours.extend(row.iter().map(|_| None));
            };
            Strata::new(4).round(seed, pixel, round, &shade, &mut Sums::default());
            places.into_inner().unwrap()
        };
        let own = first(0, [1, 2], 0);
        assert_eq!(own, first(0, [1, 2], 0));
        for other in [first(1, [1, 2], 0), first(0, [2, 1], 0), first(0, [1, 2], 1)] {
            assert_ne!(own, other);
        }
    }
}
