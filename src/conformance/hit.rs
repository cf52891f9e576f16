//! Harnesses of HIT: the search alone, and the whole operation to the colour.

use rtl_model::Config;
use rtl_model::fx::Flags;
use rtl_model::regs::Reg;

use super::field::{Field, Shape, registers};
use super::harness::{Build, Circuit, Extra, Harness, Numbers, put_words};
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

/// The harness of the stage, or of the operation.
pub(super) fn harness(
    spec: &UnitSpec,
    subject: Subject,
    build: Build,
) -> Result<Harness, InputError> {
    let map = memory::cube(build.size);
    let engine = HitRtl::new(spec, &memory::room(build.size), Some(&map), map.size())?;
    let config = &spec.config;
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
        Field::behind(config, stage, &subject.stages(), &mut outputs);
    }
    Ok(Harness::new(Shape { inputs, outputs }, config, engine))
}

/// A case's ray; of the search alone without a cone.
pub(super) fn ray(input: &[i64]) -> HitFragment {
    let mut numbers = Numbers::new(input);
    let (x, r, cone) = (numbers.reals(), numbers.reals(), numbers.reals());
    HitFragment { x, r, cone: (numbers.next() == 1).then_some(cone) }
}

impl Circuit for HitRtl {
    fn run(&mut self, input: &[i64], probe: &mut RtlProbe) -> (Flags, Extra) {
        let (block, out) = self.lanes::<1, _>(&[words(&ray(input))], probe);
        let place = |status| HitStatus::ALL.iter().position(|s| *s == status);
        let extra = Extra {
            face: block.env.face.face[0],
            count: out.probes[0],
            status: place(block.front.hit.status[0]).map_or(0, num::i64),
            iterations: block.front.hit.iterations[0].into(),
            ..Extra::default()
        };
        (out.flags[0], extra)
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
