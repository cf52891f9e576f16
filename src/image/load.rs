//! Loading images: the kind of a file, its limits, its colours, its bad texels.

use super::exr_in::{self, Want};
use super::layout::{EnvPicture, to_cube};
use super::limits::{LoadOptions, room};
use super::planar::{Colour, Planar};
use super::{ldr, mips, radiance};
use crate::base::num;
use crate::cube::CubeMap;
use crate::error::InputError;
use crate::planar::{PlanarLevel, PlanarMap};
use crate::srgb::srgb_decode;
use std::io::Read;
use std::path::Path;

/// Samples that were not usable as light and what became of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cleaned {
    /// NaN, now 0.
    pub nan: u64,
    /// +∞, now 65504 (the largest half), and −∞, now 0.
    pub inf: u64,
    /// Finite and below zero, now 0.
    pub negative: u64,
}

impl Cleaned {
    /// All of them.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.nan + self.inf + self.negative
    }

    /// One line for stderr, or nothing where nothing was wrong.
    #[must_use]
    pub fn note(&self, subject: &str) -> Option<String> {
        (self.total() > 0).then(|| {
            format!(
                "{subject}: cleaned {} texel samples: {} NaN (now 0), {} infinite (+ now 65504, - now 0), {} negative (now 0)",
                self.total(),
                self.nan,
                self.inf,
                self.negative
            )
        })
    }

    /// Cleans samples in place and counts them. Finite values beyond 65504 stay.
    pub fn clean(&mut self, samples: &mut [f32]) {
        for s in samples {
            if s.is_nan() {
                self.nan += 1;
                *s = 0.0;
            } else if s.is_infinite() {
                self.inf += 1;
                *s = if *s > 0.0 { 65504.0 } else { 0.0 };
            } else if *s < 0.0 {
                self.negative += 1;
                *s = 0.0;
            } else {
                // −0 becomes +0.
                *s += 0.0;
            }
        }
    }
}

/// Loads the top level of any image as planes.
///
/// EXR: the first part, its data window, channel names as stored (u32 samples rounded to f32).
///
/// # Errors
///
/// See [`load_planar_levels`].
pub fn load_planar(path: &Path, options: &LoadOptions) -> Result<Planar, InputError> {
    only(load(path, options, Want::Top)?, path)
}

/// Loads every stored mip level, level 0 first; files without a mip chain have one.
///
/// # Errors
///
/// A file that cannot be read, is of no known kind, exceeds the limit, is damaged, or holds what
/// is refused by name: deep data, sub-sampled channels, compressions that the decoder lacks.
pub fn load_planar_levels(path: &Path, options: &LoadOptions) -> Result<Vec<Planar>, InputError> {
    load(path, options, Want::AllMips)
}

/// Loads an environment as a cube map with its mip chain, and says what had to be cleaned.
///
/// Colours as [`Planar::colour`] finds them, PNG and JPEG decoded from sRGB; NaN, infinite and
/// negative samples cleaned before any filtering; alpha ignored; pixels are those of the data
/// window wherever the display window lies. Layouts: see [`super::layout`].
///
/// # Errors
///
/// As [`load_planar_levels`], and where colours or layout are not understood, or the cube of
/// `face_size` (or of the map's own choice) exceeds four times the limit.
pub fn load_environment(
    path: &Path,
    options: &LoadOptions,
) -> Result<(CubeMap, Cleaned), InputError> {
    let subject = path.display().to_string();
    if let Some(size) = options.face_size {
        options.admit_cube(size)?;
    }
    let planar = load_planar(path, options)?;
    let (width, height, envmap) = (planar.width, planar.height, planar.envmap);
    let (texels, cleaned) = linear(planar, &subject)?;
    let picture = EnvPicture { width, height, texels, envmap };
    let level0 = to_cube(picture, options, &subject)?;
    Ok((mips::build_mips(level0), cleaned))
}

/// Loads a 2-D texture with its mip chain, and says what had to be cleaned. Colours as in [`load_environment`].
///
/// # Errors
///
/// As [`load_planar_levels`], and where colours are not understood or a side exceeds [`MAX_TEXTURE`].
pub fn load_texture(
    path: &Path,
    options: &LoadOptions,
) -> Result<(PlanarMap, Cleaned), InputError> {
    let subject = path.display().to_string();
    let planar = load_planar(path, options)?;
    let size = [planar.width, planar.height];
    if size.iter().any(|n| *n > MAX_TEXTURE) {
        return Err(InputError::new(
            subject,
            format!("a texture of at most {MAX_TEXTURE} columns and rows"),
            format!("{}x{}", size[0], size[1]),
            "scale the image down",
        )
        .at("size"));
    }
    let (texels, cleaned) = linear(planar, &subject)?;
    Ok((mips::build_planar_mips(PlanarLevel { size, texels }), cleaned))
}

