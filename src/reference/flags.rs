//! The flags that a fragment can set.

use std::fmt;

/// A set of the flags that a fragment raised.
#[derive(Clone, Copy, Default, PartialEq, Eq, Hash)]
pub struct Flags(u16);

/// A flag of the float reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum Flag {
    /// An input was NaN (taken as 0) or infinite (taken as ±`f64::MAX`).
    NonFinite,
    /// h is parallel to n, or one of them is zero: any orthogonal pair was taken.
    Parallel,
    /// The reflected direction is zero: face +z, u = v = 0, D = 0.
    Zero,
    /// An entry of D is beyond the largest double.
    DerivativesSaturated,
    /// An entry of K is beyond the largest double (λ may still be right).
    CovarianceSaturated,
    /// λ1 or λ2 is beyond the largest double.
    LambdaSaturated,
    /// The length in texels is beyond the largest double.
    LengthSaturated,
    /// A number of a ray was NaN (taken as 0) or infinite (taken as ±`f64::MAX`).
    HitNotFinite,
    /// R = 0: (0, 0, 1) was taken.
    HitNoDirection,
    /// The wall has no plane at the hit: the footprint is the disc's.
    HitNoPlane,
    /// A step went beyond the reference surface.
    HitOvershoot,
    /// The ray parameter, or a component of the hit, is beyond the largest double.
    HitSaturated,
    /// A number of a texture request was NaN (taken as 0) or infinite (taken as ±`f64::MAX`).
    SurfNotFinite,
    /// D ∥ N, or one of them 0: any orthogonal pair was taken.
    SurfParallel,
    /// ∂P/∂s × ∂P/∂t = 0: the dot products' form was taken.
    SurfDegenerate,
    /// An entry of D on a texture is beyond the largest double.
    SurfSaturated,
}

impl Flag {
    /// Every flag, in pipeline order.
    pub const ALL: [Self; 16] = [
        Self::NonFinite,
        Self::Parallel,
        Self::Zero,
        Self::DerivativesSaturated,
        Self::CovarianceSaturated,
        Self::LambdaSaturated,
        Self::LengthSaturated,
        Self::HitNotFinite,
        Self::HitNoDirection,
        Self::HitNoPlane,
        Self::HitOvershoot,
        Self::HitSaturated,
        Self::SurfNotFinite,
        Self::SurfParallel,
        Self::SurfDegenerate,
        Self::SurfSaturated,
    ];

    /// The name that trace lines print.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::NonFinite => "reflect.non_finite",
            Self::Parallel => "local_frame.parallel",
            Self::Zero => "cube_face.zero",
            Self::DerivativesSaturated => "jacobian.d.saturated",
            Self::CovarianceSaturated => "covariance.k.saturated",
            Self::LambdaSaturated => "eigen.lambda.saturated",
            Self::LengthSaturated => "footprint.length.saturated",
            Self::HitNotFinite => "hit.non_finite",
            Self::HitNoDirection => "hit.no_direction",
            Self::HitNoPlane => "hit.no_plane",
            Self::HitOvershoot => "hit.overshoot",
            Self::HitSaturated => "hit.l.saturated",
            Self::SurfNotFinite => "surface_footprint.non_finite",
            Self::SurfParallel => "surface_footprint.parallel",
            Self::SurfDegenerate => "surface_footprint.degenerate",
            Self::SurfSaturated => "surface_footprint.d.saturated",
        }
    }
}

impl Flags {
    /// Adds a flag.
    pub fn insert(&mut self, flag: Flag) {
        self.0 |= 1 << flag as u8;
    }

    /// Whether the flag is in the set.
    #[must_use]
    pub fn contains(self, flag: Flag) -> bool {
        self.0 & (1 << flag as u8) != 0
    }

    /// Whether nothing was raised.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// The names of the flags in the set, in pipeline order.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        Flag::ALL.into_iter().filter(move |&flag| self.contains(flag)).map(Flag::name)
    }
}

impl fmt::Debug for Flags {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_set().entries(self.names()).finish()
    }
}
