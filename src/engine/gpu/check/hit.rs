//! The checks of the HIT operation's stages.

use super::back_end::BackEnd;
use super::cases::{Cases, ports};
use super::env::{facing, rotation};
use super::hit_stage::{Walls, expected};
use super::{CHUNK, Case, Checker, StageChecks};
use crate::base::num;
use crate::cube::CubeMap;
use crate::distance::Distance;
use crate::engine::Progress;
use crate::engine::gpu::Operands;
use crate::engine::gpu::hit::encode;
use crate::engine::hit::HitF64;
use crate::fragment::HitFragment;
use crate::gpu::kernels::Kernel;
use crate::gpu::{Gpu, GpuError};
use crate::reference::{Distances, Flag, Tap};
use crate::settings::Settings;
use crate::stage::Stage;

/// D of a fragment, as the reference puts it.
#[derive(Default)]
struct Matrix([[f64; 2]; 2]);

impl Tap for Matrix {
    fn put(&mut self, stage: Stage, register: &'static str, component: usize, value: f64) {
        if stage == Stage::Jacobian && register == "d" {
            self.0.as_flattened_mut()[component] = value;
        }
    }

    fn event(&mut self, _: &'static str) {}
}

/// Checks every register of every stage of the HIT operation over rays, each with its pixel.
pub fn check_hit(
    gpu: &Gpu,
    settings: &Settings,
    (map, distance): (&CubeMap, &Distance),
    rays: &[([u32; 2], HitFragment)],
    progress: Progress<'_>,
) -> Result<StageChecks, GpuError> {
    let back = BackEnd::cube(gpu, settings, map)?.with_distance(distance)?;
    let distances = Distances::new(distance);
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
        rotation: rotation(settings),
        settings,
    };
    let reference = HitF64::new(settings, distance, Some(map), map.size());
    let kernel = Kernel::Stage(Stage::Hit);
    let registers = kernel.registers(num::usize(settings.policy.hit.iterations) + 1);
    let mut checker = Checker::default();
    for rays in rays.chunks(CHUNK) {
        let mut searches = Vec::with_capacity(rays.len());
        let mut cases = Cases::default();
        let mut inputs = Vec::with_capacity(rays.len());
        for (pixel, ray) in rays {
            let mut operands = Operands::new(Flag::HitNotFinite);
            encode(&mut operands, ray);
            // The stage's own kernel takes no mark of a cone.
            operands.words.pop();
            searches.push(Case { pixel: *pixel, operands: operands.words, ..Case::default() });
            let mut d = Matrix::default();
            let found = reference.trace(ray, &mut d);
            cases.pixel = *pixel;
            let facing = facing(&mut cases, ports(found.hit.l), &walls.rotation);
            if found.env.is_some() {
                let centre = [facing.u, facing.v];
                inputs.push(back.fragment(&mut cases, facing.face, centre, &d.0.map(ports), None));
            }
        }
        let of_search = |index: usize, operands: &[u32], results: &[u32]| {
            expected(&walls, &rays[index].1, operands, results)
        };
        checker.stage(&back, (kernel, &registers), searches, Some(&of_search))?;
        back.check(&mut checker, cases, &inputs)?;
        checker.found.fragments += num::u64(rays.len());
        progress(num::u64(rays.len()));
    }
    Ok(checker.found)
}
