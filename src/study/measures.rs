//! The figures of a point: name, unit and value of each.

use serde_json::{Map, Value, json};

use crate::engine::EngineKind;
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
        &[$(Column { name: $name, unit: $unit, meaning: $meaning }),+]
    };
}

/// The figures that a study has unless it says which, in the order of the results.
pub const COLUMNS: &[Column] = columns! {
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
};

/// Figures that only a study has that names them: they take time of their own, or say little but to a certain question.
pub const ASKED: &[Column] = columns! {
    "max_iterations_share" "" "HIT: share of rays whose search ran out of look-ups";
    "overshot_share" "" "HIT: share of rays with a look-up behind the surface";
    "direction_p99_deg" "degrees" "HIT: 99th percentile of the angle to what the ray really meets";
    "surface_median_deg" "degrees" "HIT: median angle between the found hit and the first one on the impostor's own surface";
    "surface_p95_deg" "degrees" "HIT: 95th percentile";
    "surface_p99_deg" "degrees" "HIT: 99th percentile";
    "surface_max_deg" "degrees" "HIT: the largest";
    "hit_colour_lsb8" "8-bit steps" "HIT: RMS difference of the impostor's colours at the found and at the real hit";
    "footprint_disc_psnr_db" "dB" "HIT: real hits, a Gaussian over the cone's disc, against supersampled rays";
    "footprint_plane_psnr_db" "dB" "HIT: the same over the disc's cut with the wall";
    "footprint_mirror_psnr_db" "dB" "HIT: the same over the mirror's own change of direction";
    "footprint_differential_psnr_db" "dB" "HIT: the same over the hit's change from pixel to pixel";
    "footprint_rays_lsb8" "8-bit steps" "HIT: RMS error of those supersampled rays";
    "requests" "" "fragments, rays or requests that the picture takes";
    "texture_requests" "" "TEX: requests to textures";
    "texture_tiles" "" "TEX: distinct tiles of textures touched, without the environment's";
    "texture_tiles_level_0" "" "TEX: those of level 0";
    "cone_width_median" "" "TEX: median of the cone's relative error in width at textures";
    "cone_lod_median" "levels" "TEX: median error in the level of detail by the cone's registers alone";
    "cone_lod_p95" "levels" "TEX: 95th percentile";
    "cone_lod_p99" "levels" "TEX: 99th percentile";
    "cone_lod_max" "levels" "TEX: the largest";
    "cone_lod_bias" "levels" "TEX: mean of that error with its sign";
    "cone_lod_far_share" "" "TEX: share of requests two levels or more off by the cone's registers alone";
};

macro_rules! by_others {
    ($($name:literal $unit:literal $meaning:literal;)+) => {
        /// Figures of the same rays by other searches; a study names them as well.
        const OTHERS: &[Column] = &[
            $(Column {
                name: concat!("f64_", $name),
                unit: $unit,
                meaning: concat!("HIT, the search of f64: ", $meaning),
            },)+
            $(Column {
                name: concat!("march_", $name),
                unit: $unit,
                meaning: concat!("HIT, a march of 32 steps and 6 halvings: ", $meaning),
            },)+
        ];
    };
}

by_others! {
    "look_ups_per_ray" "" "distance look-ups";
    "converged_share" "" "share of rays that converged";
    "max_iterations_share" "" "share of rays that ran out of look-ups";
    "overshot_share" "" "share of rays with a look-up behind the surface";
    "direction_median_deg" "degrees" "median angle to what the ray really meets";
    "direction_p95_deg" "degrees" "95th percentile";
    "direction_p99_deg" "degrees" "99th percentile";
    "direction_max_deg" "degrees" "the largest";
    "false_far_share" "" "share of rays that converged on a wall behind the one they meet";
    "surface_median_deg" "degrees" "median angle to the first hit on the impostor's own surface";
    "surface_p95_deg" "degrees" "95th percentile";
    "surface_p99_deg" "degrees" "99th percentile";
    "surface_max_deg" "degrees" "the largest";
    "hit_colour_lsb8" "8-bit steps" "RMS difference of the impostor's colours at the found and at the real hit";
}

