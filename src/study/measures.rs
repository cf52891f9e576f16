//! The figures of a point: what each is called, its unit, and its value.

use serde_json::{Map, Value, json};

use crate::engine::Rung;
use crate::report::metrics::Pair;

/// A figure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Column {
    /// Its name in results.
    pub name: &'static str,
    /// Its unit; empty for a share or a count.
    pub unit: &'static str,
    /// What it says.
    pub meaning: &'static str,
}

macro_rules! columns {
    ($($name:literal $unit:literal $meaning:literal;)+) => {
        /// Every figure, in the order of the results.
        pub const COLUMNS: &[Column] = &[$(Column { name: $name, unit: $unit, meaning: $meaning }),+];
    };
}

columns! {
    "psnr_db" "dB" "PSNR against f64; null where no shown value differs";
    "max_lsb8" "8-bit steps" "largest difference from f64";
    "mean_lsb8" "8-bit steps" "mean difference from f64";
    "share_over_1_lsb8" "" "share of fragments more than one 8-bit step from f64";
    "max_abs" "" "largest difference from f64, 0 to 1";
    "rel_mse" "" "relative mean square error against f64, linear";
    "ewa_psnr_db" "dB" "PSNR against the elliptical Gaussian";
    "ewa_mean_lsb8" "8-bit steps" "mean difference from the elliptical Gaussian";
    "ewa_share_over_1_lsb8" "" "share of fragments more than one step from the elliptical Gaussian";
    "truth_psnr_db" "dB" "PSNR against supersampled rays";
    "truth_mean_lsb8" "8-bit steps" "mean difference from supersampled rays";
    "truth_share_over_1_lsb8" "" "share of fragments more than one step from supersampled rays";
    "axis_p95_deg" "degrees" "95th percentile of the probe line's turn against f64's, where f64 has two probes or more";
    "axis_max_deg" "degrees" "the largest turn";
    "line_end_p95" "ellipse widths" "95th percentile of how far the line's end moves across, in widths of the ellipse (at least a texel)";
    "line_end_max" "ellipse widths" "the largest move";
    "lod_p95" "levels" "95th percentile of the level of detail's error";
    "lod_max" "levels" "the largest";
    "count_differs" "" "share of requests with another number of probes";
    "look_ups_per_ray" "" "HIT: distance look-ups of the search's loop";
    "converged_share" "" "HIT: share of rays whose search converged";
    "direction_median_deg" "degrees" "HIT: median angle between the found hit and what the ray really meets";
    "direction_p95_deg" "degrees" "HIT: 95th percentile";
    "direction_max_deg" "degrees" "HIT: the largest";
    "false_far_share" "" "HIT: share of rays that converged on a wall behind the one they meet";
    "cone_width_p95" "" "TEX: 95th percentile of the cone's relative error in width at textures";
    "cone_width_max" "" "TEX: the largest";
    "flagged_share" "" "flags raised per fragment: overflows and events";
    "probes_per_fragment" "" "trilinear probes";
    "texels_per_fragment" "" "texels read";
    "tiles" "" "distinct tiles of 64x64 texels touched";
    "cache_hit_share" "" "share of the cache's line requests that hit";
    "cycles_per_fragment" "cycles" "cycles in steady state, see docs/cost.md";
    "gates" "gate equivalents" "logic and registers of the unit that the scene needs";
    "logic_gates" "gate equivalents" "multipliers, adders and shifters";
    "multiplier_bits" "bits" "sum over multipliers of the product of their operands' widths";
    "rom_bits" "bits" "tables";
    "register_bits" "bits" "named registers, pipeline copies and accumulators that are modelled";
    "unmodelled" "" "parts that the cost model lists as not modelled";
}

/// Whether there is a figure of that name.
#[must_use]
pub fn is_column(name: &str) -> bool {
    COLUMNS.iter().any(|c| c.name == name)
}

/// The names of all figures.
#[must_use]
pub fn names() -> Vec<&'static str> {
    COLUMNS.iter().map(|c| c.name).collect()
}

/// The figures of one picture by one unit; what does not apply is not there.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measures(Vec<(&'static str, Option<f64>)>);

impl Measures {
    /// Adds a figure. A name that [`COLUMNS`] has not is a mistake of this program and shows in tests.
    pub fn put(&mut self, name: &'static str, value: f64) {
        debug_assert!(is_column(name), "{name}");
        self.0.push((name, Some(value)));
    }

    /// Adds the distance of two pictures.
    pub fn put_pair(&mut self, rung: Rung, pair: &Pair) {
        let names = match rung {
            Rung::Ewa => ["ewa_psnr_db", "ewa_mean_lsb8", "ewa_share_over_1_lsb8"],
            Rung::Truth => ["truth_psnr_db", "truth_mean_lsb8", "truth_share_over_1_lsb8"],
            Rung::Rtl | Rung::Gpu | Rung::Sampler | Rung::F64 => {
                ["psnr_db", "mean_lsb8", "share_over_1_lsb8"]
            }
        };
        self.0.push((names[0], pair.psnr_db));
        self.put(names[1], pair.mean_lsb8);
        self.put(names[2], pair.share_over_1_lsb8);
        if rung == Rung::F64 {
            self.put("max_lsb8", pair.max_lsb8);
            self.put("max_abs", pair.max_abs);
            self.put("rel_mse", pair.rel_mse);
        }
    }

    /// A figure; none where it does not apply or is null.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<f64> {
        self.0.iter().find(|(n, _)| *n == name).and_then(|(_, v)| *v)
    }

    /// As JSON in the order of [`COLUMNS`], those of `kept` alone unless it is empty.
    #[must_use]
    pub fn to_json(&self, kept: &[String]) -> Map<String, Value> {
        let mut out = Map::new();
        for column in COLUMNS {
            let wanted = kept.is_empty() || kept.iter().any(|k| k == column.name);
            let found = self.0.iter().find(|(name, _)| *name == column.name);
            if let (true, Some((name, value))) = (wanted, found) {
                out.insert((*name).into(), value.map_or(Value::Null, number));
            }
        }
        out
    }
}

/// A number without a fraction is written as a whole one.
fn number(x: f64) -> Value {
    #[expect(clippy::cast_possible_truncation, reason = "whole numbers below 2^53")]
    if x.fract() == 0.0 && x.abs() < 9e15 { json!(x as i64) } else { json!(x) }
}
