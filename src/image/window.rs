//! The data window of an EXR file inside its display window.

use super::limits::LoadOptions;
use super::limits::room;
use super::planar::Planar;
use crate::error::InputError;

/// Where an EXR file has pixels, and which part of the plane it shows: first column and row, last
/// column and row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Windows {
    /// Pixels that are stored.
    pub data: [i64; 4],
    /// The frame.
    pub display: [i64; 4],
}

fn show([x0, y0, x1, y1]: [i64; 4]) -> String {
    format!("({x0}, {y0})-({x1}, {y1})")
}

/// What was done to fit the data window into the display window; empty where they are the same.
pub(super) struct Fitted {
    /// Columns and rows of the result.
    pub(super) size: [usize; 2],
    /// Column and row of the stored picture at the result's first pixel; may be negative.
    from: [i64; 2],
    stored: [usize; 2],
    /// In words.
    pub(super) words: String,
}

/// The place of the stored pixels in the frame. `fill` says whether gaps may be filled. Files with an `envmap` attribute
/// are taken by their data window, which that attribute's definition refers to.
///
/// # Errors
/// A data window that leaves gaps which nothing fills.
pub(super) fn fitted(
    planar: &Planar,
    options: &LoadOptions,
    subject: &str,
) -> Result<Fitted, InputError> {
    let stored = [planar.width, planar.height];
    let whole = Fitted { size: stored, from: [0; 2], stored, words: String::new() };
    let Some(Windows { data, display }) = planar.windows else { return Ok(whole) };
    if data == display || planar.envmap.is_some() {
        return Ok(whole);
    }
    let side = |i: usize| usize::try_from(display[i + 2] - display[i] + 1).ok().filter(|n| *n > 0);
    let (Some(width), Some(height)) = (side(0), side(1)) else { return Ok(whole) };
    let inside = [0, 1].iter().all(|i| data[*i] <= display[*i] && display[i + 2] <= data[i + 2]);
    if !inside && options.fill.is_none() {
        return Err(InputError::new(
            subject,
            format!("pixels in the whole display window {}", show(display)),
            format!("a data window {} that leaves gaps", show(data)),
            "give --fill R,G,B for the rest of the frame, or export the whole frame",
        )
        .at("dataWindow"));
    }
    let what = format!("{width}x{height} pixels of the display window");
    options.admit(subject, 12 * width as u128 * height as u128, &what)?;
    let done = if inside { "cropped to" } else { "filled up to" };
    let words = format!("data window {} {done} display window {}", show(data), show(display));
    Ok(Fitted {
        size: [width, height],
        from: [display[0] - data[0], display[1] - data[1]],
        stored,
        words,
    })
}

impl Fitted {
    /// A plane in the frame; `fill` where nothing is stored.
    pub(super) fn plane(
        &self,
        plane: Vec<f32>,
        fill: f32,
        subject: &str,
    ) -> Result<Vec<f32>, InputError> {
        if self.words.is_empty() {
            return Ok(plane);
        }
        let [width, height] = self.size;
        let mut out = room(width * height, subject)?;
        let inside = |at: i64, size: usize| usize::try_from(at).ok().filter(|at| *at < size);
        for y in (self.from[1]..).take(height) {
            let row = inside(y, self.stored[1]);
            out.extend((self.from[0]..).take(width).map(|x| {
                let place = row.zip(inside(x, self.stored[0]));
                place.map_or(fill, |(row, column)| plane[row * self.stored[0] + column])
            }));
        }
        Ok(out)
    }
}
