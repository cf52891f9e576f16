//! Surfaces that paths meet: with a signed curvature, texture coordinates and their derivatives.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::base::dual::{cross, dot};
use crate::fragment::Tangents;
use crate::mesh::Mesh;
use crate::scene::hit::object::Object as _;
use crate::scene::world::bodies::roots;

/// A ray at a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The point is origin + t · direction.
    pub t: f64,
    /// Unit normal that faces the ray's origin.
    pub normal: [f64; 3],
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
        centre: [f64; 3],
        /// Its radius.
        radius: f64,
        /// Unit vector towards the opening.
        axis: [f64; 3],
        /// −1…1: cosine of the opening's half angle.
        keep: f64,
    },
    /// An upright tube without caps.
    Tube {
        /// Middle of its lower end.
        base: [f64; 3],
        /// Its radius.
        radius: f64,
        /// Its height.
        height: f64,
    },
    /// A parallelogram of two triangles ABC and ACD with A = corner, B = A + across, D = A + down.
    Card {
        /// A, where s = t = 0.
        corner: [f64; 3],
        /// Along s.
        across: [f64; 3],
        /// Along t.
        down: [f64; 3],
    },
    /// Triangles with smooth normals.
    Mesh(Arc<Mesh>),
}

fn along(origin: [f64; 3], direction: [f64; 3], t: f64) -> [f64; 3] {
    [0, 1, 2].map(|i| origin[i] + t * direction[i])
}

fn facing(normal: [f64; 3], direction: [f64; 3]) -> ([f64; 3], bool) {
    let outside = dot(normal, direction) < 0.0;
    (normal.map(|c| if outside { c } else { -c }), outside)
}

