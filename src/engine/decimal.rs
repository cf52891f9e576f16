//! Register values in decimal, all digits.

use num_bigint::BigInt;

use super::probe::Code;
use crate::base::num;

impl Code {
    /// The value in decimal, all digits.
    #[must_use]
    pub fn decimal(self) -> String {
        decimal(self.raw, self.frac)
    }
}

/// raw · 2^−frac in decimal, all digits: −0.0625, 3, 12.5.
#[must_use]
pub fn decimal(raw: i64, frac: i64) -> String {
    // Trailing zero bits first: a normalised code needs no more digits than its value.
    let zeros = if raw == 0 { 63 } else { i64::from(raw.trailing_zeros()) };
    let drop = zeros.min(frac.max(0));
    let (raw, frac) = (raw >> drop, frac - drop);
    if frac <= 0 {
        return (BigInt::from(raw) << frac.unsigned_abs()).to_string();
    }
    // raw/2^f = raw·5^f/10^f.
    let places = num::usize(frac);
    let power = num::u32(frac);
    let digits = (BigInt::from(raw.unsigned_abs()) * BigInt::from(5).pow(power)).to_string();
    let digits = format!("{digits:0>width$}", width = places + 1);
    let (whole, part) = digits.split_at(digits.len() - places);
    let sign = if raw < 0 { "-" } else { "" };
    format!("{sign}{whole}.{part}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimals_have_all_digits_and_none_too_many() {
        assert_eq!(decimal(-1, 4), "-0.0625");
        assert_eq!(decimal(0, 30), "0");
        assert_eq!(decimal(3, -2), "12");
        assert_eq!(decimal(12 << 20, 20), "12");
        assert_eq!(decimal(25, 1), "12.5");
        assert_eq!(decimal(1, 10), "0.0009765625");
    }
}
