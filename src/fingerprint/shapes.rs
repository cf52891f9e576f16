//! Shapes of filters: the texels read beyond edges and corners of a cube, and the taps of a footprint.

use super::aniso::{Count, LodRule};
use crate::base::named::named;
use crate::sampler::{Shape, Source};

named! {
    /// The texels read beyond a cube's edge.
    pub enum Seam {
        /// The neighbouring face's texels.
        Neighbour = "the neighbouring face's texels",
        /// The face's own edge again.
        Clamped = "the face's own edge again",
    }
}

named! {
    /// What takes the place of the texel that a cube's corner does not have.
    pub enum Corner {
        /// The mean of the other three (D3D's rule).
        Mean = "the mean of the other three texels",
        /// Nothing: the other three weights are scaled to sum to 1.
        Rescaled = "nothing: the other three weights are scaled to sum to 1",
        /// The look-up's own face's corner texel.
        Own = "the own face's corner texel once more",
        /// The texel across the vertical edge.
        Beside = "the texel across the vertical edge once more",
        /// The texel across the horizontal edge.
        Below = "the texel across the horizontal edge once more",
    }
}

named! {
    /// How far apart the taps of a line are, as a share of the longer derivative.
    pub enum Spacing {
        /// 1/n: each tap stands for an equal part of the line.
        Parts = "longer/taps",
        /// 1/(n + 1): Vulkan's example.
        Between = "longer/(taps + 1)",
        /// 1/(n − 1): the outer taps lie on the line's ends.
        Ends = "longer/(taps - 1)",
    }
}

impl Spacing {
    /// The distance as a share of the longer derivative.
    #[must_use]
    pub fn share(self, taps: f64) -> f64 {
        match self {
            Self::Parts => 1.0 / taps,
            Self::Between => 1.0 / (taps + 1.0),
            Self::Ends => 1.0 / (taps - 1.0).max(1.0),
        }
    }
}

/// The taps of an elongated footprint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Line {
    /// One tap at the centre.
    Single,
    /// Equal weights along the longer length.
    Taps(Count, Spacing),
    /// No taps: every texel of one level inside Heckbert's ellipse, A = t_x² + t_y² + 1, B = −2(s_x t_x + s_y t_y),
    /// C = s_x² + s_y² + 1, with weight e^(−2q), q = (A s² + B s t + C t²)/(A C − B²/4) below 1. Beyond a cube's edge it reads
    /// what the seam says, whatever the bilinear filter does there.
    Ellipse(Seam),
}

impl Line {
    /// Every line; seams matter on cubes alone.
    #[must_use]
    pub fn all(shape: Shape) -> Vec<Self> {
        let mut all = vec![Self::Single, Self::Ellipse(Seam::Clamped)];
        if shape == Shape::Cube {
            all.push(Self::Ellipse(Seam::Neighbour));
        }
        for count in Count::ALL {
            all.extend(Spacing::ALL.map(|spacing| Self::Taps(count, spacing)));
        }
        all
    }

    /// In few words.
    #[must_use]
    pub fn short(self) -> String {
        match self {
            Self::Single => "one bilinear tap".into(),
            Self::Taps(count, spacing) => {
                format!("taps: {}, {} apart", count.name(), spacing.name())
            }
            Self::Ellipse(_) => "all texels in Heckbert's ellipse, exp(-2q)".into(),
        }
    }

    /// In words.
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Self::Single => "one bilinear tap at the centre".into(),
            Self::Taps(count, spacing) => format!(
                "bilinear taps of equal weight, {} of them, {} apart",
                count.name(),
                spacing.name()
            ),
            Self::Ellipse(seam) => format!(
                "no taps: all texels inside Heckbert's ellipse, widened by one texel, weight exp(-2q); beyond an edge {}",
                seam.name()
            ),
        }
    }
}

/// Level of detail and line of one kind of look-up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Rule {
    /// Kind of texture.
    pub shape: Shape,
    /// Where the derivatives come from.
    pub source: Source,
    /// Largest anisotropy.
    pub clamp: u16,
    /// Level of detail.
    pub lod: LodRule,
    /// Taps.
    pub line: Line,
}
