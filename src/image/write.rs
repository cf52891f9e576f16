//! Pictures out: linear EXR and sRGB PNG, the same bytes for the same picture.

use super::exr_header::scan;
use crate::base::num;
use crate::picture::Picture;
use crate::srgb::srgb_encode;
use exr::image::{Encoding, Image, Layer, SpecificChannels};
use exr::math::Vec2;
use exr::meta::attribute::{AttributeValue, Text};
use exr::meta::header::LayerAttributes;
use exr::prelude::WritableImage;
use half::f16;
use std::io::{Cursor, Error, Write};

/// Sample type of an EXR file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sample {
    /// 16 bits: nearest half, ties to even, beyond ±65504 saturated.
    Half,
    /// 32 bits: nearest f32, ties to even.
    Float,
}

/// Writes linear R, G, B as a scan-line EXR (ZIP) with string attributes.
///
/// Every pixel is written as it is, background too. Attributes are sorted by name.
///
/// # Errors
///
/// The target's error; `InvalidInput` for a picture without pixels and for an attribute
/// name that is empty or longer than 255 bytes.
pub fn write_exr(
    target: &mut impl Write,
    picture: &Picture,
    attributes: &[(String, String)],
    sample: Sample,
) -> std::io::Result<()> {
    let own = own_attributes(attributes)?;
    let size = Vec2(picture.width, picture.height);
    if size.0 == 0 || size.1 == 0 || picture.rgb.len() != size.0 * size.1 {
        return Err(invalid("picture size"));
    }
    let encoding = Encoding {
        compression: exr::compression::Compression::ZIP16,
        blocks: exr::image::Blocks::ScanLines,
        line_order: exr::meta::attribute::LineOrder::Increasing,
    };
    let at = |p: Vec2<usize>| picture.rgb[p.1 * size.0 + p.0];
    let mut bytes = Cursor::new(Vec::new());
    let written = match sample {
        Sample::Half => {
            let pixel = |p| <(f16, f16, f16)>::from(at(p).map(half));
            let layer = Layer::new(size, own, encoding, SpecificChannels::rgb(pixel));
            Image::from_layer(layer).write().to_buffered(&mut bytes)
        }
        Sample::Float => {
            let pixel = |p| <(f32, f32, f32)>::from(at(p).map(num::f32));
            let layer = Layer::new(size, own, encoding, SpecificChannels::rgb(pixel));
            Image::from_layer(layer).write().to_buffered(&mut bytes)
        }
    };
    written.map_err(|e| Error::other(e.to_string()))?;
    let bytes = sort_attributes(bytes.into_inner());
    target.write_all(&bytes)
}

/// String attributes as the writer takes them.
pub(super) fn own_attributes(attributes: &[(String, String)]) -> std::io::Result<LayerAttributes> {
    let mut own = LayerAttributes::default();
    for (name, value) in attributes {
        let name = Text::new_or_none(name)
            .filter(|_| (1..=255).contains(&name.len()))
            .ok_or_else(|| invalid("attribute name"))?;
        let value =
            Text::from_bytes_unchecked(exr::prelude::SmallVec::from_slice(value.as_bytes()));
        own.other.insert(name, AttributeValue::Text(value));
    }
    Ok(own)
}

fn half(value: f64) -> f16 {
    f16::from_f64(value.clamp(-65504.0, 65504.0))
}

pub(super) fn invalid(what: &str) -> Error {
    Error::new(std::io::ErrorKind::InvalidInput, format!("invalid {what}"))
}

/// Puts the header's attributes in alphabetical order: the writer takes them from a hash map, whose
/// order changes from run to run. The header keeps its length, so every offset stays right.
pub(super) fn sort_attributes(bytes: Vec<u8>) -> Vec<u8> {
    let Ok(raw) = scan(&bytes, "the written header") else {
        return bytes;
    };
    let Some(part) = raw.parts.first() else {
        return bytes;
    };
    let mut order: Vec<_> = part.iter().map(|a| (a.name, a.entry.clone())).collect();
    order.sort_by(|a, b| a.0.cmp(b.0));
    let mut out = bytes[..8].to_vec();
    for (_, entry) in order {
        out.extend_from_slice(&bytes[entry]);
    }
    out.extend_from_slice(&bytes[out.len()..]);
    out
}

/// Writes an 8-bit sRGB PNG: clamp(linear·2^exposure, 0, 1), encoded, rounded to the nearest code
/// (halves up); NaN becomes 0. Background pixels are written as they are.
///
/// `text` becomes text chunks (keyword of 1 to 79 Latin-1 bytes, text).
///
/// # Errors
///
/// The target's error; `InvalidInput` for a picture without pixels and for a bad keyword.
pub fn write_png(
    target: &mut impl Write,
    picture: &Picture,
    exposure: f64,
    text: &[(String, String)],
) -> std::io::Result<()> {
    let size = |n: usize| u32::try_from(n).ok().filter(|n| (1..1 << 31).contains(n));
    let (Some(width), Some(height)) = (size(picture.width), size(picture.height)) else {
        return Err(invalid("picture size"));
    };
    let mut encoder = png::Encoder::new(target, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
    for (keyword, value) in text {
        if !(1..=79).contains(&keyword.len()) {
            return Err(invalid("text keyword"));
        }
        let added = if value.is_ascii() {
            encoder.add_text_chunk(keyword.clone(), value.clone())
        } else {
            encoder.add_itxt_chunk(keyword.clone(), value.clone())
        };
        added.map_err(|e| Error::other(e.to_string()))?;
    }
    let scale = libm::exp2(exposure);
    let bytes: Vec<u8> = picture.rgb.iter().flatten().map(|linear| code(linear * scale)).collect();
    let to_io = |e: png::EncodingError| {
        if let png::EncodingError::IoError(e) = e { e } else { Error::other(e.to_string()) }
    };
    let mut writer = encoder.write_header().map_err(to_io)?;
    writer.write_image_data(&bytes).map_err(to_io)?;
    writer.finish().map_err(to_io)
}

/// The 8-bit sRGB code of linear light.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the value lies in 0.5..256; NaN becomes 0 by the cast's own rule"
)]
fn code(linear: f64) -> u8 {
    (srgb_encode(linear.clamp(0.0, 1.0)) * 255.0 + 0.5).floor() as u8
}
