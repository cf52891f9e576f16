//! The built-in scenes of the ENV operation. Lengths are in units of the object; the picture's shorter side sets the
//! focal length, so that every size shows the same.

use glam::{DVec3, dvec3};

use super::bump_maps;
use super::registry::{Plan, SceneInfo};
use super::surface::{Camera, Shape};

/// Every built-in scene of the ENV operation.
pub const SCENES: &[SceneInfo] = &[
    SceneInfo {
        name: "sphere",
        description: "a mirror ball: every anisotropy from 1 at its middle to hundreds at its rim",
        plan: Plan::Env(sphere, None),
    },
    SceneInfo {
        name: "cylinder",
        description: "a mirror column, tilted: curved in one direction only",
        plan: Plan::Env(cylinder, None),
    },
    SceneInfo {
        name: "parabola",
        description: "a parabolic mirror seen from its focus: all reflections parallel, D = 0",
        plan: Plan::Env(parabola, None),
    },
    SceneInfo {
        name: "scratches",
        description: "a curved steel plate with scratches and brushed areas: steep bump map, roughness",
        plan: Plan::Env(scratches, Some(bump_maps::scratches)),
    },
    SceneInfo {
        name: "waves",
        description: "water up to the horizon: a bump map under every minification, roughness",
        plan: Plan::Env(waves, Some(bump_maps::waves)),
    },
];

/// A camera that looks straight ahead.
fn straight(width: usize, height: usize, focal: f64) -> Camera {
    Camera::tilted(width, height, focal * width.min(height) as f64, 0.0, 1.0)
}

/// Silhouette radius z0/√(d² − 1) = 0.48 of the shorter side.
fn sphere(width: usize, height: usize) -> (Camera, Shape) {
    let centre = dvec3(0.0, 0.0, -(1.0 + 2.5f64 * 2.5).sqrt());
    (straight(width, height, 1.2), Shape::Sphere { centre, radius: 1.0, repeats: 4.0 })
}

/// The axis leans to the right by the angle of (6, 18, 1)/19, a unit vector.
fn cylinder(width: usize, height: usize) -> (Camera, Shape) {
    let axis = dvec3(6.0 / 19.0, 18.0 / 19.0, 1.0 / 19.0);
    let toward_eye = dvec3(0.0, -1.0 / 19.0, 18.0 / 19.0);
    let right = axis.cross(toward_eye).normalize();
    let shape = Shape::Cylinder {
        centre: dvec3(0.0, 0.0, -3.5),
        axis,
        radius: 1.0,
        across: [right.cross(axis), right],
        repeats: 4.0,
    };
    (straight(width, height, 1.2), shape)
}

/// (3, 4, 12)/13 is a unit vector, and so are the two across it.
fn parabola(width: usize, height: usize) -> (Camera, Shape) {
    let axis = dvec3(3.0 / 13.0, 4.0 / 13.0, 12.0 / 13.0);
    let right = DVec3::Y.cross(axis).normalize();
    let shape = Shape::Parabola {
        axis,
        length: 1.0,
        // Where the middle ray −z meets |P| = ⟨P, axis⟩ + 2: distance 2/(1 + 12/13).
        aim: dvec3(0.0, 0.0, -26.0 / 25.0),
        across: [right, axis.cross(right)],
        aperture: 0.46,
        tile: 0.5,
    };
    (straight(width, height, 1.0), shape)
}

/// The plate leans back by the angle of 7-24-25.
fn scratches(width: usize, height: usize) -> (Camera, Shape) {
    let shape = Shape::Plate {
        middle: dvec3(0.0, 0.0, -3.0),
        normal: dvec3(0.0, 0.28, 0.96),
        across: [DVec3::X, dvec3(0.0, 0.96, -0.28)],
        radius: 2.4,
        aperture: 1.12,
        tile: 2.0,
    };
    (straight(width, height, 1.2), shape)
}

/// The camera looks down by the angle of 7-24-25.
fn waves(width: usize, height: usize) -> (Camera, Shape) {
    let side = width.min(height) as f64;
    (Camera::tilted(width, height, 0.9 * side, 0.28, 0.96), Shape::Water { depth: 1.0, tile: 4.0 })
}
