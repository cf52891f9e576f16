//! Seeded numbers: a case's numbers depend on its seed and its index alone, so that any case can be replayed.

/// A generator of 64-bit words (SplitMix64).
#[derive(Clone, Copy, Debug)]
pub struct Random(u64);

impl Random {
    /// The numbers of case `index` under a seed and a salt, which keeps classes apart.
    #[must_use]
    pub fn new(seed: u64, salt: u64, index: u64) -> Self {
        let mut out = Self(seed);
        out.0 = out.word() ^ salt;
        out.0 = out.word() ^ index;
        out
    }

    /// The next word.
    pub fn word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `n`, which is at least 1.
    pub fn below(&mut self, n: u64) -> u64 {
        self.word() % n.max(1)
    }

    /// An index into a list of `n`.
    pub fn index(&mut self, n: usize) -> usize {
        let n = u64::try_from(n).unwrap_or(1);
        usize::try_from(self.below(n)).unwrap_or(0)
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
        libm::ldexp(self.low_bits(53), -53)
    }

    /// A double in (−1, 1).
    pub fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    #[expect(clippy::cast_precision_loss, reason = "at most 53 bits")]
    fn low_bits(&mut self, bits: u32) -> f64 {
        (self.word() >> (64 - bits)) as f64
    }

    /// Three doubles in (−1, 1).
    pub fn vector(&mut self) -> [f64; 3] {
        [self.signed(), self.signed(), self.signed()]
    }
}
