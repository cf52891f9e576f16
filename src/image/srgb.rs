//! The sRGB transfer curve (IEC 61966-2-1, the exact piecewise form) in double precision.

/// Encodes linear light, 0..1 to 0..1; values beyond follow the same formulas, NaN stays NaN.
#[must_use]
pub fn srgb_encode(linear: f64) -> f64 {
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055
    }
}

/// Decodes an sRGB code value, 0..1 to 0..1.
#[must_use]
pub fn srgb_decode(encoded: f64) -> f64 {
    if encoded <= 0.040_45 {
        encoded / 12.92
    } else {
        libm::pow((encoded + 0.055) / 1.055, 2.4)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn known_points_of_the_curve() {
        // 1.055 − 0.055 = 1 and (1.055/1.055)^2.4 = 1 to one rounding each.
        assert!((srgb_encode(1.0) - 1.0).abs() <= 2e-16);
        assert!((srgb_decode(1.0) - 1.0).abs() <= 2e-16);
        // Published: linear 0.18 is sRGB 0.4613561295… (118 of 255 after rounding).
        assert!((srgb_encode(0.18) * 255.0 - 117.645_8).abs() < 1e-3);
        assert_eq!(srgb_encode(0.0).to_bits(), 0.0f64.to_bits());
    }
}
