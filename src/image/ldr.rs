//! PNG and JPEG: code values 0..1 as stored, 8 or 16 bits; colour profiles and gamma chunks are
//! ignored (sRGB is taken for granted by whoever wants light).

use super::limits::{LoadOptions, room};
use super::planar::Planar;
use crate::base::num;
use crate::base::quiet::guarded;
use crate::error::InputError;
use image::{ImageDecoder, ImageReader, Limits};
use std::io::Cursor;

/// Reads planes R, G, B or Y, and A where there is one.
pub(super) fn read(
    bytes: &[u8],
    subject: &str,
    options: &LoadOptions,
) -> Result<Planar, InputError> {
    let damaged = |found: String| {
        InputError::new(subject, "an intact PNG or JPEG file", found, "export the image again")
    };
    let limits = || {
        let mut limits = Limits::default();
        limits.max_alloc = Some(options.max_bytes());
        limits
    };
    let result = guarded(|| -> Result<_, InputError> {
        let mut reader = ImageReader::new(Cursor::new(bytes))
            .with_guessed_format()
            .map_err(|e| damaged(e.to_string()))?;
        reader.limits(limits());
        let mut decoder = reader.into_decoder().map_err(|e| damaged(e.to_string()))?;
        let (width, height) = decoder.dimensions();
        let total = decoder.total_bytes();
        let what = format!("{width}x{height} pixels");
        options.admit(subject, u128::from(total), &what)?;
        // Deflate expands at most 1032 times (258 bytes from 2 bits), before palettes and sub-byte
        // samples widen by up to 24 (1 bit of palette index to 3 bytes).
        let most = (bytes.len() as u128) * 1032 * 24;
        if bytes.starts_with(b"\x89PNG") && u128::from(total) > most {
            return Err(damaged(format!("{what} in {} bytes", bytes.len())));
        }
        decoder.set_limits(limits()).map_err(|e| damaged(e.to_string()))?;
        let colour = decoder.color_type();
        let size = num::usize(total);
        let mut buffer = room(size, subject)?;
        buffer.resize(size, 0);
        decoder.read_image(&mut buffer).map_err(|e| damaged(e.to_string()))?;
        Ok((width, height, colour, buffer))
    });
    let (width, height, colour, buffer) = result.map_err(damaged)??;
    // `image` decodes these two formats to 8 or 16 bits only.
    let names: &[&str] = match colour.channel_count() {
        1 => &["Y"],
        2 => &["Y", "A"],
        3 => &["R", "G", "B"],
        _ => &["R", "G", "B", "A"],
    };
    let stride = usize::from(colour.bytes_per_pixel());
    let bytes_per_sample = stride / names.len();
    if width == 0 || height == 0 || !(1..=2).contains(&bytes_per_sample) {
        return Err(damaged(format!("{width}x{height} pixels of {colour:?}")));
    }
    let mut planes = Vec::new();
    for index in 0..names.len() {
        let mut plane = room(buffer.len() / stride, subject)?;
        let at = index * bytes_per_sample;
        plane.extend(buffer.chunks_exact(stride).map(|pixel| {
            match pixel[at..at + bytes_per_sample] {
                [a, b] => f32::from(u16::from_ne_bytes([a, b])) / 65535.0,
                [a, ..] => f32::from(a) / 255.0,
                [] => 0.0,
            }
        }));
        planes.push(plane);
    }
    Ok(Planar {
        width: width as usize,
        height: height as usize,
        channels: names.iter().map(|n| (*n).to_owned()).zip(planes).collect(),
        linear: false,
        envmap: None,
    })
}
