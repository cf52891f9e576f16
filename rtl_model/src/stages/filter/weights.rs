//! Probe weights: integers that sum to exactly 2^bits.
//!
//! Weight i of `count` is e^(−2x²), or e^(−x²) for `bell`, x its offset over half the line: (2i + 1 − count)/count, or
//! (2i + 1 − count)/(count − 1) where the line has probes at its ends. Each is rounded to nearest; the
//! residue goes to the middle probe, the lower one of two, for `bell` half to each. Where that would make it negative, all are
//! rounded down instead.

use alloc::vec;
use alloc::vec::Vec;

use crate::policy::{FootprintPolicy, FootprintRule, Weights};

/// Fraction bits of the exponential series.
const FRAC: u32 = 60;

/// e^(−p/q) with 60 fraction bits, p/q ≤ 2, off by < 2^−50.
///
/// The series of e^(−x) alternates; for x ≤ 2 its terms stay below 2 and each loses < 1 LSB.
fn exp_neg(p: i128, q: i128) -> i128 {
    let one = 1i128 << FRAC;
    let mut term = one;
    let mut sum = one;
    let mut k = 1;
    while term != 0 && k < 60 {
        term = -(term * p / (q * k));
        sum += term;
        k += 1;
    }
    sum
}

/// The weights of `count` probes; 1 each for box weights.
#[must_use]
pub fn weights(count: u32, policy: &FootprintPolicy) -> Vec<i64> {
    let (steepness, halves) = match policy.weights {
        Weights::Box => return vec![1; usize::try_from(count).unwrap_or(0)],
        Weights::Gaussian => (2, false),
        Weights::Bell => (1, count.is_multiple_of(2)),
    };
    let bits = policy.weight_bits;
    let end_points = policy.count.has_end_points() && policy.policy == FootprintRule::Paper;
    let n = i128::from(count.max(1));
    let half_line = if end_points { (n - 1).max(1) } else { n };
    // x² = (2i + 1 − n)²/(half line)².
    let raw: Vec<i128> = (0..n)
        .map(|i| exp_neg(steepness * (2 * i + 1 - n) * (2 * i + 1 - n), half_line * half_line))
        .collect();
    let total: i128 = raw.iter().sum();
    let middle = (raw.len() - 1) / 2;
    let rounded = |half: i128| {
        let mut out: Vec<i64> = raw
            .iter()
            .map(|w| i64::try_from(((w << (bits + 1)) + half * total) / (2 * total)).unwrap_or(0))
            .collect();
        let residue = (1i64 << bits) - out.iter().sum::<i64>();
        if let Some(w) = out.get_mut(middle) {
            *w += if halves { residue / 2 } else { residue };
        }
        if halves && let Some(w) = out.get_mut(middle + 1) {
            *w += residue / 2;
        }
        out
    };
    let nearest = rounded(1);
    // Rounded down, the residue is never negative.
    if nearest.iter().all(|w| *w >= 0) { nearest } else { rounded(0) }
}

/// The weights of every count up to `max`, by count.
#[must_use]
pub fn rom(policy: &FootprintPolicy) -> Vec<Vec<i64>> {
    (0..=policy.max_probes).map(|count| weights(count, policy)).collect()
}

/// Weight of probe `k` of `count`.
#[inline(always)]
pub(super) fn at(rom: &[Vec<i64>], count: i64, k: i64) -> i64 {
    let index = |x: i64| usize::try_from(x).unwrap_or(0);
    rom.get(index(count)).and_then(|row| row.get(index(k))).copied().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_sum_to_a_power_of_two_and_fall_towards_the_ends() {
        for bits in [4, 8, 12] {
            for count in 1..=64 {
                let (weights_of, weight_bits) = (Weights::Gaussian, bits);
                let plain = FootprintPolicy::default();
                let policy = FootprintPolicy { weights: weights_of, weight_bits, ..plain };
                let w = weights(count, &policy);
                assert_eq!(w.iter().sum::<i64>(), 1 << bits, "{count} probes");
                let middle = (w.len() - 1) / 2;
                for i in 0..w.len() {
                    if i != middle && w.len() - 1 - i != middle {
                        assert_eq!(w[i], w[w.len() - 1 - i], "{count} probes, weight {i}");
                    }
                }
                assert!(w[0] <= w[middle] + 8);
            }
        }
    }
}
