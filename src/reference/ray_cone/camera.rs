//! Cones at the camera, and which of two counts, in doubles.

use super::{Angle, Cone, Width};
use crate::reference::real::Real as _;
use crate::reference::vector::{Vector, dot, vector};
use crate::reference::wide::Wide;

/// The camera's frame and the picture's size in pixels: W from the eye to the middle of the view rectangle, |U| and |V|
/// half of its width and height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// To the right.
    pub u: [f64; 3],
    /// Upwards.
    pub v: [f64; 3],
    /// To the middle.
    pub w: [f64; 3],
    /// Columns and rows; 0 counts as 1.
    pub size: [u32; 2],
}

fn length(v: Vector<Wide>) -> Wide {
    dot(v, v).sqrt()
}

/// A pixel's width on the image plane, 2·min(|U|/columns, |V|/rows).
#[must_use]
pub fn pixel_width(frame: &Frame) -> f64 {
    pixel(frame).to_f64()
}

fn pixel(frame: &Frame) -> Wide {
    let side = |axis: [f64; 3], pixels: u32| {
        let two = Wide::from_f64(2.0);
        two * length(vector(axis)) / Wide::from_f64(f64::from(pixels.max(1)))
    };
    let (a, b) = (side(frame.u, frame.size[0]), side(frame.v, frame.size[1]));
    if a < b { a } else { b }
}

/// ⟨D,W⟩/⟨W,W⟩; 0 where W is 0.
fn per_distance(frame: &Frame, direction: [f64; 3]) -> Wide {
    let w = vector::<Wide>(frame.w);
    let square = dot(w, w);
    if square.is_zero() {
        return square;
    }
    dot(vector(direction), w) / square
}

/// α = 2 min(|U|/columns, |V|/rows)·⟨D,W⟩/⟨W,W⟩, w = 0.
#[must_use]
pub fn pinhole(frame: &Frame, direction: [f64; 3]) -> Cone {
    Cone {
        angle: Angle((pixel(frame) * per_distance(frame, direction)).to_f64()),
        width: Width(0.0),
    }
}

/// α = −w_lens⟨D,W⟩/⟨W,W⟩, w = w_lens.
#[must_use]
pub fn thin_lens(frame: &Frame, direction: [f64; 3], lens_width: f64) -> Cone {
    let angle = -(Wide::from_f64(lens_width) * per_distance(frame, direction));
    Cone { angle: Angle(angle.to_f64()), width: Width(lens_width) }
}

/// α = 0, w = a pixel's width on the image plane.
#[must_use]
pub fn orthographic(frame: &Frame) -> Cone {
    Cone { angle: Angle(0.0), width: Width(pixel_width(frame)) }
}

/// Which of two cones a look-up takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Larger {
    /// The larger |w|: HIT and TEX. The first one on ties.
    Width,
    /// The larger |α|: ENV. The first one on ties.
    Angle,
}

/// The cone of two that a look-up takes; `alone` is the first-hit exception of pinhole and orthographic cameras.
#[must_use]
pub fn choose([first, second]: [Cone; 2], larger: Larger, alone: bool) -> Cone {
    let magnitude = |cone: Cone| match larger {
        Larger::Width => cone.width.0.abs(),
        Larger::Angle => cone.angle.0.abs(),
    };
    if alone || magnitude(first) >= magnitude(second) { first } else { second }
}
