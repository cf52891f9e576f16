//! The shapes of environment pictures, and their conversion into a cube map.
//!
//! | picture | meaning |
//! |---|---|
//! | `envmap` latlong | lat-long, samples on the poles |
//! | `envmap` cube, 1:6 | OpenEXR's six faces, samples on the edges |
//! | 2:1 | lat-long at half-texel centres |
//! | 1:6, 6:1 | strip of faces +X −X +Y −Y +Z −Z as a GPU has them |
//! | 4:3, 3:4 | cross of faces, +Z in the middle, −X on its left |

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

/// Resamples a picture into level 0 of a cube.
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
) -> Result<CubeLevel, InputError> {
    let EnvPicture { width, height, texels, envmap } = picture;
    let arrangement = match (envmap, width, height) {
        (Some(EnvLayout::LatLong), ..) => None,
        (Some(EnvLayout::Cube), w, h) if h == 6 * w => Some((Arrangement::OpenExr, w)),
        (Some(EnvLayout::Cube), ..) => return Err(shape(subject, width, height, true)),
        (None, w, h) if w == 2 * h => None,
        (None, w, h) if h == 6 * w => Some((Arrangement::Column, w)),
        (None, w, h) if w == 6 * h => Some((Arrangement::Row, h)),
        (None, w, h) if w % 4 == 0 && w / 4 * 3 == h => Some((Arrangement::WideCross, w / 4)),
        (None, w, h) if h % 4 == 0 && h / 4 * 3 == w => Some((Arrangement::TallCross, h / 4)),
        (None, ..) => return Err(shape(subject, width, height, false)),
    };
    let Some((arrangement, side)) = arrangement else {
        let size = options.face_size.unwrap_or(latlong_face_size(height));
        options.admit_cube(size)?;
        let map = LatLong { width, height, texels, on_poles: envmap.is_some() };
        return Ok(map.to_cube(size));
    };
    let cube = cut(&texels, width, side, arrangement);
    drop(texels);
    let size = options.face_size.unwrap_or(side);
    options.admit_cube(size)?;
    let samples = samples_per_side(real(side) / real(size));
    Ok(if arrangement == Arrangement::OpenExr {
        resample(size, samples, |face, u, v| lookup_on_edges(&cube, face, u, v))
    } else if size == side {
        cube
    } else {
        resample(size, samples, |face, u, v| lookup_at_halves(&cube, face, u, v))
    })
}

fn shape(subject: &str, width: usize, height: usize, cube: bool) -> InputError {
    let (expected, found) = if cube {
        ("six square faces stacked vertically (1:6)", " marked as a cube")
    } else {
        ("a lat-long map (2:1), a strip of six faces (1:6 or 6:1) or a cross (4:3 or 3:4)", "")
    };
    InputError::new(
        subject,
        expected,
        format!("{width}x{height} pixels{found}"),
        "crop or rearrange the image",
    )
    .at("size")
}
