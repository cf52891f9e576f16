//! The analytic surfaces and the pinhole camera that sees them.
//!
//! The eye is the origin of a right-handed world with +y up. A camera has three orthonormal axes,
//! right × down = forward; the image point (x, y), in pixels from the centre with y downwards, is seen
//! along x·right + y·down + z0·forward. So v = −(x, y, z0) in camera axes and ∂v/∂x = −right,
//! ∂v/∂y = −down. The straight camera has right = +x, down = −y, forward = −z.
//!
//! Texture coordinates (s, t) address a bump map as a picture seen from outside the surface: s grows
//! along e1, t grows along −e2 (rows go down), one unit is one repetition of the map.

use std::sync::Arc;

use glam::{DVec3, dvec3};

use crate::base::dual::{Scalar, constants, difference, dot, scaled, sum, values};
use crate::mesh::{self, Mesh};

/// A pinhole camera at the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Unit vector of increasing image x.
    pub right: DVec3,
    /// Unit vector of increasing image y (downwards).
    pub down: DVec3,
    /// Unit vector that the camera looks along.
    pub forward: DVec3,
    /// Focal length z0 in pixels.
    pub focal: f64,
    /// The image centre in pixels from the top left corner.
    pub centre: [f64; 2],
}

impl Camera {
    /// A camera whose view is tilted down by the angle of that sine and cosine.
    #[must_use]
    pub fn tilted(width: usize, height: usize, focal: f64, sine: f64, cosine: f64) -> Self {
        Self {
            right: DVec3::X,
            down: dvec3(0.0, -cosine, sine),
            forward: dvec3(0.0, -sine, -cosine),
            focal,
            centre: [half(width), half(height)],
        }
    }

    /// Moves the picture to the right and down.
    pub fn shift(&mut self, pixels: f64) {
        self.centre = self.centre.map(|centre| centre + pixels);
    }

    /// The ray through an image position in pixels from the top left corner, not normalised; v is its
    /// negative.
    #[inline]
    pub fn ray<S: Scalar>(&self, px: S, py: S) -> [S; 3] {
        let x = px - S::constant(self.centre[0]);
        let y = py - S::constant(self.centre[1]);
        let plane = sum(scaled(constants(self.right), x), scaled(constants(self.down), y));
        sum(plane, constants(self.forward * self.focal))
    }
}

/// Half of a size in pixels; sizes are far below 2⁵³.
fn half(size: usize) -> f64 {
    size as f64 / 2.0
}

/// Where a ray meets a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit<S> {
    /// The surface normal, towards the eye's side, not normalised.
    pub n: [S; 3],
    /// Texture coordinates of a bump map; zero where the caller asked for none.
    pub st: [S; 2],
    /// The main direction h of the local frame, which makes e1 point along s.
    pub h: DVec3,
    /// Whether t grows along +e2, not along −e2: the map is seen from its back.
    pub mirrored: bool,
}

/// A surface in front of the camera.
#[derive(Clone, Debug)]
pub enum Shape {
    /// A ball; texture by longitude and colatitude, pole axis +y.
    Sphere {
        /// Centre.
        centre: DVec3,
        /// Radius.
        radius: f64,
        /// Repetitions of the map over a full turn; over half a turn of latitude half as many.
        repeats: f64,
    },
    /// An endless circular cylinder.
    Cylinder {
        /// A point of the axis.
        centre: DVec3,
        /// Unit vector of the axis.
        axis: DVec3,
        /// Radius.
        radius: f64,
        /// Two unit vectors across the axis: angle 0 and a quarter turn on.
        across: [DVec3; 2],
        /// Repetitions of the map over a full turn.
        repeats: f64,
    },
    /// A paraboloid |P| = ⟨P, axis⟩ + 2·length with its focus in the eye, cut to a round mirror.
    Parabola {
        /// Unit vector of the axis: every ray leaves along it.
        axis: DVec3,
        /// Focal length of the mirror (not of the camera).
        length: f64,
        /// A point on the line through the mirror's centre along the axis.
        aim: DVec3,
        /// Two unit vectors across the axis, along s and up.
        across: [DVec3; 2],
        /// Radius of the mirror's outline, across the axis.
        aperture: f64,
        /// Width of one repetition of the map.
        tile: f64,
    },
    /// A round cap of a large ball, textured as a plate.
    Plate {
        /// The middle of the plate.
        middle: DVec3,
        /// Its unit normal there.
        normal: DVec3,
        /// Unit vectors along s and up.
        across: [DVec3; 2],
        /// Radius of the ball.
        radius: f64,
        /// Radius of the plate's outline.
        aperture: f64,
        /// Width of one repetition of the map.
        tile: f64,
    },
    /// The endless plane y = −depth.
    Water {
        /// How far the eye is above it.
        depth: f64,
        /// Width of one repetition of the map.
        tile: f64,
    },
    /// Triangles with interpolated normals; texture by their own coordinates.
    Mesh(Arc<Mesh>),
}

impl Shape {
    /// The main direction h of the local frame, which makes e1 point along s.
    #[must_use]
    pub fn main_direction(&self) -> DVec3 {
        match self {
            Self::Sphere { .. } => DVec3::Y,
            Self::Cylinder { axis, .. } => *axis,
            Self::Parabola { across, .. } | Self::Plate { across, .. } => across[1],
            Self::Water { .. } => DVec3::NEG_Z,
            // Each triangle has its own: see `Hit`.
            Self::Mesh(_) => DVec3::ZERO,
        }
    }

