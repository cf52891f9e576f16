//! The choices that every engine honours, as the float engines see them.

use crate::policy::{
    Axis, ConeRules, Count, Curvature, Dnmod, HitPolicy, Minor, Placement, RoughnessInterpolation,
    SetDiffuse, TexPolicy, Weights,
};

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
    /// Most probes that a fragment may take.
    pub max_probes: u32,
    /// Rule of the probe count.
    pub count: Count,
    /// Direction of the probe line.
    pub axis: Axis,
    /// Probe weights.
    pub weights: Weights,
    /// Bits of the gaussian probe weights: they are integers that sum to 2^bits in every engine.
    pub probe_weight_bits: u32,
    /// s in K = D Dᵀ + s² K3.
    pub roughness_scale: f64,
    /// What the roughness pyramid interpolates.
    pub roughness_interpolation: RoughnessInterpolation,
    /// Where the bump map's own curvature goes.
    pub roughness_curvature: Curvature,
    /// How λ2 is found.
    pub minor: Minor,
    /// What stands for ∂n_mod.
    pub dnmod: Dnmod,
    /// The HIT operation's choices.
    pub hit: HitPolicy,
    /// The TEX operation's choices.
    pub tex: TexPolicy,
    /// Whose rules of a ray cone hold.
    pub cone_rules: ConeRules,
    /// What a diffuse scatter writes under OptiX Toolkit's rules.
    pub set_diffuse: SetDiffuse,
    /// Rotation of the environment, row by row.
    pub rotation: [[f64; 3]; 3],
    /// The angle table, used where `axis` is `EigenTable` and the reference was asked for the table's
    /// axis; `None` means the exact axis.
    pub reference_table: Option<AngleTable>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            max_probes: 16,
            count: Count::default(),
            axis: Axis::default(),
            weights: Weights::default(),
            probe_weight_bits: 8,
            roughness_scale: 1.0,
            roughness_interpolation: RoughnessInterpolation::default(),
            roughness_curvature: Curvature::default(),
            minor: Minor::default(),
            dnmod: Dnmod::default(),
            hit: HitPolicy::default(),
            tex: TexPolicy::default(),
            cone_rules: ConeRules::default(),
            set_diffuse: SetDiffuse::default(),
            rotation: IDENTITY,
            reference_table: None,
        }
    }
}
