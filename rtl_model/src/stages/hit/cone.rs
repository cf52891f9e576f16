//! The ray cone at the hit: w' = w + α d in registers of bfloat16, to nearest even.

use crate::port;

/// Bits of a bfloat16 significand.
const BITS: i64 = 8;
/// Power of two of the last place of the smallest normal number.
const LEAST: i64 = -133;
/// Power of two of the last place of the largest.
const MOST: i64 = 120;

/// m·2^e to the nearest bfloat16 as (significand, power of two); beyond the range the largest.
fn store(m: i128, e: i64) -> (i64, i64) {
    if m == 0 {
        return (0, 0);
    }
    let size = m.unsigned_abs();
    let top = 127 - i64::from(size.leading_zeros());
    let shift = (top + 1 - BITS).max(LEAST - e);
    let code = if shift <= 0 {
        size << u32::try_from(-shift).unwrap_or(0).min(100)
    } else if shift > 126 {
        0
    } else {
        let half = 1u128 << (shift - 1);
        (size + (half - 1) + ((size >> shift) & 1)) >> shift
    };
    let mut code = i64::try_from(code).unwrap_or(255);
    let mut e = e + shift;
    if code > 255 {
        code >>= 1;
        e += 1;
    }
    if e > MOST {
        (code, e) = (255, MOST);
    }
    (if m < 0 { -code } else { code }, e)
}

/// A binary64 word as its register holds it.
#[must_use]
pub fn load(word: u64) -> ((i64, i64), bool) {
    let (m, e, finite) = port::unpack(word);
    (store(m.into(), e), finite)
}

/// w + α·d, d = code·2^e; the sum is rounded once.
#[must_use]
pub fn propagate(angle: (i64, i64), width: (i64, i64), d: (i64, i64)) -> (i64, i64) {
    let product = i128::from(angle.0) * i128::from(d.0);
    let product_e = angle.1 + d.1;
    let width_m = i128::from(width.0);
    if product == 0 {
        return store(width_m, width.1);
    }
    if width_m == 0 {
        return store(product, product_e);
    }
    // 80 bits are more than both hold: beyond them the smaller one is less than half of the last place kept,
    // and only its sign counts.
    let gap = product_e - width.1;
    let (m, e) = match gap {
        81.. => ((product << 20) + width_m.signum(), product_e - 20),
        0..=80 => (
            (product << u32::try_from(gap).unwrap_or(0)) + width_m,
            width.1,
        ),
        -80..=-1 => (
            product + (width_m << u32::try_from(-gap).unwrap_or(0)),
            product_e,
        ),
        _ => ((width_m << 20) + product.signum(), width.1 - 20),
    };
    store(m, e)
}
