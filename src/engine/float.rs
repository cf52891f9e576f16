//! The float engines: `f64`, `ewa` and `truth`. Each operation's job says how they render it.

use crate::settings::Settings;
use crate::truth::TruthOptions;

/// The float reference of the same algorithm.
#[derive(Clone, Debug)]
pub struct F64Engine {
    /// Policies.
    pub settings: Settings,
}

/// The elliptical Gaussian over level 0.
#[derive(Clone, Debug)]
pub struct EwaEngine {
    /// Policies; the footprint is the float reference's.
    pub settings: Settings,
}

/// Supersampled rays.
#[derive(Clone, Debug)]
pub struct TruthEngine {
    /// Policies: only the environment's rotation and how textures repeat matter.
    pub settings: Settings,
    /// Samples and seed.
    pub options: TruthOptions,
}
