//! Distance impostors: a world seen from a reference point, as three cube maps.
//!
//! All three have Vulkan's faces with texel centres at half texels (see [`crate::cube`]):
//! colour with its mip chain, the Euclidean distance from the reference point (not a depth along a face's
//! axis), and the place on the wall that is seen, for light maps.
//!
//! Source: Szirmay-Kalos, Aszódi, Lazányi, "Ray Tracing Effects without Tracing Rays" (2005).

#[cfg(feature = "files")]
pub mod write;

use glam::DVec3;
use rayon::prelude::*;

use crate::base::num;
use crate::cube::{CubeLevel, CubeMap, direction, face_uv};
use crate::distance::DistanceCube;
use crate::mips::build_mips;
use crate::scene::world::World;

#[cfg(feature = "files")]
pub use crate::image::{CleanedDistances, load_distance};
#[cfg(feature = "files")]
pub use write::write_impostor;

/// Rays along each side of a texel whose mean is its colour.
const SAMPLES: usize = 4;

/// Which wall a direction sees, and where on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallPlace {
    /// Number of the wall in [`World::walls`]; −1 where nothing is seen.
    pub wall: i32,
    /// Place on it, 0…1 each way.
    pub uv: [f32; 2],
}

/// Wall places by direction. Read the nearest texel: between two walls there is nothing to interpolate.
#[derive(Clone, Debug, PartialEq)]
pub struct WallCube {
    /// Texels along an edge.
    pub size: usize,
    /// Face-major, then row-major.
    pub texels: Vec<WallPlace>,
}

impl WallCube {
    /// Wall and place in a direction: bilinear where all four texels around it are of one wall, else the
    /// nearest texel's; `None` where nothing is seen.
    #[must_use]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped to the face's texels"
    )]
    pub fn place(&self, direction: [f64; 3]) -> Option<(usize, [f64; 2])> {
        let (face, u, v) = face_uv(direction);
        let size = self.size as f64;
        let texel = |x: usize, y: usize| self.texels[(face * self.size + y) * self.size + x];
        let at = [u, v].map(|t| (0.5 * (t + 1.0) * size - 0.5).clamp(0.0, size - 1.0));
        let [x, y] = at.map(|t| t as usize);
        let [x1, y1] = [x, y].map(|t| (t + 1).min(self.size - 1));
        let [fx, fy] = [at[0] - x as f64, at[1] - y as f64];
        let four = [texel(x, y), texel(x1, y), texel(x, y1), texel(x1, y1)];
        let near = texel(if fx < 0.5 { x } else { x1 }, if fy < 0.5 { y } else { y1 });
        let wall = usize::try_from(near.wall).ok()?;
        if four.iter().any(|t| t.wall != near.wall) {
            return Some((wall, near.uv.map(f64::from)));
        }
        let mix = |c: usize| {
            let [a, b, d, e] = four.map(|t| f64::from(t.uv[c]));
            let (above, below) = (a + (b - a) * fx, d + (e - d) * fx);
            above + (below - above) * fy
        };
        Some((wall, [mix(0), mix(1)]))
    }
}

/// A world seen from a point.
#[derive(Clone, Debug, PartialEq)]
pub struct Impostor {
    /// Linear RGB, the mean of 4 × 4 rays a texel, with the mip chain.
    pub colour: CubeMap,
    /// Distance along the ray through each texel's centre; +∞ where it escapes.
    pub distance: DistanceCube,
    /// What that ray meets.
    pub walls: WallCube,
}

/// u or v of sample `sample` of `of` in texel `texel` of a face of `size`.
fn at(texel: usize, sample: usize, of: usize, size: usize) -> f64 {
    let halves = (of * size) as f64;
    ((2 * (of * texel + sample) + 1) as f64 - halves) / halves
}

impl Impostor {
    /// Looks around from `reference`, with `size` ≥ 1 texels along a face's edge.
    #[must_use]
    pub fn build(world: &World, reference: DVec3, size: usize) -> Self {
        let rows: Vec<(Vec<_>, Vec<_>)> = (0..6 * size)
            .into_par_iter()
            .map(|row| {
                let (face, y) = (row / size, row % size);
                (0..size)
                    .map(|x| {
                        (
                            colour(world, reference, size, [face, x, y]),
                            centre(world, reference, size, [face, x, y]),
                        )
                    })
                    .unzip()
            })
            .collect();
        let (colours, centres): (Vec<_>, Vec<_>) = rows.into_iter().unzip();
        let (distances, walls) = centres.concat().into_iter().unzip();
        Self {
            colour: build_mips(CubeLevel { size, texels: colours.concat() }),
            distance: DistanceCube { size, texels: distances },
            walls: WallCube { size, texels: walls },
        }
    }
}

