//! The subject of a test: a stage, or one of the unit's three operations as a whole.

use crate::error::InputError;
use crate::stage::Stage;

/// A stage or an operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Subject {
    /// One stage.
    Stage(Stage),
    /// ENV from the ports to the colour.
    Env,
    /// HIT from the ports to the colour.
    Hit,
    /// TEX from the ports to the colour.
    Tex,
}

impl Subject {
    /// Every subject: the stages in pipeline order, then the operations.
    pub fn all() -> impl Iterator<Item = Self> {
        Stage::ALL.into_iter().map(Self::Stage).chain([Self::Env, Self::Hit, Self::Tex])
    }

    /// The name on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Stage(stage) => stage.name(),
            Self::Env => "unit",
            Self::Hit => "unit-hit",
            Self::Tex => "unit-tex",
        }
    }

    /// The subject of that name.
    pub fn parse(name: &str) -> Result<Self, InputError> {
        Self::all().find(|s| s.name() == name).ok_or_else(|| {
            let names: Vec<&str> = Self::all().map(Self::name).collect();
            InputError::new(
                "STAGE",
                format!("one of {}", names.join(", ")),
                format!("`{name}`"),
                "choose a stage, or `unit` for the whole ENV operation",
            )
        })
    }

    /// The stages that a vector of it shows.
    #[must_use]
    pub fn stages(self) -> Vec<Stage> {
        use Stage as S;
        const BACK: [S; 5] = [S::Covariance, S::Eigen, S::Footprint, S::Address, S::Filter];
        match self {
            Self::Stage(stage) => vec![stage],
            Self::Env => Stage::ALL
                .into_iter()
                .filter(|s| !matches!(s, S::RayCone | S::Hit | S::SurfaceFootprint))
                .collect(),
            Self::Hit => [S::Hit, S::CubeFace, S::Jacobian].into_iter().chain(BACK).collect(),
            Self::Tex => [S::SurfaceFootprint].into_iter().chain(BACK).collect(),
        }
    }
}
