//! Where camera and surface of each built-in scene stand.

use super::surface::{Camera, Shape};
use crate::base::dual::{cross, dot};

/// Camera and shape of a scene. Lengths are in units of the object; the picture's shorter side sets
/// the focal length, so that every size shows the same.
pub(super) fn view(name: &str, width: usize, height: usize) -> (Camera, Shape) {
    let side = width.min(height) as f64;
    let straight = |focal: f64| Camera::tilted(width, height, focal * side, 0.0, 1.0);
    match name {
        // Silhouette radius z0/√(d² − 1) = 0.48 of the shorter side.
        "sphere" => (
            straight(1.2),
            Shape::Sphere {
                centre: [0.0, 0.0, -(1.0 + 2.5f64 * 2.5).sqrt()],
                radius: 1.0,
                repeats: 4.0,
            },
        ),
        // The axis leans to the right by the angle of (6, 18, 1)/19, a unit vector.
        "cylinder" => {
            let axis = [6.0 / 19.0, 18.0 / 19.0, 1.0 / 19.0];
            let toward_eye = [0.0, -1.0 / 19.0, 18.0 / 19.0];
            let e = cross(axis, toward_eye);
            let unit = 1.0 / dot(e, e).sqrt();
            let right = e.map(|c| c * unit);
            (
                straight(1.2),
                Shape::Cylinder {
                    centre: [0.0, 0.0, -3.5],
                    axis,
                    radius: 1.0,
                    across: [cross(right, axis), right],
                    repeats: 4.0,
                },
            )
        }
        // (3, 4, 12)/13 is a unit vector, and so are the two across it.
        "parabola" => {
            let axis = [3.0 / 13.0, 4.0 / 13.0, 12.0 / 13.0];
            let e = cross([0.0, 1.0, 0.0], axis);
            let unit = 1.0 / dot(e, e).sqrt();
            let right = e.map(|c| c * unit);
            // Where the middle ray −z meets |P| = ⟨P, axis⟩ + 2: distance 2/(1 + 12/13).
            let aim = [0.0, 0.0, -26.0 / 25.0];
            (
                straight(1.0),
                Shape::Parabola {
                    axis,
                    length: 1.0,
                    aim,
                    across: [right, cross(axis, right)],
                    aperture: 0.46,
                    tile: 0.5,
                },
            )
        }
        // The plate leans back by the angle of 7-24-25.
        "scratches" => (
            straight(1.2),
            Shape::Plate {
                middle: [0.0, 0.0, -3.0],
                normal: [0.0, 0.28, 0.96],
                across: [[1.0, 0.0, 0.0], [0.0, 0.96, -0.28]],
                radius: 2.4,
                aperture: 1.12,
                tile: 2.0,
            },
        ),
        // The camera looks down by the angle of 7-24-25.
        _ => (
            Camera::tilted(width, height, 0.9 * side, 0.28, 0.96),
            Shape::Water { depth: 1.0, tile: 4.0 },
        ),
    }
}
