//! The limits that a user sets on an image.

use super::curve::Transfer;
use super::layout::Layout;
use crate::error::InputError;

/// What a user allows and asks for.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadOptions {
    /// Largest image in MiB (2²⁰ bytes) of uncompressed pixels: EXR as stored, Radiance as 12 bytes
    /// a pixel, PNG and JPEG as decoded. A file, and level 0 of a cube as f32, may have four times that.
    pub max_image_mb: u64,
    /// Texels along a cube's edge; the map's own choice where absent.
    pub face_size: Option<usize>,
    /// The shape of an environment, instead of what its size says.
    pub layout: Option<Layout>,
    /// The curve of samples, instead of the file's word.
    pub transfer: Option<Transfer>,
    /// The colour of what a data window leaves empty of its display window.
    pub fill: Option<[f32; 3]>,
    /// Distances from here on mean that nothing is there.
    pub far: Option<f64>,
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self {
            max_image_mb: 512,
            face_size: None,
            layout: None,
            transfer: None,
            fill: None,
            far: None,
        }
    }
}

impl LoadOptions {
    /// The limit in bytes.
    #[must_use]
    pub fn max_bytes(&self) -> u64 {
        self.max_image_mb.saturating_mul(1 << 20)
    }

    /// Refuses a cube whose level 0 as f32 RGB (72 bytes a texel of a face) exceeds four times the
    /// limit, or that has no texels.
    pub(super) fn admit_cube(&self, size: usize) -> Result<(), InputError> {
        let size = size as u128;
        let bytes = size.saturating_mul(size).saturating_mul(72);
        if size > 0 && bytes <= 4 * u128::from(self.max_bytes()) {
            return Ok(());
        }
        let mb = self.max_image_mb.saturating_mul(4);
        Err(InputError::new(
            "--face-size",
            format!(
                "faces of at least one texel that fit into {mb} MiB, four times --max-image-mb"
            ),
            format!("{size}x{size} texels"),
            "ask for another size with --face-size",
        ))
    }

    /// Refuses `bytes` of pixels beyond the limit.
    pub(super) fn admit(&self, subject: &str, bytes: u128, what: &str) -> Result<(), InputError> {
        if bytes <= u128::from(self.max_bytes()) {
            return Ok(());
        }
        let mb = bytes.div_ceil(1 << 20);
        Err(InputError::new(
            subject,
            format!("at most {} MiB of pixels", self.max_image_mb),
            format!("{what}, {mb} MiB"),
            format!("raise the limit with --max-image-mb {mb} if the file is to be trusted"),
        )
        .at("size"))
    }
}

/// An empty vector with room for `n`, or an error where memory does not suffice.
pub(super) fn room<T>(n: usize, subject: &str) -> Result<Vec<T>, InputError> {
    let mut out = Vec::new();
    out.try_reserve_exact(n).map_err(|_| {
        InputError::new(
            subject,
            "an image that fits into memory",
            format!("one that needs another {} MiB", n.saturating_mul(size_of::<T>()) >> 20),
            "scale the image down",
        )
    })?;
    Ok(out)
}
