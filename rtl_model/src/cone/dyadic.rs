//! Whole numbers times a power of two: the operands of a cone operation.

use crate::port;

/// Largest magnitude of an exponent: binary64 needs 1074, a fixed register less than 64.
const MAX_EXPONENT: i64 = 1100;

/// ±m · 2^e, exactly. Zero has m = 0 and no sign.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dyadic {
    /// Whether the number is below zero.
    pub negative: bool,
    /// Magnitude.
    pub m: u64,
    /// Power of two, from −1100 to 1100.
    pub e: i64,
}

impl Dyadic {
    /// 0.
    pub const ZERO: Self = Self::new(false, 0, 0);
    /// 1.
    pub const ONE: Self = Self::new(false, 1, 0);

    /// ±m · 2^e; an exponent beyond ±1100 is taken as that.
    #[inline(always)]
    #[must_use]
    pub const fn new(negative: bool, m: u64, e: i64) -> Self {
        Self {
            negative: negative && m != 0,
            m,
            e: if m == 0 {
                0
            } else if e > MAX_EXPONENT {
                MAX_EXPONENT
            } else if e < -MAX_EXPONENT {
                -MAX_EXPONENT
            } else {
                e
            },
        }
    }

    /// A fixed-point register: raw · 2^−frac.
    #[must_use]
    pub const fn fixed(raw: i64, frac: i64) -> Self {
        Self::new(raw < 0, raw.unsigned_abs(), -frac)
    }

    /// An IEEE 754 binary64 word, exactly, and whether it was finite: ±∞ reads as the largest
    /// finite number, NaN as 0.
    #[must_use]
    pub fn binary64(word: u64) -> (Self, bool) {
        let (m, e, finite) = port::unpack(word);
        (Self::fixed(m, -e), finite)
    }

    /// Whether the number is 0.
    #[must_use]
    pub const fn is_zero(self) -> bool {
        self.m == 0
    }

    /// The magnitude.
    #[must_use]
    pub const fn abs(self) -> Self {
        Self::new(false, self.m, self.e)
    }

    /// The number with the other sign.
    #[must_use]
    pub const fn neg(self) -> Self {
        Self::new(!self.negative, self.m, self.e)
    }
}
