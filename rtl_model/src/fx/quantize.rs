//! Rounding and overflow without branches: a register write.
//!
//! `(x + c0 + ((x >> 63) & c1) + (−((x >> s) & 1) & c2)) >> s` gives all eight roundings for the
//! right constants; they depend on the shift only through 2^(s−1), so that a block register, whose
//! shift differs from fragment to fragment, uses the same circuit.

use super::format::{Format, Overflow, Rounding};

/// A register's format compiled to the constants of its rounding circuit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Quantizer {
    /// The format.
    pub format: Format,
    /// Fraction bits of the value that comes in; meaningless for block registers.
    pub frac_in: i64,
    /// Right shift of a value with `frac_in` fraction bits, and 2^(shift − 1) − 1.
    down: i64,
    low: i64,
    half: i64,
    minus: i64,
    sign_full: i64,
    sign_one: i64,
    odd: i64,
    min: i64,
    max: i64,
    wrap_shift: u32,
    /// What writes of whole lane arrays use.
    pub(crate) lanes: LaneRounding,
}

/// The part of a register write that needs no case: half-even rounding by a shift that does not lose
/// everything, and whether the result is in range. Registers that need more pass their input through and
/// count as out of range, so that these lanes are run again one by one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct LaneRounding {
    /// Right shift, 2^(shift − 1) − 1, and 1 where ties must see the last bit kept.
    pub(crate) down: i64,
    pub(crate) low: i64,
    pub(crate) odd: i64,
    /// y is in range where (y + bias) has none of the bits of `beyond`.
    pub(crate) bias: i64,
    pub(crate) beyond: i64,
}

impl LaneRounding {
    fn new(format: Format, down: i64) -> Self {
        if !Quantizer::is_standard(format) || !(0..=62).contains(&down) {
            return Self { down: 0, low: 0, odd: 0, bias: 0, beyond: -1 };
        }
        Self {
            down,
            low: ((1 << down) - 1) >> 1,
            odd: i64::from(down > 0),
            bias: -format.min_raw(),
            beyond: !(format.max_raw() - format.min_raw()),
        }
    }
}

impl Quantizer {
    /// The register write for values with `frac_in` fraction bits.
    #[must_use]
    pub fn new(format: Format, frac_in: i64) -> Self {
        // (mask of 2^(s−1), constant, mask of 2^s − 1 on negatives, constant on negatives, on odd)
        let (half, minus, sign_full, sign_one, odd) = match format.rounding {
            Rounding::Floor => (0, 0, 0, 0, 0),
            Rounding::Zero => (0, 0, -1, 0, 0),
            Rounding::HalfUp => (-1, 0, 0, 0, 0),
            Rounding::HalfDown => (-1, -1, 0, 0, 0),
            Rounding::HalfAway => (-1, 0, 0, -1, 0),
            Rounding::HalfZero => (-1, -1, 0, 1, 0),
            Rounding::HalfEven => (-1, -1, 0, 0, 1),
            Rounding::HalfOdd => (-1, 0, 0, 0, -1),
        };
        let down = frac_in - i64::from(format.frac);
        Self {
            format,
            frac_in,
            down,
            low: if (1..=62).contains(&down) { (1 << (down - 1)) - 1 } else { 0 },
            half,
            minus,
            sign_full,
            sign_one,
            odd,
            min: format.min_raw(),
            max: format.max_raw(),
            wrap_shift: 64 - format.width(),
            lanes: LaneRounding::new(format, down),
        }
    }

    /// Fraction bits of the register.
    #[inline(always)]
    #[must_use]
    pub fn frac(&self) -> i64 {
        self.format.frac.into()
    }

    /// Bits of the register without the sign.
    #[inline(always)]
    #[must_use]
    pub fn bits(&self) -> i64 {
        self.format.magnitude_bits().into()
    }

    /// Fraction bits of a block register's mantissas in the nominal scale: the largest in [1, 2).
    #[inline(always)]
    #[must_use]
    pub fn block_frac(&self) -> i64 {
        self.bits() - 1
    }

    /// `x · 2^−shift` rounded to an integer; a shift ≤ 0 is exact. |x| < 2^62, shift ≤ 62, and
    /// a left shift must fit.
    #[inline(always)]
    #[must_use]
    pub fn round(&self, x: i64, shift: i64) -> i64 {
        if shift <= 0 {
            return x << -shift;
        }
        let half = 1i64 << (shift - 1);
        let sign = x >> 63;
        let odd = -((x >> shift) & 1);
        let c0 = (half & self.half) + self.minus;
        let c1 = ((half + (half - 1)) & self.sign_full) + self.sign_one;
        (x + c0 + (sign & c1) + (odd & self.odd)) >> shift
    }

