//! Two pictures made ready for a comparison: equal sizes, and light as a screen shows it.

use crate::error::InputError;
use crate::picture::Picture;
use crate::srgb::srgb_encode;

/// From linear light to displayed values: exposure, clamp, sRGB.
#[derive(Clone, Copy, Debug)]
pub struct Show {
    scale: f64,
}

impl Show {
    /// Shows with an exposure in stops.
    ///
    /// # Errors
    ///
    /// `exposure` is not within ±64.
    pub fn new(exposure: f64) -> Result<Self, InputError> {
        if (-64.0..=64.0).contains(&exposure) {
            Ok(Self { scale: libm::exp2(exposure) })
        } else {
            Err(InputError::new(
                "--exposure",
                "stops from -64 to 64",
                format!("{exposure}"),
                "0 shows linear 1 as white; each stop doubles the light",
            ))
        }
    }

    /// The shown value of a linear channel, in [0, 1].
    #[must_use]
    pub fn channel(self, linear: f64) -> f64 {
        srgb_encode((linear * self.scale).clamp(0.0, 1.0))
    }
}

/// Refuses two pictures of different size.
///
/// # Errors
///
/// The sizes differ; the message has both.
pub fn same_size(a: &Picture, b: &Picture) -> Result<(), InputError> {
    if (a.width, a.height) == (b.width, b.height) {
        Ok(())
    } else {
        Err(InputError::new(
            "the second picture",
            format!("{}x{} pixels like the first", a.width, a.height),
            format!("{}x{}", b.width, b.height),
            "render both at the same --size",
        ))
    }
}