macro_rules! edges {
    (thin $($ratio:literal)+; jumps $($name:literal $at:literal)+;) => {
        /// Figures of the edges of ENV's input; a study names them as well.
        const EDGES: &[Column] = &[
            $(Column {
                name: concat!("minor_error_", $ratio),
                unit: "",
                meaning: concat!("ENV: worst relative error of the minor axis where the major one is as many times longer: ", $ratio),
            },
            Column {
                name: concat!("thin_line_end_", $ratio),
                unit: "probe widths",
                meaning: concat!("ENV: the farthest that the line's end moves across on such ellipses: ", $ratio),
            },)+
            $(edges!("jump_", $name, "_max_lsb8", "ENV: largest jump of a channel over ", $at),
            edges!("jump_", $name, "_mean_lsb8", "ENV: mean jump over ", $at),
            edges!("jump_f64_", $name, "_max_lsb8", "ENV: f64's largest jump over ", $at),
            edges!("jump_f64_", $name, "_mean_lsb8", "ENV: f64's mean jump over ", $at),)+
        ];
    };
    ($who:literal, $name:literal, $what:literal, $meaning:literal, $at:literal) => {
        Column {
            name: concat!($who, $name, $what),
            unit: "8-bit steps",
            meaning: concat!($meaning, $at),
        }
    };
}

edges! {
    thin 1 3 10 30 100 300 1000 3000 10000 30000;
    jumps "seam" "a face's seam"
        "table" "a break of the angle table of 32 entries"
        "equal" "a circular footprint"
        "count" "one probe more";
}

/// Every figure, in the order of the results.
pub fn columns() -> impl Iterator<Item = &'static Column> {
    [COLUMNS, ASKED, OTHERS, EDGES].into_iter().flatten()
}

/// Whether there is a figure of that name.
#[must_use]
pub fn is_column(name: &str) -> bool {
    columns().any(|c| c.name == name)
}

/// The names of all figures.
#[must_use]
pub fn names() -> Vec<&'static str> {
    columns().map(|c| c.name).collect()
}

/// The figures of one picture by one unit; what does not apply is not there.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measures(Vec<(&'static str, Option<f64>)>);

impl Measures {
    /// Adds a figure. A name that [`columns`] has not is a mistake of this program and shows in tests.
    pub fn put(&mut self, name: &'static str, value: f64) {
        debug_assert!(is_column(name), "{name}");
        self.0.push((name, Some(value)));
    }

    /// Adds a figure that is null where two pictures do not differ.
    pub fn put_db(&mut self, name: &'static str, value: Option<f64>) {
        debug_assert!(is_column(name), "{name}");
        self.0.push((name, value));
    }

    /// Adds a figure of a search: `searcher` is the beginning of its name.
    pub fn put_of(&mut self, searcher: &str, name: &str, value: f64) {
        let found = columns().find(|c| c.name.strip_prefix(searcher) == Some(name));
        debug_assert!(found.is_some(), "{searcher}{name}");
        if let Some(column) = found {
            self.put(column.name, value);
        }
    }

    /// Adds the distance of two pictures.
    pub fn put_pair(&mut self, kind: EngineKind, pair: &Pair) {
        let names = match kind {
            EngineKind::Ewa => ["ewa_psnr_db", "ewa_mean_lsb8", "ewa_share_over_1_lsb8"],
            EngineKind::Truth => ["truth_psnr_db", "truth_mean_lsb8", "truth_share_over_1_lsb8"],
            EngineKind::Rtl | EngineKind::Gpu | EngineKind::Sampler | EngineKind::F64 => {
                ["psnr_db", "mean_lsb8", "share_over_1_lsb8"]
            }
        };
        self.put_db(names[0], pair.psnr_db);
        self.put(names[1], pair.mean_lsb8);
        self.put(names[2], pair.share_over_1_lsb8);
        if kind == EngineKind::F64 {
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

    /// Those of `kept` as JSON, in the order of [`columns`].
    #[must_use]
    pub fn to_json(&self, kept: &[String]) -> Map<String, Value> {
        let mut out = Map::new();
        for column in columns().filter(|column| kept.iter().any(|k| k == column.name)) {
            if let Some((name, value)) = self.0.iter().find(|(name, _)| *name == column.name) {
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
