//! Radiance HDR (RGBE): the header is checked here, the pixels are decoded by `image`.
//!
//! Values are mantissa · 2^(exponent − 136). `EXPOSURE` and colour corrections are not applied.

use super::limits::{LoadOptions, room};
use super::planar::Planar;
use crate::base::num;
use crate::base::quiet::guarded;
use crate::error::InputError;
use image::ImageDecoder;
use image::codecs::hdr::HdrDecoder;

/// Reads planes R, G, B.
pub(super) fn read(
    bytes: &[u8],
    subject: &str,
    options: &LoadOptions,
) -> Result<Planar, InputError> {
    let (width, height, start) = header(bytes, subject)?;
    let (w, h) = (u128::from(width), u128::from(height));
    options.admit(subject, 12 * w * h, &format!("{width}x{height} pixels"))?;
    // The densest row that any of the formats allows: one pixel and a run marker, 4 bytes each.
    let least = h * if w > 1 { 8 } else { 4 };
    let rest = (bytes.len() - start) as u128;
    if least > rest {
        return Err(damaged(
            subject,
            format!("at least {least} bytes of pixels for {width}x{height}"),
            format!("{rest} bytes"),
        )
        .at("pixels"));
    }
    let size = num::usize(12 * w * h);
    let mut buffer: Vec<u8> = room(size, subject)?;
    let decode = || -> image::ImageResult<bool> {
        let decoder = HdrDecoder::new_nonstrict(bytes)?;
        if decoder.dimensions() != (width, height) {
            return Ok(false);
        }
        buffer.resize(size, 0);
        decoder.read_image(&mut buffer)?;
        Ok(true)
    };
    let agrees = guarded(decode)
        .and_then(|result| result.map_err(|e| e.to_string()))
        .map_err(|e| damaged(subject, "an intact Radiance file", e).at("pixels"))?;
    if !agrees {
        let found = "two readings that differ";
        return Err(damaged(subject, "one resolution", found).at("header"));
    }
    let mut planes = Vec::new();
    for offset in [0, 4, 8] {
        let mut plane = room(size / 12, subject)?;
        plane.extend(buffer.chunks_exact(12).map(|pixel| {
            let sample: [u8; 4] = pixel[offset..offset + 4].try_into().unwrap_or_default();
            f32::from_ne_bytes(sample)
        }));
        planes.push(plane);
    }
    Ok(Planar {
        width: width as usize,
        height: height as usize,
        channels: ["R", "G", "B"].map(str::to_owned).into_iter().zip(planes).collect(),
        linear: true,
        envmap: None,
    })
}

fn damaged(subject: &str, expected: impl Into<String>, found: impl Into<String>) -> InputError {
    InputError::new(subject, expected, found, "the file is damaged or truncated; export it again")
}

/// Width, height and where the pixels start.
fn header(bytes: &[u8], subject: &str) -> Result<(u32, u32, usize), InputError> {
    let bad = |expected: &str, found: String| Err(damaged(subject, expected, found).at("header"));
    let mut at = 0;
    let mut line_number = 0;
    loop {
        let Some(length) = bytes[at..].iter().take(4096).position(|b| *b == b'\n') else {
            return bad(
                "header lines of less than 4096 bytes, then a resolution line",
                format!("no end of line {}", line_number + 1),
            );
        };
        let line = &bytes[at..at + length];
        at += length + 1;
        line_number += 1;
        if line.is_empty() {
            break;
        }
        if let Some(format) = line.strip_prefix(b"FORMAT=")
            && format.trim_ascii() != b"32-bit_rle_rgbe"
        {
            return bad("FORMAT=32-bit_rle_rgbe", text(line));
        }
    }
    let Some(length) = bytes[at..].iter().take(256).position(|b| *b == b'\n') else {
        return bad("a resolution line", "the end of the file".to_owned());
    };
    let line = text(&bytes[at..at + length]);
    let words: Vec<&str> = line.split_ascii_whitespace().collect();
    let sizes = match words[..] {
        ["-Y", height, "+X", width] => width.parse::<u32>().ok().zip(height.parse::<u32>().ok()),
        _ => None,
    };
    match sizes {
        Some((width, height))
            if (1..1 << 30).contains(&width) && (1..1 << 30).contains(&height) =>
        {
            Ok((width, height, at + length + 1))
        }
        _ => bad("a resolution line \"-Y height +X width\"", format!("\"{line}\"")),
    }
}

fn text(bytes: &[u8]) -> String {
    bytes
        .iter()
        .take(60)
        .map(|b| if b.is_ascii_graphic() || *b == b' ' { char::from(*b) } else { '?' })
        .collect()
}
