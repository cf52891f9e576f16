//! The eigen-angle table: sines and cosines of α, and the bin boundaries of 2α.
//!
//! By symmetry the table holds the angles |α| ≤ 45° and the sign is applied to the sine. The bin of
//! |2b|/|c − a| = tan|2α| is found without a division or an arctangent: boundary θ is passed where
//! |2b|·cos θ > |c − a|·sin θ.

use alloc::vec::Vec;

use super::contents::sin_cos;
use super::rom::TableSpec;
use crate::policy::Placement;

/// Fraction bits of the boundary constants.
pub const BOUNDARY_FRAC: u32 = 28;

/// The angle table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AngleRom {
    /// Knobs: `entries` over 90°, `order` 0 or 1, `frac` of an entry.
    pub spec: TableSpec,
    /// Where the entries lie.
    pub placement: Placement,
    /// (cos α, sin α) of the angles α ≥ 0, ascending, with `spec.frac` bits.
    pub angles: Vec<(i64, i64)>,
    /// (cos θ, sin θ) of the boundaries θ of |2α|, ascending, with `BOUNDARY_FRAC` bits: midway
    /// between the entries (order 0) or at the entries above the first (order 1).
    pub boundaries: Vec<(i64, i64)>,
    /// (cos 2α, sin 2α) of the first entry, with `BOUNDARY_FRAC` bits.
    pub first_theta: (i64, i64),
    /// cot of the step of 2α between entries, for order 1, with `BOUNDARY_FRAC` − 8 bits.
    pub cot_step: i64,
}

impl AngleRom {
    /// Builds the table; `None` where a value cannot be rounded correctly in the series' width.
    #[must_use]
    pub fn new(spec: TableSpec, placement: Placement) -> Option<Self> {
        let n = spec.entries;
        // α as a fraction of π: 90°·k/n = π·k/(2n) (edges), π·(2k + 1)/(4n) (centres).
        let angle = |k: u32| match placement {
            Placement::Edges => (2 * k, 4 * n),
            Placement::Centres => (2 * k + 1, 4 * n),
        };
        let count = match placement {
            Placement::Edges => n / 2 + 1,
            Placement::Centres => n / 2,
        };
        let mut angles = Vec::new();
        for k in 0..count {
            let (p, q) = angle(k);
            angles.push((
                sin_cos(p, q, true, spec.frac)?,
                sin_cos(p, q, false, spec.frac)?,
            ));
        }
        let mut boundaries = Vec::new();
        for k in 1..count {
            let ((p0, q), (p1, _)) = (angle(k - 1), angle(k));
            // 2α: doubled numerator; midway: the mean of the two.
            let theta = if spec.order == 0 { p0 + p1 } else { 2 * p1 };
            boundaries.push((
                sin_cos(theta, q, true, BOUNDARY_FRAC)?,
                sin_cos(theta, q, false, BOUNDARY_FRAC)?,
            ));
        }
        // tan of the step 2·90°/n = π/n; n = 2 has one bin of 90°, whose cotangent is 0.
        let (c, s) = (
            sin_cos(1, n, true, BOUNDARY_FRAC)?,
            sin_cos(1, n, false, BOUNDARY_FRAC)?,
        );
        let (p, q) = angle(0);
        let first_theta = (
            sin_cos(2 * p, q, true, BOUNDARY_FRAC)?,
            sin_cos(2 * p, q, false, BOUNDARY_FRAC)?,
        );
        Some(Self {
            spec,
            placement,
            first_theta,
            angles,
            boundaries,
            cot_step: (c << (BOUNDARY_FRAC - 8)) / s,
        })
    }

    /// How many boundaries |2b|/|c − a| has passed: the index of the entry. Both < 2^33.
    ///
    /// A ratio exactly on a boundary (as its constants are rounded) belongs to the lower entry.
    #[inline(always)]
    #[must_use]
    pub fn index(&self, two_b: i64, c_minus_a: i64) -> usize {
        let mut low = 0;
        let mut size = self.boundaries.len();
        while size > 0 {
            let half = size / 2;
            let (cos, sin) = self.boundaries.get(low + half).copied().unwrap_or((0, 1));
            let passed = two_b * cos > c_minus_a * sin;
            if passed {
                low += half + 1;
                size -= half + 1;
            } else {
                size = half;
            }
        }
        low
    }

    /// Table bits: two values an entry and two constants a boundary.
    #[must_use]
    pub fn bits(&self) -> u64 {
        let wide =
            |n: usize, width: u32| u64::try_from(2 * n).unwrap_or(u64::MAX) * u64::from(width);
        wide(self.angles.len(), self.spec.frac + 1) + wide(self.boundaries.len(), BOUNDARY_FRAC + 1)
    }
}
