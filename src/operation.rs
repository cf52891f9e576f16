//! The unit's three operations, and the stages that each of them runs.

pub use rtl_model::unit::Needs;

use crate::stage::Stage;

/// What the unit must be able to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operation {
    /// Reflections.
    Env(Needs),
    /// Rays against a distance map.
    Hit,
    /// Textures and an environment through ray cones.
    Tex,
}

impl Operation {
    /// The name in lists and files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Env(_) => "env",
            Self::Hit => "hit",
            Self::Tex => "tex",
        }
    }

    /// Whether it runs a stage.
    #[must_use]
    pub const fn runs(self, stage: Stage) -> bool {
        match (stage, self) {
            (Stage::LocalFrame, Self::Env(needs)) => needs.frame(),
            (Stage::Bump, Self::Env(needs)) => needs.bump,
            (Stage::Roughness, Self::Env(needs)) => needs.rough,
            (Stage::Reflect, _) => matches!(self, Self::Env(_)),
            (Stage::RayCone, _) => !matches!(self, Self::Env(_)),
            (Stage::Hit, _) => matches!(self, Self::Hit),
            (Stage::SurfaceFootprint, _) => matches!(self, Self::Tex),
            (Stage::LocalFrame | Stage::Bump | Stage::Roughness, Self::Hit | Self::Tex) => false,
            (
                Stage::CubeFace
                | Stage::Jacobian
                | Stage::Covariance
                | Stage::Eigen
                | Stage::Footprint
                | Stage::Address
                | Stage::Filter,
                _,
            ) => true,
        }
    }

    /// The stages that it runs, in pipeline order.
    #[must_use]
    pub fn stages(self) -> Vec<Stage> {
        Stage::ALL.into_iter().filter(|stage| self.runs(*stage)).collect()
    }
}
