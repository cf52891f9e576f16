//! Exact sums of products: nothing is rounded before the store.
//!
//! Two terms of at most 126 bits go through one 128-bit adder ([`sum2`]). Any number of terms goes
//! through an accumulator as wide as their exponents lie apart ([`sum`]). Both give the leading 128
//! bits of the sum and one bit that says whether anything lies below: enough for every rounding.

use super::dyadic::Dyadic;

/// Leading bits of an exact value: ±(m + θ) · 2^e with 0 ≤ θ < 1, θ > 0 only where `sticky`.
///
/// With `sticky` the top bits of m are set far enough down that no format's last place is below them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sum {
    /// Whether the value is below zero.
    pub negative: bool,
    /// Leading bits.
    pub m: u128,
    /// Power of two.
    pub e: i64,
    /// Whether bits below m were dropped.
    pub sticky: bool,
}

/// One product of a sum: ±m · 2^e, m in four words, the lowest first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Term {
    /// Whether the product is below zero.
    pub negative: bool,
    /// Magnitude.
    pub m: [u64; 4],
    /// Power of two.
    pub e: i64,
}

/// 1/π · 2^256, rounded down; the error is below 2^−256 and the next bits are 0xdb92….
const INV_PI: [u64; 4] =
    [0xff28_b1d5_ef5d_e2b0, 0x6db1_4acc_9e21_c820, 0xfe13_abe8_fa9a_6ee0, 0x517c_c1b7_2722_0a94];

/// Words of the accumulator: four factors of exponents within ±1100 and of 64 bits each.
const WORDS: usize = 144;

impl Term {
    /// The exact product of up to four numbers.
    #[must_use]
    pub fn product(factors: &[Dyadic]) -> Self {
        let mut out = Self { negative: false, m: [1, 0, 0, 0], e: 0 };
        for factor in factors.iter().take(4) {
            out.negative ^= factor.negative;
            out.e += factor.e;
            let mut carry = 0u128;
            for word in &mut out.m {
                let wide = u128::from(*word) * u128::from(factor.m) + carry;
                *word = low(wide);
                carry = wide >> 64;
            }
        }
        out
    }

    /// 2^power/π, rounded down at the 256th bit below 2^power.
    #[must_use]
    pub const fn inverse_pi(negative: bool, power: i64) -> Self {
        Self { negative, m: INV_PI, e: power - 256 }
    }

    /// The product with the other sign.
    #[must_use]
    pub const fn neg(mut self) -> Self {
        self.negative = !self.negative;
        self
    }

    fn is_zero(&self) -> bool {
        self.m == [0; 4]
    }

    fn bits(&self) -> i64 {
        let mut bits = 0;
        for (word, base) in self.m.iter().zip([0, 64, 128, 192]) {
            if *word != 0 {
                bits = base + 64 - i64::from(word.leading_zeros());
            }
        }
        bits
    }
}

/// The low word.
fn low(wide: u128) -> u64 {
    u64::try_from(wide & u128::from(u64::MAX)).unwrap_or(0)
}

/// The sum of any number of products.
///
/// Exponents lie at most 8,800 bits apart, which [`Dyadic`] sees to; a term that an accumulator of
/// 9,216 bits does not reach is impossible.
#[must_use]
pub fn sum(terms: &[Term]) -> Sum {
    let live = || terms.iter().filter(|t| !t.is_zero());
    let Some(base) = live().map(|t| t.e).min() else {
        return Sum::default();
    };
    let top = live().map(|t| t.e + t.bits()).max().unwrap_or(base);
    let span = usize::try_from(top - base).unwrap_or(0);
    let used = (span / 64 + 2).min(WORDS);
    let mut words = [0u64; WORDS];
    for term in live() {
        add(&mut words[..used], term, base);
    }
    let negative = words[used - 1] >> 63 == 1;
    if negative {
        let mut carry = true;
        for word in &mut words[..used] {
            (*word, carry) = (!*word).overflowing_add(u64::from(carry));
        }
    }
    leading(&words[..used], base, negative)
}

