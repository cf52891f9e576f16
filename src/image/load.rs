//! Loading images: the kind of a file, its limits, its colours, its bad texels.

use super::curve::Curve;
use super::exr_in::{self, Suits, Want};
use super::layout::{EnvPicture, to_cube};
use super::limits::{LoadOptions, room};
use super::planar::{Colour, Planar};
use super::{colours, ldr, radiance, window};
use crate::base::num;
use crate::cube::CubeMap;
use crate::error::InputError;
use crate::mips;
use crate::planar::{PlanarLevel, PlanarMap};
use crate::taken::Taken;
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

/// A map, what had to be cleaned of its texels, and what its file was taken for.
#[derive(Clone, Debug, PartialEq)]
pub struct Loaded<M, C = Cleaned> {
    /// The map.
    pub map: M,
    /// What was cleaned.
    pub cleaned: C,
    /// In words.
    pub taken: Taken,
}

/// Loads the top level of any image as planes.
///
/// EXR: the first part with colours, else the first; `FILE.exr:NAME` names a part, a layer or a
/// channel; the data window, channel names as stored (u32 samples rounded to f32).
///
/// # Errors
///
/// See [`load_planar_levels`].
pub fn load_planar(path: &Path, options: &LoadOptions) -> Result<Planar, InputError> {
    only(load(path, options, Want::Top, &has_light)?, path)
}

/// The same for another purpose.
pub(super) fn load_planar_for(
    path: &Path,
    options: &LoadOptions,
    suits: Suits<'_>,
) -> Result<Planar, InputError> {
    only(load(path, options, Want::Top, suits)?, path)
}

/// Loads every stored mip level, level 0 first; files without a mip chain have one.
///
/// # Errors
///
/// A file that cannot be read, is of no known kind, exceeds the limit, is damaged, or holds what
/// is refused by name: deep data, sub-sampled channels, compressions that the decoder lacks.
pub fn load_planar_levels(path: &Path, options: &LoadOptions) -> Result<Vec<Planar>, InputError> {
    load(path, options, Want::AllMips, &has_light)
}

/// Three colours before a single channel.
pub(super) fn has_light(names: &[&str], layer: Option<&str>) -> u8 {
    match colours::find(names, layer) {
        Ok(Colour::Rgb(_)) => 2,
        Ok(Colour::Grey(_)) => 1,
        Err(_) => 0,
    }
}

/// Loads an environment as a cube map with its mip chain, and says what it was taken for.
///
/// Colours as [`Planar::colour`] finds them, decoded by the file's curve; NaN, infinite and negative
/// samples cleaned before any filtering; alpha ignored; pixels outside the display window cropped.
/// Layouts: see [`super::layout`].
///
/// # Errors
///
/// As [`load_planar_levels`], and where colours, window or layout are not understood, or the cube of
/// `face_size` (or of the map's own choice) exceeds four times the limit.
pub fn load_environment(path: &Path, options: &LoadOptions) -> Result<Loaded<CubeMap>, InputError> {
    let subject = path.display().to_string();
    if let Some(size) = options.face_size {
        options.admit_cube(size)?;
    }
    let planar = load_planar(path, options)?;
    let envmap = planar.envmap;
    let Light { size: [width, height], texels, cleaned, mut taken } =
        light(planar, options, &subject)?;
    let picture = EnvPicture { width, height, texels, envmap };
    let (level0, kind) = to_cube(picture, options, &subject)?;
    taken.option = "--env";
    taken.kind = kind;
    taken.flags = &["--env-layout", "--transfer", "--fill", "FILE.exr:NAME"];
    Ok(Loaded { map: mips::build_mips(level0), cleaned, taken })
}

/// Loads a 2-D texture with its mip chain, and says what had to be cleaned. Colours as in [`load_environment`].
///
/// # Errors
///
/// As [`load_planar_levels`], and where colours are not understood or a side exceeds [`MAX_TEXTURE`].
pub fn load_texture(path: &Path, options: &LoadOptions) -> Result<Loaded<PlanarMap>, InputError> {
    let subject = path.display().to_string();
    let planar = load_planar(path, options)?;
    let Light { size, texels, cleaned, mut taken } = light(planar, options, &subject)?;
    if size.iter().any(|n| *n > MAX_TEXTURE) {
        return Err(InputError::new(
            subject,
            format!("a texture of at most {MAX_TEXTURE} columns and rows"),
            format!("{}x{}", size[0], size[1]),
            "scale the image down",
        )
        .at("size"));
    }
    taken.option = "--texture";
    taken.kind = format!("texture {}x{}, s to the right, t down", size[0], size[1]);
    taken.flags = &["--transfer", "--fill", "FILE.exr:NAME"];
    Ok(Loaded { map: mips::build_planar_mips(PlanarLevel { size, texels }), cleaned, taken })
}

