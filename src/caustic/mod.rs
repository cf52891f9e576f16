//! Caustics: light that a refractive object throws onto the walls around it.
//!
//! After Szirmay-Kalos, Aszódi and Lazányi: a caustic map of 64 × 64 primary rays from a lamp through a view plane in
//! front of the object; each refracted ray is a HIT search, its hit's wall and place come from the impostor's uv map,
//! and a Gaussian adds its power to the wall's light map. A search may be any engine's; `traced` takes real rays.

use std::f64::consts::PI;

use glam::DVec3;

use crate::base::vector::unit;
use crate::fragment::HitFragment;
use crate::impostor::WallCube;
use crate::optics::{fresnel, refract};
use crate::scene::hit::object::Object;
use crate::scene::world::World;
use crate::scene::world::light::{Lamp, LightMap};

/// Primary rays along each side of the caustic map.
pub const SIDE: usize = 64;

/// Texels of a light map per world unit.
pub const TEXELS: f64 = 32.0;

/// Standard deviation of a photon's splat, in world units: a texel and a half.
pub const SIGMA: f64 = 1.5 / TEXELS;

/// A refracted primary ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Photon {
    /// Where it leaves the object, and where to.
    pub fragment: HitFragment,
    /// Power that it carries, linear RGB.
    pub power: [f64; 3],
}

/// Light on walls and where it came from.
#[derive(Clone, Debug, PartialEq)]
pub struct Caustic {
    /// Irradiance of the walls.
    pub map: LightMap,
    /// Photons that met a wall.
    pub landed: usize,
    /// Power of those that met one: what the map must hold.
    pub power: [f64; 3],
}

/// Solid angle of the rectangle [0, x] × [0, y] at distance 1.
fn corner(x: f64, y: f64) -> f64 {
    libm::atan2(x * y, (1.0 + x * x + y * y).sqrt())
}

/// The photons of a lamp through an object inside the ball (`centre`, `radius`), of the relative index `index`.
///
/// The view plane just covers the ball; a map texel's power is that of its solid angle, exactly, times
/// the share that the surface lets in. One refraction, at the first surface, as in the paper.
#[must_use]
pub fn photons(
    lamp: &Lamp,
    object: &dyn Object,
    (centre, radius): (DVec3, f64),
    index: f64,
) -> Vec<Photon> {
    let to = centre - lamp.position;
    let square = to.length_squared();
    if square <= radius * radius {
        return Vec::new();
    }
    let forward = unit(to);
    let up = if forward.y.abs() < 0.9 { DVec3::Y } else { DVec3::X };
    let right = unit(forward.cross(up));
    let down = forward.cross(right);
    let half = radius / (square - radius * radius).sqrt();
    let edge = |i: usize| half * (2.0 * i as f64 / SIDE as f64 - 1.0);
    let mut out = Vec::new();
    for row in 0..SIDE {
        for column in 0..SIDE {
            let [x0, x1, y0, y1] = [edge(column), edge(column + 1), edge(row), edge(row + 1)];
            let (a, b) = (0.5 * (x0 + x1), 0.5 * (y0 + y1));
            let direction = unit(forward + a * right + b * down);
            let Some(skin) = object.skin(lamp.position, direction, 0.0) else {
                continue;
            };
            let Some(through) = refract(direction, skin.normal, 1.0 / index) else {
                continue;
            };
            let solid = corner(x1, y1) - corner(x0, y1) - corner(x1, y0) + corner(x0, y0);
            let share = 1.0 - fresnel(direction.dot(skin.normal).abs(), index, 0.0);
            out.push(Photon {
                fragment: HitFragment {
                    x: (lamp.position + skin.t * direction).to_array(),
                    r: through.to_array(),
                    cone: None,
                },
                power: lamp.power.map(|p| p / (4.0 * PI) * solid * share),
            });
        }
    }
    out
}

/// Adds up photons whose places are known; `None` are lost.
#[must_use]
pub fn gather(
    walls: &[[f64; 2]],
    photons: &[Photon],
    places: &[Option<(usize, [f64; 2])>],
) -> Caustic {
    let mut out = Caustic { map: LightMap::new(walls, TEXELS), landed: 0, power: [0.0; 3] };
    for (photon, place) in photons.iter().zip(places) {
        let Some((wall, uv)) = place else { continue };
        out.landed += 1;
        for (sum, power) in out.power.iter_mut().zip(photon.power) {
            *sum += power;
        }
        out.map.splat(*wall, *uv, photon.power, SIGMA);
    }
    out
}