impl Shape {
    /// The first contact with t > `beyond`; `direction` is a unit vector.
    #[must_use]
    pub fn meet(&self, origin: [f64; 3], direction: [f64; 3], beyond: f64) -> Option<Contact> {
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

fn floor(half: f64, origin: [f64; 3], direction: [f64; 3], beyond: f64) -> Option<Contact> {
    let t = -origin[1] / direction[1];
    if !(t > beyond && t.is_finite()) {
        return None;
    }
    let p = along(origin, direction, t);
    if p[0].abs() > half || p[2].abs() > half {
        return None;
    }
    let (normal, outside) = facing([0.0, 1.0, 0.0], direction);
    let side = 2.0 * half;
    Some(Contact {
        t,
        normal,
        curvature: 0.0,
        outside,
        texture: Some((
            [(p[0] + half) / side, (p[2] + half) / side],
            Tangents::Surface { dp_ds: [side, 0.0, 0.0], dp_dt: [0.0, 0.0, side] },
        )),
    })
}

fn shell(
    (centre, radius): ([f64; 3], f64),
    (axis, keep): ([f64; 3], f64),
    origin: [f64; 3],
    direction: [f64; 3],
    beyond: f64,
) -> Option<Contact> {
    let from = [0, 1, 2].map(|i| origin[i] - centre[i]);
    let rest = dot(from, from) - radius * radius;
    let both = roots(dot(direction, direction), dot(direction, from), rest)?;
    let there = |t: f64| {
        let r = along(from, direction, t);
        (t > beyond && dot(r, axis) <= keep * radius).then_some((t, r))
    };
    let (t, r) = both.into_iter().find_map(there)?;
    let (normal, outside) = facing(r.map(|c| c / radius), direction);
    let [x, y, z] = r;
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
    base: [f64; 3],
    radius: f64,
    height: f64,
    origin: [f64; 3],
    direction: [f64; 3],
    beyond: f64,
) -> Option<Contact> {
    let from = [0, 1, 2].map(|i| origin[i] - base[i]);
    let flat = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[2] * b[2];
    let rest = flat(from, from) - radius * radius;
    let both = roots(flat(direction, direction), flat(direction, from), rest)?;
    let there = |t: f64| {
        let r = along(from, direction, t);
        (t > beyond && (0.0..=height).contains(&r[1])).then_some((t, r))
    };
    let (t, [x, y, z]) = both.into_iter().find_map(there)?;
    let (normal, outside) = facing([x / radius, 0.0, z / radius], direction);
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
    [corner, across, down]: [[f64; 3]; 3],
    origin: [f64; 3],
    direction: [f64; 3],
    beyond: f64,
) -> Option<Contact> {
    let plane = cross(across, down);
    let from = [0, 1, 2].map(|i| origin[i] - corner[i]);
    let t = -dot(plane, from) / dot(plane, direction);
    if !(t > beyond && t.is_finite()) {
        return None;
    }
    let p = along(from, direction, t);
    let square = dot(plane, plane);
    let st = [dot(cross(p, down), plane) / square, dot(cross(across, p), plane) / square];
    if st.iter().any(|x| !(0.0..=1.0).contains(x)) {
        return None;
    }
    let length = square.sqrt();
    let (normal, outside) = facing(plane.map(|c| c / length), direction);
    let far = [0, 1, 2].map(|i| across[i] + down[i]);
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
        texture: Some((st, Tangents::Triangle { edges, st: at })),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn surface(shape: &Shape, origin: [f64; 3], direction: [f64; 3]) -> (Contact, [f64; 3]) {
        let contact = shape.meet(origin, direction, 0.0).expect("a contact");
        let point = along(origin, direction, contact.t);
        (contact, point)
    }

    /// Moves the ray a little and compares the change of s, t with the point's change through the derivatives.
    #[test]
    fn texture_coordinates_change_as_their_derivatives_say() {
        let unit = |v: [f64; 3]| {
            let length = dot(v, v).sqrt();
            v.map(|c| c / length)
        };
        let shapes = [
            Shape::Floor { half: 3.0 },
            Shape::Shell {
                centre: [0.2, 0.5, -0.1],
                radius: 1.2,
                axis: [0.0, 1.0, 0.0],
                keep: 0.8,
            },
            Shape::Tube { base: [0.1, -2.0, 0.0], radius: 1.5, height: 4.0 },
        ];
        for shape in &shapes {
            let origin = [2.0, 3.0, 2.5];
            let direction = unit([-0.6, -0.9, -0.8]);
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
            corner: [-1.0, 2.0, 0.0],
            across: [2.0, 0.2, 0.0],
            down: [0.1, -2.0, 0.3],
        };
        let mut halves = [0, 0];
        for i in 1..8 {
            let x = f64::from(i) / 4.0 - 1.0;
            let (contact, p) = surface(&card, [x, 1.0, 5.0], [0.0, 0.0, -1.0]);
            let (st, Tangents::Triangle { edges, st: at }) = contact.texture.expect("a texture")
            else {
                panic!("not a triangle");
            };
            halves[usize::from(st[0] < st[1])] += 1;
            // st = β·st_B + γ·st_C with the barycentric coordinates of the point: A has (0, 0).
            let n = cross(edges[0], edges[1]);
            let from = [0, 1, 2].map(|c| p[c] - [-1.0, 2.0, 0.0][c]);
            let beta = dot(cross(from, edges[1]), n) / dot(n, n);
            let gamma = dot(cross(edges[0], from), n) / dot(n, n);
            for c in 0..2 {
                assert!((beta * at[0][c] + gamma * at[1][c] - st[c]).abs() < 1e-12);
            }
        }
        assert!(halves[0] > 0 && halves[1] > 0);
    }

    #[test]
    fn a_shell_is_open_where_it_is_cut_and_hollow_inside() {
        let bowl = Shape::Shell { centre: [0.0; 3], radius: 1.0, axis: [0.0, 1.0, 0.0], keep: 0.5 };
        // From above through the opening onto the inner side of the bottom.
        let inside = bowl.meet([0.0, 3.0, 0.0], [0.0, -1.0, 0.0], 0.0).unwrap();
        assert!((inside.t - 4.0).abs() < 1e-12 && !inside.outside);
        assert!((inside.curvature + 1.0).abs() < 1e-12 && inside.normal[1] > 0.0);
        let outside = bowl.meet([0.0, -3.0, 0.0], [0.0, 1.0, 0.0], 0.0).unwrap();
        assert!((outside.t - 2.0).abs() < 1e-12 && outside.outside);
        assert!((outside.curvature - 1.0).abs() < 1e-12 && outside.normal[1] < 0.0);
    }
}
