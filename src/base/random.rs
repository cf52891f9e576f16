//! Seeded numbers, the same on every machine.

use super::num;

/// A word mixed: the first one of [`Random::new`] with `value` as its seed. No two words give the same.
#[must_use]
pub fn hash(value: u64) -> u64 {
    Random::new(value).word()
}

/// A word whose bits all depend on all of `z`: SplitMix64's last step.
#[must_use]
pub fn mixed(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// A shorter one, for procedural textures.
#[must_use]
pub fn stirred(mut z: u64) -> u64 {
    z = (z ^ (z >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z ^ (z >> 32)
}

/// A word's upper 53 bits as a double in [0, 1).
#[must_use]
pub fn share(word: u64) -> f64 {
    (word >> 11) as f64 / 9_007_199_254_740_992.0
}

/// SplitMix64 (Steele, Lea, Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014): a counter times a
/// constant, then mixed.
#[derive(Clone, Copy, Debug)]
pub struct Random(u64);

impl Random {
    /// The numbers of a seed.
    #[must_use]
    pub const fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The numbers of case `index` under a seed and a salt, which keeps classes apart: any case can be replayed alone.
    #[must_use]
    pub fn of_case(seed: u64, salt: u64, index: u64) -> Self {
        let mut out = Self(seed);
        out.0 = out.word() ^ salt;
        out.0 = out.word() ^ index;
        out
    }

    /// The next word.
    pub fn word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        mixed(self.0)
    }

    /// A number below `n`, which is at least 1.
    pub fn below(&mut self, n: u64) -> u64 {
        self.word() % n.max(1)
    }

    /// An index into a list of `n`.
    pub fn index(&mut self, n: usize) -> usize {
        let n = num::u64(n);
        num::usize(self.below(n))
    }

    /// One of a list that is not empty.
    pub fn one_of<T: Copy>(&mut self, list: &[T]) -> T {
        list[self.index(list.len())]
    }

    /// A number from `low` to `high`.
    pub fn between(&mut self, low: i64, high: i64) -> i64 {
        let span = high.abs_diff(low).saturating_add(1);
        low.wrapping_add(self.below(span).cast_signed())
    }

    /// A double in [0, 1) of 53 bits.
    pub fn unit(&mut self) -> f64 {
        share(self.word())
    }

    /// A double from `low` on and below `high`.
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// A double in (−1, 1).
    pub fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    /// Three doubles in (−1, 1).
    pub fn vector(&mut self) -> [f64; 3] {
        [self.signed(), self.signed(), self.signed()]
    }
}

/// Numbers of a key and a counter.
#[derive(Clone, Debug)]
pub struct Keyed {
    key: u64,
    count: u64,
}

impl Keyed {
    /// The numbers of a sample of an image position.
    #[must_use]
    pub fn new(seed: u64, place: [f64; 2], sample: u64) -> Self {
        let words = [seed, place[0].to_bits(), place[1].to_bits(), sample];
        Self { key: words.into_iter().fold(0, |key, word| hash(key ^ word)), count: 0 }
    }

    /// The next number, from 0 on and below 1.
    pub fn number(&mut self) -> f64 {
        self.count += 1;
        Random(self.key.wrapping_add(self.count)).unit()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_numbers_are_the_published_ones_and_stay_in_range() {
        // The sequence of seed 1234567 in the authors' reference implementation.
        let mut random = Random::new(1_234_567);
        let first: Vec<u64> = (0..2).map(|_| random.word()).collect();
        assert_eq!(first, [6_457_827_717_110_365_317, 3_203_168_211_198_807_973]);
        assert!((0..1000).all(|_| random.index(7) < 7 && random.unit() < 1.0));
        assert_eq!((random.below(0), random.index(0)), (0, 0));
    }
}
