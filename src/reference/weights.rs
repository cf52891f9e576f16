//! Integer weights of the probes along the line.

/// Gaussian weights of `count` probes that sum to exactly 2^`bits`: the ROM of every engine.
///
/// Probe i has weight e^(−2x²), x = its offset over half the line: (2i + 1 − count)/count, or with
/// `end_points` (feline) (2i + 1 − count)/(count − 1). Each is divided by their sum, times 2^bits,
/// rounded to nearest; what then lacks or exceeds is put to the middle probe, of two middle ones to
/// the lower index. Where that would leave the middle probe negative (many probes, few bits), all are
/// rounded down instead. `bits` above 30 counts as 30; `count` 0 gives no weights.
#[must_use]
pub fn probe_weights(count: u32, bits: u32, end_points: bool) -> Vec<u32> {
    let total = 1i64 << bits.min(30);
    let half_line = f64::from(if end_points { count.saturating_sub(1).max(1) } else { count });
    let bells: Vec<f64> = (0..count)
        .map(|i| {
            let x = (2.0 * f64::from(i) + 1.0 - f64::from(count)) / half_line;
            libm::exp(-2.0 * x * x)
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
        if let Some(middle) = weights.get_mut(count.saturating_sub(1) as usize / 2) {
            *middle += residue;
        }
        let weights: Result<Vec<u32>, _> = weights.into_iter().map(u32::try_from).collect();
        weights.ok()
    };
    // Rounded down, the residue is never negative.
    rounded(0.5).or_else(|| rounded(0.0)).unwrap_or_default()
}
