//! Stage `bump`: the normal moved by the bump map.

use super::local_frame::Frame;
use super::real::Real;
use super::tap::{Tap, put};
use super::vector::{Vector, add, scale};
use crate::stage::Stage;

/// n_mod = n + b1·e1 + b2·e2 (Schilling, above eq. 4).
#[inline]
pub fn bump<R: Real, T: Tap>(n: Vector<R>, frame: &Frame<R>, b: [R; 2], tap: &mut T) -> Vector<R> {
    let n_mod = add(add(n, scale(b[0], frame.e1)), scale(b[1], frame.e2));
    put(tap, Stage::Bump, "b", &b);
    put(tap, Stage::Bump, "n_mod", &n_mod);
    n_mod
}
