//! The eight ways in which rows and columns can be stored.

use super::limits::room;
use super::planar::Planar;
use crate::error::InputError;

/// How a stored picture becomes an upright one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Turn {
    /// Columns of the stored picture are rows of the upright one.
    pub(super) transpose: bool,
    /// Stored columns run backwards.
    pub(super) columns: bool,
    /// Stored rows run backwards.
    pub(super) rows: bool,
}

impl Turn {
    /// Turns every plane of a picture; `what` names the reason in the remarks.
    pub(super) fn apply(
        self,
        planar: &mut Planar,
        subject: &str,
        what: &str,
    ) -> Result<(), InputError> {
        if self == Self::default() {
            return Ok(());
        }
        let (width, height) = (planar.width, planar.height);
        let [columns, rows] = if self.transpose { [height, width] } else { [width, height] };
        for (_, plane) in &mut planar.channels {
            let mut out = room(plane.len(), subject)?;
            for y in 0..rows {
                out.extend((0..columns).map(|x| {
                    let (a, b) = if self.transpose { (y, x) } else { (x, y) };
                    let a = if self.columns { width - 1 - a } else { a };
                    let b = if self.rows { height - 1 - b } else { b };
                    plane[b * width + a]
                }));
            }
            *plane = out;
        }
        (planar.width, planar.height) = (columns, rows);
        planar.remarks.push(format!("turned upright by its {what}"));
        Ok(())
    }
}
