//! The analytic bodies: rooms and blocks with sides along the axes, balls, upright columns.

use glam::DVec3;

use super::{Body, Meeting};

/// A box with sides along the axes. Parts are its sides in the order +X −X +Y −Y +Z −Z.
///
/// On ±X a place is (z, y) from the lowest corner, on ±Y (x, z), on ±Z (x, y).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cuboid {
    /// Its lowest corner.
    pub low: DVec3,
    /// Its highest corner.
    pub high: DVec3,
}

/// The two axes across each axis: columns and rows of a side.
const ACROSS: [[usize; 2]; 3] = [[2, 1], [0, 2], [0, 1]];

impl Cuboid {
    fn meeting(&self, origin: DVec3, direction: DVec3, t: f64, axis: usize, high: bool) -> Meeting {
        let mut normal = DVec3::ZERO;
        normal[axis] = if direction[axis] > 0.0 { -1.0 } else { 1.0 };
        let place = ACROSS[axis].map(|a| {
            let along = origin[a] + t * direction[a] - self.low[a];
            along.clamp(0.0, self.high[a] - self.low[a])
        });
        Meeting { t, normal, part: 2 * axis + usize::from(!high), place }
    }
}

impl Body for Cuboid {
    fn meet(&self, origin: DVec3, direction: DVec3, beyond: f64) -> Option<Meeting> {
        // Entry: the latest of the near planes; exit: the earliest of the far ones.
        let mut entry = (f64::NEG_INFINITY, 0);
        let mut exit = (f64::INFINITY, 0);
        for axis in 0..3 {
            if direction[axis] == 0.0 {
                if !(self.low[axis]..=self.high[axis]).contains(&origin[axis]) {
                    return None;
                }
                continue;
            }
            let to = |plane: f64| (plane - origin[axis]) / direction[axis];
            let (a, b) = (to(self.low[axis]), to(self.high[axis]));
            let (near, far) = if a < b { (a, b) } else { (b, a) };
            if near > entry.0 {
                entry = (near, axis);
            }
            if far < exit.0 {
                exit = (far, axis);
            }
        }
        if entry.0 > exit.0 {
            return None;
        }
        let forward = |axis: usize| direction[axis] > 0.0;
        if entry.0 > beyond {
            let (t, axis) = entry;
            return Some(self.meeting(origin, direction, t, axis, !forward(axis)));
        }
        let (t, axis) = exit;
        (t > beyond && t.is_finite())
            .then(|| self.meeting(origin, direction, t, axis, forward(axis)))
    }

    fn parts(&self) -> Vec<[f64; 2]> {
        (0..6).map(|part| ACROSS[part / 2].map(|a| self.high[a] - self.low[a])).collect()
    }
}

/// A ball. One part: longitude and colatitude, as arc lengths at the equator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Its centre.
    pub centre: DVec3,
    /// Its radius.
    pub radius: f64,
}

/// The two roots of |direction|²·t² + 2·half·t + rest = 0, the smaller first.
pub(crate) fn roots(square: f64, half: f64, rest: f64) -> Option<[f64; 2]> {
    let discriminant = half * half - square * rest;
    if discriminant < 0.0 || square <= 0.0 {
        return None;
    }
    // One root by a sum of equal signs, the other by their product: neither cancels.
    let root = discriminant.sqrt();
    let sum = if half > 0.0 { -half - root } else { root - half };
    if sum == 0.0 {
        return Some([0.0, 0.0]);
    }
    let (a, b) = (sum / square, rest / sum);
    Some(if a < b { [a, b] } else { [b, a] })
}

/// The multiples of `direction` at which a ray, that starts at `from` as seen from the centre, meets a ball.
pub(crate) fn ball_roots(from: DVec3, direction: DVec3, radius: f64) -> Option<[f64; 2]> {
    let rest = from.length_squared() - radius * radius;
    roots(direction.length_squared(), direction.dot(from), rest)
}

impl Body for Ball {
    fn meet(&self, origin: DVec3, direction: DVec3, beyond: f64) -> Option<Meeting> {
        let from = origin - self.centre;
        let t = ball_roots(from, direction, self.radius)?.into_iter().find(|t| *t > beyond)?;
        let outward = (from + t * direction) / self.radius;
        let facing = if outward.dot(direction) > 0.0 { -1.0 } else { 1.0 };
        let turn = std::f64::consts::PI;
        Some(Meeting {
            t,
            normal: facing * outward,
            part: 0,
            place: [
                (libm::atan2(outward.x, outward.z) + turn) * self.radius,
                libm::acos(outward.y.clamp(-1.0, 1.0)) * self.radius,
            ],
        })
    }

    fn parts(&self) -> Vec<[f64; 2]> {
        let turn = std::f64::consts::PI;
        vec![[2.0 * turn * self.radius, turn * self.radius]]
    }
}

/// An upright round column. Part 0 is the mantle (arc length, height), 1 the top, 2 the bottom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Column {
    /// x and z of the axis.
    pub axis: [f64; 2],
    /// Its radius.
    pub radius: f64,
    /// y of the bottom and of the top.
    pub span: [f64; 2],
}

