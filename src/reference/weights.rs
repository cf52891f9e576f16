//! Integer weights of the probes along the line.

use crate::policy::{FootprintPolicy, FootprintRule, Weights};

/// Weights of `count` probes that sum to exactly 2^`weight_bits`: the ROM of every engine. All are 1 for box weights.
///
/// Probe i has weight e^(−2x²), for `bell` e^(−x²), x = its offset over half the line: (2i + 1 − count)/count, or with
/// end points (feline) (2i + 1 − count)/(count − 1). Each is divided by their sum, times 2^bits,
/// rounded to nearest; what then lacks or exceeds is put to the middle probe, of two middle ones to
/// the lower index, for `bell` half to each. Where that would leave the middle probe negative (many probes, few bits), all are
/// rounded down instead. `bits` above 30 counts as 30; `count` 0 gives no weights.
#[must_use]
pub fn probe_weights(count: u32, policy: &FootprintPolicy) -> Vec<u32> {
    let (steepness, halves) = match policy.weights {
        Weights::Box => return vec![1; count as usize],
        Weights::Gaussian => (2.0, false),
        Weights::Bell => (1.0, count.is_multiple_of(2)),
    };
    let end_points = policy.count.has_end_points() && policy.policy == FootprintRule::Paper;
    let total = 1i64 << policy.weight_bits.min(30);
    let half_line = f64::from(if end_points { count.saturating_sub(1).max(1) } else { count });
    let bells: Vec<f64> = (0..count)
        .map(|i| {
            let x = (2.0 * f64::from(i) + 1.0 - f64::from(count)) / half_line;
            libm::exp(-steepness * x * x)
        })
        .collect();
    let sum: f64 = bells.iter().sum();
    let rounded = |offset: f64| {
        let mut weights: Vec<i64> = bells
            .iter()
            .map(|bell| {
                #[expect(
                    clippy::cast_possible_truncation,
                    reason = "a share of 2^bits with bits at most 30"
                )]
                let weight = (bell / sum * total as f64 + offset).floor() as i64;
                weight
            })
            .collect();
        let residue = total - weights.iter().sum::<i64>();
        let middle = count.saturating_sub(1) as usize / 2;
        if let Some(middle) = weights.get_mut(middle) {
            *middle += if halves { residue / 2 } else { residue };
        }
        if halves && let Some(next) = weights.get_mut(middle + 1) {
            *next += residue / 2;
        }
        let weights: Result<Vec<u32>, _> = weights.into_iter().map(u32::try_from).collect();
        weights.ok()
    };
    // Rounded down, the residue is never negative.
    rounded(0.5).or_else(|| rounded(0.0)).unwrap_or_default()
}

/// V_n of 1, 2, 3, … probes; empty where the policy does not need it.
#[must_use]
pub fn spreads(policy: &FootprintPolicy) -> Vec<f64> {
    match policy.policy {
        FootprintRule::Paper => Vec::new(),
        FootprintRule::Moments => (1..=policy.max_probes).map(|n| spread(n, policy)).collect(),
    }
}

/// V_n of `count` probes: twelve times the variance of their places i with their weights.
fn spread(count: u32, policy: &FootprintPolicy) -> f64 {
    let (mut sum, mut moment) = (0u64, 0u64);
    for (i, weight) in (0..count).zip(probe_weights(count, policy)) {
        let twice = u64::from((2 * i + 1).abs_diff(count));
        sum += u64::from(weight);
        moment += 3 * u64::from(weight) * twice * twice;
    }
    moment as f64 / sum.max(1) as f64
}