fn colour(world: &World, reference: DVec3, size: usize, [face, x, y]: [usize; 3]) -> [f32; 3] {
    let mut sum = [0.0; 3];
    for j in 0..SAMPLES {
        for i in 0..SAMPLES {
            let d = direction(face, at(x, i, SAMPLES, size), at(y, j, SAMPLES, size)).into();
            for (sum, c) in sum.iter_mut().zip(world.radiance(reference, d)) {
                *sum += c;
            }
        }
    }
    sum.map(|c| num::f32(c / (SAMPLES * SAMPLES) as f64))
}

fn centre(
    world: &World,
    reference: DVec3,
    size: usize,
    [face, x, y]: [usize; 3],
) -> (f32, WallPlace) {
    let d = DVec3::from(direction(face, at(x, 0, 1, size), at(y, 0, 1, size)));
    match world.look(reference, d) {
        None => (f32::INFINITY, WallPlace { wall: -1, uv: [0.0; 2] }),
        Some(sight) => (
            num::f32(sight.meeting.t * d.length()),
            WallPlace { wall: num::i32(sight.wall), uv: sight.uv.map(num::f32) },
        ),
    }
}

#[cfg(test)]
mod tests {
    use glam::dvec3;

    use super::*;
    use crate::scene::world::bodies::{Ball, Cuboid};
    use crate::scene::world::paint::Paint;

    #[test]
    fn distances_are_euclidean_and_infinite_where_a_ray_escapes() {
        let world = World::default().with(
            Ball { centre: dvec3(0.0, 0.0, -3.0), radius: 1.0 },
            Paint::Tiled { colour: [0.5; 3] },
        );
        let got = Impostor::build(&world, DVec3::ZERO, 33);
        // The middle of −z sees the ball 2 away; +x sees nothing.
        let texel = |face: usize, x: usize, y: usize| (face * 33 + y) * 33 + x;
        assert!((got.distance.texels[texel(5, 16, 16)] - 2.0).abs() < 1e-6);
        assert!(got.distance.texels[texel(0, 16, 16)].is_infinite());
        assert_eq!(got.walls.texels[texel(0, 16, 16)].wall, -1);
        assert_eq!(got.walls.texels[texel(5, 16, 16)].wall, 0);
        assert!(got.colour.levels[0].texel(0, 3, 4).iter().all(|c| c.abs() <= 0.0));
        assert_eq!(got.colour.levels.len(), 6);
    }

    #[test]
    fn every_texel_of_a_box_lies_on_its_wall() {
        let room = Cuboid { low: dvec3(-1.0, -2.0, -3.0), high: dvec3(4.0, 5.0, 6.0) };
        let world = World::default().with(room, Paint::Room);
        let reference = dvec3(0.5, -0.25, 1.0);
        let size = 16;
        let got = Impostor::build(&world, reference, size);
        let mut seen = [0; 6];
        for (index, (distance, place)) in
            got.distance.texels.iter().zip(&got.walls.texels).enumerate()
        {
            let (face, y, x) = (index / size / size, index / size % size, index % size);
            let d = DVec3::from(direction(face, at(x, 0, 1, size), at(y, 0, 1, size)));
            let point = reference + f64::from(*distance) * d / d.length();
            let wall = num::usize(place.wall);
            let axis = wall / 2;
            let plane = if wall % 2 == 0 { room.high } else { room.low };
            // Distances below 10, rounded to f32: half an ulp is 2⁻²¹.
            assert!((point[axis] - plane[axis]).abs() < 1e-6, "{index} {point:?}");
            seen[wall] += 1;
            let [a, b] = [[2, 1], [0, 2], [0, 1]][axis];
            for (uv, k) in place.uv.into_iter().zip([a, b]) {
                let back = room.low[k] + f64::from(uv) * (room.high[k] - room.low[k]);
                assert!((back - point[k]).abs() < 2e-6);
            }
        }
        assert!(seen.iter().all(|n| *n > 20), "{seen:?}");
    }
}
