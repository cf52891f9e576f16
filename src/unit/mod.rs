//! The unit as a user sees it: every choice under a path, a default, a file format.
//!
//! [`UnitSpec`] holds the integer model's [`rtl_model::Config`] and, next to it, the numbers that the
//! float engines use as they were written (the roughness scale and the rotation in doubles).

pub mod bounds;
pub mod file;
pub mod knobs;

use fixed::types::{I40F24, I44F20};
use rtl_model::cone::StoreRounding;
use rtl_model::unit::{HitUnit, Needs, TexUnit};
use rtl_model::{Config, ConfigError, Unit};

use crate::base::hash;
use crate::error::InputError;
use crate::policy::{Axis, ConeEnv, ConeGradient, ConeRules, SetDiffuse};
use crate::settings::{AngleTable, IDENTITY, Settings};

/// Which axis the float reference uses where the unit's is the table's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum ReferenceAxis {
    /// The eigenvector itself.
    Exact,
    /// The same table entries: what is left is the words' error.
    Table,
}

/// A unit: formats, tables and policies.
#[derive(Clone, Debug, PartialEq)]
pub struct UnitSpec {
    /// The configuration of the integer model.
    pub config: Config,
    /// s in K = D Dᵀ + s² K3, as written.
    pub roughness_scale: f64,
    /// Rotation of the environment, row by row, as written; `None` is the identity.
    pub rotation: Option<[[f64; 3]; 3]>,
}

/// √12: the scale at which box length and standard deviation have the same second moment.
pub const SQRT_12: f64 = 3.464_101_615_137_754_6;

impl Default for UnitSpec {
    fn default() -> Self {
        let mut spec = Self { config: Config::default(), roughness_scale: 1.0, rotation: None };
        spec.set_scale(SQRT_12);
        spec
    }
}

impl UnitSpec {
    /// Names of the presets.
    pub const PRESETS: [&'static str; 3] = ["default", "schilling", "otk"];

    /// A preset: `default`, `schilling` (ten angle entries and roughness scale 1, as in the paper), or `otk`
    /// (ray cones as OptiX Toolkit's code treats them: truncating stores, its rules, the angle and width of a
    /// diffuse scatter exchanged, the note's gradients).
    #[must_use]
    pub fn preset(name: &str) -> Option<Self> {
        let mut spec = Self::default();
        match name {
            "default" => {}
            "schilling" => {
                spec.config.tables.eigen.entries = 10;
                spec.set_scale(1.0);
            }
            "otk" => {
                let cone = &mut spec.config.policy.cone;
                cone.rounding = StoreRounding::Truncate;
                cone.rules = ConeRules::Otk;
                cone.set_diffuse = SetDiffuse::Exchanged;
                cone.gradient = ConeGradient::Otk;
                cone.env = ConeEnv::Otk;
            }
            _ => return None,
        }
        Some(spec)
    }

    /// The unit with a knob set as `--set` does: `path=value`.
    ///
    /// # Errors
    /// No such path, or a value that it does not take: the message has the path, what is legal and what was given.
    pub fn with(self, set: &str) -> Result<Self, InputError> {
        file::set(self, set)
    }

    /// Sets s for every engine; the integer model takes it to the nearest 2^−20.
    pub fn set_scale(&mut self, scale: f64) {
        self.roughness_scale = scale;
        self.config.roughness_scale = I44F20::saturating_from_num(scale).to_bits();
    }

    /// Sets the rotation for every engine; the integer model takes it to the nearest 2^−24.
    pub fn set_rotation(&mut self, rotation: Option<[[f64; 3]; 3]>) {
        self.rotation = rotation;
        self.config.rotation =
            rotation.map(|a| a.map(|row| row.map(|x| I40F24::saturating_from_num(x).to_bits())));
    }

    /// The policies that the float engines honour.
    #[must_use]
    pub fn settings(&self, reference_axis: ReferenceAxis) -> Settings {
        let Config { tables, policy, .. } = &self.config;
        let table = AngleTable {
            entries: tables.eigen.entries,
            placement: policy.eigen.placement,
            order: tables.eigen.order,
        };
        let by_table = policy.footprint.axis == Axis::EigenTable;
        Settings {
            policy: policy.shared(),
            roughness_scale: self.roughness_scale,
            rotation: self.rotation.unwrap_or(IDENTITY),
            reference_table: (by_table && reference_axis == ReferenceAxis::Table).then_some(table),
        }
    }

    /// Identity of the unit: FNV-1a of its file text.
    #[must_use]
    pub fn hash(&self) -> String {
        hash::hash_text(hash::text_hash(&file::to_toml(self)))
    }
}

/// Face sizes that a unit must be able to serve.
const FACES: [u32; 2] = [1, 16384];

/// Whether the unit can be exact inside with every stage built.
///
/// # Errors
/// The model's refusal, by the register's or the knob's path.
pub fn check(spec: &UnitSpec) -> Result<(), InputError> {
    for size in FACES {
        for all in [true, false] {
            let needs = Needs { bump: all, rough: all };
            Unit::new(&spec.config, needs, size).map_err(refused)?;
        }
        HitUnit::new(&spec.config, size).map_err(refused)?;
        TexUnit::new(&spec.config, [size, 1]).map_err(refused)?;
    }
    Ok(())
}

/// The model's refusal, in the shape of every input error.
#[must_use]
pub fn refused(error: ConfigError) -> InputError {
    InputError::new(
        "unit",
        error.expected,
        error.found,
        "shorten the register's words (or those that feed it), or take the default of `tapline unit show`",
    )
    .at(error.path)
}