/// The largest number of 16 bits, which is what most units store.
const LARGEST_HALF: f32 = 65504.0;

/// Longest side of a 2-D texture, which the unit's address registers are made for.
pub const MAX_TEXTURE: usize = 1 << 15;

/// A picture's linear RGB, cleaned, in its display window.
struct Light {
    size: [usize; 2],
    texels: Vec<[f32; 3]>,
    cleaned: Cleaned,
    taken: Taken,
}

fn light(mut planar: Planar, options: &LoadOptions, subject: &str) -> Result<Light, InputError> {
    let colour = planar.colour(subject)?;
    let fitted = window::fitted(&planar, options, subject)?;
    let (curve, why) = match options.transfer {
        Some(transfer) => (Curve::from(transfer), "by --transfer"),
        None => planar.curve,
    };
    let mut taken = Taken {
        file: subject.to_owned(),
        from: planar.source(colour),
        transfer: [curve.name().as_str(), why].join(" ").trim_end().to_owned(),
        window: fitted.words.clone(),
        remarks: std::mem::take(&mut planar.remarks),
        ..Taken::default()
    };
    let mut cleaned = Cleaned::default();
    let fill = options.fill.unwrap_or_default();
    let mut take = |index: usize, fill: f32| -> Result<Vec<f32>, InputError> {
        let mut samples = std::mem::take(&mut planar.channels[index].1);
        cleaned.clean(&mut samples);
        if curve != Curve::Linear {
            for s in &mut samples {
                *s = num::f32(curve.decode(f64::from(*s)));
            }
        }
        fitted.plane(samples, fill, subject)
    };
    let mut texels: Vec<[f32; 3]> = room(fitted.size[0] * fitted.size[1], subject)?;
    match colour {
        Colour::Grey(y) => {
            texels.extend(take(y, fill[1])?.into_iter().map(|v| [v; 3]));
        }
        Colour::Rgb([r, g, b]) => {
            let (r, g, b) = (take(r, fill[0])?, take(g, fill[1])?, take(b, fill[2])?);
            texels.extend(r.into_iter().zip(g).zip(b).map(|((r, g), b)| [r, g, b]));
        }
    }
    let top = |texel: &[f32; 3]| texel.iter().copied().fold(0.0, f32::max);
    let beyond = texels.iter().map(top).filter(|c| *c > LARGEST_HALF);
    let (count, largest) = beyond.fold((0u64, 0.0f32), |(n, most), c| (n + 1, most.max(c)));
    if count > 0 {
        taken.remarks.push(format!("{count} pixels beyond {LARGEST_HALF}, the largest {largest}"));
    }
    Ok(Light { size: fitted.size, texels, cleaned, taken })
}

fn only(levels: Vec<Planar>, path: &Path) -> Result<Planar, InputError> {
    levels
        .into_iter()
        .next()
        .ok_or_else(|| InputError::new(path.display().to_string(), "an image", "no pixels", ""))
}

/// A file, and the part, layer or channel that is named behind its `.exr:`.
pub(super) fn selector(path: &Path) -> (&Path, Option<&str>) {
    let split = || {
        let (file, name) = path.to_str()?.rsplit_once(':')?;
        (file.to_ascii_lowercase().ends_with(".exr") && !path.exists()).then_some((file, name))
    };
    split().map_or((path, None), |(file, name)| (Path::new(file), Some(name)))
}

fn load(
    path: &Path,
    options: &LoadOptions,
    want: Want,
    suits: Suits<'_>,
) -> Result<Vec<Planar>, InputError> {
    let (path, chosen) = selector(path);
    let piped = path.as_os_str() == "-";
    let subject = if piped { "standard input".into() } else { path.display().to_string() };
    let bytes = read_file(path, &subject, options)?;
    let hdr_name = path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("hdr") || e.eq_ignore_ascii_case("pic"));
    if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        exr_in::read(&bytes, &subject, options, want, (chosen, suits))
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
    let file: Box<dyn Read> = if path.as_os_str() == "-" {
        Box::new(std::io::stdin().lock())
    } else {
        Box::new(std::fs::File::open(path).map_err(unreadable)?)
    };
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
