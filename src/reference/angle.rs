//! The angle table as the float reference uses it: exact cosines and sines at the table's entries.

use std::f64::consts::FRAC_PI_2;

use crate::policy::Placement;
use crate::settings::AngleTable;

/// Entries and bin boundaries over 0 ≤ |2α| ≤ 90°; the other half of the table is its mirror image.
#[derive(Clone, Debug)]
pub struct Angles {
    order: u32,
    /// Cosine and sine of 2α at the bin boundaries, ascending.
    boundaries: Vec<[f64; 2]>,
    /// Cosine and sine of α of the entry of each bin, and of the entry after the last.
    entries: Vec<[f64; 2]>,
    /// Cosine and sine of 2α of the entry of each bin; tangent of the step in 2α.
    doubled: Vec<[f64; 2]>,
    tan_step: f64,
}

/// Cosine and sine, exact at 0.
fn circle(angle: f64) -> [f64; 2] {
    [libm::cos(angle), libm::sin(angle)]
}

impl Angles {
    /// The entries of a table. Fewer than 2 entries count as 2, an odd number as the even one above.
    #[must_use]
    pub fn new(table: AngleTable) -> Self {
        let half = table.entries.clamp(2, 1 << 20).div_ceil(2);
        // Angles are multiples of half a step; the step in 2α is 180°/n = 90°/(n/2).
        let half_step = FRAC_PI_2 / f64::from(half) / 2.0;
        // First boundary, and first entry, in half steps: bins are two half steps wide.
        let (boundary, entry) = match (table.order, table.placement) {
            (0, Placement::Edges) => (1.0, 0.0),
            (0, Placement::Centres) => (2.0, 1.0),
            (_, Placement::Edges) => (2.0, 0.0),
            (_, Placement::Centres) => (1.0, -1.0),
        };
        let boundaries: Vec<_> = (0..half)
            .map(|j| f64::from(2 * j) + boundary)
            .filter(|&at| at < f64::from(2 * half))
            .map(|at| circle(at * half_step))
            .collect();
        let at = |j: usize| (2.0 * j as f64 + entry) * half_step;
        Self {
            order: table.order,
            entries: (0..boundaries.len() + 2).map(|j| circle(at(j) / 2.0)).collect(),
            doubled: (0..boundaries.len() + 1).map(|j| circle(at(j))).collect(),
            tan_step: libm::tan(2.0 * half_step),
            boundaries,
        }
    }

    /// What a float engine of its own needs: bin boundaries of 2α, then the bins' entries of α and the one after the
    /// last, then the entries' 2α; order and tan of a step of 2α. Boundaries are one less than bins.
    #[must_use]
    pub fn parts(&self) -> (Vec<[f64; 2]>, usize, u32, f64) {
        let rows = [&self.boundaries, &self.entries, &self.doubled];
        let flat = rows.into_iter().flatten().copied().collect();
        (flat, self.boundaries.len(), self.order, self.tan_step)
    }

    /// Cosine and sine of |α| from those of |2α|: the nearest entry (order 0, a tie goes to the entry
    /// nearer to 0°), or the two neighbours mixed by tan(2α − 2θ)/tan(step), θ the entry nearer to 0°,
    /// without normalising the result (order 1).
    #[must_use]
    pub fn look_up(&self, [cos, sin]: [f64; 2]) -> [f64; 2] {
        let bin = self.boundaries.partition_point(|[c, s]| sin * c > cos * s);
        let [low_cos, low_sin] = self.entries[bin];
        if self.order == 0 {
            return [low_cos, low_sin];
        }
        let [c, s] = self.doubled[bin];
        let fraction = ((sin * c - cos * s) / (cos * c + sin * s) / self.tan_step).clamp(0.0, 1.0);
        let [high_cos, high_sin] = self.entries[bin + 1];
        [low_cos + (high_cos - low_cos) * fraction, low_sin + (high_sin - low_sin) * fraction]
    }
}
