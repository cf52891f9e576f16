//! The FLIP error of two pictures: how visible their difference is when they alternate on a screen.
//!
//! Source: Andersson et al., FLIP: A Difference Evaluator for Alternating Images, HPG 2020; the
//! crate `flip-rs` ports version 1.7. It calls the platform's `powf`, so the last bits may differ
//! between machines: FLIP is printed, never hashed and never a bound.

use flip_rs::{DEFAULT_PPD, FlipError, RgbImage, ldr_flip};

use super::metrics::{Pair, compare};
use super::shown::{Show, same_size};
use crate::error::InputError;
use crate::picture::Picture;

/// Mean of the LDR FLIP map over fragments, 0 (no visible difference) to 1.
///
/// `b` is the reference. The background is black in both pictures; 67.02 pixels per degree, the
/// viewing distance of the original tool.
///
/// # Errors
///
/// The pictures differ in size, hold no fragment, hold values that are not finite, or are too
/// large for the filters.
pub fn mean_flip(a: &Picture, b: &Picture, exposure: f64) -> Result<f64, InputError> {
    same_size(a, b)?;
    let show = Show::new(exposure)?;
    let shown = |picture: &Picture| {
        let masked = picture.rgb.iter().zip(a.covered.iter().zip(&b.covered));
        let channels = masked.flat_map(|(rgb, (&in_a, &in_b))| {
            let covered = in_a || in_b;
            #[expect(
                clippy::cast_possible_truncation,
                reason = "shown values lie in [0, 1]; f32 is what FLIP works in"
            )]
            rgb.map(|channel| if covered { show.channel(channel) as f32 } else { 0.0 })
        });
        RgbImage::new(picture.width, picture.height, channels.collect())
    };
    let refused = |error: FlipError| {
        InputError::new(
            "the pictures",
            "two pictures that FLIP can filter",
            error.to_string(),
            "leave FLIP out, or compare a smaller --size",
        )
    };
    let reference = shown(b).map_err(refused)?;
    let test = shown(a).map_err(refused)?;
    let map = ldr_flip(&reference, &test, DEFAULT_PPD).map_err(refused)?;
    let covered = a.covered.iter().zip(&b.covered).map(|(&p, &q)| p || q);
    let (mut sum, mut count) = (0.0f64, 0.0f64);
    for (&error, covered) in map.pixels().iter().zip(covered) {
        if covered {
            sum += f64::from(error);
            count += 1.0;
        }
    }
    if count > 0.0 { Ok(sum / count) } else { Err(refused(FlipError::InvalidDimensions)) }
}

/// Like [`compare`], with the FLIP error as well (two to three times as long in all).
///
/// # Errors
///
/// Those of [`compare`] and of [`mean_flip`].
pub fn compare_with_flip(a: &Picture, b: &Picture, exposure: f64) -> Result<Pair, InputError> {
    let pair = compare(a, b, exposure)?;
    let flip = Some(mean_flip(a, b, exposure)?);
    Ok(Pair { flip, ..pair })
}
