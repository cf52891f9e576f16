//! Format of a register: sign, integer bits, fraction bits, rounding, overflow.

use crate::literals::literals;

literals! {
    /// The treatment of the bits below the last one kept. `ac_types` names in brackets.
    Rounding {
        /// Towards −∞ (AC_TRN).
        Floor = "floor",
        /// Towards zero (AC_TRN_ZERO).
        Zero = "zero",
        /// To nearest, ties towards +∞ (AC_RND).
        HalfUp = "half-up",
        /// To nearest, ties towards −∞ (AC_RND_MIN_INF).
        HalfDown = "half-down",
        /// To nearest, ties away from zero (AC_RND_INF).
        HalfAway = "half-away",
        /// To nearest, ties towards zero (AC_RND_ZERO).
        HalfZero = "half-zero",
        /// To nearest, ties to the even code (AC_RND_CONV).
        HalfEven = "half-even",
        /// To nearest, ties to the odd code (AC_RND_CONV_ODD).
        HalfOdd = "half-odd",
    }
}

literals! {
    /// The treatment of a value outside the register's range. `ac_types` names in brackets.
    Overflow {
        /// Keep the low bits (AC_WRAP).
        Wrap = "wrap",
        /// The nearest end of the range (AC_SAT).
        Saturate = "saturate",
        /// The nearest end of [−max, max] (AC_SAT_SYM).
        SaturateSymmetric = "saturate-symmetric",
        /// Zero (AC_SAT_ZERO).
        Zero = "zero",
    }
}

/// Format of a register. `int` excludes the sign bit: signed Q17.24 is 42 bits wide.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Format {
    /// Whether there is a sign bit.
    pub signed: bool,
    /// Integer bits.
    pub int: u32,
    /// Fraction bits.
    pub frac: u32,
    /// Rounding.
    pub rounding: Rounding,
    /// Overflow.
    pub overflow: Overflow,
}

impl Format {
    /// A signed format that rounds to the nearest even code and saturates.
    #[must_use]
    pub const fn signed(int: u32, frac: u32) -> Self {
        Self { signed: true, int, frac, rounding: Rounding::HalfEven, overflow: Overflow::Saturate }
    }

    /// An unsigned format that rounds to the nearest even code and saturates.
    #[must_use]
    pub const fn unsigned(int: u32, frac: u32) -> Self {
        Self { signed: false, ..Self::signed(int, frac) }
    }

    /// Magnitude bits: `int + frac`.
    #[must_use]
    pub const fn magnitude_bits(self) -> u32 {
        self.int.saturating_add(self.frac)
    }

    /// Bits of the register, the sign included.
    #[must_use]
    pub const fn width(self) -> u32 {
        self.magnitude_bits().saturating_add(if self.signed { 1 } else { 0 })
    }

    /// Largest code.
    #[must_use]
    pub const fn max_raw(self) -> i64 {
        (1i64 << self.magnitude_bits()) - 1
    }

    /// Smallest code; −max where the overflow is symmetric.
    #[must_use]
    pub const fn min_raw(self) -> i64 {
        match (self.signed, self.overflow) {
            (false, _) => 0,
            (true, Overflow::SaturateSymmetric) => -self.max_raw(),
            (true, _) => -self.max_raw() - 1,
        }
    }
}
