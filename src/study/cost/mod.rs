//! The cost of a unit: circuits by stage, gate equivalents, cycles, texels.
//!
//! The model assumes one circuit for every operation that a stage does on one fragment, pipelined, so that a fragment
//! can enter every `front_interval` cycles, a probe every `probe_interval` and a look-up of the search every
//! `look_up_interval`. Formulas and sources are in docs/cost.md. A part of the unit that is not counted has its line
//! in [`UNMODELLED`]; nothing is left out silently.

mod env;
pub mod gates;
mod knobs;
mod rays;
pub mod texels;

use rtl_model::Config;
use rtl_model::regs::Reg;

use super::measures::Measures;
use crate::operation::Operation;
use crate::stage::Stage;
use gates::{Cells, Parts};
use texels::Cache;

/// Parts of every unit that are not counted.
pub const UNMODELLED: &[&str] = &[
    "registers that only carry values from stage to stage of a pipeline",
    "control: state machines, valid bits, stalls, the lane masks of the search",
    "texel memory, its cache and the queue in front of it",
    "distance memory",
    "mip-level base addresses and the border rules at a cube's edges",
    "flags and their counters",
    "clock tree, test logic, wiring",
];

/// Knobs of the cost model.
#[derive(Clone, Debug, PartialEq)]
pub struct CostModel {
    /// Areas of cells.
    pub cells: Cells,
    /// Cycles from one fragment to the next in front of the probes.
    pub front_interval: f64,
    /// Cycles a trilinear probe.
    pub probe_interval: f64,
    /// Cycles a look-up of the search takes its circuit: no other ray of the same loop can use it meanwhile.
    pub look_up_interval: f64,
    /// The texel cache.
    pub cache: Cache,
}

impl Default for CostModel {
    fn default() -> Self {
        Self {
            cells: Cells::default(),
            front_interval: 1.0,
            probe_interval: 1.0,
            look_up_interval: 1.0,
            cache: Cache::default(),
        }
    }
}

/// The circuits of a unit, stage by stage.
#[derive(Clone, Debug, PartialEq)]
pub struct Sheet {
    /// Stages that are built.
    pub stages: Vec<(Stage, Parts)>,
    /// What is not counted.
    pub unmodelled: Vec<&'static str>,
    operation: Operation,
}

impl CostModel {
    /// The circuits that an operation needs.
    #[must_use]
    pub fn sheet(&self, c: &Config, operation: Operation) -> Sheet {
        let mut stages = Vec::new();
        let mut unmodelled = UNMODELLED.to_vec();
        match operation {
            Operation::Env(needs) => {
                if needs.frame() {
                    stages.push((Stage::LocalFrame, env::local_frame(c)));
                }
                if needs.bump {
                    stages.push((Stage::Bump, env::bump(c)));
                }
                stages.push((Stage::Reflect, env::reflect(c, needs.bump)));
                stages.push((Stage::CubeFace, env::cube_face(c, Reg::ReflectVr)));
                stages.push((Stage::Jacobian, env::jacobian(c, needs.bump)));
                if needs.rough {
                    stages.push((Stage::Roughness, env::roughness(c)));
                }
                unmodelled.push("the bump map's and the roughness pyramid's own filters");
            }
            Operation::Hit => {
                stages.push((Stage::RayCone, rays::ray_cone(c, false, 1)));
                stages.push((Stage::Hit, rays::hit(c)));
                stages.push((Stage::CubeFace, env::cube_face(c, Reg::HitTo)));
                stages.push((Stage::Jacobian, rays::hit_footprint(c)));
                unmodelled.push("curvatures, and whatever makes rays");
            }
            Operation::Tex => {
                stages.push((Stage::RayCone, rays::ray_cone(c, true, c.policy.cone.count)));
                stages.push((Stage::SurfaceFootprint, rays::surface_footprint(c)));
                // The environment that paths leave for.
                stages.push((Stage::CubeFace, env::cube_face(c, Reg::HitTo)));
                stages.push((Stage::Jacobian, rays::hit_footprint(c)));
                unmodelled
                    .push("the camera's first cone: an inverse length and two products a pixel");
                unmodelled.push("curvatures, and whatever makes rays");
            }
        }
        let (d, rough, planar) = match operation {
            Operation::Env(needs) => (Reg::JacD, needs.rough, false),
            Operation::Hit => (Reg::JacD, false, false),
            Operation::Tex => (Reg::SurfJac, false, true),
        };
        stages.push((Stage::Covariance, env::covariance(c, d, rough)));
        stages.push((Stage::Eigen, env::eigen(c)));
        stages.push((Stage::Footprint, env::footprint(c)));
        let mut address = env::address(c, planar);
        if planar {
            // One address unit that does both kinds of texture.
            address.merge(&env::address(c, false));
        }
        stages.push((Stage::Address, address));
        stages.push((Stage::Filter, env::filter(c)));
        stages.sort_by_key(|(stage, _)| *stage);
        Sheet { stages, unmodelled, operation }
    }

    /// Cycles a fragment takes in the long run: the slowest of what works side by side.
    #[must_use]
    pub fn cycles(&self, operation: Operation, [probes, look_ups]: [f64; 2]) -> f64 {
        let search = match operation {
            // Two look-ups before the loop: dist(R) and dist(x).
            Operation::Hit => (look_ups + 2.0) * self.look_up_interval,
            Operation::Env(_) | Operation::Tex => 0.0,
        };
        self.front_interval.max(probes * self.probe_interval).max(search)
    }
}

impl Sheet {
    /// All stages together.
    #[must_use]
    pub fn total(&self) -> Parts {
        let mut total = Parts::default();
        self.stages.iter().for_each(|(_, parts)| total.merge(parts));
        total
    }

    /// Puts the figures of the whole unit.
    #[expect(clippy::cast_precision_loss, reason = "counts of bits")]
    pub(super) fn put(&self, model: &CostModel, loops: [f64; 2], measures: &mut Measures) {
        let total = self.total();
        measures.put("cycles_per_fragment", model.cycles(self.operation, loops));
        measures.put("gates", total.gates(&model.cells).round());
        measures.put("logic_gates", total.logic(&model.cells).round());
        measures.put("multiplier_bits", total.multiplier_bits() as f64);
        measures.put("rom_bits", total.rom_bits as f64);
        measures.put("register_bits", total.register_bits as f64);
        measures.put("unmodelled", self.unmodelled.len() as f64);
    }
}