    /// The register's code for an integer that counts LSBs, and whether it left the range.
    #[inline(always)]
    #[must_use]
    pub fn limit(&self, y: i64) -> (i64, bool) {
        let over = (y > self.max) | (y < self.min);
        let code = match self.format.overflow {
            Overflow::Saturate | Overflow::SaturateSymmetric => y.clamp(self.min, self.max),
            Overflow::Zero => {
                if over {
                    0
                } else {
                    y
                }
            }
            Overflow::Wrap if self.format.signed => y << self.wrap_shift >> self.wrap_shift,
            Overflow::Wrap => y & self.max,
        };
        (code, over)
    }

    /// Writes `x · 2^−frac_in` to the register: code and whether it left the range.
    #[inline(always)]
    #[must_use]
    pub fn write(&self, x: i64) -> (i64, bool) {
        self.write_shifted(x, self.down)
    }

    /// [`Quantizer::write`], compiled for half-even and saturation alone where `standard`.
    #[inline(always)]
    #[must_use]
    pub fn write_fixed_as(&self, standard: bool, x: i64) -> (i64, bool) {
        if !standard {
            return self.write_shifted(x, self.down);
        }
        if !(1..=62).contains(&self.down) {
            return self.write_seldom(x, self.down);
        }
        let y = (x + self.low + ((x >> self.down) & 1)) >> self.down;
        let code = y.clamp(self.min, self.max);
        (code, code != y)
    }

    /// Writes `x` with the given right shift. A shift that would lose everything is the sign or 0;
    /// a left shift that would leave 63 bits leaves the range.
    #[inline(always)]
    #[must_use]
    pub fn write_shifted(&self, x: i64, shift: i64) -> (i64, bool) {
        if shift < 0 {
            let room = i64::from(x.unsigned_abs().leading_zeros()) - 1;
            if x != 0 && -shift > room {
                let far = if x < 0 { self.min } else { self.max };
                return match self.format.overflow {
                    Overflow::Saturate | Overflow::SaturateSymmetric => (far, true),
                    // All kept bits are shifted-in zeros only beyond 63; the low bits otherwise.
                    Overflow::Wrap => {
                        let y = if -shift > 63 { 0 } else { x << -shift };
                        (self.limit(y).0, true)
                    }
                    Overflow::Zero => (0, true),
                };
            }
            return self.limit(if x == 0 { 0 } else { x << -shift });
        }
        // Beyond 62 less than half an LSB is left, and only its sign counts.
        let x = if shift > 62 { x.signum() } else { x };
        self.limit(self.round(x, shift.min(62)))
    }

    /// [`Quantizer::round`], compiled for half-even alone where `standard`.
    #[inline(always)]
    #[must_use]
    pub fn round_as(&self, standard: bool, x: i64, shift: i64) -> i64 {
        if !standard {
            return self.round(x, shift);
        }
        if shift <= 0 {
            return x << -shift;
        }
        half_even(x, shift)
    }

    /// [`Quantizer::write_shifted`], compiled for half-even and saturation alone where `standard`.
    #[inline(always)]
    #[must_use]
    pub fn write_as(&self, standard: bool, x: i64, shift: i64) -> (i64, bool) {
        if !standard {
            return self.write_shifted(x, shift);
        }
        if !(1..=62).contains(&shift) {
            return self.write_seldom(x, shift);
        }
        let y = half_even(x, shift);
        let code = y.clamp(self.min, self.max);
        (code, code != y)
    }

    /// Shifts that do not round, kept out of the way of those that do.
    #[cold]
    #[inline(never)]
    fn write_seldom(&self, x: i64, shift: i64) -> (i64, bool) {
        self.write_shifted(x, shift)
    }

    /// Whether the register rounds half-even and saturates.
    #[must_use]
    pub fn is_standard(format: Format) -> bool {
        format.rounding == Rounding::HalfEven && format.overflow == Overflow::Saturate
    }
}

/// x·2^−shift to nearest, ties to even; shift from 1 to 62.
#[inline(always)]
fn half_even(x: i64, shift: i64) -> i64 {
    let low = (1i64 << (shift - 1)) - 1;
    (x + low + ((x >> shift) & 1)) >> shift
}
