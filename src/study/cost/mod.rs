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
use gates::{Cells, Circuit, Parts};
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
        let mut unmodelled = UNMODELLED.to_vec();
        unmodelled.extend_from_slice(match operation {
            Operation::Env(_) => &["the bump map's and the roughness pyramid's own filters"],
            Operation::Hit => &["curvatures, and whatever makes rays"],
            Operation::Tex => &[
                "the camera's first cone: an inverse length and two products a pixel",
                "curvatures, and whatever makes rays",
            ],
        });
        let stage = |stage| {
            let mut circuit = Circuit::new(c);
            draw(&mut circuit, stage, operation);
            (stage, circuit.parts)
        };
        let stages = operation.stages().into_iter().map(stage).collect();
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

/// The circuits of a stage as an operation needs them.
fn draw(p: &mut Circuit<'_>, stage: Stage, operation: Operation) {
    let reflects = operation.runs(Stage::Reflect);
    let (bumped, rough) = (operation.runs(Stage::Bump), operation.runs(Stage::Roughness));
    let planar = operation.runs(Stage::SurfaceFootprint);
    match stage {
        Stage::LocalFrame => env::local_frame(p),
        Stage::Bump => env::bump(p),
        Stage::Reflect => env::reflect(p, bumped),
        Stage::CubeFace => env::cube_face(p, if reflects { Reg::ReflectVr } else { Reg::HitTo }),
        Stage::Jacobian if reflects => env::jacobian(p, bumped),
        Stage::Jacobian => rays::hit_footprint(p),
        Stage::Roughness => env::roughness(p),
        // Paths over textures bend and scatter rays.
        Stage::RayCone if planar => rays::ray_cone(p, true, p.config.policy.cone.count),
        Stage::RayCone => rays::ray_cone(p, false, 1),
        Stage::Hit => rays::hit(p),
        Stage::SurfaceFootprint => rays::surface_footprint(p),
        Stage::Covariance => {
            env::covariance(p, if planar { Reg::SurfJac } else { Reg::JacD }, rough);
        }
        Stage::Eigen => env::eigen(p),
        Stage::Footprint => env::footprint(p),
        Stage::Address => {
            // Paths leave for an environment: one address unit does both kinds of texture.
            if planar {
                env::address(p, true);
            }
            env::address(p, false);
        }
        Stage::Filter => env::filter(p),
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
