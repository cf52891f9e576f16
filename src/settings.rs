//! The choices that every engine honours, as the float engines see them.

use crate::policy::{Placement, Policy};

/// The rotation that turns nothing, row by row.
pub const IDENTITY: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// The angle table as the float reference uses it under `--reference-axis table`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AngleTable {
    /// Entries over 90° (even).
    pub entries: u32,
    /// Where the entries lie in their bins.
    pub placement: Placement,
    /// 0: nearest entry; 1: linear between entries.
    pub order: u32,
}

/// The policies of a unit. Words, roundings and table contents are not here: floats ignore them.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Knobs; those that float engines do not honour have their defaults.
    pub policy: Policy,
    /// s in K = D Dᵀ + s² K3.
    pub roughness_scale: f64,
    /// Rotation of the environment, row by row.
    pub rotation: [[f64; 3]; 3],
    /// The angle table, used where `footprint.axis` is `eigen-table` and the reference was asked for the table's
    /// axis; `None` means the exact axis.
    pub reference_table: Option<AngleTable>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            policy: Policy::default(),
            roughness_scale: 1.0,
            rotation: IDENTITY,
            reference_table: None,
        }
    }
}

impl Settings {
    /// The same with other knobs.
    #[must_use]
    pub fn with(mut self, change: impl FnOnce(&mut Policy)) -> Self {
        change(&mut self.policy);
        self
    }
}
