//! Stage `local_frame`: the tangent vectors e1 and e2.

use super::flags::{Flag, Flags};
use super::real::Real;
use super::tap::{Tap, put};
use super::vector::{Vector, cross, dot, scale};
use crate::stage::Stage;

/// The local frame and what its derivatives need.
#[derive(Clone, Copy, Debug)]
pub struct Frame<R> {
    /// The main direction that was used: h, or a unit axis where h ∥ n.
    pub h: Vector<R>,
    /// Unit vector along h × n (zero where n = 0).
    pub direction: Vector<R>,
    /// 1/|h × n| (0 where n = 0).
    pub inv_length: R,
    /// |n|.
    pub n_length: R,
    /// e1, as long as n.
    pub e1: Vector<R>,
    /// e2, as long as n.
    pub e2: Vector<R>,
}

/// e1 = (h × n)/|h × n|·|n|, e2 = (n × e1)/|n| (Schilling, appendix A; both are as long as n).
///
/// Where h × n is exactly zero, h is replaced by the axis e_k with the smallest |n_k| (on equal
/// magnitudes z wins over y over x) and `local_frame.parallel` is raised; n = 0 gives e1 = e2 = 0.
#[inline]
pub fn local_frame<R: Real, T: Tap>(
    n: Vector<R>,
    h: Vector<R>,
    flags: &mut Flags,
    tap: &mut T,
) -> Frame<R> {
    let zero = R::from_f64(0.0);
    let mut used = h;
    let mut c = cross(h, n);
    if c.iter().all(|x| x.is_zero()) {
        flags.insert(Flag::Parallel);
        let [x, y, z] = n.map(R::abs);
        let axis = if z <= x && z <= y {
            2
        } else if y <= x {
            1
        } else {
            0
        };
        used = [zero; 3];
        used[axis] = R::from_f64(1.0);
        c = cross(used, n);
    }
    let length = dot(c, c).sqrt();
    let inv_length = if length.is_zero() { zero } else { R::from_f64(1.0) / length };
    let n_length = dot(n, n).sqrt();
    let direction = scale(inv_length, c);
    let e1 = scale(n_length, direction);
    let e2 = cross(n, direction);
    let stage = Stage::LocalFrame;
    put(tap, stage, "n", &n);
    put(tap, stage, "h", &used);
    put(tap, stage, "cross", &c);
    put(tap, stage, "inv_length", &[inv_length]);
    put(tap, stage, "e1", &e1);
    put(tap, stage, "e2", &e2);
    Frame { h: used, direction, inv_length, n_length, e1, e2 }
}
