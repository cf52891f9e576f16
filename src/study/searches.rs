//! Searches for a hit: against what rays really meet, against the impostor's own surface, and a linear march.

use glam::DVec3;
use rayon::prelude::*;

use super::measures::Measures;
use super::sweep::Measuring;
use crate::base::vector::degrees;
use crate::distance::{Distance, DistanceCube};
use crate::engine::HitJob;
use crate::engine::hit::{HitF64, HitResult};
use crate::engine::reuse::lines::quantile;
use crate::policy::{HitStatus, LookUp};
use crate::reference::Distances;
use crate::settings::Settings;
use crate::srgb::srgb_encode;
use crate::truth::texels::PaddedCube;

/// A ray of a scene and its real hit.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Case {
    /// Where it starts, relative to the reference point.
    x: [f64; 3],
    /// Its unit direction.
    r: [f64; 3],
    /// The point that it meets in the world.
    real: [f64; 3],
    /// Distance along the ray to that point.
    d: f64,
}

/// The result of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Found {
    /// The point (where it escaped the direction).
    l: [f64; 3],
    /// Its distance along the ray.
    d: f64,
    /// Look-ups made in the loop.
    look_ups: u32,
    /// Whether one of them lay behind the surface.
    overshot: bool,
    /// How it ended.
    status: HitStatus,
}

impl From<&HitResult> for Found {
    fn from(result: &HitResult) -> Self {
        Self {
            l: result.l,
            d: result.d,
            look_ups: result.iterations,
            overshot: result.overshot,
            status: result.status,
        }
    }
}

/// How much farther than the real hit a point counts as another wall's: walls in the built-in worlds are farther apart
/// than that, and an impostor's own error on the right wall is far below.
const FAR_SHARE: f64 = 0.1;
/// Steps and halvings of the march that is the usual alternative to a search.
const MARCH: [u32; 2] = [32, 6];
/// Steps and halvings that find the exact hit on an impostor's surface.
const FINE: [u32; 2] = [2048, 48];

fn length(a: [f64; 3]) -> f64 {
    DVec3::from(a).length()
}

