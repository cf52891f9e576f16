//! Distances as the float reference reads them.

use super::address::texel_coordinate;
use crate::base::num;
use crate::cube::{across_edge, direction, face_uv};
use crate::distance::Distance;
use crate::policy::LookUp;

/// A map of distances, ready for look-ups.
#[derive(Clone, Debug)]
pub struct Distances(Source);

#[derive(Clone, Debug)]
enum Source {
    /// Six faces with a border of one texel.
    Cube {
        size: usize,
        texels: Vec<f64>,
    },
    Box([f64; 3]),
    Sphere(f64),
}

/// |v| of finite components, whatever their size; ∞ beyond the doubles.
pub(super) fn length(v: [f64; 3]) -> f64 {
    let largest = v.iter().fold(0.0f64, |most, x| most.max(x.abs()));
    if largest == 0.0 {
        return 0.0;
    }
    let (_, exponent) = libm::frexp(largest);
    let [x, y, z] = v.map(|x| libm::ldexp(x, -exponent));
    libm::ldexp((x * x + y * y + z * z).sqrt(), exponent)
}

/// v/|v|; +z where v is zero.
pub(super) fn unit(v: [f64; 3]) -> [f64; 3] {
    let largest = v.iter().fold(0.0f64, |most, x| most.max(x.abs()));
    if largest == 0.0 {
        return [0.0, 0.0, 1.0];
    }
    let (_, exponent) = libm::frexp(largest);
    let v = v.map(|x| libm::ldexp(x, -exponent));
    let size = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    v.map(|x| x / size)
}

/// Whether every component is 0.
pub(super) fn is_zero(v: [f64; 3]) -> bool {
    v.iter().all(|c| *c == 0.0)
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

impl Distances {
    /// Prepares a map. A corner of a cube, which has no texel, is the mean of the three that meet there.
    #[must_use]
    pub fn new(distance: &Distance) -> Self {
        let cube = match distance {
            Distance::Box(half_edges) => return Self(Source::Box(*half_edges)),
            Distance::Sphere(radius) => return Self(Source::Sphere(*radius)),
            Distance::Cube(cube) => cube,
        };
        let size = cube.size;
        let n = num::i64(size);
        let tap = |face: usize, x: i64, y: i64| {
            across_edge(size, face, x, y).map_or(f64::INFINITY, |(f, x, y)| {
                let index = (f * size + y) * size + x;
                cube.texels.get(index).map_or(f64::INFINITY, |t| f64::from(*t))
            })
        };
        let mut texels = Vec::with_capacity(6 * (size + 2) * (size + 2));
        for face in 0..6 {
            for y in -1..=n {
                for x in -1..=n {
                    let (ix, iy) = (x.clamp(0, n - 1), y.clamp(0, n - 1));
                    texels.push(if x != ix && y != iy {
                        (tap(face, ix, iy) + tap(face, x, iy) + tap(face, ix, y)) / 3.0
                    } else {
                        tap(face, x, y)
                    });
                }
            }
        }
        Self(Source::Cube { size, texels })
    }

    /// The size of a cube's faces and its texels with their border of one texel: index (face·(size + 2) + y)·(size + 2)
    /// + x, row and column 0 outside. `None` for a box and a sphere.
    #[must_use]
    pub fn bordered(&self) -> Option<(usize, &[f64])> {
        match &self.0 {
            Source::Cube { size, texels } => Some((*size, texels)),
            Source::Box(_) | Source::Sphere(_) => None,
        }
    }

    /// dist(q); q = 0 counts as +z. A texel of infinite distance that has any weight makes the whole infinite.
    #[must_use]
    pub fn read(&self, q: [f64; 3], look_up: LookUp) -> f64 {
        let q = unit(q);
        match &self.0 {
            Source::Sphere(radius) => *radius,
            Source::Box(half_edges) => q
                .iter()
                .zip(half_edges)
                .filter(|(q, _)| **q != 0.0)
                .map(|(q, h)| h / q.abs())
                .fold(f64::INFINITY, f64::min),
            Source::Cube { size, texels } => {
                let (face, [x, y], [s, t]) = place(*size, q, look_up);
                let at = |dx: usize, dy: usize| {
                    texels[(face * (size + 2) + y + dy) * (size + 2) + x + dx]
                };
                if look_up == LookUp::Nearest {
                    return at(0, 0);
                }
                let mut sum = 0.0;
                for (value, weight) in [
                    (at(0, 0), (1.0 - s) * (1.0 - t)),
                    (at(1, 0), s * (1.0 - t)),
                    (at(0, 1), (1.0 - s) * t),
                    (at(1, 1), s * t),
                ] {
                    if weight > 0.0 {
                        sum += value * weight;
                    }
                }
                sum
            }
        }
    }

    /// A normal of the surface in direction q, of any length: exact for a box and a sphere; for a cube the cross
    /// product of the diagonals of the four texels about q, inside of its face. `None` where it has none.
    #[must_use]
    pub fn normal(&self, q: [f64; 3]) -> Option<[f64; 3]> {
        let q = unit(q);
        match &self.0 {
            Source::Sphere(_) => Some(q),
            Source::Box(half_edges) => {
                let mut best = None;
                for axis in 0..3 {
                    let here = half_edges[axis] / q[axis].abs();
                    if q[axis] != 0.0 && best.is_none_or(|(_, least)| here < least) {
                        best = Some((axis, here));
                    }
                }
                let (axis, _) = best?;
                let mut n = [0.0; 3];
                n[axis] = q[axis].signum();
                Some(n)
            }
            Source::Cube { size, .. } if *size < 2 => Some(q),
            Source::Cube { size, texels } => {
                let (face, corner, _) = place(*size, q, LookUp::Bilinear);
                let [x, y] = corner.map(|c| c.clamp(1, size - 1));
                let n = *size as f64;
                let point = |dx: usize, dy: usize| {
                    let [x, y] = [x + dx, y + dy];
                    let distance = texels[(face * (size + 2) + y) * (size + 2) + x];
                    let centre = |c: usize| (2.0 * c as f64 - 1.0) / n - 1.0;
                    let way = unit(direction(face, centre(x), centre(y)));
                    distance.is_finite().then(|| way.map(|c| c * distance))
                };
                let [a, b, c, d] = [point(0, 0)?, point(1, 0)?, point(0, 1)?, point(1, 1)?];
                let minus = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
                let diagonals = [minus(d, a), minus(c, b)];
                let n = cross(unit(diagonals[0]), unit(diagonals[1]));
                let zero = is_zero(n) || diagonals.into_iter().any(is_zero);
                (!zero).then_some(n)
            }
        }
    }
}

/// Face, first column and row of the bordered face, and weights of the second ones.
fn place(size: usize, q: [f64; 3], look_up: LookUp) -> (usize, [usize; 2], [f64; 2]) {
    let (face, u, v) = face_uv(q);
    let mut corner = [0; 2];
    let mut weight = [0.0; 2];
    for (i, c) in [u, v].into_iter().enumerate() {
        let s = texel_coordinate(c, size);
        let (s, low) = match look_up {
            LookUp::Nearest => (s + 0.5, 0.0),
            LookUp::Bilinear => (s, -1.0),
        };
        let whole = s.floor().clamp(low, size as f64 - 1.0);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a whole number from 0 to the face's size"
        )]
        let index = (whole + 1.0) as usize;
        corner[i] = index;
        weight[i] = s - whole;
    }
    (face, corner, weight)
}