    /// Meets the surface along a ray from the origin; `None` where it misses. Texture coordinates are
    /// worked out only where `textured`.
    #[inline]
    pub fn hit<S: Scalar>(&self, ray: [S; 3], textured: bool) -> Option<Hit<S>> {
        let zero = [S::constant(0.0); 2];
        let h = self.main_direction();
        let hit = |n: [S; 3], st: [S; 2]| Hit { n, st, h, mirrored: false };
        match *self {
            Self::Mesh(ref mesh) => on_mesh(mesh, ray, textured),
            Self::Sphere { centre, radius, repeats } => {
                let c = constants(centre);
                let n = difference(scaled(ray, ball(ray, c, radius)?), c);
                let st = if textured {
                    let longitude = n[0].atan2(n[2]);
                    let colatitude = (n[1] / S::constant(radius)).acos();
                    let per_radian = S::constant(repeats / (2.0 * std::f64::consts::PI));
                    [longitude * per_radian, colatitude * per_radian]
                } else {
                    zero
                };
                Some(hit(n, st))
            }
            Self::Cylinder { centre, axis, radius, across, repeats } => {
                let a = constants(axis);
                let c = constants(centre);
                let flat = |p: [S; 3]| difference(p, scaled(a, dot(p, a)));
                let (ray_flat, c_flat) = (flat(ray), flat(c));
                let distance = ball(ray_flat, c_flat, radius)?;
                let n = difference(scaled(ray_flat, distance), c_flat);
                let st = if textured {
                    let angle = dot(n, constants(across[1])).atan2(dot(n, constants(across[0])));
                    let along = dot(difference(scaled(ray, distance), c), a);
                    let turn = 2.0 * std::f64::consts::PI;
                    [
                        angle * S::constant(repeats / turn),
                        -along * S::constant(repeats / (turn * radius)),
                    ]
                } else {
                    zero
                };
                Some(hit(n, st))
            }
            Self::Parabola { axis, length, aim, across, aperture, tile } => {
                let a = constants(axis);
                let norm = dot(ray, ray).sqrt();
                let open = norm - dot(ray, a);
                let point = scaled(ray, S::constant(2.0 * length) / open);
                let st = outline(point, aim, across, aperture, tile)?;
                // The bisector of v = −ray and the axis, both of length |v|.
                let n = difference(scaled(a, norm), ray);
                Some(hit(n, st))
            }
            Self::Plate { middle, normal, across, radius, aperture, tile } => {
                let c =
                    difference(constants(middle), scaled(constants(normal), S::constant(radius)));
                let point = scaled(ray, ball(ray, c, radius)?);
                let st = outline(point, middle, across, aperture, tile)?;
                let n = scaled(difference(point, c), S::constant(1.0 / radius));
                Some(hit(n, st))
            }
            Self::Water { depth, tile } => {
                if ray[1].value() >= 0.0 {
                    return None;
                }
                let st = if textured {
                    let distance = S::constant(-depth / tile) / ray[1];
                    [ray[0] * distance, ray[2] * distance]
                } else {
                    zero
                };
                Some(hit(constants(DVec3::Y), st))
            }
        }
    }
}

/// Meets a mesh from the origin: the nearest triangle, then its corners' normals and texture coordinates by
/// weights that carry the screen derivatives.
fn on_mesh<S: Scalar>(mesh: &Mesh, ray: [S; 3], textured: bool) -> Option<Hit<S>> {
    let direction = values(ray);
    let triangle = &mesh.triangles()[mesh.nearest(DVec3::ZERO, direction, 0.0)?];
    let [a, b, c] = mesh::meet(triangle, constants(DVec3::ZERO), ray)?.weights;
    let [na, nb, nc] = triangle.normals.map(constants::<S>);
    let n = sum(sum(scaled(na, a), scaled(nb, b)), scaled(nc, c));
    // The side that the eye sees.
    let n = if triangle.plane_normal().dot(direction) > 0.0 { n.map(|c| -c) } else { n };
    if !textured {
        return Some(Hit { n, st: [S::constant(0.0); 2], h: DVec3::ZERO, mirrored: false });
    }
    let [ta, tb, tc] = triangle.texcoords;
    let st =
        [0, 1].map(|i| a * S::constant(ta[i]) + b * S::constant(tb[i]) + c * S::constant(tc[i]));
    let (along_s, along_t) = triangle.tangents();
    // (h × n) is along ∂P/∂s across n for h = n × ∂P/∂s; e2 = n × e1.
    let h = values(n).cross(along_s);
    Some(Hit { n, st, h, mirrored: h.dot(along_t) > 0.0 })
}

/// The nearest multiple of the ray on a ball that does not hold the origin; a ray that only touches it
/// misses, because derivatives are not finite there.
#[inline]
fn ball<S: Scalar>(ray: [S; 3], centre: [S; 3], radius: f64) -> Option<S> {
    let square = dot(ray, ray);
    let along = dot(ray, centre);
    let outside = dot(centre, centre) - S::constant(radius * radius);
    let discriminant = along * along - square * outside;
    if discriminant.value() <= 0.0 || along.value() <= 0.0 {
        return None;
    }
    // Not (along − √…)/square, which cancels for a far ball.
    Some(outside / (along + discriminant.sqrt()))
}

/// Texture coordinates of a point by its place in a plane; `None` outside a round outline.
#[inline]
fn outline<S: Scalar>(
    point: [S; 3],
    middle: DVec3,
    across: [DVec3; 2],
    aperture: f64,
    tile: f64,
) -> Option<[S; 2]> {
    let from_middle = difference(point, constants(middle));
    let along = |axis: DVec3| dot(from_middle, constants(axis));
    let (s, up) = (along(across[0]), along(across[1]));
    let square = s.value() * s.value() + up.value() * up.value();
    if square > aperture * aperture {
        return None;
    }
    let scale = S::constant(1.0 / tile);
    let half = S::constant(0.5);
    Some([half + s * scale, half - up * scale])
}
