//! Surfaces that paths meet: with a signed curvature, texture coordinates and their derivatives.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DVec3, dvec3};

use crate::base::vector::unit;
use crate::fragment::Tangents;
use crate::mesh::Mesh;
use crate::scene::hit::object::Object as _;
use crate::scene::world::bodies::{ball_roots, roots};

/// A ray at a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The point is origin + t · direction.
    pub t: f64,
    /// Unit normal that faces the ray's origin.
    pub normal: DVec3,
    /// Curvature for that normal, per world unit: positive where the surface bulges towards the ray.
    pub curvature: f64,
    /// Whether the ray comes from outside of the solid, or from above.
    pub outside: bool,
    /// Texture coordinates and how they change; a mesh has none.
    pub texture: Option<([f64; 2], Tangents)>,
}

/// The surfaces of the built-in scenes.
#[derive(Clone, Debug)]
pub enum Shape {
    /// The square |x|, |z| ≤ `half` at y = 0, its texture once over it.
    Floor {
        /// Half of its side.
        half: f64,
    },
    /// A ball of which the part with ⟨p − centre, axis⟩ > `keep`·radius is cut away; a whole one from `keep` = 1 on.
    Shell {
        /// Its centre.
        centre: DVec3,
        /// Its radius.
        radius: f64,
        /// Unit vector towards the opening.
        axis: DVec3,
        /// −1…1: cosine of the opening's half angle.
        keep: f64,
    },
    /// An upright tube without caps.
    Tube {
        /// Middle of its lower end.
        base: DVec3,
        /// Its radius.
        radius: f64,
        /// Its height.
        height: f64,
    },
    /// A parallelogram of two triangles ABC and ACD with A = corner, B = A + across, D = A + down.
    Card {
        /// A, where s = t = 0.
        corner: DVec3,
        /// Along s.
        across: DVec3,
        /// Along t.
        down: DVec3,
    },
    /// Triangles with smooth normals.
    Mesh(Arc<Mesh>),
}

fn facing(normal: DVec3, direction: DVec3) -> (DVec3, bool) {
    let outside = normal.dot(direction) < 0.0;
    (if outside { normal } else { -normal }, outside)
}

impl Shape {
    /// The first contact with t > `beyond`; `direction` is a unit vector.
    #[must_use]
    pub fn meet(&self, origin: DVec3, direction: DVec3, beyond: f64) -> Option<Contact> {
        match self {
            Self::Floor { half } => floor(*half, origin, direction, beyond),
            Self::Shell { centre, radius, axis, keep } => {
                shell((*centre, *radius), (*axis, *keep), origin, direction, beyond)
            }
            Self::Tube { base, radius, height } => {
                tube(*base, *radius, *height, origin, direction, beyond)
            }
            Self::Card { corner, across, down } => {
                card([*corner, *across, *down], origin, direction, beyond)
            }
            Self::Mesh(mesh) => {
                let skin = mesh.skin(origin, direction, beyond)?;
                Some(Contact {
                    t: skin.t,
                    normal: skin.normal,
                    curvature: skin.curvature,
                    outside: true,
                    texture: None,
                })
            }
        }
    }
}

fn floor(half: f64, origin: DVec3, direction: DVec3, beyond: f64) -> Option<Contact> {
    let t = -origin.y / direction.y;
    if !(t > beyond && t.is_finite()) {
        return None;
    }
    let p = origin + t * direction;
    if p.x.abs() > half || p.z.abs() > half {
        return None;
    }
    let (normal, outside) = facing(DVec3::Y, direction);
    let side = 2.0 * half;
    Some(Contact {
        t,
        normal,
        curvature: 0.0,
        outside,
        texture: Some((
            [(p.x + half) / side, (p.z + half) / side],
            Tangents::Surface { dp_ds: [side, 0.0, 0.0], dp_dt: [0.0, 0.0, side] },
        )),
    })
}

fn shell(
    (centre, radius): (DVec3, f64),
    (axis, keep): (DVec3, f64),
    origin: DVec3,
    direction: DVec3,
    beyond: f64,
) -> Option<Contact> {
    let from = origin - centre;
    let both = ball_roots(from, direction, radius)?;
    let there = |t: f64| {
        let r = from + t * direction;
        (t > beyond && r.dot(axis) <= keep * radius).then_some((t, r))
    };
    let (t, r) = both.into_iter().find_map(there)?;
    let (normal, outside) = facing(r / radius, direction);
    let [x, y, z] = r.to_array();
    let ring = (x * x + z * z).sqrt();
    // On the poles s has no direction.
    let (sine, cosine) = if ring > 0.0 { (x / ring, z / ring) } else { (0.0, 1.0) };
    Some(Contact {
        t,
        normal,
        curvature: if outside { 1.0 } else { -1.0 } / radius,
        outside,
        texture: Some((
            [libm::atan2(x, z) / (2.0 * PI) + 0.5, libm::acos((y / radius).clamp(-1.0, 1.0)) / PI],
            Tangents::Surface {
                dp_ds: [2.0 * PI * z, 0.0, -2.0 * PI * x],
                dp_dt: [PI * y * sine, -PI * ring, PI * y * cosine],
            },
        )),
    })
}