/// The caustic of hits: `hits` has each photon's direction from the reference point, `None` where it escaped.
#[must_use]
pub fn searched(
    world: &World,
    uv_map: &WallCube,
    photons: &[Photon],
    hits: &[Option<[f64; 3]>],
) -> Caustic {
    let places: Vec<_> = hits.iter().map(|hit| hit.and_then(|l| uv_map.place(l))).collect();
    gather(world.walls(), photons, &places)
}

/// The caustic of real rays.
#[must_use]
pub fn traced(world: &World, photons: &[Photon]) -> Caustic {
    let places: Vec<_> = photons
        .iter()
        .map(|photon| {
            let sight = world.look(photon.fragment.x.into(), photon.fragment.r.into())?;
            Some((sight.wall, sight.uv))
        })
        .collect();
    gather(world.walls(), photons, &places)
}

/// Root mean square of the difference of two maps over the texels that either lights, relative to the root
/// mean square of the second; 0 where both are dark.
#[must_use]
pub fn difference(a: &LightMap, b: &LightMap) -> f64 {
    let (mut square, mut size) = (0.0, 0.0);
    for (a, b) in a.walls.iter().zip(&b.walls) {
        for (a, b) in a.texels.iter().zip(&b.texels) {
            for (a, b) in a.iter().zip(b) {
                square += (a - b) * (a - b);
                size += b * b;
            }
        }
    }
    if size > 0.0 { (square / size).sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use glam::dvec3;

    use super::*;
    use crate::impostor::Impostor;
    use crate::scene::world::bodies::Ball;
    use crate::scene::world::built_in;

    const LAMP: Lamp = Lamp { position: dvec3(2.0, 2.0, 1.0), power: [100.0, 80.0, 60.0] };
    const BALL: Ball = Ball { centre: dvec3(0.5, -0.5, -1.0), radius: 0.8 };

    #[test]
    fn a_caustic_holds_the_power_of_the_photons_that_hit() {
        let world = built_in::room();
        let photons = photons(&LAMP, &BALL, (BALL.centre, BALL.radius), 1.3);
        // The inscribed circle of the square: π/4 of 4096, to a texel's width along its edge.
        let disc = PI / 4.0 * 4096.0;
        assert!((photons.len() as f64 - disc).abs() < PI * 64.0, "{}", photons.len());
        let caustic = traced(&world, &photons);
        assert_eq!(caustic.landed, photons.len(), "a room has no hole");
        let sent: f64 = photons.iter().map(|p| p.power[0]).sum();
        // Sums of some 3000 photons of some 80 texels each, every term rounded a few times.
        let slack = 3000.0 * 80.0 * f64::EPSILON;
        assert!((caustic.power[0] / sent - 1.0).abs() < slack);
        assert!((caustic.map.power()[0] / sent - 1.0).abs() < slack);
        // No more than the ball's solid angle lets through, no less than at a normal surface's loss of 1.7 % twice.
        let sine2 = BALL.radius * BALL.radius / BALL.centre.distance_squared(LAMP.position);
        let whole = LAMP.power[0] * (1.0 - (1.0 - sine2).sqrt()) / 2.0;
        assert!(sent < whole * (1.0 + 4.0 / 64.0) && sent > 0.85 * whole, "{sent} of {whole}");
    }

    #[test]
    fn searched_photons_land_where_real_ones_do_but_for_the_texels_of_the_uv_map() {
        let world = built_in::room();
        let impostor = Impostor::build(&world, DVec3::ZERO, 128);
        let photons = photons(&LAMP, &BALL, (BALL.centre, BALL.radius), 1.3);
        let hits: Vec<_> = photons
            .iter()
            .map(|p| {
                world.look(p.fragment.x.into(), p.fragment.r.into()).map(|s| s.point.to_array())
            })
            .collect();
        let caustic = searched(&world, &impostor.walls, &photons, &hits);
        assert!(caustic.landed * 100 > photons.len() * 98, "edges between walls lose some");
        let apart = difference(&caustic.map, &traced(&world, &photons).map);
        // Between texels of one wall the place is interpolated on a projective map: off by an eighth of its second
        // derivative, (2/128)²/8 of some metres, far below σ; the walls' edges lose a few photons.
        assert!(apart > 0.0 && apart < 0.2, "{apart}");
    }
}
