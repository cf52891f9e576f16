//! Harnesses of the ENV operation: one stage behind its wires, and the whole from the ports to the colour.

use rtl_model::fx::Flags;
use rtl_model::stages::Roms;
use rtl_model::unit::{Needs, Results, State, Wire, Words};
use rtl_model::{Config, NoTap, Tap, Texture, Unit};

use super::field::{Field, Shape, beside, components, registers};
use super::harness::{Build, Circuit, Extra, Harness, Numbers, put_words};
use super::memory;
use super::stimuli::Stimulus;
use super::subject::Subject;
use crate::engine::encode;
use crate::engine::probe::RtlProbe;
use crate::error::InputError;
use crate::fragment::Fragment;
use crate::stage::Stage;
use crate::unit::{UnitSpec, refused};

/// The unit with its texel memory and the state of one fragment.
struct Lane {
    unit: Unit,
    config: Config,
    texture: Texture,
    needs: Needs,
    state: State<1>,
    out: Results<1>,
}

impl Lane {
    fn new(spec: &UnitSpec, build: Build) -> Result<Self, InputError> {
        let needs = Needs { bump: build.bump, rough: build.rough };
        let map = memory::cube(build.size);
        Ok(Self {
            unit: Unit::new(&spec.config, needs, build.size).map_err(refused)?,
            config: spec.config.clone(),
            texture: encode::texture(&spec.config, &map).map_err(refused)?,
            needs,
            state: State::default(),
            out: Results::default(),
        })
    }

    /// Every stage, up to one of them or all, on words from the ports; sticky flags of all that ran.
    fn run(&mut self, words: &Words, before: Option<Stage>, tap: &mut impl Tap) -> Flags {
        let texture = Some(&self.texture);
        self.unit.one(words, before, texture, &mut self.state, &mut self.out, tap)
    }

    fn alone(&mut self, stage: Stage, tap: &mut RtlProbe) -> Flags {
        let texture = Some(&self.texture);
        self.unit.alone(stage, &mut self.state, texture, &mut self.out, tap)
    }

    fn extra(&mut self) -> Extra {
        let mut face = [0];
        Wire::Face.get(&mut self.state, &mut face);
        Extra { face: face[0], count: self.state.line.count[0], ..Extra::default() }
    }

    /// Fields of the registers that a stage writes in this unit. Which it writes depends on the configuration alone: an
    /// ordinary fragment shows it.
    fn outputs(&self, stage: Stage, seen: &RtlProbe, out: &mut Vec<Field>) {
        let mut regs = Vec::new();
        for reg in registers(stage) {
            if !seen.get(reg).is_empty() {
                regs.push(reg);
                let components = components(&self.config, stage, reg);
                Field::written(&self.config, stage, reg, components, out);
            }
        }
        out.extend(beside(&self.config, stage, 1));
        out.push(Field::flags(stage, &regs));
    }
}

/// A fragment in which every stage has something to do.
fn ordinary() -> Words {
    let bits = |v: [f64; 3]| v.map(f64::to_bits);
    Words {
        v: bits([0.3, 0.2, 1.0]),
        n: bits([0.1, 0.9, 0.6]),
        dv: [bits([0.01, 0.0, 0.002]), bits([0.0, 0.01, 0.001])],
        dn: [bits([0.02, 0.01, 0.0]), bits([0.0, 0.01, 0.03])],
        h: bits([1.0, 0.2, 0.1]),
        b: [0.2, 0.1].map(f64::to_bits),
        d: bits([0.01, 0.002, 0.02]),
    }
}

/// One stage of ENV alone.
struct EnvStage {
    lane: Lane,
    stage: Stage,
    wires: Vec<Wire>,
}

/// The harness of a stage.
pub(super) fn stage(spec: &UnitSpec, stage: Stage, build: Build) -> Result<Harness, InputError> {
    let mut lane = Lane::new(spec, build)?;
    let missing = || {
        InputError::new(
            stage.name(),
            "a unit with that stage behind wires of its own",
            "one that is built without it",
            "leave footprint.axis = longer-derivative, or a unit without bump and roughness, to `unit`",
        )
    };
    let wires = lane.unit.wires(&lane.config, stage).concat();
    if wires.is_empty() {
        return Err(missing());
    }
    lane.run(&ordinary(), Some(stage), &mut NoTap);
    let mut seen = RtlProbe::default();
    lane.alone(stage, &mut seen);
    let inputs = wires.iter().map(|wire| Field::wire(&lane.config, stage, *wire)).collect();
    let mut outputs = Vec::new();
    lane.outputs(stage, &seen, &mut outputs);
    let circuit = EnvStage { lane, stage, wires };
    Ok(Harness::new(Shape { inputs, outputs }, &spec.config, circuit))
}

