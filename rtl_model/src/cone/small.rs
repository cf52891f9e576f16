//! Small floating-point formats as data, and the store: one rounding into a register.
//!
//! A code is sign, biased exponent, mantissa, as in IEEE 754; an exponent of 0 is subnormal. Codes
//! with the largest exponent (infinity, NaN) are never written; read, they are the largest
//! finite number and 0. Zero is always written as +0.

use super::dyadic::Dyadic;
use super::exact::Sum;
use crate::literals::literals;

literals! {
    /// How a cone's registers round.
    StoreRounding {
        /// To nearest, ties to the even code.
        Rne = "rne",
        /// Towards zero: the low bits are dropped.
        Truncate = "truncate",
        /// Away from zero with the probability of the dropped fraction, from a seed.
        Stochastic = "stochastic",
    } default Rne
}

/// A binary floating-point format of at most 32 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SmallFloat {
    /// Bits of the exponent, 2…8.
    pub exponent_bits: u32,
    /// Bits of the mantissa without the hidden one, 1…23.
    pub mantissa_bits: u32,
}

/// A code and whether the value was beyond the format and became ±its largest number.
#[must_use]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stored {
    /// The code.
    pub code: u32,
    /// Whether the value saturated.
    pub saturated: bool,
}

impl SmallFloat {
    /// bfloat16.
    pub const BF16: Self = Self { exponent_bits: 8, mantissa_bits: 7 };
    /// IEEE 754 binary16.
    pub const F16: Self = Self { exponent_bits: 5, mantissa_bits: 10 };
    /// IEEE 754 binary32.
    pub const F32: Self = Self { exponent_bits: 8, mantissa_bits: 23 };

    /// Bits of a code, the sign included.
    #[must_use]
    pub const fn width(self) -> u32 {
        1 + self.exponent_bits + self.mantissa_bits
    }

    /// Code of the sign alone.
    #[must_use]
    pub const fn sign(self) -> u32 {
        1 << (self.exponent_bits + self.mantissa_bits)
    }

    /// Code of the largest finite number.
    #[must_use]
    pub const fn largest(self) -> u32 {
        self.sign() - (1 << self.mantissa_bits) - 1
    }

    /// Power of two of the smallest subnormal.
    #[inline(always)]
    #[must_use]
    pub fn lowest_exponent(self) -> i64 {
        2 - (1 << (self.exponent_bits - 1)) - i64::from(self.mantissa_bits)
    }

    /// The value of a code, and whether it is a finite one. Bits above the format's are ignored.
    #[inline(always)]
    #[must_use]
    pub fn unpack(self, code: u32) -> (Dyadic, bool) {
        let negative = code & self.sign() != 0;
        let magnitude = code & (self.sign() - 1);
        let infinite = self.largest() + 1;
        let (magnitude, finite) = match magnitude {
            m if m < infinite => (m, true),
            m if m == infinite => (self.largest(), false),
            _ => (0, false),
        };
        let hidden = 1u32 << self.mantissa_bits;
        let biased = magnitude >> self.mantissa_bits;
        let fraction = magnitude & (hidden - 1);
        let normal = u32::from(biased != 0);
        let m = fraction | (normal * hidden);
        let e = i64::from(biased.max(1)) - 1 + self.lowest_exponent();
        (Dyadic::new(negative, m.into(), e), finite)
    }

    /// Rounds an exact value into a register. `random` decides where `rounding` is stochastic.
    ///
    /// Within half an ulp (`rne`), below one (`truncate`, `stochastic`). Beyond the largest number the
    /// value saturates: where the code after the rounding would be infinity's or more.
    #[inline]
    pub fn store(self, rounding: StoreRounding, random: u32, x: &Sum) -> Stored {
        if x.m == 0 {
            // A sum that is dropped bits alone lies far below every format.
            return Stored { code: 0, saturated: false };
        }
        let top = 127 - i64::from(x.m.leading_zeros()) + x.e;
        let lowest = self.lowest_exponent();
        let lsb = (top - i64::from(self.mantissa_bits)).max(lowest);
        let shift = lsb - x.e;
        let (quotient, up) = if shift <= 0 {
            // The format holds every bit; a sum with dropped bits fills 128 and never comes here.
            (x.m << shift.unsigned_abs().min(127), false)
        } else if shift > 127 {
            // Nothing of the value reaches the last place: below half of it.
            let fraction =
                if shift < 160 { x.m >> (shift - 32).unsigned_abs().min(127) } else { 0 };
            let half = shift == 128 && (x.m >> 127 == 1) && (x.m << 1 != 0 || x.sticky);
            (0, self.up(rounding, random, half, false, fraction))
        } else {
            let kept = x.m >> shift;
            let rest = x.m & ((1 << shift) - 1);
            let half = 1u128 << (shift - 1);
            let above = rest > half || (rest == half && x.sticky);
            let tie = rest == half && !x.sticky && kept & 1 == 1;
            let fraction = if shift >= 32 { rest >> (shift - 32) } else { rest << (32 - shift) };
            (kept, self.up(rounding, random, above, tie, fraction))
        };
        // A carry out of the mantissa runs into the exponent, as it should.
        let steps = u64::try_from(quotient).unwrap_or(u64::MAX) + u64::from(up);
        let binade = u64::try_from(lsb - lowest).unwrap_or(0);
        let magnitude = binade.saturating_mul(1 << self.mantissa_bits).saturating_add(steps);
        let saturated = magnitude > self.largest().into();
        let magnitude = u32::try_from(magnitude).unwrap_or(u32::MAX).min(self.largest());
        let sign = if x.negative && magnitude != 0 { self.sign() } else { 0 };
        Stored { code: magnitude | sign, saturated }
    }

    #[inline(always)]
    fn up(
        self,
        rounding: StoreRounding,
        random: u32,
        above: bool,
        tie: bool,
        fraction: u128,
    ) -> bool {
        match rounding {
            StoreRounding::Rne => above || tie,
            StoreRounding::Truncate => false,
            StoreRounding::Stochastic => u128::from(random) < fraction,
        }
    }

    /// The code with the other sign; zero keeps its one code.
    #[must_use]
    pub const fn negate(self, code: u32) -> u32 {
        if code & (self.sign() - 1) == 0 { 0 } else { code ^ self.sign() }
    }

    /// The code of the magnitude.
    #[must_use]
    pub const fn abs(self, code: u32) -> u32 {
        code & (self.sign() - 1)
    }
}

/// Random bits of one ray's stochastic stores: the n-th store of a ray has the same bits whatever
/// order or number of threads rays are worked in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dither {
    key: u64,
    stores: u64,
}

impl Dither {
    /// The stores of a ray.
    #[must_use]
    pub const fn new(seed: u64, ray: u64) -> Self {
        Self { key: mix(seed ^ mix(ray)), stores: 0 }
    }

    /// The next store's bits.
    #[inline(always)]
    pub fn next_bits(&mut self) -> u32 {
        self.stores = self.stores.wrapping_add(1);
        let bits = mix(self.key.wrapping_add(self.stores.wrapping_mul(0x9e37_79b9_7f4a_7c15)));
        u32::try_from(bits >> 32).unwrap_or(0)
    }
}

/// The finaliser of SplitMix64 (Steele, Lea and Flood 2014).
const fn mix(x: u64) -> u64 {
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}
