//! From code values to light: the curves that files declare.

use crate::srgb::srgb_decode;

/// The curve between stored samples and light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Curve {
    /// Samples are light.
    Linear,
    /// The curve of sRGB.
    Srgb,
    /// Light is the sample to this power.
    Power(f64),
    /// The curve of ITU-R BT.709.
    Bt709,
}

/// The curve that a user asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Transfer {
    /// Samples are light.
    Linear,
    /// Samples are codes of sRGB.
    Srgb,
}

impl From<Transfer> for Curve {
    fn from(transfer: Transfer) -> Self {
        match transfer {
            Transfer::Linear => Self::Linear,
            Transfer::Srgb => Self::Srgb,
        }
    }
}

impl Curve {
    /// The light of a sample.
    #[must_use]
    pub fn decode(self, sample: f64) -> f64 {
        match self {
            Self::Linear => sample,
            Self::Srgb => srgb_decode(sample),
            Self::Power(exponent) => libm::pow(sample.max(0.0), exponent),
            Self::Bt709 if sample < 0.081 => sample / 4.5,
            Self::Bt709 => libm::pow((sample + 0.099) / 1.099, 1.0 / 0.45),
        }
    }

    /// Its name.
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Self::Linear => "linear".into(),
            Self::Srgb => "sRGB curve".into(),
            Self::Power(exponent) => format!("power {exponent:.4}"),
            Self::Bt709 => "curve of BT.709".into(),
        }
    }
}

/// The curve that a PNG file declares, what declares it, and what it declares that is not applied.
///
/// The order is that of the PNG specification: `cICP`, then `sRGB`, then `gAMA`. The codes of sRGB are usual without any.
///
/// # Errors
/// A transfer function of `cICP` that is not read, by its name.
pub(super) fn of_png(bytes: &[u8]) -> Result<(Curve, &'static str, Vec<String>), String> {
    let mut remarks = Vec::new();
    let usual = (Curve::Srgb, "as usual for PNG");
    let Ok(reader) = png::Decoder::new(std::io::Cursor::new(bytes)).read_info() else {
        return Ok((usual.0, usual.1, remarks));
    };
    let info = reader.info();
    if let Some(code) = &info.coding_independent_code_points {
        if code.color_primaries != 1 {
            remarks.push(format!("primaries {} of cICP kept as they are", code.color_primaries));
        }
        let curve = match code.transfer_function {
            1 | 6 | 14 | 15 => Curve::Bt709,
            4 => Curve::Power(2.2),
            5 => Curve::Power(2.8),
            8 => Curve::Linear,
            13 => Curve::Srgb,
            16 => return Err("PQ (transfer function 16 of cICP)".into()),
            18 => return Err("HLG (transfer function 18 of cICP)".into()),
            other => return Err(format!("transfer function {other} of cICP")),
        };
        return Ok((curve, "by cICP", remarks));
    }
    if info.icc_profile.is_some() {
        remarks.push("its ICC profile is not applied".into());
    }
    if info.srgb.is_some() {
        return Ok((Curve::Srgb, "by its chunk sRGB", remarks));
    }
    let Some(gamma) = info.gama_chunk else {
        return Ok((usual.0, usual.1, remarks));
    };
    // 1/2.2 is what writers of sRGB codes have always put there.
    let curve = match gamma.into_scaled() {
        100_000 => Curve::Linear,
        45_000..=46_000 => Curve::Srgb,
        0 => return Ok((usual.0, "as its gAMA is 0", remarks)),
        other => Curve::Power(100_000.0 / f64::from(other)),
    };
    Ok((curve, "by gAMA", remarks))
}
