//! Benches of HIT: the search alone, and the whole operation to the colour.

use rtl_model::Config;
use rtl_model::regs::Reg;

use super::bench::{Bench, Build, Extra, Model, put_words, record};
use super::field::{Field, Shape, beside, components, registers};
use super::memory;
use super::stimuli::Stimulus;
use super::subject::Subject;
use crate::base::num;
use crate::engine::hit::{HitRtl, words};
use crate::engine::probe::RtlProbe;
use crate::error::InputError;
use crate::fragment::HitFragment;
use crate::policy::HitStatus;
use crate::stage::Stage;
use crate::unit::UnitSpec;

/// A ray through the search and, with a cone, through the stages behind it.
pub struct HitBench {
    engine: HitRtl,
    shape: Shape,
    probe: RtlProbe,
    whole: bool,
}

/// Registers that a ray writes once, or of which a trace shows the last value alone.
const ONCE: [Reg; 16] = [
    Reg::HitInvRadius,
    Reg::HitInvSpan,
    Reg::HitQuotient,
    Reg::HitX,
    Reg::HitDirection,
    Reg::HitInvNorm,
    Reg::HitR,
    Reg::HitTo,
    Reg::HitInvAcross,
    Reg::HitInvNormal,
    Reg::HitNormal,
    Reg::HitCosine,
    Reg::HitInvCosine,
    Reg::HitAlong,
    Reg::HitSlope,
    Reg::HitTangent,
];

/// Numbers of a register of `hit`: one set a ray, or one for R, one for x and one for each look-up of the loop.
fn searched(config: &Config, reg: Reg) -> usize {
    let each = reg.info().components;
    if ONCE.contains(&reg) { each } else { each * (2 + num::usize(config.policy.hit.iterations)) }
}

/// Registers that the footprint at the hit writes of other stages, and those of the back end.
fn others(config: &Config, stage: Stage, out: &mut Vec<Field>) {
    let mut regs = Vec::new();
    for reg in registers(stage) {
        let turned = reg == Reg::FaceRotated && config.rotation.is_none();
        let written = [Reg::JacDvr, Reg::JacNumerator, Reg::JacD].contains(&reg);
        if turned || (stage == Stage::Jacobian && !written) {
            continue;
        }
        regs.push(reg);
        Field::written(config, stage, reg, components(config, stage, reg), out);
    }
    out.push(Field::flags(stage, &regs));
}

/// Fields of the stages behind an operation's own, as HIT and TEX have them.
pub(super) fn behind(config: &Config, own: Stage, stages: &[Stage], out: &mut Vec<Field>) {
    for stage in stages.iter().filter(|stage| **stage != own) {
        let first = out.len();
        others(config, *stage, out);
        // A ray without a cone takes no probe.
        out.extend(beside(config, *stage, 0));
        for field in &mut out[first..] {
            field.name = format!("{}.{}", stage.name(), field.name);
        }
    }
}

impl HitBench {
    /// The bench of the stage, or of the operation.
    pub fn new(spec: &UnitSpec, subject: Subject, build: Build) -> Result<Self, InputError> {
        let map = memory::cube(build.size);
        let size = map.size();
        let engine = HitRtl::new(spec, &memory::room(build.size), Some(&map), size)?;
        let config = &engine.config;
        let (stage, whole) = (Stage::Hit, subject == Subject::Hit);
        let mut inputs = vec![
            Field::words(stage, "x", 3, "where the ray starts"),
            Field::words(stage, "r", 3, "its direction, of any length"),
        ];
        if whole {
            inputs.push(Field::words(stage, "cone", 2, "full angle and full width of its cone"));
            inputs.push(Field::count(stage, "has_cone", [0, 1], "whether it has a cone"));
        }
        let mut outputs = Vec::new();
        let mut regs = Vec::new();
        for reg in registers(stage) {
            let at_hit = reg.index() >= Reg::HitInvAcross.index();
            if at_hit && !whole {
                continue;
            }
            regs.push(reg);
            Field::written(config, stage, reg, searched(config, reg), &mut outputs);
        }
        let names = HitStatus::ALL.iter().map(|s| s.name()).collect();
        outputs.push(Field::choice(stage, "status", names, "how the search ended"));
        let most = i64::from(config.policy.hit.iterations);
        outputs.push(Field::count(stage, "iterations", [0, most], "look-ups in the loop"));
        outputs.push(Field::flags(stage, &regs));
        if whole {
            for field in &mut outputs {
                field.name = format!("hit.{}", field.name);
            }
            behind(config, stage, &subject.stages(), &mut outputs);
        }
        Ok(Self { engine, shape: Shape { inputs, outputs }, probe: RtlProbe::default(), whole })
    }
}

impl Bench for HitBench {
    fn shape(&self) -> &Shape {
        &self.shape
    }

    fn run(&mut self, input: &[i64], output: &mut [i64]) {
        let word = |k: usize| input.get(k).map_or(0, |x| x.cast_unsigned());
        let number = |k: usize| f64::from_bits(word(k));
        let ray = HitFragment {
            x: [number(0), number(1), number(2)],
            r: [number(3), number(4), number(5)],
            cone: (self.whole && word(8) == 1).then(|| [number(6), number(7)]),
        };
        self.probe.clear();
        let (block, out) = self.engine.lanes::<1, _>(&[words(&ray)], &mut self.probe);
        let place = |status| HitStatus::ALL.iter().position(|s| *s == status);
        let extra = Extra {
            face: num::i64(block.env.face.face[0]),
            count: out.probes[0],
            status: place(block.front.hit.status[0]).map_or(0, num::i64),
            iterations: block.front.hit.iterations[0].into(),
        };
        record(&self.shape, &self.probe, out.flags[0], extra, output);
    }
}

impl Model for HitBench {
    fn probe(&self) -> &RtlProbe {
        &self.probe
    }

    fn config(&self) -> &Config {
        &self.engine.config
    }

    fn drive(&mut self, stimulus: &Stimulus, input: &mut [i64]) {
        let Stimulus::Ray(ray) = stimulus else { return };
        let words = words(ray);
        let cone = words.cone.unwrap_or([0; 2]);
        let has_cone = u64::from(words.cone.is_some());
        let all = words.x.into_iter().chain(words.r).chain(cone);
        put_words(all.chain([has_cone]), input);
    }
}
