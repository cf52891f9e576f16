//! Ray cones along the paths of a scene: the same walk in the unit's registers and in doubles.

use glam::DVec3;
use lanes::{Runs as _, Simd, Task};
use rtl_model::cone::{Cone as RtlCone, Dither, Dyadic};
use rtl_model::fx::Flags;
use rtl_model::regs as model;
use rtl_model::stages::ray_cone::{self as rtl, Cfg, camera as rtl_camera};

use super::dispatch::Level;
use crate::policy::{ConeMetric, ConePolicy, ConeRules, SetDiffuse};
use crate::reference::ray_cone::{self as float, Step, camera as float_camera};
use crate::scene::tex::camera::{Camera, Lens};
use crate::scene::tex::path::{Event, Look, Path};

/// Arithmetic of cones: registers or doubles.
pub trait Cones {
    /// A cone.
    type Cone: Copy;

    /// The pinhole's cone of a ray.
    fn pinhole(&mut self, direction: [f64; 3]) -> Self::Cone;
    /// The cone of a ray through a lens of a width.
    fn thin_lens(&mut self, direction: [f64; 3], width: f64) -> Self::Cone;
    /// The cone of a ray of an orthographic camera.
    fn orthographic(&mut self) -> Self::Cone;
    /// A pixel's width on the image plane.
    fn pixel_width(&self) -> f64;
    /// The cone after a step.
    fn step(&mut self, cone: Self::Cone, step: Step) -> Self::Cone;
    /// Which of two a look-up takes.
    fn choose(&self, cones: [Self::Cone; 2], larger: Larger, alone: bool) -> Self::Cone;
}

pub use crate::reference::ray_cone::camera::Larger;

/// The operand of a step as registers take it, and whether its numbers were finite.
#[must_use]
pub fn rtl_step(step: Step) -> (rtl::Step, bool) {
    let mut finite = true;
    let mut take = |x: f64| {
        let (value, is_finite) = Dyadic::binary64(x.to_bits());
        finite &= is_finite;
        value
    };
    let out = match step {
        Step::Propagate(d) => rtl::Step::Propagate(take(d)),
        Step::Reflect(k) => rtl::Step::Reflect(take(k)),
        Step::Refract { curvature, outside, inside } => rtl::Step::Refract {
            curvature: take(curvature),
            outside: take(outside),
            inside: take(inside),
        },
        Step::Scatter(f) => rtl::Step::Scatter(take(f)),
    };
    (out, finite)
}

/// Names of the events of a cone's loads and stores that are set.
pub fn event_names(flags: Flags) -> impl Iterator<Item = &'static str> {
    let set = model::Event::ALL.iter().filter(move |event| flags.has_event(**event));
    set.map(|event| event.name())
}

fn operand(x: f64) -> Dyadic {
    Dyadic::binary64(x.to_bits()).0
}

/// Cones in the unit's registers.
#[derive(Clone, Debug)]
pub struct RtlCones<'a> {
    cfg: &'a Cfg,
    frame: rtl_camera::Frame,
    pixel_width: f64,
    dither: Dither,
    /// The events of the cones' stores.
    pub flags: Flags,
}

impl<'a> RtlCones<'a> {
    /// The cones of a camera's rays.
    #[must_use]
    pub fn new(cfg: &'a Cfg, camera: &Camera) -> Self {
        let vector = |v: DVec3| v.to_array().map(operand);
        let frame = rtl_camera::Frame {
            u: vector(camera.u),
            v: vector(camera.v),
            w: vector(camera.w),
            size: camera.size,
        };
        Self {
            cfg,
            frame,
            pixel_width: super::tex::value(rtl_camera::pixel_width(&frame)),
            dither: cfg.dither(0),
            flags: Flags::default(),
        }
    }

    /// Starts the random bits of a path's stores.
    pub fn ray(&mut self, number: u64) {
        self.dither = self.cfg.dither(number);
    }
}

impl Cones for RtlCones<'_> {
    type Cone = RtlCone;

    fn pinhole(&mut self, direction: [f64; 3]) -> RtlCone {
        let direction = direction.map(operand);
        let (dither, flags) = (&mut self.dither, &mut self.flags);
        rtl_camera::pinhole(self.cfg, &self.frame, &direction, dither, flags)
    }

    fn thin_lens(&mut self, direction: [f64; 3], width: f64) -> RtlCone {
        let direction = direction.map(operand);
        let (dither, flags) = (&mut self.dither, &mut self.flags);
        let width = operand(width);
        rtl_camera::thin_lens(self.cfg, &self.frame, &direction, width, dither, flags)
    }

    fn orthographic(&mut self) -> RtlCone {
        rtl_camera::orthographic(self.cfg, &self.frame, &mut self.dither, &mut self.flags)
    }

    fn pixel_width(&self) -> f64 {
        self.pixel_width
    }

    fn step(&mut self, cone: RtlCone, step: Step) -> RtlCone {
        let (step, _) = rtl_step(step);
        rtl::ray_cone(self.cfg, cone, step, &mut self.dither, &mut self.flags)
    }

    fn choose(&self, cones: [RtlCone; 2], larger: Larger, alone: bool) -> RtlCone {
        let larger = match larger {
            Larger::Width => rtl::Larger::Width,
            Larger::Angle => rtl::Larger::Angle,
        };
        rtl::choose(self.cfg, cones, larger, alone)
    }
}

