//! Reflective objects: solids with a normal and a curvature at every point.

use std::fmt::Debug;

use glam::DVec3;

use crate::base::vector::unit;
use crate::mesh::{Mesh, Triangle, meet};
use crate::scene::world::Body;
use crate::scene::world::bodies::Ball;

/// A point of a reflective surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Skin {
    /// The point is origin + t · direction.
    pub t: f64,
    /// Unit shading normal that faces the ray's origin.
    pub normal: DVec3,
    /// Curvature k for that normal, per world unit: positive where the surface bulges towards the ray.
    pub curvature: f64,
}

/// A reflective solid: a ball, or a mesh with smooth normals.
pub trait Object: Debug + Send + Sync {
    /// The first meeting with t > `beyond`. `direction` has any length but zero.
    fn skin(&self, origin: DVec3, direction: DVec3, beyond: f64) -> Option<Skin>;
}

impl Object for Ball {
    fn skin(&self, origin: DVec3, direction: DVec3, beyond: f64) -> Option<Skin> {
        let meeting = self.meet(origin, direction, beyond)?;
        let at = origin + meeting.t * direction - self.centre;
        let outside = at.dot(meeting.normal) > 0.0;
        Some(Skin {
            t: meeting.t,
            normal: meeting.normal,
            curvature: if outside { 1.0 } else { -1.0 } / self.radius,
        })
    }
}

impl Object for Mesh {
    fn skin(&self, origin: DVec3, direction: DVec3, beyond: f64) -> Option<Skin> {
        let triangle = &self.triangles()[self.nearest(origin, direction, beyond)?];
        let found = meet(triangle, origin.to_array(), direction.to_array())?;
        let weighted = triangle.normals.into_iter().zip(found.weights);
        let smooth: DVec3 = weighted.map(|(corner, weight)| weight * corner).sum();
        // The plane tells the side; an interpolated normal that disagrees gives way to it.
        let plane = triangle.plane_normal();
        let side = if plane.dot(direction) > 0.0 { -1.0 } else { 1.0 };
        let normal = if side * smooth.dot(direction) >= 0.0 { plane } else { smooth };
        Some(Skin {
            t: found.distance,
            normal: unit(side * normal),
            curvature: side * curvature(triangle),
        })
    }
}

/// Curvature of a triangle with normals at its corners, positive where it bulges along them: that of the edge
/// whose curvature is least in magnitude, 0 where the edges' signs differ (Cline, *Ray Cones for Texture
/// Filtering*). An edge's curvature is ⟨n_b − n_a, b − a⟩/⟨b − a, b − a⟩.
#[must_use]
pub fn curvature(triangle: &Triangle) -> f64 {
    let edge = |i: usize| {
        let j = (i + 1) % 3;
        let along = triangle.positions[j] - triangle.positions[i];
        let turn = triangle.normals[j] - triangle.normals[i];
        turn.dot(along) / along.length_squared()
    };
    let edges = [edge(0), edge(1), edge(2)];
    if edges.iter().any(|k| *k > 0.0) && edges.iter().any(|k| *k < 0.0) {
        return 0.0;
    }
    edges.into_iter().fold(f64::INFINITY, |least, k| if k.abs() < least.abs() { k } else { least })
}

#[cfg(test)]
mod tests {
    use glam::dvec3;

    use super::*;

    #[test]
    fn the_curvature_of_a_triangle_on_a_ball_is_the_balls() {
        let normals = [DVec3::Z, dvec3(0.6, 0.0, 0.8), dvec3(0.0, 0.28, 0.96)];
        let positions = normals.map(|n| 2.5 * n);
        let ball = Triangle { positions, normals, texcoords: [[0.0; 2]; 3] };
        assert!((curvature(&ball) - 0.4).abs() < 1e-15);
        let hollow = Triangle { normals: normals.map(|n| -n), ..ball };
        assert!((curvature(&hollow) + 0.4).abs() < 1e-15);
        // A saddle: one edge bulges, another sinks.
        let saddle = Triangle {
            positions: [DVec3::ZERO, DVec3::X, DVec3::Y],
            normals: [DVec3::Z, dvec3(0.1, 0.0, 0.995), dvec3(0.0, -0.1, 0.995)],
            texcoords: [[0.0; 2]; 3],
        };
        assert_eq!(curvature(&saddle).to_bits(), 0);
    }
}
