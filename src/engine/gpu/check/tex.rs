//! The checks of the TEX operation's stages.

use super::back_end::{BackEnd, FilterInput};
use super::cases::{Cases, Operand as _, ports};
use super::{Bounded, Checker, Requests, StageChecks};
use crate::base::num;
use crate::engine::Progress;
use crate::engine::TexJob;
use crate::engine::cones::{Asked, Cones, FloatCones, walk};
use crate::engine::gpu::Operands;
use crate::engine::gpu::tex::{encode, step_words};
use crate::fragment::TexFragment;
use crate::gpu::policy::to_f32;
use crate::gpu::{Gpu, GpuError};
use crate::planar::PlanarMap;
use crate::reference::Flag;
use crate::reference::ray_cone::{Cone, Step, after, camera::Larger};
use crate::reference::surface_footprint::surface_footprint;
use crate::scene::tex::path::Path;
use crate::settings::Settings;
use crate::stage::Stage;

/// Requests whose operands are put together before the kernels run.
const ROWS: usize = 32;

/// Cones in doubles that remember every step.
struct Remembering<'a> {
    cones: FloatCones,
    steps: &'a mut Vec<(Cone, Step)>,
}

impl Cones for Remembering<'_> {
    type Cone = Cone;

    fn pinhole(&mut self, direction: [f64; 3]) -> Cone {
        self.cones.pinhole(direction)
    }

    fn thin_lens(&mut self, direction: [f64; 3], width: f64) -> Cone {
        self.cones.thin_lens(direction, width)
    }

    fn orthographic(&mut self) -> Cone {
        self.cones.orthographic()
    }

    fn pixel_width(&self) -> f64 {
        self.cones.pixel_width()
    }

    fn step(&mut self, cone: Cone, step: Step) -> Cone {
        self.steps.push((cone, step));
        self.cones.step(cone, step)
    }

    fn choose(&self, cones: [Cone; 2], larger: Larger, alone: bool) -> Cone {
        self.cones.choose(cones, larger, alone)
    }
}

/// A step with its operands rounded to f32.
fn rounded_step(step: Step) -> Step {
    let [_, a, b, c] = step_words(step).map(f64::from);
    match step {
        Step::Propagate(_) => Step::Propagate(a),
        Step::Reflect(_) => Step::Reflect(a),
        Step::Refract { .. } => Step::Refract { curvature: a, outside: b, inside: c },
        Step::Scatter(_) => Step::Scatter(a),
    }
}

/// The case of a step.
fn cone(cases: &mut Cases, settings: &Settings, cone: Cone, step: Step) {
    let cone = ports([cone.angle.0, cone.width.0]);
    let [kind, operands @ ..] = step_words(step);
    let exact = rounded_step(step);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the number of a step, 0 to 3"
    )]
    let kind = kind as u32;
    let (rules, diffuse) = (settings.policy.cone.rules, settings.policy.cone.set_diffuse);
    cases.stage(Stage::RayCone, (cone, kind, operands.map(f32::to_bits)), |tap, _| {
        let after = after(cone[0], cone[1], exact, rules, diffuse);
        for (c, x) in after.iter().enumerate() {
            tap.put.push(("cone", c, x.value, x.error));
        }
        after
    });
}

/// The cases of one request.
fn surface(
    cases: &mut Cases,
    back: &BackEnd<'_>,
    fragment: &TexFragment,
    width: f64,
) -> FilterInput {
    let settings = &back.settings;
    let [width] = ports([width]);
    let mut exact = *fragment;
    exact.for_each(|x| *x = f64::from(to_f32(*x)));
    let mut operands = Operands::new(Flag::SurfNotFinite);
    width.put(&mut operands.words);
    encode(&mut operands, fragment, settings.policy.address.wrap());
    // The place on the texture belongs to `address`.
    let st = operands.words.split_off(operands.words.len() - 2);
    let centre = [0, 1].map(|i| {
        let st = f64::from(f32::from_bits(st[i]));
        Bounded::exact(2.0 * st - 1.0).rounded()
    });
    let d = cases.stage(Stage::SurfaceFootprint, operands.words.as_slice(), |tap, flags| {
        surface_footprint(&exact, width, back.size, &settings.policy, flags, tap).d
    });
    back.fragment(cases, 0, centre, &d, None)
}

impl Requests {
    /// Checks them against a texture.
    fn check(&self, checker: &mut Checker, back: &BackEnd<'_>) -> Result<(), GpuError> {
        let mut cases = Cases::default();
        for (pixel, before, step) in &self.steps {
            cases.pixel = *pixel;
            cone(&mut cases, &back.settings, *before, *step);
        }
        let mut inputs = Vec::with_capacity(self.surfaces.len());
        for (pixel, fragment, width) in &self.surfaces {
            cases.pixel = *pixel;
            inputs.push(surface(&mut cases, back, fragment, *width));
        }
        back.check(checker, cases, &inputs)?;
        checker.found.fragments += num::u64(inputs.len());
        Ok(())
    }
}

/// Checks every register of every stage of the TEX operation over requests to one texture.
pub fn check_requests(
    gpu: &Gpu,
    settings: &Settings,
    map: &PlanarMap,
    requests: &Requests,
) -> Result<StageChecks, GpuError> {
    let mut checker = Checker::default();
    requests.check(&mut checker, &BackEnd::planar(gpu, settings, map)?)?;
    Ok(checker.found)
}

/// Checks every register of every stage of the TEX operation over the first path of each pixel.
pub fn check_tex(
    gpu: &Gpu,
    settings: &Settings,
    subject: &TexJob,
    progress: Progress<'_>,
) -> Result<StageChecks, GpuError> {
    let scene = &subject.scene;
    let textures = scene.textures.iter();
    let backs = textures
        .map(|map| BackEnd::planar(gpu, settings, map))
        .collect::<Result<Vec<_>, GpuError>>()?;
    let mut checker = Checker::default();
    let mut path = Path::default();
    for first in (0..scene.height).step_by(ROWS) {
        let last = (first + ROWS).min(scene.height);
        let mut requests: Vec<Requests> = vec![Requests::default(); backs.len()];
        for (y, x) in (first..last).flat_map(|y| (0..scene.width).map(move |x| (y, x))) {
            let pixel = [x, y].map(num::u32);
            scene.path([x, y].map(|n| n as f64 + 0.5), [0, scene.samples], &mut path);
            let mut steps = Vec::new();
            let mut remembering = Remembering {
                cones: FloatCones::new(
                    &scene.camera,
                    settings.policy.cone.rules,
                    settings.policy.cone.set_diffuse,
                ),
                steps: &mut steps,
            };
            let lens = scene.camera.lens;
            walk(&mut remembering, &settings.policy.cone, lens, &path, &mut |asked, cone| {
                if let Asked::Look(look) = asked {
                    let request = (pixel, look.fragment, cone.width.0);
                    requests[look.texture].surfaces.push(request);
                }
            });
            if let Some(first) = requests.first_mut() {
                first.steps.extend(steps.into_iter().map(|(cone, step)| (pixel, cone, step)));
            }
        }
        for (requests, back) in requests.iter().zip(&backs) {
            requests.check(&mut checker, back)?;
        }
        progress(num::u64((last - first) * scene.width));
    }
    Ok(checker.found)
}
