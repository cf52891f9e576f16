//! What a fragment can report beside its numbers.

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
}

impl Flag {
    /// Every flag, in pipeline order.
    pub const ALL: [Self; 7] = [
        Self::NonFinite,
        Self::Parallel,
        Self::Zero,
        Self::DerivativesSaturated,
        Self::CovarianceSaturated,
        Self::LambdaSaturated,
        Self::LengthSaturated,
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
        Flag::ALL
            .into_iter()
            .filter(move |&flag| self.contains(flag))
            .map(Flag::name)
    }
}

impl fmt::Debug for Flags {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_set().entries(self.names()).finish()
    }
}
