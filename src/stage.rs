//! The stages of the unit. A stage has one name in every implementation, vector file and document.

/// A stage of the unit, in pipeline order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Stage {
    /// Tangent vectors e1, e2 of the surface, from the normal and the main direction h.
    LocalFrame,
    /// The normal moved by the bump map's offsets.
    Bump,
    /// The reflected direction.
    Reflect,
    /// Face, reciprocal of the major component, coordinates on the face.
    CubeFace,
    /// Derivatives of the face coordinates by screen position: the matrix D.
    Jacobian,
    /// The roughness ellipse B carried to the face: B'.
    Roughness,
    /// Angle and width of a ray cone on its way.
    RayCone,
    /// A ray's hit with the surface of a distance map.
    Hit,
    /// A cone's footprint on a textured surface: ddx, ddy and D.
    SurfaceFootprint,
    /// K = D Dᵀ + s² B' B'ᵀ with one shared exponent.
    Covariance,
    /// Lengths and direction of the ellipse's axes.
    Eigen,
    /// Probe count, probe width, level of detail and step.
    Footprint,
    /// Texel addresses and weights of one probe.
    Address,
    /// Weighted sums of texels and the output register.
    Filter,
}

impl Stage {
    /// Every stage, in pipeline order.
    pub const ALL: [Self; 14] = [
        Self::LocalFrame,
        Self::Bump,
        Self::Reflect,
        Self::CubeFace,
        Self::Jacobian,
        Self::Roughness,
        Self::RayCone,
        Self::Hit,
        Self::SurfaceFootprint,
        Self::Covariance,
        Self::Eigen,
        Self::Footprint,
        Self::Address,
        Self::Filter,
    ];

    /// The stage's name: file name, function name, vector name, document name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::LocalFrame => "local_frame",
            Self::Bump => "bump",
            Self::Reflect => "reflect",
            Self::CubeFace => "cube_face",
            Self::Jacobian => "jacobian",
            Self::Roughness => "roughness",
            Self::RayCone => "ray_cone",
            Self::Hit => "hit",
            Self::SurfaceFootprint => "surface_footprint",
            Self::Covariance => "covariance",
            Self::Eigen => "eigen",
            Self::Footprint => "footprint",
            Self::Address => "address",
            Self::Filter => "filter",
        }
    }
}
