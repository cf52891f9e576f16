//! The checks of the HIT operation's stages.

use super::behind::{Behind, Footing};
use super::env::{CUBE_FACE, facing_case};
use super::hit_stage::{Walls, expected, registers};
use super::{Bounded, CHUNK, Case, Checker, StageChecks, Station, ports, rotation};
use crate::base::num;
use crate::cube::CubeMap;
use crate::distance::Distance;
use crate::engine::Progress;
use crate::engine::gpu::Operands;
use crate::engine::gpu::hit::encode;
use crate::engine::hit::HitF64;
use crate::fragment::HitFragment;
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

/// Checks every register of every stage of the HIT operation over rays, each with its pixel.
///
/// # Errors
///
/// What the driver reports.
pub fn check_hit(
    gpu: &Gpu,
    settings: &Settings,
    (map, distance): (&CubeMap, &Distance),
    rays: &[([u32; 2], HitFragment)],
    progress: Progress<'_>,
) -> Result<StageChecks, GpuError> {
    let behind = Behind::cube(gpu, settings, map)?;
    let maps = Maps::none(gpu)?.with_distance(gpu, distance)?;
    let policy = behind.policy.clone().with_distance(distance);
    let distances = Distances::new(distance);
    let rotation = rotation(settings);
    let walls = Walls {
        distances: &distances,
        half_edges: match distance {
            Distance::Box(half_edges) => Some(*half_edges),
            Distance::Cube(_) | Distance::Sphere(_) => None,
        },
        radius: match distance {
            Distance::Sphere(radius) => Some(*radius),
            Distance::Cube(_) | Distance::Box(_) => None,
        },
        rotation,
        settings,
    };
    let reference = HitF64::new(settings, distance, Some(map), map.size());
    let registers = registers(settings.policy.hit.iterations);
    let mut checker = Checker::new(gpu);
    for rays in rays.chunks(CHUNK) {
        let mut cases = Vec::with_capacity(rays.len());
        let mut faces = Vec::with_capacity(rays.len());
        let mut footings = Vec::with_capacity(rays.len());
        for (pixel, ray) in rays {
            let mut operands = Operands::new(Flag::HitNotFinite);
            encode(&mut operands, ray);
            // The stage's own kernel takes no mark of a cone.
            operands.words.pop();
            cases.push(Case { pixel: *pixel, operands: operands.words, ..Case::default() });
            let mut d = Matrix::default();
            let found = reference.trace(ray, &mut d);
            let (case, facing) = facing_case(ports(found.hit.l), &walls.rotation, *pixel);
            faces.push(case);
            if found.env.is_some() {
                let d: [Bounded; 4] = ports(d.0);
                footings.push(Footing {
                    pixel: *pixel,
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
            let (_, ray) = &rays[fragments.get()];
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
        checker.found.fragments += num::u64(rays.len());
        progress(num::u64(rays.len()));
    }
    Ok(checker.found)
}
