//! The eigen-angle table: sines and cosines of α, and the bin boundaries of 2α.
//!
//! By symmetry the table holds the angles |α| ≤ 45° and the sign is applied to the sine. The bin of
//! |2b|/|c − a| = tan|2α| is found without a division or an arctangent: boundary θ is passed where
//! |2b|·cos θ > |c − a|·sin θ.

use alloc::vec::Vec;

use lanes::{Mask as _, Vector};

use super::contents::sin_cos;
use super::rom::{PORT_FRAC, TableSpec};
use crate::policy::Placement;

/// Fraction bits of the boundary constants.
pub const BOUNDARY_FRAC: u32 = 28;

/// Most boundaries that all lanes are compared with; more are searched.
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
    pub angles: Vec<[i64; 2]>,
    /// (cos θ, sin θ) of the boundaries θ of |2α|, ascending, with `BOUNDARY_FRAC` bits: midway
    /// between the entries (order 0) or at the entries (order 1).
    pub boundaries: Vec<[i64; 2]>,
    /// (cos 2α, sin 2α) of each bin's entry, with `BOUNDARY_FRAC` bits, for order 1.
    pub doubled: Vec<[i64; 2]>,
    /// cot of the step of 2α between entries, for order 1, with `BOUNDARY_FRAC` − 8 bits.
    pub cot_step: i64,
}

/// The pair at these places; zeros beyond the table.
#[inline(always)]
pub(crate) fn pair<V: Vector>(table: &[[i64; 2]], at: V) -> [V; 2] {
    let (table, at) = (table.as_flattened(), at.up(1));
    [at.look_up(table), at.plus(1).look_up(table)]
}

/// (cos, sin) of π·k/q for |k|/q ≤ ½.
fn circle(k: i32, q: u32, frac: u32) -> Option<[i64; 2]> {
    let p = k.unsigned_abs();
    let sin = sin_cos(p, q, false, frac)?;
    Some([sin_cos(p, q, true, frac)?, if k < 0 { -sin } else { sin }])
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
        let [c, s] = circle(1, n, BOUNDARY_FRAC)?;
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
    /// A ratio exactly on a boundary (as its constants are rounded) belongs to the lower entry. The boundaries
    /// ascend, so that counting those that were passed gives the same as a search for the last one.
    #[inline(always)]
    #[must_use]
    pub fn index<V: Vector>(&self, two_b: V, c_minus_a: V) -> V {
        let mut low = two_b.like(0);
        if self.boundaries.len() <= MOST_COUNTED {
            for [cos, sin] in &self.boundaries {
                let (cos, sin) = (low.like(*cos), low.like(*sin));
                let passed = two_b.mul_unsigned(cos).gt(c_minus_a.mul_unsigned(sin));
                low = passed.select(low.plus(1), low);
            }
            return low;
        }
        for bit in (0..=self.boundaries.len().ilog2()).rev() {
            let more = low.plus(1 << bit);
            // Beyond the last boundary there are zeros, which nothing passes.
            let [cos, sin] = pair(&self.boundaries, more.plus(-1));
            let passed = two_b.mul_unsigned(cos).gt(c_minus_a.mul_unsigned(sin));
            low = passed.select(more, low);
        }
        low
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