/// Adds a term to an accumulator in two's complement whose lowest bit weighs 2^base.
fn add(words: &mut [u64], term: &Term, base: i64) {
    let offset = usize::try_from(term.e - base).unwrap_or(0);
    let (first, shift) = (offset / 64, offset % 64);
    let mut carry = false;
    let mut before = 0u64;
    for (i, word) in words.iter_mut().skip(first).enumerate() {
        let here = term.m.get(i).copied().unwrap_or(0);
        let part = low(((u128::from(here) << 64 | u128::from(before)) << shift) >> 64);
        before = here;
        let (value, c0, c1);
        if term.negative {
            (value, c0) = word.overflowing_sub(part);
            (*word, c1) = value.overflowing_sub(u64::from(carry));
        } else {
            (value, c0) = word.overflowing_add(part);
            (*word, c1) = value.overflowing_add(u64::from(carry));
        }
        carry = c0 | c1;
    }
}

/// The leading 128 bits of a magnitude.
fn leading(words: &[u64], base: i64, negative: bool) -> Sum {
    let Some(top) = words.iter().rposition(|w| *w != 0) else {
        return Sum::default();
    };
    let at = |back: usize| top.checked_sub(back).and_then(|i| words.get(i)).copied().unwrap_or(0);
    let wide = u128::from(at(0)) << 64 | u128::from(at(1));
    let zeros = wide.leading_zeros();
    // `wide` has a word that is not 0 on top, so that at most 63 bits come from the third one.
    let third = u128::from(at(2)) << zeros;
    let m = wide << zeros | third >> 64;
    let dropped = at(2) << zeros != 0;
    let below = words.iter().take(top.saturating_sub(2)).any(|w| *w != 0);
    let words_below = i64::try_from(top).unwrap_or(0) - 1;
    Sum { negative, m, e: base + 64 * words_below - i64::from(zeros), sticky: dropped || below }
}

/// a·b + c through one adder. Exact while a·b has at most 126 bits; a code has at most 24.
#[inline]
#[must_use]
pub fn sum2(a: Dyadic, b: Dyadic, c: Dyadic) -> Sum {
    let product = normal(a.negative != b.negative, u128::from(a.m) * u128::from(b.m), a.e + b.e);
    let other = normal(c.negative, c.m.into(), c.e);
    if product.m == 0 {
        return other;
    }
    if other.m == 0 {
        return product;
    }
    let (big, small) = if product.e >= other.e { (product, other) } else { (other, product) };
    // Both have their leading one at bit 125; what the shift drops is folded into a last bit that
    // both roundings and signs see. Where it drops any, at most one leading bit cancels.
    let shift = big.e - small.e;
    let (moved, sticky) = if shift > 127 {
        (0, true)
    } else {
        let moved = small.m >> shift;
        (moved, moved << shift != small.m)
    };
    let (negative, m) = if big.negative == small.negative {
        (big.negative, big.m + moved)
    } else if sticky {
        // big − (moved + θ) = (big − moved − 1) + (1 − θ).
        (big.negative, big.m - moved - 1)
    } else if big.m >= moved {
        (big.negative, big.m - moved)
    } else {
        (small.negative, moved - big.m)
    };
    Sum { negative: negative && (m != 0 || sticky), m, e: big.e, sticky }
}

/// A magnitude with its leading one at bit 125.
#[inline(always)]
fn normal(negative: bool, m: u128, e: i64) -> Sum {
    if m == 0 {
        return Sum::default();
    }
    let shift = i64::from(m.leading_zeros()) - 2;
    let (m, e) = if shift >= 0 {
        (m << shift, e - shift)
    } else {
        // 127 or 128 bits of two full words: what drops out stays as a set last bit.
        let kept = m >> -shift;
        (kept | u128::from(kept << -shift != m), e - shift)
    };
    Sum { negative, m, e, sticky: false }
}

impl Sum {
    /// The quotient by a whole number other than 0, times 2^−`e`.
    #[must_use]
    pub fn divided_by(self, divisor: Dyadic) -> Self {
        if self.m == 0 || divisor.m == 0 {
            return self;
        }
        let shift = if self.sticky { 0 } else { self.m.leading_zeros() };
        let m = self.m << shift;
        let d = u128::from(divisor.m);
        Self {
            negative: self.negative != divisor.negative,
            m: m / d,
            e: self.e - i64::from(shift) - divisor.e,
            sticky: self.sticky || !m.is_multiple_of(d),
        }
    }

    /// Whether the value is 0.
    #[must_use]
    pub const fn is_zero(&self) -> bool {
        self.m == 0 && !self.sticky
    }
}
