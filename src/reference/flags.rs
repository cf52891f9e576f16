//! The flags that a fragment can set.

use std::fmt;

use crate::base::named::named;

/// A set of the flags that a fragment raised.
#[derive(Clone, Copy, Default, PartialEq, Eq, Hash)]
pub struct Flags(u16);

named! {
    /// A flag of the float reference.
    #[derive(PartialOrd, Ord)]
    #[repr(u8)]
    pub enum Flag {
        /// An input was NaN (taken as 0) or infinite (taken as ±`f64::MAX`).
        NonFinite = "reflect.non_finite",
        /// h is parallel to n, or one of them is zero: any orthogonal pair was taken.
        Parallel = "local_frame.parallel",
        /// The reflected direction is zero: face +z, u = v = 0, D = 0.
        Zero = "cube_face.zero",
        /// An entry of D is beyond the largest double.
        DerivativesSaturated = "jacobian.d.saturated",
        /// An entry of K is beyond the largest double (λ may still be right).
        CovarianceSaturated = "covariance.k.saturated",
        /// λ1 or λ2 is beyond the largest double.
        LambdaSaturated = "eigen.lambda.saturated",
        /// The length in texels is beyond the largest double.
        LengthSaturated = "footprint.length.saturated",
        /// A number of a ray was NaN (taken as 0) or infinite (taken as ±`f64::MAX`).
        HitNotFinite = "hit.non_finite",
        /// R = 0: (0, 0, 1) was taken.
        HitNoDirection = "hit.no_direction",
        /// The wall has no plane at the hit: the footprint is the disc's.
        HitNoPlane = "hit.no_plane",
        /// A step went beyond the reference surface.
        HitOvershoot = "hit.overshoot",
        /// The ray parameter, or a component of the hit, is beyond the largest double.
        HitSaturated = "hit.l.saturated",
        /// A number of a texture request was NaN (taken as 0) or infinite (taken as ±`f64::MAX`).
        SurfNotFinite = "surface_footprint.non_finite",
        /// D ∥ N, or one of them 0: any orthogonal pair was taken.
        SurfParallel = "surface_footprint.parallel",
        /// ∂P/∂s × ∂P/∂t = 0: the dot products' form was taken.
        SurfDegenerate = "surface_footprint.degenerate",
        /// An entry of D on a texture is beyond the largest double.
        SurfSaturated = "surface_footprint.d.saturated",
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