impl Circuit for EnvStage {
    fn run(&mut self, input: &[i64], probe: &mut RtlProbe) -> (Flags, Extra) {
        let (lane, mut numbers) = (&mut self.lane, input);
        for wire in &self.wires {
            if let Some(here) = numbers.split_off(..wire.components()) {
                wire.set(&mut lane.state, here);
            }
        }
        for wire in &self.wires {
            wire.put(&lane.config, &mut lane.state, probe);
        }
        (lane.alone(self.stage, probe), lane.extra())
    }

    fn drive(&mut self, stimulus: &Stimulus, mut input: &mut [i64]) {
        let Stimulus::Fragment(words) = stimulus else {
            return;
        };
        self.lane.run(words, Some(self.stage), &mut NoTap);
        for wire in &self.wires {
            if let Some(here) = input.split_off_mut(..wire.components()) {
                wire.get(&mut self.lane.state, here);
            }
        }
    }
}

/// The harness of the whole operation.
pub(super) fn whole(spec: &UnitSpec, build: Build) -> Result<Harness, InputError> {
    let mut lane = Lane::new(spec, build)?;
    let mut seen = RtlProbe::default();
    lane.run(&ordinary(), None, &mut seen);
    let word = Field::words;
    let mut inputs = vec![
        word(Stage::Reflect, "v", 3, "direction to the eye"),
        word(Stage::Reflect, "n", 3, "interpolated normal"),
        word(Stage::Jacobian, "dv_dx", 3, "∂v per pixel in x"),
        word(Stage::Jacobian, "dv_dy", 3, "∂v per pixel in y"),
        word(Stage::Jacobian, "dn_dx", 3, "∂n per pixel in x"),
        word(Stage::Jacobian, "dn_dy", 3, "∂n per pixel in y"),
    ];
    if lane.needs.frame() {
        inputs.push(word(Stage::LocalFrame, "h", 3, "main direction"));
    }
    if lane.needs.bump {
        inputs.push(word(Stage::Bump, "b", 2, "bump offsets"));
    }
    if lane.needs.rough {
        inputs.push(word(Stage::Roughness, "d", 3, "d1, d2, d3 of the roughness"));
    }
    let mut outputs = Vec::new();
    for stage in Subject::Env.stages() {
        let first = outputs.len();
        lane.outputs(stage, &seen, &mut outputs);
        if outputs[first..].len() == 1 {
            outputs.truncate(first);
        }
        for field in &mut outputs[first..] {
            field.name = format!("{}.{}", stage.name(), field.name);
        }
    }
    Ok(Harness::new(Shape { inputs, outputs }, &spec.config, lane))
}

/// A case's fragment.
pub(super) fn fragment(input: &[i64], needs: Needs) -> Fragment {
    let mut numbers = Numbers::new(input);
    Fragment {
        v: numbers.reals(),
        n: numbers.reals(),
        dv_dx: numbers.reals(),
        dv_dy: numbers.reals(),
        dn_dx: numbers.reals(),
        dn_dy: numbers.reals(),
        h: needs.frame().then(|| numbers.reals()),
        bump: needs.bump.then(|| numbers.reals()),
        rough: needs.rough.then(|| numbers.reals()),
    }
}

impl Circuit for Lane {
    fn run(&mut self, input: &[i64], probe: &mut RtlProbe) -> (Flags, Extra) {
        let words = encode::words(&fragment(input, self.needs));
        (Self::run(self, &words, None, probe), self.extra())
    }

    fn drive(&mut self, stimulus: &Stimulus, input: &mut [i64]) {
        let Stimulus::Fragment(words) = stimulus else {
            return;
        };
        let needs = self.needs;
        let always = [words.v, words.n, words.dv[0], words.dv[1], words.dn[0], words.dn[1]];
        let h = words.h.into_iter().filter(|_| needs.frame());
        let b = words.b.into_iter().filter(|_| needs.bump);
        let d = words.d.into_iter().filter(|_| needs.rough);
        put_words(always.into_iter().flatten().chain(h).chain(b).chain(d), input);
    }

    fn roms(&mut self) -> Option<&mut Roms> {
        Some(&mut self.unit.roms)
    }
}
