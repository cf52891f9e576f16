//! The checks of the TEX operation's stages.

use super::behind::{Behind, Footing};
use super::{
    Bounded, Case, Checker, Register, StageChecks, Station, bits, expect, float, handed, ports,
    recorded, whole,
};
use crate::base::num;
use crate::engine::Progress;
use crate::engine::cones::{Asked, Cones, FloatCones, walk};
use crate::engine::gpu::Operands;
use crate::engine::gpu::tex::{encode, step_words};
use crate::engine::tex_subject::TexSubject;
use crate::fragment::{Tangents, TexFragment};
use crate::gpu::kernels::Kernel;
use crate::gpu::maps::Maps;
use crate::gpu::{Gpu, GpuError};
use crate::planar::PlanarMap;
use crate::reference::Flag;
use crate::reference::ray_cone::{Cone, Step, after, camera::Larger};
use crate::reference::surface_footprint::surface_footprint;
use crate::scene::tex::path::Path;
use crate::settings::Settings;
use crate::stage::Stage;

const RAY_CONE: &[Register] = &[float("cone", 2)];
const SURFACE: &[Register] = &[
    float("d_unit", 3),
    float("n_unit", 3),
    float("cosine", 1),
    float("across", 3),
    float("along", 3),
    float("dp_dx", 3),
    float("dp_dy", 3),
    float("grad_s", 3),
    float("grad_t", 3),
    float("ddx", 2),
    float("ddy", 2),
    float("d", 4),
    whole("flags"),
];
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

/// Doubles of a request rounded to f32.
fn rounded(fragment: &TexFragment) -> TexFragment {
    let v = |x: [f64; 3]| ports(x).map(|c| c.value);
    TexFragment {
        d: v(fragment.d),
        n: v(fragment.n),
        tangents: match fragment.tangents {
            Tangents::Surface { dp_ds, dp_dt } => {
                Tangents::Surface { dp_ds: v(dp_ds), dp_dt: v(dp_dt) }
            }
            Tangents::Triangle { edges, st } => Tangents::Triangle {
                edges: edges.map(v),
                st: st.map(|st| ports(st).map(|c| c.value)),
            },
        },
        st: ports(fragment.st).map(|c| c.value),
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

fn cone_case(settings: &Settings, cone: Cone, step: Step, pixel: [u32; 2]) -> Case {
    let cone = ports([cone.angle.0, cone.width.0]);
    let ([kind, operands @ ..], exact) = (step_words(step), rounded_step(step));
    let (after, _, undecided) = recorded(|_, _| {
        after(cone[0], cone[1], exact, settings.policy.cone.rules, settings.policy.cone.set_diffuse)
    });
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the number of a step, 0 to 3"
    )]
    let kind = kind as u32;
    let mut words: Vec<u32> = bits(&cone).collect();
    words.push(kind);
    words.extend(operands.map(f32::to_bits));
    Case { pixel, operands: words, expected: after.map(expect).to_vec(), undecided }
}

/// One request at `surface_footprint`, and where it stands behind it.
fn surface_case(
    settings: &Settings,
    fragment: &TexFragment,
    width: f64,
    size: [usize; 2],
    pixel: [u32; 2],
) -> (Case, Footing) {
    let [width] = ports([width]);
    let exact = rounded(fragment);
    let (found, recorder, undecided) =
        recorded(|tap, flags| surface_footprint(&exact, width, size, &settings.policy, flags, tap));
    let mut operands = Operands::new(Flag::SurfNotFinite);
    operands.words.extend(bits(&[width]));
    encode(&mut operands, fragment, settings.policy.address.wrap());
    // The place on the texture belongs to `address`.
    let st = operands.words.split_off(operands.words.len() - 2);
    let centre = [0, 1].map(|i| {
        let st = f64::from(f32::from_bits(st[i]));
        Bounded::exact(f64::from(crate::gpu::policy::to_f32(2.0 * st - 1.0)))
    });
    let case =
        Case { pixel, operands: operands.words, expected: recorder.expected(SURFACE), undecided };
    let footing = Footing { pixel, face: 0, centre, d: found.d.map(handed), rough: None };
    (case, footing)
}

/// Requests to one texture and steps of cones, each with its pixel.
#[derive(Clone, Debug, Default)]
pub struct Requests {
    /// A ray at a surface and the width of its cone.
    pub surfaces: Vec<([u32; 2], TexFragment, f64)>,
    /// A cone before a step, and the step.
    pub steps: Vec<([u32; 2], Cone, Step)>,
}

impl Requests {
    /// Checks them against a texture.
    fn check(
        &self,
        checker: &mut Checker<'_>,
        settings: &Settings,
        (behind, size): (&Behind<'_>, [usize; 2]),
        maps: &Maps,
    ) -> Result<(), GpuError> {
        let station = |stage: Stage, registers| Station {
            kernel: Kernel::Stage(stage),
            maps,
            policy: &behind.policy,
            registers,
        };
        let steps = self.steps.iter();
        let mut cones: Vec<Case> =
            steps.map(|(pixel, cone, step)| cone_case(settings, *cone, *step, *pixel)).collect();
        checker.stage(&station(Stage::RayCone, RAY_CONE), &mut cones, &|_, _| {})?;
        let (mut surfaces, footings): (Vec<Case>, Vec<Footing>) = self
            .surfaces
            .iter()
            .map(|(pixel, fragment, width)| surface_case(settings, fragment, *width, size, *pixel))
            .unzip();
        let surface = station(Stage::SurfaceFootprint, SURFACE);
        checker.stage(&surface, &mut surfaces, &|_, _| {})?;
        behind.check(checker, &footings)?;
        checker.found.fragments += num::u64(footings.len());
        Ok(())
    }
}

/// Checks every register of every stage of the TEX operation over requests to one texture.
///
/// # Errors
///
/// What the driver reports.
pub fn check_requests(
    gpu: &Gpu,
    settings: &Settings,
    map: &PlanarMap,
    requests: &Requests,
) -> Result<StageChecks, GpuError> {
    let behind = Behind::planar(gpu, settings, map)?;
    let mut checker = Checker::new(gpu);
    let maps = Maps::none(gpu)?;
    requests.check(&mut checker, settings, (&behind, map.size()), &maps)?;
    Ok(checker.found)
}

/// Checks every register of every stage of the TEX operation over the first path of each pixel.
///
/// # Errors
///
/// What the driver reports.
pub fn check_tex(
    gpu: &Gpu,
    settings: &Settings,
    subject: &TexSubject,
    progress: Progress<'_>,
) -> Result<StageChecks, GpuError> {
    let scene = &subject.scene;
    let textures = scene.textures.iter();
    let behind = textures
        .map(|map| Ok((Behind::planar(gpu, settings, map)?, map.size())))
        .collect::<Result<Vec<_>, GpuError>>()?;
    let maps = Maps::none(gpu)?;
    let mut checker = Checker::new(gpu);
    let mut path = Path::default();
    for first in (0..scene.height).step_by(ROWS) {
        let last = (first + ROWS).min(scene.height);
        let mut requests: Vec<Requests> = vec![Requests::default(); behind.len()];
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
        for (requests, (behind, size)) in requests.iter().zip(&behind) {
            requests.check(&mut checker, settings, (behind, *size), &maps)?;
        }
        progress(num::u64((last - first) * scene.width));
    }
    Ok(checker.found)
}
