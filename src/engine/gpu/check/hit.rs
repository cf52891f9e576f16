//! The checks of the HIT operation's stages.

use super::behind::{Behind, Footing};
use super::env::{CUBE_FACE, facing_case};
use super::hit_stage::{Walls, expected, registers};
use super::{Bounded, CHUNK, Case, Checker, StageChecks, Station, ports, rotation};
use crate::distance::Distance;
use crate::engine::gpu::Operands;
use crate::engine::gpu::hit::encode;
use crate::engine::hit_subject::HitSubject;
use crate::engine::{Progress, to_u64};
use crate::gpu::kernels::Kernel;
use crate::gpu::maps::Maps;
use crate::gpu::{Gpu, GpuError};
use crate::reference::{Distances, Flag, Tap};
use crate::settings::Settings;
use crate::stage::Stage;

/// D of a fragment, as the reference puts it.
#[derive(Default)]
struct Matrix([f64; 4]);

impl Tap for Matrix {
    fn put(&mut self, stage: Stage, register: &'static str, component: usize, value: f64) {
        if stage == Stage::Jacobian && register == "d" {
            self.0[component] = value;
        }
    }

    fn event(&mut self, _: &'static str) {}
}

/// Checks every register of every stage of the HIT operation over a subject's rays.
///
/// # Errors
///
/// What the driver reports.
pub fn check_hit(
    gpu: &Gpu,
    settings: &Settings,
    subject: &HitSubject,
    progress: Progress<'_>,
) -> Result<StageChecks, GpuError> {
    let behind = Behind::cube(gpu, settings, &subject.map)?;
    let maps = Maps::none(gpu)?.with_distance(gpu, &subject.distance)?;
    let policy = behind.policy.clone().with_distance(&subject.distance);
    let distances = Distances::new(&subject.distance);
    let rotation = rotation(settings);
    let walls = Walls {
        distances: &distances,
        half_edges: match &subject.distance {
            Distance::Box(half_edges) => Some(*half_edges),
            Distance::Cube(_) | Distance::Sphere(_) => None,
        },
        radius: match &subject.distance {
            Distance::Sphere(radius) => Some(*radius),
            Distance::Cube(_) | Distance::Box(_) => None,
        },
        rotation,
        settings,
    };
    let reference = subject.reference(settings);
    let registers = registers(settings.hit.iterations);
    let mut checker = Checker::new(gpu);
    for rays in subject.scene.rays.chunks(CHUNK) {
        let mut cases = Vec::with_capacity(rays.len());
        let mut faces = Vec::with_capacity(rays.len());
        let mut footings = Vec::with_capacity(rays.len());
        for ray in rays {
            let mut operands = Operands::new(Flag::HitNotFinite);
            encode(&mut operands, &ray.fragment);
            // The stage's own kernel takes no mark of a cone.
            operands.words.pop();
            cases.push(Case {
                pixel: ray.pixel,
                operands: operands.words,
                ..Case::default()
            });
            let mut d = Matrix::default();
            let found = reference.trace(&ray.fragment, &mut d);
            let (case, facing) = facing_case(ports(found.hit.l), &walls.rotation, ray.pixel);
            faces.push(case);
            if found.env.is_some() {
                let d: [Bounded; 4] = ports(d.0);
                footings.push(Footing {
                    pixel: ray.pixel,
                    face: facing.face,
                    centre: [facing.u, facing.v],
                    d: [[d[0], d[1]], [d[2], d[3]]],
                    rough: None,
                });
            }
        }
        let station = Station {
            kernel: Kernel::Stage(Stage::Hit),
            maps: &maps,
            policy: &policy,
            registers: &registers,
        };
        let fragments = std::cell::Cell::new(0);
        checker.stage(&station, &mut cases, &|case, results| {
            let ray = &rays[fragments.get()].fragment;
            fragments.set(fragments.get() + 1);
            let _ = Bounded::undecided();
            case.expected = expected(&walls, ray, &case.operands, results);
            case.undecided = Bounded::undecided() > 0;
        })?;
        let station = Station {
            kernel: Kernel::Stage(Stage::CubeFace),
            maps: &maps,
            policy: &policy,
            registers: CUBE_FACE,
        };
        checker.stage(&station, &mut faces, &|_, _| {})?;
        behind.check(&mut checker, &footings)?;
        checker.found.fragments += to_u64(rays.len());
        progress(to_u64(rays.len()));
    }
    Ok(checker.found)
}
