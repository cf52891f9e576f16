//! What iterations, words and texels of an impostor buy: errors of the hit's direction over the rays of a
//! scene.

use glam::DVec3;
use rayon::prelude::*;

use super::march::march;
use crate::distance::DistanceCube;
use crate::policy::HitStatus;
use crate::reference::Distances;
use crate::scene::hit::HitScene;
use crate::srgb::srgb_encode;
use crate::truth::texels::PaddedCube;

/// A ray of the scene and what it really meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Case {
    /// Where it starts, relative to the reference point.
    pub x: [f64; 3],
    /// Its unit direction.
    pub r: [f64; 3],
    /// The point that it meets in the world.
    pub real: [f64; 3],
    /// Distance along the ray to that point.
    pub d: f64,
}

/// The rays of a scene that meet something.
#[must_use]
pub fn cases(scene: &HitScene) -> Vec<Case> {
    scene
        .rays
        .par_iter()
        .filter_map(|ray| {
            let (x, r) = (ray.fragment.x, ray.fragment.r);
            let sight = scene.view.world.look(x.into(), r.into())?;
            Some(Case { x, r, real: sight.point.to_array(), d: sight.meeting.t })
        })
        .collect()
}

/// Points of the first search for the exact hit; between two of them a root is halved until it stands.
const FINE: u32 = 2048;

/// Where each ray first passes behind the bilinear surface of an impostor: what an unlimited search could
/// find there. `None` where it never does within reach.
#[must_use]
pub fn exact(cases: &[Case], distances: &Distances, farthest: f64) -> Vec<Option<[f64; 3]>> {
    let all = marches(cases, distances, farthest, [FINE, 48]);
    let surface = |found: Found| (found.status == HitStatus::Converged).then_some(found.l);
    all.into_iter().map(surface).collect()
}

/// [`march`] of every ray, as far as the farthest wall can be.
#[must_use]
pub fn marches(
    cases: &[Case],
    distances: &Distances,
    farthest: f64,
    [steps, halvings]: [u32; 2],
) -> Vec<Found> {
    cases
        .par_iter()
        .map(|case| {
            let range = farthest + DVec3::from(case.x).length();
            march(distances, case.x, case.r, range, steps, halvings)
        })
        .collect()
}

/// Largest finite distance of a cube; 0 where there is none.
#[must_use]
pub fn farthest(cube: &DistanceCube) -> f64 {
    let finite = cube.texels.iter().filter(|t| t.is_finite());
    finite.fold(0.0, |most: f64, t| most.max(f64::from(*t)))
}

/// What a search found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// The point (where it escaped the direction).
    pub l: [f64; 3],
    /// Its distance along the ray.
    pub d: f64,
    /// Look-ups made in the loop.
    pub look_ups: u32,
    /// Whether one of them lay behind the surface.
    pub overshot: bool,
    /// How it ended.
    pub status: HitStatus,
}

/// The angle between two directions in degrees; 180 where one of them is zero.
#[must_use]
pub fn degrees(a: [f64; 3], b: [f64; 3]) -> f64 {
    let [a, b] = [a, b].map(DVec3::from);
    if a.length() == 0.0 || b.length() == 0.0 {
        return 180.0;
    }
    libm::atan2(a.cross(b).length(), a.dot(b)).to_degrees()
}

/// Quantiles of an error in degrees.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Angles {
    /// Half of the rays are below.
    pub median: f64,
    /// 95 % are below.
    pub p95: f64,
    /// 99 % are below.
    pub p99: f64,
    /// The largest.
    pub max: f64,
}

impl Angles {
    fn of(mut errors: Vec<f64>) -> Self {
        errors.sort_by(f64::total_cmp);
        let at = |per_cent: usize| {
            let index = (errors.len() * per_cent).div_ceil(100).max(1) - 1;
            errors.get(index).copied().unwrap_or(0.0)
        };
        Self { median: at(50), p95: at(95), p99: at(99), max: at(100) }
    }
}

/// What a way of searching made of all rays.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Against the real rays.
    pub real: Angles,
    /// Against the exact hit on the impostor's surface, where there is one.
    pub surface: Angles,
    /// RMS over rays and channels of colour(l) − colour(real hit), both bilinear at level 0 of the
    /// impostor, in 8-bit sRGB steps.
    pub colour_steps: f64,
    /// Rays by status, in the order of [`HitStatus::ALL`].
    pub endings: [u64; 6],
    /// Rays with a look-up behind the surface.
    pub overshoots: u64,
    /// Look-ups in the loop per ray.
    pub look_ups: f64,
    /// Rays that say `converged` although the real ray meets a wall well before: d exceeds the real
    /// distance by more than [`FAR_SHARE`] of it.
    pub false_far: u64,
}

/// How much farther than the real hit a point counts as another wall's: walls in the built-in worlds are
/// farther apart than that, and an impostor's own error on the right wall is far below.
pub const FAR_SHARE: f64 = 0.1;

/// Sums up what a search found for every ray.
#[must_use]
pub fn run(
    cases: &[Case],
    exact: &[Option<[f64; 3]>],
    colours: &PaddedCube,
    found: &[Found],
) -> Row {
    let mut endings = [0; 6];
    let (mut overshoots, mut look_ups, mut false_far, mut squares) = (0, 0, 0, 0.0);
    let (mut real, mut surface) = (Vec::with_capacity(cases.len()), Vec::new());
    let encode = |c: f64| 255.0 * srgb_encode(c.clamp(0.0, 1.0));
    for ((case, exact), found) in cases.iter().zip(exact).zip(found) {
        real.push(degrees(found.l, case.real));
        surface.extend(exact.map(|l| degrees(found.l, l)));
        if let Some(index) = HitStatus::ALL.iter().position(|e| *e == found.status) {
            endings[index] += 1;
        }
        overshoots += u64::from(found.overshot);
        look_ups += u64::from(found.look_ups);
        let beyond = found.d > case.d * (1.0 + FAR_SHARE);
        false_far += u64::from(found.status == HitStatus::Converged && beyond);
        let (a, b) = (colours.look_up(found.l), colours.look_up(case.real));
        for c in 0..3 {
            let step = encode(a[c]) - encode(b[c]);
            squares += step * step;
        }
    }
    let rays = cases.len().max(1) as f64;
    Row {
        real: Angles::of(real),
        surface: Angles::of(surface),
        colour_steps: (squares / (3.0 * rays)).sqrt(),
        endings,
        overshoots,
        look_ups: look_ups as f64 / rays,
        false_far,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_degrees_and_quantiles_are_of_sorted_errors() {
        assert!((degrees([1.0, 0.0, 0.0], [0.0, 2.0, 0.0]) - 90.0).abs() < 1e-12);
        assert!((degrees([1.0, 1e-9, 0.0], [1.0, 0.0, 0.0]) - 5.729_577_951e-8).abs() < 1e-15);
        let angles = Angles::of((1..=200).rev().map(f64::from).collect());
        let got = [angles.median, angles.p95, angles.p99, angles.max];
        assert_eq!(got.map(f64::to_bits), [100.0, 190.0, 198.0, 200.0f64].map(f64::to_bits));
    }
}
