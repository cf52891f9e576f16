//! The eigen-angle table: sines and cosines of α, and the bin boundaries of 2α.
//!
//! By symmetry the table holds the angles |α| ≤ 45° and the sign is applied to the sine. The bin of
//! |2b|/|c − a| = tan|2α| is found without a division or an arctangent: boundary θ is passed where
//! |2b|·cos θ > |c − a|·sin θ.

use alloc::vec::Vec;

use super::contents::sin_cos;
use super::rom::{PORT_FRAC, TableSpec};
use crate::lanes::mul_unsigned;
use crate::policy::Placement;
use crate::tap::Tap;

/// Fraction bits of the boundary constants.
pub const BOUNDARY_FRAC: u32 = 28;

/// Most boundaries that all lanes are compared with; more are searched lane by lane.
const MOST_COUNTED: usize = 64;

/// The angle table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AngleRom {
    /// Knobs: `entries` over 90°, `order` 0 or 1, `frac` of an entry.
    pub spec: TableSpec,
    /// Where the entries lie.
    pub placement: Placement,
    /// (cos α, sin α) of each bin's entry, ascending, with `spec.frac` bits; with order 1 one more, the
    /// neighbour of the last bin's. Below 0° with order 1 and centres: the first entry's mirror image.
    pub angles: Vec<(i64, i64)>,
    /// (cos θ, sin θ) of the boundaries θ of |2α|, ascending, with `BOUNDARY_FRAC` bits: midway
    /// between the entries (order 0) or at the entries (order 1).
    pub boundaries: Vec<(i64, i64)>,
    /// (cos 2α, sin 2α) of each bin's entry, with `BOUNDARY_FRAC` bits, for order 1.
    pub doubled: Vec<(i64, i64)>,
    /// cot of the step of 2α between entries, for order 1, with `BOUNDARY_FRAC` − 8 bits.
    pub cot_step: i64,
}

/// (cos, sin) of π·k/q for |k|/q ≤ ½.
fn circle(k: i32, q: u32, frac: u32) -> Option<(i64, i64)> {
    let p = k.unsigned_abs();
    let sin = sin_cos(p, q, false, frac)?;
    Some((sin_cos(p, q, true, frac)?, if k < 0 { -sin } else { sin }))
}

impl AngleRom {
    /// Builds the table; `None` where a value cannot be rounded correctly in the series' width.
    #[must_use]
    pub fn new(spec: TableSpec, placement: Placement) -> Option<Self> {
        let n = spec.entries;
        let last = i32::try_from(n).ok()?;
        // In half steps of 2α, which are π/(2n): where the first boundary and the first entry lie.
        let (boundary, entry) = match (spec.order, placement) {
            (0, Placement::Edges) => (1, 0),
            (0, Placement::Centres) => (2, 1),
            (_, Placement::Edges) => (2, 0),
            (_, Placement::Centres) => (1, -1),
        };
        let mut boundaries = Vec::new();
        let mut at = boundary;
        while at < last {
            boundaries.push(circle(at, 2 * n, BOUNDARY_FRAC)?);
            at += 2;
        }
        let bins = i32::try_from(boundaries.len()).ok()? + 1;
        let angle = |bin: i32| circle(2 * bin + entry, 4 * n, spec.frac);
        let stored = if spec.order == 0 { bins } else { bins + 1 };
        let doubled = |bin: i32| circle(2 * bin + entry, 2 * n, BOUNDARY_FRAC);
        // tan of the step 2·90°/n = π/n; n = 2 has one bin of 90°, whose cotangent is 0.
        let (c, s) = circle(1, n, BOUNDARY_FRAC)?;
        Some(Self {
            spec,
            placement,
            angles: (0..stored).map(angle).collect::<Option<_>>()?,
            doubled: if spec.order == 0 {
                Vec::new()
            } else {
                (0..bins).map(doubled).collect::<Option<_>>()?
            },
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

    /// [`AngleRom::index`] of every lane. The boundaries ascend, so that counting those that were passed
    /// gives the same.
    #[inline(always)]
    pub(crate) fn indices<const N: usize, T: Tap>(
        &self,
        n: usize,
        two_b: &[i64; N],
        c_minus_a: &[i64; N],
    ) -> [usize; N] {
        let mut out = [0; N];
        if self.boundaries.len() > MOST_COUNTED {
            for (i, out) in out.iter_mut().enumerate().take(n) {
                *out = self.index(two_b[i], c_minus_a[i]);
            }
            return out;
        }
        for (cos, sin) in &self.boundaries {
            for i in 0..n.min(N) {
                let passed =
                    mul_unsigned::<T>(two_b[i], *cos) > mul_unsigned::<T>(c_minus_a[i], *sin);
                out[i] += usize::from(passed);
            }
        }
        out
    }

    /// Fraction bits of a looked-up value: an entry's, and 30 more where entries are interpolated.
    pub(crate) fn value_frac(&self) -> u32 {
        self.spec.frac + if self.spec.order == 0 { 0 } else { PORT_FRAC }
    }

    /// Table bits: two values an entry and two constants a boundary.
    #[must_use]
    pub fn bits(&self) -> u64 {
        let wide =
            |n: usize, width: u32| u64::try_from(2 * n).unwrap_or(u64::MAX) * u64::from(width);
        wide(self.angles.len(), self.spec.frac + 1)
            + wide(self.boundaries.len() + self.doubled.len(), BOUNDARY_FRAC + 1)
    }
}
