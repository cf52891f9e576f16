//! The sRGB transfer function in doubles, without quantisation.
//!
//! Source: IEC 61966-2-1, the piecewise curve with the constants 12.92, 0.055, 1.055 and 2.4.
//! `libm` gives the same bits on every platform.

/// Encodes a linear value in [0, 1] for the display.
///
/// The caller clamps: outside [0, 1] the same formulas go on (negative values stay linear), NaN stays NaN.
#[must_use]
pub fn srgb_encode(linear: f64) -> f64 {
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        // 1.055·p − 0.055, written so that 1 gives exactly 1.
        let p = libm::pow(linear, 1.0 / 2.4);
        p + 0.055 * (p - 1.0)
    }
}

/// The inverse of [`srgb_encode`], from an encoded value in [0, 1] to linear.
#[must_use]
pub fn srgb_decode(encoded: f64) -> f64 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) }
}

/// Linear light of an 8-bit sRGB colour; encoding it and rounding to 8 bits gives the bytes back.
#[must_use]
pub fn linear_of_bytes(rgb: [u8; 3]) -> [f64; 3] {
    rgb.map(|byte| srgb_decode(f64::from(byte) / 255.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_8_bit_code_survives_decoding_and_encoding() {
        for code in 0..=255u8 {
            let [linear, ..] = linear_of_bytes([code; 3]);
            let back = srgb_encode(linear) * 255.0;
            // Two pow calls, each within an ulp of values near 1, amplified by at most 12.92.
            assert!((back - f64::from(code)).abs() < 1e-9, "{code} => {back}");
        }
    }

    #[test]
    fn every_sixteen_bit_code_survives_decoding_and_encoding() {
        // The two pieces meet within 2⁻²⁵ at the standard's rounded threshold; a code step is 2⁻¹⁶
        // and the curve's slope is at most 12.92, so the round trip must land on the same code.
        for code in 0..=65_535u32 {
            let value = f64::from(code) / 65_535.0;
            let back = srgb_encode(srgb_decode(value)) * 65_535.0;
            assert!((back - f64::from(code)).abs() < 0.5, "{code}: {back}");
        }
    }

    #[test]
    fn black_and_white_are_fixed_points() {
        assert_eq!(srgb_encode(0.0).to_bits(), 0.0f64.to_bits());
        assert_eq!(srgb_encode(1.0).to_bits(), 1.0f64.to_bits());
        // (1.055/1.055)^2.4 is 1 to one rounding of the sum 1 + 0.055 and one of the power.
        assert!((srgb_decode(1.0) - 1.0).abs() <= 2e-16);
    }

    #[test]
    fn known_points_of_the_curve_agree() {
        // Middle grey of the standard: code 119 (0.46667) is 18.4 % linear; 0.5 linear is 0.735357.
        for (linear, encoded) in [(0.5, 0.735_356_983_052_449_4), (0.001, 0.01292)] {
            assert!((srgb_encode(linear) - encoded).abs() < 1e-12, "{linear}");
        }
        // Published: linear 0.18 is sRGB 0.4613561295… (118 of 255 after rounding).
        assert!((srgb_encode(0.18) * 255.0 - 117.645_8).abs() < 1e-3);
    }
}
