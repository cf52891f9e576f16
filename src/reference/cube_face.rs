//! Stage `cube_face`: the face, 1/|ma| and the coordinates on the face.

use super::flags::{Flag, Flags};
use super::real::Real;
use super::tap::{Tap, put};
use super::vector::{Vector, transform};
use crate::cube::FACE_AXES;
use crate::stage::Stage;

/// Where a direction meets the cube.
#[derive(Clone, Copy, Debug)]
pub struct Facing<R> {
    /// Face, 0…5 for +x −x +y −y +z −z.
    pub face: usize,
    /// 1/|ma|; 0 where the direction is zero.
    pub inv_ma: R,
    /// sc/|ma|.
    pub u: R,
    /// tc/|ma|.
    pub v: R,
}

/// Face, 1/|ma|, u = sc/|ma| and v = tc/|ma| of A·v_r (`rotation` is `None` for the identity).
///
/// On equal magnitudes z wins over y over x. v_r = 0 gives +z, u = v = 0 and 1/|ma| = 0, so that
/// all derivatives become 0, and raises `cube_face.zero`.
#[inline]
pub fn cube_face<R: Real, T: Tap>(
    v_r: Vector<R>,
    rotation: Option<&[[R; 3]; 3]>,
    flags: &mut Flags,
    tap: &mut T,
) -> Facing<R> {
    let zero = R::from_f64(0.0);
    let d = match rotation {
        Some(matrix) => {
            let rotated = transform(matrix, v_r);
            put(tap, Stage::CubeFace, "rotated", &rotated);
            rotated
        }
        None => v_r,
    };
    let [x, y, z] = d.map(R::abs);
    let axis = if z >= x && z >= y {
        2
    } else if y >= x {
        1
    } else {
        0
    };
    let face = 2 * axis + usize::from(d[axis] < zero);
    let ma = d[axis].abs();
    let facing = if ma.is_zero() {
        flags.insert(Flag::Zero);
        Facing { face, inv_ma: zero, u: zero, v: zero }
    } else {
        let [s, t, _] = FACE_AXES[face].map(|(axis, sign)| signed(d[axis], sign));
        Facing { face, inv_ma: R::from_f64(1.0) / ma, u: s / ma, v: t / ma }
    };
    put(tap, Stage::CubeFace, "inv_ma", &[facing.inv_ma]);
    put(tap, Stage::CubeFace, "u", &[facing.u]);
    put(tap, Stage::CubeFace, "v", &[facing.v]);
    facing
}

/// The value with the sign of a face axis.
pub(super) fn signed<R: Real>(value: R, sign: f64) -> R {
    if sign < 0.0 { -value } else { value }
}

impl<R: Real> Facing<R> {
    /// G without its factor 1/|ma|: (∂sc − u·∂|ma|, ∂tc − v·∂|ma|) of a derivative of the direction.
    #[inline]
    pub fn numerator(&self, derivative: Vector<R>) -> [R; 2] {
        let [s, t, m] = FACE_AXES[self.face].map(|(axis, sign)| signed(derivative[axis], sign));
        [s - self.u * m, t - self.v * m]
    }
}
