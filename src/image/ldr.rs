//! PNG and JPEG: code values 0..1 as stored, 8 or 16 bits, turned upright; the curve that the file
//! declares goes with them. Colour profiles are named, not applied.

use super::curve::{Curve, of_png};
use super::limits::{LoadOptions, room};
use super::planar::Planar;
use super::turn::Turn;
use crate::base::num;
use crate::base::quiet::guarded;
use crate::error::InputError;
use image::metadata::Orientation;
use image::{ImageDecoder, ImageError, ImageReader, Limits};
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
    let failed = |error: ImageError| {
        let ImageError::Unsupported(what) = &error else { return damaged(error.to_string()) };
        InputError::new(
            subject,
            "a PNG or JPEG file of a kind that is read",
            what.to_string(),
            "save the image as a plain PNG or a baseline JPEG",
        )
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
        let mut decoder = reader.into_decoder().map_err(failed)?;
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
        decoder.set_limits(limits()).map_err(failed)?;
        let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
        let profile = decoder.icc_profile().ok().flatten().is_some();
        let colour = decoder.color_type();
        let size = num::usize(total);
        let mut buffer = room(size, subject)?;
        buffer.resize(size, 0);
        decoder.read_image(&mut buffer).map_err(failed)?;
        Ok((width, height, colour, buffer, orientation, profile))
    });
    let (width, height, colour, buffer, orientation, profile) = result.map_err(damaged)??;
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
    let channels = names.iter().map(|n| (*n).to_owned()).zip(planes).collect();
    let mut planar = Planar::plain(width as usize, height as usize, channels);
    planar.curve = (Curve::Srgb, "as usual for JPEG");
    if bytes.starts_with(b"\x89PNG") {
        match (guarded(|| of_png(bytes)).map_err(damaged)?, options.transfer) {
            (Ok((curve, why, remarks)), _) => {
                planar.curve = (curve, why);
                planar.remarks = remarks;
            }
            (Err(_), Some(_)) => {}
            (Err(found), None) => {
                return Err(InputError::new(
                    subject,
                    "a linear picture, sRGB, BT.709 or a power",
                    found,
                    "give --transfer linear or --transfer srgb, or convert the image",
                )
                .at("cICP"));
            }
        }
    } else if profile {
        planar.remarks.push("its ICC profile is not applied".into());
    }
    turn(orientation).apply(&mut planar, subject, "EXIF orientation")?;
    Ok(planar)
}

/// The turn that makes a picture upright.
const fn turn(orientation: Orientation) -> Turn {
    let (transpose, columns, rows) = match orientation {
        Orientation::NoTransforms => (false, false, false),
        Orientation::FlipHorizontal => (false, true, false),
        Orientation::FlipVertical => (false, false, true),
        Orientation::Rotate180 => (false, true, true),
        Orientation::Rotate90 => (true, false, true),
        Orientation::Rotate270 => (true, true, false),
        Orientation::Rotate90FlipH => (true, false, false),
        Orientation::Rotate270FlipH => (true, true, true),
    };
    Turn { transpose, columns, rows }
}