fn tube(
    base: DVec3,
    radius: f64,
    height: f64,
    origin: DVec3,
    direction: DVec3,
    beyond: f64,
) -> Option<Contact> {
    let from = origin - base;
    let flat = |a: DVec3, b: DVec3| a.x * b.x + a.z * b.z;
    let rest = flat(from, from) - radius * radius;
    let both = roots(flat(direction, direction), flat(direction, from), rest)?;
    let there = |t: f64| {
        let r = from + t * direction;
        (t > beyond && (0.0..=height).contains(&r.y)).then_some((t, r.to_array()))
    };
    let (t, [x, y, z]) = both.into_iter().find_map(there)?;
    let (normal, outside) = facing(dvec3(x / radius, 0.0, z / radius), direction);
    Some(Contact {
        t,
        normal,
        // Upright edges are straight: the least of a tube's curvatures is 0.
        curvature: 0.0,
        outside,
        texture: Some((
            [libm::atan2(x, z) / (2.0 * PI) + 0.5, 1.0 - y / height],
            Tangents::Surface {
                dp_ds: [2.0 * PI * z, 0.0, -2.0 * PI * x],
                dp_dt: [0.0, -height, 0.0],
            },
        )),
    })
}

fn card(
    [corner, across, down]: [DVec3; 3],
    origin: DVec3,
    direction: DVec3,
    beyond: f64,
) -> Option<Contact> {
    let plane = across.cross(down);
    let from = origin - corner;
    let t = -plane.dot(from) / plane.dot(direction);
    if !(t > beyond && t.is_finite()) {
        return None;
    }
    let p = from + t * direction;
    let square = plane.length_squared();
    let st = [p.cross(down).dot(plane) / square, across.cross(p).dot(plane) / square];
    if st.iter().any(|x| !(0.0..=1.0).contains(x)) {
        return None;
    }
    let (normal, outside) = facing(unit(plane), direction);
    let far = across + down;
    let (edges, at) = if st[0] >= st[1] {
        ([across, far], [[1.0, 0.0], [1.0, 1.0]])
    } else {
        ([far, down], [[1.0, 1.0], [0.0, 1.0]])
    };
    Some(Contact {
        t,
        normal,
        curvature: 0.0,
        outside,
        texture: Some((st, Tangents::Triangle { edges: edges.map(DVec3::into), st: at })),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn surface(shape: &Shape, origin: DVec3, direction: DVec3) -> (Contact, DVec3) {
        let contact = shape.meet(origin, direction, 0.0).expect("a contact");
        (contact, origin + contact.t * direction)
    }

    /// Moves the ray a little and compares the change of s, t with the point's change through the derivatives.
    #[test]
    fn texture_coordinates_change_as_their_derivatives_say() {
        let shapes = [
            Shape::Floor { half: 3.0 },
            Shape::Shell { centre: dvec3(0.2, 0.5, -0.1), radius: 1.2, axis: DVec3::Y, keep: 0.8 },
            Shape::Tube { base: dvec3(0.1, -2.0, 0.0), radius: 1.5, height: 4.0 },
        ];
        for shape in &shapes {
            let origin = dvec3(2.0, 3.0, 2.5);
            let direction = unit(dvec3(-0.6, -0.9, -0.8));
            let (here, p) = surface(shape, origin, direction);
            let (st, Tangents::Surface { dp_ds, dp_dt }) = here.texture.expect("a texture") else {
                panic!("not a surface with derivatives");
            };
            for k in 0..3 {
                let mut moved = origin;
                moved[k] += 1e-6;
                let (there, q) = surface(shape, moved, direction);
                let (other, _) = there.texture.expect("a texture");
                let [ds, dt] = [other[0] - st[0], other[1] - st[1]];
                for c in 0..3 {
                    let by = dp_ds[c] * ds + dp_dt[c] * dt;
                    // Second order: 1e-12 times curvatures of the order of 1.
                    assert!((by - (q[c] - p[c])).abs() < 2e-11, "{shape:?} {k} {c}");
                }
            }
        }
    }

    #[test]
    fn the_triangles_of_a_card_agree_with_its_parallelogram() {
        let card = Shape::Card {
            corner: dvec3(-1.0, 2.0, 0.0),
            across: dvec3(2.0, 0.2, 0.0),
            down: dvec3(0.1, -2.0, 0.3),
        };
        let mut halves = [0, 0];
        for i in 1..8 {
            let x = f64::from(i) / 4.0 - 1.0;
            let (contact, p) = surface(&card, dvec3(x, 1.0, 5.0), DVec3::NEG_Z);
            let (st, Tangents::Triangle { edges, st: at }) = contact.texture.expect("a texture")
            else {
                panic!("not a triangle");
            };
            halves[usize::from(st[0] < st[1])] += 1;
            // st = β·st_B + γ·st_C with the barycentric coordinates of the point: A has (0, 0).
            let [b, c] = edges.map(DVec3::from);
            let n = b.cross(c);
            let from = p - dvec3(-1.0, 2.0, 0.0);
            let beta = from.cross(c).dot(n) / n.length_squared();
            let gamma = b.cross(from).dot(n) / n.length_squared();
            for c in 0..2 {
                assert!((beta * at[0][c] + gamma * at[1][c] - st[c]).abs() < 1e-12);
            }
        }
        assert!(halves[0] > 0 && halves[1] > 0);
    }

    #[test]
    fn a_shell_is_open_where_it_is_cut_and_hollow_inside() {
        let bowl = Shape::Shell { centre: DVec3::ZERO, radius: 1.0, axis: DVec3::Y, keep: 0.5 };
        // From above through the opening onto the inner side of the bottom.
        let inside = bowl.meet(3.0 * DVec3::Y, DVec3::NEG_Y, 0.0).unwrap();
        assert!((inside.t - 4.0).abs() < 1e-12 && !inside.outside);
        assert!((inside.curvature + 1.0).abs() < 1e-12 && inside.normal[1] > 0.0);
        let outside = bowl.meet(-3.0 * DVec3::Y, DVec3::Y, 0.0).unwrap();
        assert!((outside.t - 2.0).abs() < 1e-12 && outside.outside);
        assert!((outside.curvature - 1.0).abs() < 1e-12 && outside.normal[1] < 0.0);
    }
}
