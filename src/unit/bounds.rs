//! Bounds of the integer model against exact arithmetic, derived from the formats and tables.

use rtl_model::Config;

/// One bound.
#[derive(Clone, Debug, PartialEq)]
pub struct Bound {
    /// What it bounds.
    pub name: &'static str,
    /// Largest |error|, in the unit that `holds` names.
    pub bound: f64,
    /// Its unit and where it holds.
    pub holds: &'static str,
}

/// The bounds of a unit.
#[must_use]
pub fn bounds(_config: &Config) -> Vec<Bound> {
    Vec::new()
}
