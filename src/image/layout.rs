//! The shapes of environment pictures, and their conversion into a cube map.
//!
//! | picture | meaning |
//! |---|---|
//! | `envmap` latlong | lat-long, samples on the poles |
//! | `envmap` cube, 1:6 | OpenEXR's six faces, samples on the edges |
//! | 2:1, also rounded | lat-long at half-texel centres |
//! | 1:6, 6:1 | strip of faces +X −X +Y −Y +Z −Z as a GPU has them |
//! | 4:3, 3:4 | cross of faces, +Z in the middle, −X on its left; its other cells are empty |
//!
//! In a 3:4 cross the face −Z is turned by half a turn or upright, whichever fits its neighbours better.

use super::cross;
use super::cubes::{Arrangement, cut, lookup_at_halves, lookup_on_edges};
use super::latlong::LatLong;
use super::limits::LoadOptions;
use super::planar::EnvLayout;
use super::resample::{real, resample, samples_per_side};
use crate::cube::CubeLevel;
use crate::error::InputError;

/// Linear RGB pixels with the file's own word on what they are.
pub(super) struct EnvPicture {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) texels: Vec<[f32; 3]>,
    pub(super) envmap: Option<EnvLayout>,
}

/// The face size where none is asked for: the next power of two ≥ height/2 of a lat-long map.
fn latlong_face_size(height: usize) -> usize {
    height.div_ceil(2).next_power_of_two()
}

/// The shape of an environment picture, as a user names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Layout {
    /// Longitude and latitude, centres at half texels.
    LatLong,
    /// Longitude and latitude, samples on the poles and on both ends of a row (OpenEXR).
    LatLongOnPoles,
    /// Six faces in a row or a column, +X −X +Y −Y +Z −Z, as a GPU has them.
    Strip,
    /// Six faces in a column, mirrored, samples on the edges (OpenEXR).
    StripOpenexr,
    /// 4:3 cross; 3:4 cross whose −Z is turned by half a turn.
    Cross,
    /// 3:4 cross whose −Z is upright.
    CrossUpright,
}

/// How a picture is cut: nothing for a lat-long map; the arrangement and the side of its faces.
type Cut = Option<(Arrangement, usize)>;

impl Layout {
    /// How a picture of this size is cut, if it can be of this shape.
    fn cut(self, w: usize, h: usize) -> Option<Cut> {
        let wide = w.is_multiple_of(4) && w / 4 * 3 == h;
        let tall = h.is_multiple_of(4) && h / 4 * 3 == w;
        let cut = match self {
            Self::LatLong | Self::LatLongOnPoles => return Some(None),
            Self::StripOpenexr if h == 6 * w => (Arrangement::OpenExr, w),
            Self::Strip if h == 6 * w => (Arrangement::Column, w),
            Self::Strip if w == 6 * h => (Arrangement::Row, h),
            Self::Cross if wide => (Arrangement::WideCross, w / 4),
            Self::Cross if tall => (Arrangement::TallCross, h / 4),
            Self::CrossUpright if tall => (Arrangement::UprightCross, h / 4),
            Self::StripOpenexr | Self::Strip | Self::Cross | Self::CrossUpright => return None,
        };
        Some(Some(cut))
    }

    /// Its name and grid in words.
    const fn words(self) -> &'static str {
        match self {
            Self::LatLong => "lat-long, centres at half texels",
            Self::LatLongOnPoles => "lat-long, samples on the poles",
            Self::Strip => "cube strip, +X -X +Y -Y +Z -Z",
            Self::StripOpenexr => "OpenEXR's cube, faces mirrored, samples on the edges",
            Self::Cross => "cube cross",
            Self::CrossUpright => "cube cross, -Z upright",
        }
    }
}

/// The shape that a picture shows by itself, and what says so.
fn shown(picture: &EnvPicture, subject: &str) -> Result<(Layout, &'static str), InputError> {
    let (w, h) = (picture.width, picture.height);
    match picture.envmap {
        Some(EnvLayout::LatLong) => return Ok((Layout::LatLongOnPoles, "by its attribute envmap")),
        Some(EnvLayout::Cube) => return Ok((Layout::StripOpenexr, "by its attribute envmap")),
        None => {}
    }
    // 2:1, and larger maps also where a side was rounded.
    if w == 2 * h || (h >= 16 && w.abs_diff(2 * h) == 1) {
        return Ok((Layout::LatLong, "by its shape"));
    }
    if Layout::Strip.cut(w, h).is_some() {
        return Ok((Layout::Strip, "by its shape"));
    }
    let Some(Some((arrangement, side))) = Layout::Cross.cut(w, h) else {
        return Err(shape(subject, w, h, ""));
    };
    let tall = arrangement == Arrangement::TallCross;
    if !cross::empty_cells(&picture.texels, w, side, tall) {
        return Err(shape(subject, w, h, ", the shape of a cross whose empty cells are not empty"));
    }
    if !tall {
        return Ok((Layout::Cross, "by its shape and empty cells"));
    }
    let seams = |a| cross::seams(&cut(&picture.texels, w, side, a));
    let upright = seams(Arrangement::UprightCross) < seams(Arrangement::TallCross);
    Ok(if upright {
        (Layout::CrossUpright, "by its seams")
    } else {
        (Layout::Cross, "-Z turned by half a turn, by its seams")
    })
}

/// Resamples a picture into level 0 of a cube, and says what the picture was taken for.
///
/// A lat-long map becomes faces of the next power of two ≥ height/2, a cube keeps its size, unless
/// the options say otherwise. Every texel is the mean of at least 4×4 bilinear look-ups (more where
/// the source is finer, see `samples_per_side`); a GPU-style cube that keeps its size is copied.
///
/// # Errors
///
/// A shape that is none of the above, and a face size of 0 or beyond the limit.
pub(super) fn to_cube(
    picture: EnvPicture,
    options: &LoadOptions,
    subject: &str,
) -> Result<(CubeLevel, String), InputError> {
    let (layout, why) = match options.layout {
        Some(layout) => (layout, "by --env-layout"),
        None => shown(&picture, subject)?,
    };
    let EnvPicture { width, height, texels, .. } = picture;
    let arrangement = layout.cut(width, height).ok_or_else(|| {
        shape(subject, width, height, &format!(" taken {why} for: {}", layout.words()))
    })?;
    let words = format!("{} ({width}x{height}, {why})", layout.words());
    let Some((arrangement, side)) = arrangement else {
        let size = options.face_size.unwrap_or(latlong_face_size(height));
        options.admit_cube(size)?;
        let on_poles = layout == Layout::LatLongOnPoles;
        let map = LatLong { width, height, texels, on_poles };
        return Ok((map.to_cube(size), words));
    };
    let cube = cut(&texels, width, side, arrangement);
    drop(texels);
    let size = options.face_size.unwrap_or(side);
    options.admit_cube(size)?;
    let samples = samples_per_side(real(side) / real(size));
    let cube = if arrangement == Arrangement::OpenExr {
        resample(size, samples, |face, u, v| lookup_on_edges(&cube, face, u, v))
    } else if size == side {
        cube
    } else {
        resample(size, samples, |face, u, v| lookup_at_halves(&cube, face, u, v))
    };
    Ok((cube, words))
}

fn shape(subject: &str, width: usize, height: usize, found: &str) -> InputError {
    InputError::new(
        subject,
        "a lat-long map (2:1), a strip of six faces (1:6 or 6:1) or a cross (4:3 or 3:4)",
        format!("{width}x{height} pixels{found}"),
        "crop or rearrange the image, or name its shape by --env-layout",
    )
    .at("size")
}
