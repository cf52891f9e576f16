//! Settings with the tables that depend on them alone.

use super::angle::Angles;
use super::real::saturate;
use super::weights::{probe_weights, spreads};
use crate::policy::{Axis, Weights};
use crate::settings::Settings;

/// Most probes that the reference takes, whatever the settings say.
pub const MOST_PROBES: u32 = 1024;

/// Settings, ready for any number of fragments.
#[derive(Clone, Debug)]
pub struct Prepared {
    settings: Settings,
    rotated: bool,
    angles: Option<Angles>,
    /// Weights of 1, 2, 3, … probes one after the other; empty where all weigh the same.
    weights: Vec<u32>,
    spreads: Vec<f64>,
}

impl Prepared {
    /// Builds the tables. Non-finite numbers in the settings become finite ones, and `max_probes` is
    /// clamped to 1 … [`MOST_PROBES`]: units are checked elsewhere.
    #[must_use]
    pub fn new(settings: &Settings) -> Self {
        let mut settings = settings.clone();
        let policy = &mut settings.policy.footprint;
        policy.max_probes = policy.max_probes.clamp(1, MOST_PROBES);
        let policy = *policy;
        settings.roughness_scale = finite(settings.roughness_scale).0;
        settings.rotation = settings.rotation.map(|row| row.map(|x| finite(x).0));
        let identity = Settings::default().rotation;
        let rotated = settings.rotation != identity;
        let angles =
            settings.reference_table.filter(|_| policy.axis == Axis::EigenTable).map(Angles::new);
        let weights = match policy.weights {
            Weights::Box => Vec::new(),
            Weights::Gaussian | Weights::Bell => {
                (1..=policy.max_probes).flat_map(|count| probe_weights(count, &policy)).collect()
            }
        };
        let spreads = spreads(&policy);
        Self { settings, rotated, angles, weights, spreads }
    }

    /// The settings.
    #[must_use]
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The rotation, unless it is the identity.
    pub(super) fn rotation(&self) -> Option<&[[f64; 3]; 3]> {
        self.rotated.then_some(&self.settings.rotation)
    }

    /// The angle table, where the axis comes from one.
    pub(super) fn angles(&self) -> Option<&Angles> {
        self.angles.as_ref()
    }

    /// V_n of 1, 2, 3, … probes; empty where the policy does not need it.
    pub(super) fn spreads(&self) -> &[f64] {
        &self.spreads
    }

    /// The weight of a probe.
    pub(super) fn weight(&self, index: u32, count: u32) -> u32 {
        let before = count as usize * (count as usize - 1) / 2;
        self.weights.get(before + index as usize).copied().unwrap_or(1)
    }
}

/// The value as a finite number (NaN becomes 0) without −0, and whether it had to change.
pub(super) fn finite(value: f64) -> (f64, bool) {
    if value.is_nan() { (0.0, true) } else { (saturate(value), value.is_infinite()) }
}