/// Longest side of a 2-D texture, which the unit's address registers are made for.
pub const MAX_TEXTURE: usize = 1 << 15;

/// A picture's linear RGB, cleaned.
fn linear(mut planar: Planar, subject: &str) -> Result<(Vec<[f32; 3]>, Cleaned), InputError> {
    let colour = planar.colour(subject)?;
    let mut cleaned = Cleaned::default();
    let (linear, width, height) = (planar.linear, planar.width, planar.height);
    let mut take = |index: usize| {
        let mut samples = std::mem::take(&mut planar.channels[index].1);
        cleaned.clean(&mut samples);
        if !linear {
            for s in &mut samples {
                *s = num::f32(srgb_decode(f64::from(*s)));
            }
        }
        samples
    };
    let mut texels: Vec<[f32; 3]> = room(width * height, subject)?;
    match colour {
        Colour::Grey(y) => texels.extend(take(y).into_iter().map(|v| [v; 3])),
        Colour::Rgb([r, g, b]) => {
            let (r, g, b) = (take(r), take(g), take(b));
            texels.extend(r.into_iter().zip(g).zip(b).map(|((r, g), b)| [r, g, b]));
        }
    }
    Ok((texels, cleaned))
}

fn only(levels: Vec<Planar>, path: &Path) -> Result<Planar, InputError> {
    levels
        .into_iter()
        .next()
        .ok_or_else(|| InputError::new(path.display().to_string(), "an image", "no pixels", ""))
}

fn load(path: &Path, options: &LoadOptions, want: Want) -> Result<Vec<Planar>, InputError> {
    let subject = path.display().to_string();
    let bytes = read_file(path, &subject, options)?;
    let hdr_name = path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("hdr") || e.eq_ignore_ascii_case("pic"));
    if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        exr_in::read(&bytes, &subject, options, want)
    } else if bytes.starts_with(b"#?") || hdr_name {
        Ok(vec![radiance::read(&bytes, &subject, options)?])
    } else if bytes.starts_with(b"\x89PNG") || bytes.starts_with(&[0xff, 0xd8, 0xff]) {
        Ok(vec![ldr::read(&bytes, &subject, options)?])
    } else {
        let start: Vec<String> = bytes.iter().take(4).map(|b| format!("{b:02x}")).collect();
        let found = if start.is_empty() {
            "an empty file".to_owned()
        } else {
            format!("a file that starts with the bytes {}", start.join(" "))
        };
        Err(InputError::new(
            subject,
            "an OpenEXR, Radiance HDR, PNG or JPEG file",
            found,
            "convert the image to one of these",
        ))
    }
}

fn read_file(path: &Path, subject: &str, options: &LoadOptions) -> Result<Vec<u8>, InputError> {
    let unreadable = |error: std::io::Error| {
        InputError::new(subject, "a readable image file", error.to_string(), "check the path")
    };
    let limit = options.max_bytes().saturating_mul(4);
    let file = std::fs::File::open(path).map_err(unreadable)?;
    let mut bytes = Vec::new();
    file.take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(unreadable)?;
    if u64::try_from(bytes.len()).is_ok_and(|n| n > limit) {
        return Err(InputError::new(
            subject,
            format!("a file of at most {} MiB", options.max_image_mb.saturating_mul(4)),
            "a larger one",
            "raise the limit with --max-image-mb",
        ));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_samples_are_replaced_and_counted() {
        let mut samples = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, -0.0, 0.25, 1.0e30];
        let mut cleaned = Cleaned::default();
        cleaned.clean(&mut samples);
        let expected = [0.0f32, 65504.0, 0.0, 0.0, 0.0, 0.25, 1.0e30];
        assert_eq!(samples.map(f32::to_bits), expected.map(f32::to_bits));
        let counts = Cleaned { nan: 1, inf: 2, negative: 1 };
        assert_eq!(cleaned, counts);
        assert!(cleaned.note("f").is_some_and(|n| n.starts_with("f: cleaned 4")));
        assert_eq!(Cleaned::default().note("f"), None);
    }
}
