//! Texel rows: two neighbouring texels of a row times their weights, for two rows.

use super::Sums;

/// Memory that yields weighted sums of two rows of two texels.
pub trait Rows {
    /// `upper[0]·t(a) + upper[1]·t(a + 1) + lower[0]·t(b) + lower[1]·t(b + 1)`, channel by channel.
    fn sum(&self, a: usize, upper: [i64; 2], b: usize, lower: [i64; 2]) -> Sums;

    /// Reads the same texels and folds their words together.
    fn touch(&self, a: usize, b: usize) -> u64;
}

/// Texels decoded beforehand.
#[derive(Clone, Copy, Debug)]
pub struct Wide<'a>(pub &'a [[i64; 4]]);

impl Rows for Wide<'_> {
    #[inline(always)]
    fn sum(&self, a: usize, upper: [i64; 2], b: usize, lower: [i64; 2]) -> Sums {
        let ([t0, t1], [t2, t3]) = (pair(self.0, a), pair(self.0, b));
        let mut sum = [0; 4];
        for (c, s) in sum.iter_mut().enumerate() {
            *s = upper[0] * t0[c] + upper[1] * t1[c] + lower[0] * t2[c] + lower[1] * t3[c];
        }
        sum
    }

    #[inline(always)]
    fn touch(&self, a: usize, b: usize) -> u64 {
        fold(self.0, a, b, i64::cast_unsigned)
    }
}

/// Folds the words of two rows of two texels together, channel by channel.
#[inline(always)]
fn fold<X: Copy + Default>(texels: &[[X; 4]], a: usize, b: usize, word: impl Fn(X) -> u64) -> u64 {
    let ([t0, t1], [t2, t3]) = (pair(texels, a), pair(texels, b));
    let mut sum = 0u64;
    for c in 0..4 {
        sum ^= word(t0[c]) ^ word(t1[c]) ^ word(t2[c]) ^ word(t3[c]);
    }
    sum
}

/// binary16 texels, decoded on the way.
#[derive(Clone, Copy, Debug)]
pub struct Half<'a>(pub &'a [[u16; 4]]);

impl Rows for Half<'_> {
    #[inline(always)]
    fn sum(&self, a: usize, upper: [i64; 2], b: usize, lower: [i64; 2]) -> Sums {
        let ([t0, t1], [t2, t3]) = (pair(self.0, a), pair(self.0, b));
        let mut sum = [0; 4];
        for (texel, weight) in [
            (t0, upper[0]),
            (t1, upper[1]),
            (t2, lower[0]),
            (t3, lower[1]),
        ] {
            // 11 bits of mantissa times ≤ 17 bits of weight fit 32; the exponent shifts afterwards.
            let weight = u32::try_from(weight & 0x1_ffff).unwrap_or(0);
            for (s, word) in sum.iter_mut().zip(texel) {
                let (m, shift) = split(word);
                *s += (u64::from(m * weight) << shift).cast_signed();
            }
        }
        sum
    }

    #[inline(always)]
    fn touch(&self, a: usize, b: usize) -> u64 {
        fold(self.0, a, b, u64::from)
    }
}

/// Mantissa and left shift of a finite, non-negative half: value = m · 2^shift · 2^−24.
#[inline(always)]
fn split(word: u16) -> (u32, u32) {
    let e = u32::from(word >> 10) & 0x1f;
    let normal = u32::from(e != 0);
    (u32::from(word & 0x3ff) | (normal << 10), e - normal)
}

/// Two neighbouring texels; zeros beyond the memory, which no address reaches.
#[inline(always)]
fn pair<X: Copy + Default>(texels: &[[X; 4]], at: usize) -> [[X; 4]; 2] {
    match texels.get(at..at + 2) {
        Some(&[a, b]) => [a, b],
        _ => [[X::default(); 4]; 2],
    }
}