impl Body for Column {
    fn meet(&self, origin: DVec3, direction: DVec3, beyond: f64) -> Option<Meeting> {
        let from = [origin.x - self.axis[0], origin.z - self.axis[1]];
        let [low, high] = self.span;
        let mut best: Option<Meeting> = None;
        let mut offer = |meeting: Meeting| {
            if meeting.t > beyond && best.is_none_or(|b| meeting.t < b.t) {
                best = Some(meeting);
            }
        };
        let flat = [direction.x, direction.z];
        let square = flat[0] * flat[0] + flat[1] * flat[1];
        let half = flat[0] * from[0] + flat[1] * from[1];
        let rest = from[0] * from[0] + from[1] * from[1] - self.radius * self.radius;
        for t in roots(square, half, rest).into_iter().flatten() {
            let y = origin.y + t * direction.y;
            if !(low..=high).contains(&y) {
                continue;
            }
            let out = [0, 1].map(|i| (from[i] + t * flat[i]) / self.radius);
            let facing = if out[0] * flat[0] + out[1] * flat[1] > 0.0 { -1.0 } else { 1.0 };
            let angle = libm::atan2(out[0], out[1]) + std::f64::consts::PI;
            offer(Meeting {
                t,
                normal: DVec3::new(facing * out[0], 0.0, facing * out[1]),
                part: 0,
                place: [angle * self.radius, y - low],
            });
        }
        if direction.y != 0.0 {
            for (part, y) in [(1, high), (2, low)] {
                let t = (y - origin.y) / direction.y;
                let at = [0, 1].map(|i| from[i] + t * flat[i]);
                if at[0] * at[0] + at[1] * at[1] <= self.radius * self.radius {
                    offer(Meeting {
                        t,
                        normal: if direction.y > 0.0 { DVec3::NEG_Y } else { DVec3::Y },
                        part,
                        place: at.map(|c| c + self.radius),
                    });
                }
            }
        }
        best
    }

    fn parts(&self) -> Vec<[f64; 2]> {
        let around = 2.0 * std::f64::consts::PI * self.radius;
        let across = 2.0 * self.radius;
        vec![[around, self.span[1] - self.span[0]], [across, across], [across, across]]
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "whole numbers, of which every step is exact")]
mod tests {
    use glam::dvec3;

    use super::*;

    #[test]
    fn a_room_is_met_from_inside_and_a_block_from_outside() {
        let cuboid = Cuboid { low: dvec3(-1.0, -2.0, -3.0), high: dvec3(4.0, 5.0, 6.0) };
        let inside = cuboid.meet(DVec3::ZERO, 2.0 * DVec3::X, 0.0).unwrap();
        assert_eq!((inside.t, inside.part, inside.normal), (2.0, 0, DVec3::NEG_X));
        assert_eq!(inside.place, [3.0, 2.0]);
        let outside = cuboid.meet(dvec3(-3.0, 0.0, 1.0), DVec3::X, 0.0).unwrap();
        assert_eq!((outside.t, outside.part, outside.normal), (2.0, 1, DVec3::NEG_X));
        assert!(cuboid.meet(dvec3(-3.0, 9.0, 1.0), DVec3::X, 0.0).is_none());
        assert!(cuboid.meet(9.0 * DVec3::X, DVec3::X, 0.0).is_none());
        for part in 0..6 {
            let mut d = DVec3::ZERO;
            d[part / 2] = if part % 2 == 0 { 1.0 } else { -1.0 };
            assert_eq!(cuboid.meet(DVec3::ZERO, d, 0.0).unwrap().part, part);
        }
    }

    #[test]
    fn round_bodies_are_met_on_their_surface_with_a_normal_that_faces_the_ray() {
        let ball = Ball { centre: dvec3(1.0, 2.0, -3.0), radius: 0.75 };
        let column = Column { axis: [1.0, -3.0], radius: 0.5, span: [-1.0, 2.0] };
        let mut met = [0, 0];
        for i in 0..400 {
            let turn = f64::from(i) * 0.37;
            let origin = dvec3(4.0 * libm::sin(turn), 5.0 * libm::cos(1.7 * turn), 3.0);
            let direction = dvec3(1.0 + 0.8 * libm::sin(3.1 * turn), 1.5, -3.0) - origin;
            if let Some(m) = ball.meet(origin, direction, 0.0) {
                let out = (origin + m.t * direction - ball.centre) / ball.radius;
                // A few roundings of numbers below 10 over a radius of ¾.
                assert!((out.length_squared() - 1.0).abs() < 1e-13);
                assert!(out.abs_diff_eq(m.normal, 1e-13) && m.normal.dot(direction) < 0.0);
                met[0] += 1;
            }
            if let Some(m) = column.meet(origin, direction, 0.0) {
                let p = origin + m.t * direction;
                let reach = ((p.x - 1.0).powi(2) + (p.z + 3.0).powi(2)).sqrt();
                let on = match m.part {
                    0 => (reach - 0.5).abs() < 1e-13 && (-1.0..=2.0).contains(&p.y),
                    1 => (p.y - 2.0).abs() < 1e-13 && reach <= 0.5,
                    _ => (p.y + 1.0).abs() < 1e-13 && reach <= 0.5,
                };
                assert!(on && m.normal.dot(direction) < 0.0, "{m:?} {p:?}");
                let [width, height] = column.parts()[m.part];
                assert!((0.0..=width).contains(&m.place[0]));
                assert!((0.0..=height + 1e-13).contains(&m.place[1]));
                met[1] += 1;
            }
        }
        assert!(met.iter().all(|n| *n > 100), "{met:?}");
    }

    #[test]
    fn a_ray_that_starts_on_a_surface_leaves_it() {
        let ball = Ball { centre: DVec3::ZERO, radius: 1.0 };
        assert!(ball.meet(DVec3::X, dvec3(1.0, 0.5, 0.0), 0.0).is_none());
        let back = ball.meet(DVec3::X, DVec3::NEG_X, 0.0).unwrap();
        assert_eq!((back.t, back.normal), (2.0, DVec3::X));
    }
}
