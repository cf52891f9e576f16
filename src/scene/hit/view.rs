//! An eye, a reflective object and the world around both.

use std::sync::Arc;

use glam::DVec3;

use super::object::Object;
use crate::base::vector::unit;
use crate::fragment::HitFragment;
use crate::optics::{fresnel, refract};
use crate::scene::surface::Camera;
use crate::scene::world::World;

/// The object's effect on light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Finish {
    /// Reflects all of it.
    Mirror,
    /// Reflects what Fresnel's equations say and refracts the rest, once: as in the distance-impostor paper the refracted
    /// ray leaves for the world as if the object had no back.
    Glass {
        /// Index of refraction against the outside.
        index: f64,
    },
}

/// A ray that leaves the object, and its share of the pixel's light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leaving {
    /// The unit's input; x is relative to the reference point.
    pub fragment: HitFragment,
    /// Linear RGB factor of the light that the ray finds.
    pub weight: [f64; 3],
}

/// A camera in a world with a reflective object. The impostor's reference point is the world's origin.
#[derive(Clone, Debug)]
pub struct View {
    /// Axes and focal length.
    pub camera: Camera,
    /// Where the camera stands.
    pub eye: DVec3,
    /// What reflects.
    pub object: Arc<dyn Object>,
    /// Its finish.
    pub finish: Finish,
    /// What surrounds it; the object itself is not part of it.
    pub world: World,
}

/// A camera that looks from `eye` at `aim` with +y up.
#[must_use]
pub fn look_at(eye: DVec3, aim: DVec3, [width, height]: [usize; 2], focal: f64) -> Camera {
    let forward = unit(aim - eye);
    let right = unit(forward.cross(DVec3::Y));
    Camera {
        right,
        down: forward.cross(right),
        forward,
        focal,
        centre: [width, height].map(|n| n as f64 / 2.0),
    }
}

impl View {
    /// Tells `each` every ray that leaves the object at an image position (pixels from the top left
    /// corner); false where the object is missed.
    ///
    /// The cone starts with the angle that a pixel has at the eye, 1/|ray| for a ray in pixels, is as wide as
    /// angle · distance on the surface, and reflects as α' = α + 2k|w|.
    pub fn leaving(&self, px: f64, py: f64, each: &mut dyn FnMut(Leaving)) -> bool {
        let ray = DVec3::from(self.camera.ray(px, py));
        let Some(skin) = self.object.skin(self.eye, ray, 0.0) else {
            return false;
        };
        let x = (self.eye + skin.t * ray).to_array();
        let angle = 1.0 / ray.length();
        // The distance is t·|ray|, so that the width is t: a pixel is as wide as the ray's own unit.
        let width = skin.t;
        let reflected = unit(ray.reflect(skin.normal));
        let bend = skin.curvature * width.abs();
        let mut send = |r: DVec3, angle: f64, share: f64| {
            each(Leaving {
                fragment: HitFragment { x, r: r.to_array(), cone: Some([angle, width]) },
                weight: [share; 3],
            });
        };
        match self.finish {
            Finish::Mirror => send(reflected, angle + 2.0 * bend, 1.0),
            Finish::Glass { index } => {
                let direction = unit(ray);
                let share = fresnel(direction.dot(skin.normal).abs(), index, 0.0);
                send(reflected, angle + 2.0 * bend, share);
                if let Some(through) = refract(direction, skin.normal, 1.0 / index) {
                    send(through, (angle + bend) / index - bend, 1.0 - share);
                }
            }
        }
        true
    }

    /// What real rays through an image position see in the object; `None` where it is missed.
    #[must_use]
    pub fn shade(&self, px: f64, py: f64) -> Option<[f64; 3]> {
        let mut sum = [0.0; 3];
        self.leaving(px, py, &mut |leaving| {
            let found = self.world.radiance(leaving.fragment.x.into(), leaving.fragment.r.into());
            for ((sum, c), weight) in sum.iter_mut().zip(found).zip(leaving.weight) {
                *sum += weight * c;
            }
        })
        .then_some(sum)
    }

    /// The view past the object: the mean of 4 × 4 rays through the pixel.
    #[must_use]
    pub fn past(&self, column: usize, row: usize) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for j in 0..4 {
            for i in 0..4 {
                let at = |n: usize, k: usize| n as f64 + (2 * k + 1) as f64 / 8.0;
                let ray = self.camera.ray(at(column, i), at(row, j)).into();
                for (sum, c) in sum.iter_mut().zip(self.world.radiance(self.eye, ray)) {
                    *sum += c / 16.0;
                }
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use glam::dvec3;

    use super::*;
    use crate::scene::world::bodies::Ball;
    use crate::scene::world::built_in;

    #[test]
    fn the_cone_is_as_wide_as_the_rays_of_a_pixel_where_the_mirror_is_met_head_on() {
        let ball = Ball { centre: dvec3(0.5, 0.25, -2.0), radius: 0.75 };
        let eye = dvec3(0.5, 0.25, 3.0);
        let view = View {
            camera: look_at(eye, ball.centre, [64, 64], 400.0),
            eye,
            object: Arc::new(ball),
            finish: Finish::Mirror,
            world: built_in::room(),
        };
        let at = |px: f64| {
            let mut found = None;
            assert!(view.leaving(px, 32.0, &mut |l| found = Some(l.fragment)));
            found.unwrap()
        };
        let (left, middle, right) = (at(31.5), at(32.0), at(32.5));
        let [angle, width] = middle.cone.unwrap();
        let apart = |a: [f64; 3], b: [f64; 3]| DVec3::from(a).distance(b.into());
        // Chords instead of arcs: relative errors of the order of the angles' squares, 1e-3.
        assert!((apart(left.x, right.x) / width - 1.0).abs() < 1e-3);
        assert!((apart(left.r, right.r) / angle - 1.0).abs() < 1e-3);
        assert!(angle > 10.0 / 400.0, "the ball widens the cone");
        // The middle ray comes straight back.
        assert!((middle.r[2] - 1.0).abs() < 1e-12);
        // The silhouette's radius is 61 pixels.
        assert!(view.leaving(-28.0, 32.0, &mut |_| ()) && !view.leaving(-30.0, 32.0, &mut |_| ()));
    }
}