/// Cones in doubles.
#[derive(Clone, Copy, Debug)]
pub struct FloatCones {
    frame: float_camera::Frame,
    rules: ConeRules,
    set_diffuse: SetDiffuse,
}

impl FloatCones {
    /// The cones of a camera's rays.
    #[must_use]
    pub fn new(camera: &Camera, rules: ConeRules, set_diffuse: SetDiffuse) -> Self {
        Self {
            frame: float_camera::Frame {
                u: camera.u.into(),
                v: camera.v.into(),
                w: camera.w.into(),
                size: camera.size,
            },
            rules,
            set_diffuse,
        }
    }
}

impl Cones for FloatCones {
    type Cone = float::Cone;

    fn pinhole(&mut self, direction: [f64; 3]) -> float::Cone {
        float_camera::pinhole(&self.frame, direction)
    }

    fn thin_lens(&mut self, direction: [f64; 3], width: f64) -> float::Cone {
        float_camera::thin_lens(&self.frame, direction, width)
    }

    fn orthographic(&mut self) -> float::Cone {
        float_camera::orthographic(&self.frame)
    }

    fn pixel_width(&self) -> f64 {
        float_camera::pixel_width(&self.frame)
    }

    fn step(&mut self, cone: float::Cone, step: Step) -> float::Cone {
        float::ray_cone(cone, step, self.rules, self.set_diffuse)
    }

    fn choose(&self, cones: [float::Cone; 2], larger: Larger, alone: bool) -> float::Cone {
        float_camera::choose(cones, larger, alone)
    }
}

/// A path's request with its cone.
#[derive(Clone, Copy, Debug)]
pub enum Asked<'a> {
    /// A texture.
    Look(&'a Look),
    /// The environment in a direction, with a weight.
    Sky([f64; 3], f64),
}

/// Carries a path's cones along and tells `each` the one of every look-up.
///
/// The two cones are those of the note: a thin lens's and a pinhole's, or a pinhole's or an orthographic camera's and
/// that of a lens of one pixel's width. At the first hit of the latter two the first cone counts alone. With
/// `cone.metric = "distance"` there is the pinhole's cone only, and nothing but distances changes it.
pub fn walk<C: Cones>(
    cones: &mut C,
    policy: &ConePolicy,
    lens: Lens,
    path: &Path,
    each: &mut dyn FnMut(Asked<'_>, C::Cone),
) {
    let d = path.direction;
    let distance = policy.metric == ConeMetric::Distance;
    let one_pixel = cones.pixel_width();
    let mut pair = match (distance, lens) {
        (true, _) => {
            let cone = cones.pinhole(d);
            [cone, cone]
        }
        (false, Lens::Pinhole) => [cones.pinhole(d), cones.thin_lens(d, one_pixel)],
        (false, Lens::Orthographic) => [cones.orthographic(), cones.thin_lens(d, one_pixel)],
        (false, Lens::Thin { width }) => [cones.thin_lens(d, width), cones.pinhole(d)],
    };
    let single = distance || policy.count < 2;
    let exception = !matches!(lens, Lens::Thin { .. });
    let mut bounced = false;
    for event in &path.events {
        let (asked, larger) = match event {
            Event::Step(step) => {
                let bounce = !matches!(step, Step::Propagate(_));
                bounced |= bounce;
                if bounce && distance {
                    continue;
                }
                pair[0] = cones.step(pair[0], *step);
                if !single {
                    pair[1] = cones.step(pair[1], *step);
                }
                continue;
            }
            Event::Look(look) => (Asked::Look(look), Larger::Width),
            Event::Sky { direction, weight } => (Asked::Sky(*direction, *weight), Larger::Angle),
        };
        let alone = single || (exception && !bounced);
        each(asked, cones.choose(pair, larger, alone));
    }
}

/// [`rtl::propagate_batch`] compiled for the vectors that `level` names; the same bits.
pub fn propagate_batch(
    level: Level,
    cfg: &Cfg,
    cones: &mut [RtlCone],
    distances: &[u32],
    first_ray: u64,
) {
    struct Batch<'a>(&'a Cfg, &'a mut [RtlCone], &'a [u32], u64);

    impl Task for Batch<'_> {
        type Output = ();

        #[inline(always)]
        fn run<S: Simd>(self, _: S) {
            rtl::propagate_batch(self.0, self.1, self.2, self.3);
        }
    }

    level.run(Batch(cfg, cones, distances, first_ray));
}
