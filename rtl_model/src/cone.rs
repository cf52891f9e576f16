//! Ray cones: an angle and a width in two small floating-point registers, computed with integers.
//!
//! `small` holds the formats and the store, `dyadic` the numbers that go in, `exact` sums of products
//! that no rounding has touched. The operations are the stage [`crate::stages::ray_cone`].

pub mod dyadic;
pub mod exact;
pub mod fast;
pub mod small;

pub use dyadic::Dyadic;
pub use exact::{Sum, Term};
pub use small::{Dither, SmallFloat, StoreRounding, Stored};

use crate::literals::literals;

literals! {
    /// Format of the two registers of a cone.
    ConeFormat {
        /// bfloat16: 8 exponent and 7 mantissa bits.
        Bf16 = "bf16",
        /// binary16: 5 exponent and 10 mantissa bits.
        F16 = "f16",
        /// binary32: 8 exponent and 23 mantissa bits.
        F32 = "f32",
    } default Bf16
}

impl ConeFormat {
    /// The format's fields.
    #[must_use]
    pub const fn float(self) -> SmallFloat {
        match self {
            Self::Bf16 => SmallFloat::BF16,
            Self::F16 => SmallFloat::F16,
            Self::F32 => SmallFloat::F32,
        }
    }
}

literals! {
    /// Which half of the packed word holds which register.
    LaneOrder {
        /// The angle in the low half, the width in the high half (OptiX Toolkit).
        AngleLow = "angle-low",
        /// The width in the low half, the angle in the high half.
        WidthLow = "width-low",
    } default AngleLow
}

/// Code of a cone's full angle in radians; positive where the cone diverges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Angle(pub u32);

/// Code of a cone's full width in world units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Width(pub u32);

/// A ray cone as its registers hold it: two codes of one [`SmallFloat`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Cone {
    /// Full angle.
    pub angle: Angle,
    /// Full width.
    pub width: Width,
}

impl Cone {
    /// Both codes in one word, each in `format.width()` bits: 32 for bf16 and f16, 64 for f32.
    ///
    /// In bf16 with `angle-low`, α = 1 and w = 2 make 0x4000_3f80.
    #[must_use]
    pub fn pack(self, format: SmallFloat, order: LaneOrder) -> u64 {
        let (low, high) = match order {
            LaneOrder::AngleLow => (self.angle.0, self.width.0),
            LaneOrder::WidthLow => (self.width.0, self.angle.0),
        };
        u64::from(high) << format.width() | u64::from(low)
    }

    /// The inverse of [`Cone::pack`]; bits above the two codes are ignored.
    #[must_use]
    pub fn unpack(word: u64, format: SmallFloat, order: LaneOrder) -> Self {
        let mask = (1u64 << format.width()) - 1;
        let code = |bits: u64| u32::try_from(bits & mask).unwrap_or(0);
        let (low, high) = (code(word), code(word >> format.width()));
        let (angle, width) = match order {
            LaneOrder::AngleLow => (low, high),
            LaneOrder::WidthLow => (high, low),
        };
        Self { angle: Angle(angle), width: Width(width) }
    }
}