/// `steps` equal steps over `range` until the first point behind the surface, then halvings of the last step. Look-ups
/// as made; hardware without early exit pays for all.
fn march(distances: &Distances, x: [f64; 3], r: [f64; 3], range: f64, how: [u32; 2]) -> Found {
    let [steps, halvings] = how;
    let along = |d: f64| [0, 1, 2].map(|i| x[i] + r[i] * d);
    let behind = |d: f64| {
        let l = along(d);
        let size = length(l);
        size > 0.0 && size > distances.read(l, LookUp::Bilinear)
    };
    let place = |step: u32| range * f64::from(step) / f64::from(steps);
    let Some(step) = (1..=steps).find(|step| behind(place(*step))) else {
        let status = HitStatus::Escaped;
        return Found { l: r, d: range, look_ups: steps, overshot: false, status };
    };
    let (mut low, mut high) = (place(step - 1), place(step));
    for _ in 0..halvings {
        let middle = 0.5 * (low + high);
        if behind(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    let d = 0.5 * (low + high);
    let look_ups = step + halvings;
    Found { l: along(d), d, look_ups, overshot: true, status: HitStatus::Converged }
}

/// Largest finite distance of a cube; 0 where there is none.
fn farthest(cube: &DistanceCube) -> f64 {
    let finite = cube.texels.iter().filter(|t| t.is_finite());
    finite.fold(0.0, |most: f64, t| most.max(f64::from(*t)))
}

/// A scene's rays with the data that no unit changes.
#[derive(Debug)]
pub(super) struct RealRays {
    /// Rays that meet something.
    cases: Vec<Case>,
    /// Where each first passes behind the impostor's bilinear surface, once that was asked for.
    surface: Option<Vec<Option<[f64; 3]>>>,
    /// The results of the march, once they were asked for.
    march: Option<Vec<Found>>,
}

impl RealRays {
    /// Follows the rays of a scene into its world.
    pub(super) fn new(subject: &HitJob) -> Self {
        let case = |ray: &crate::scene::hit::PixelRay| {
            let (x, r) = (ray.fragment.x, ray.fragment.r);
            let sight = subject.scene.view.world.look(x.into(), r.into())?;
            Some(Case { x, r, real: sight.point.to_array(), d: sight.meeting.t })
        };
        let cases = subject.scene.rays.par_iter().filter_map(case).collect();
        Self { cases, surface: None, march: None }
    }

    /// [`march`] of every ray, as far as the farthest wall can be.
    fn marches(&self, distance: &Distance, how: [u32; 2]) -> Vec<Found> {
        let distances = Distances::new(distance);
        let most = match distance {
            Distance::Cube(cube) => farthest(cube),
            Distance::Box(half) => length(*half),
            Distance::Sphere(radius) => *radius,
        };
        let one = |c: &Case| march(&distances, c.x, c.r, most + length(c.x), how);
        self.cases.par_iter().map(one).collect()
    }

    /// Puts the figures of a unit's search, and of the others that `how` asks for.
    pub(super) fn compare(
        &mut self,
        subject: &HitJob,
        settings: &Settings,
        results: &[HitResult],
        how: &Measuring,
        measures: &mut Measures,
    ) {
        let surface = |found: &Found| (found.status == HitStatus::Converged).then_some(found.l);
        if how.wants("surface_") && self.surface.is_none() {
            let fine = self.marches(&subject.distance, FINE);
            self.surface = Some(fine.iter().map(surface).collect());
        }
        if how.wants("march_") && self.march.is_none() {
            self.march = Some(self.marches(&subject.distance, MARCH));
        }
        let colours = how.wants("hit_colour").then(|| PaddedCube::new(&subject.map.levels[0]));
        let mut put = |searcher: &str, found: &[Found]| {
            for (name, value) in self.figures(found, colours.as_ref()) {
                measures.put_of(searcher, name, value);
            }
        };
        put("", &results.iter().map(Found::from).collect::<Vec<_>>());
        if how.wants("f64_") {
            let engine = HitF64::new(settings, &subject.distance, None, 1);
            let results = engine.filter(&subject.rays(), &|_| {});
            put("f64_", &results.iter().map(Found::from).collect::<Vec<_>>());
        }
        if let Some(march) = &self.march {
            put("march_", march);
        }
    }

    /// The figures of a search by name; of rays that meet nothing there is no direction to compare with.
    fn figures(&self, found: &[Found], colours: Option<&PaddedCube>) -> Vec<(&'static str, f64)> {
        let share = |n: usize| n as f64 / found.len().max(1) as f64;
        let count = |of: &dyn Fn(&Found) -> bool| share(found.iter().filter(|f| of(f)).count());
        let look_ups: u64 = found.iter().map(|f| u64::from(f.look_ups)).sum();
        let mut out = vec![
            ("look_ups_per_ray", look_ups as f64 / found.len().max(1) as f64),
            ("converged_share", count(&|f| f.status == HitStatus::Converged)),
            ("max_iterations_share", count(&|f| f.status == HitStatus::MaxIterations)),
            ("overshot_share", count(&|f| f.overshot)),
        ];
        if self.cases.len() != found.len() {
            return out;
        }
        let pairs = || found.iter().zip(&self.cases);
        let mut real: Vec<f64> = pairs().map(|(f, case)| degrees(f.l, case.real)).collect();
        real.sort_by(f64::total_cmp);
        out.extend([
            ("direction_median_deg", quantile(&real, 50)),
            ("direction_p95_deg", quantile(&real, 95)),
            ("direction_p99_deg", quantile(&real, 99)),
            ("direction_max_deg", quantile(&real, 100)),
        ]);
        let far = |(f, case): &(&Found, &Case)| {
            f.status == HitStatus::Converged && f.d > case.d * (1.0 + FAR_SHARE)
        };
        out.push(("false_far_share", share(pairs().filter(far).count())));
        if let Some(surface) = &self.surface {
            let there = found.iter().zip(surface);
            let mut there: Vec<f64> =
                there.filter_map(|(f, l)| l.map(|l| degrees(f.l, l))).collect();
            there.sort_by(f64::total_cmp);
            out.extend([
                ("surface_median_deg", quantile(&there, 50)),
                ("surface_p95_deg", quantile(&there, 95)),
                ("surface_p99_deg", quantile(&there, 99)),
                ("surface_max_deg", quantile(&there, 100)),
            ]);
        }
        if let Some(colours) = colours {
            let encode = |c: f64| 255.0 * srgb_encode(c.clamp(0.0, 1.0));
            let mut squares = 0.0;
            for (f, case) in pairs() {
                let (a, b) = (colours.look_up(f.l), colours.look_up(case.real));
                for c in 0..3 {
                    let step = encode(a[c]) - encode(b[c]);
                    squares += step * step;
                }
            }
            out.push(("hit_colour_lsb8", (squares / (3 * found.len().max(1)) as f64).sqrt()));
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_degrees() {
        assert!((degrees([1.0, 0.0, 0.0], [0.0, 2.0, 0.0]) - 90.0).abs() < 1e-12);
        assert!((degrees([1.0, 1e-9, 0.0], [1.0, 0.0, 0.0]) - 5.729_577_951e-8).abs() < 1e-15);
    }

    #[test]
    fn the_march_brackets_the_wall_within_its_last_step() {
        let distances = Distances::new(&Distance::Box([4.0, 3.0, 5.0]));
        let got = march(&distances, [0.5, 0.5, 0.5], [0.6, 0.0, 0.8], 16.0, MARCH);
        // The wall z = 5 is 4.5/0.8 away, nearer than x = 4; half a step after six halvings is 16/32/128.
        assert!((got.d - 4.5 / 0.8).abs() <= 16.0 / 32.0 / 128.0);
        assert_eq!(got.status, HitStatus::Converged);
        assert_eq!(got.look_ups, 12 + 6);
    }
}
