//! What reflects: solids with a normal and a curvature at every point.

use std::fmt::Debug;

use crate::scene::world::Body;
use crate::scene::world::bodies::Ball;

/// A point of a reflective surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Skin {
    /// The point is origin + t · direction.
    pub t: f64,
    /// Unit shading normal that faces the ray's origin.
    pub normal: [f64; 3],
    /// Curvature k for that normal, per world unit: positive where the surface bulges towards the ray.
    pub curvature: f64,
}

/// A reflective solid: a ball, or a mesh with smooth normals.
pub trait Object: Debug + Send + Sync {
    /// The first meeting with t > `beyond`. `direction` has any length but zero.
    fn skin(&self, origin: [f64; 3], direction: [f64; 3], beyond: f64) -> Option<Skin>;
}

impl Object for Ball {
    fn skin(&self, origin: [f64; 3], direction: [f64; 3], beyond: f64) -> Option<Skin> {
        let meeting = self.meet(origin, direction, beyond)?;
        let at = [0, 1, 2].map(|i| origin[i] + meeting.t * direction[i] - self.centre[i]);
        let outside = (0..3).map(|i| at[i] * meeting.normal[i]).sum::<f64>() > 0.0;
        Some(Skin {
            t: meeting.t,
            normal: meeting.normal,
            curvature: if outside { 1.0 } else { -1.0 } / self.radius,
        })
    }
}
