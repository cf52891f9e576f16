//! Benches of the ENV operation: one stage behind its wires, and the whole from the ports to the colour.

use rtl_model::fx::Flags;
use rtl_model::stages::Roms;
use rtl_model::unit::{Alone, Needs, Results, State, Wire, Words};
use rtl_model::{Config, Texture, Unit};

use super::bench::{Bench, Build, Extra, Model, put_words, record};
use super::field::{Field, Shape, beside, components, registers};
use super::memory;
use super::stimuli::Stimulus;
use super::subject::Subject;
use crate::engine::encode;
use crate::engine::probe::RtlProbe;
use crate::error::InputError;
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
    probe: RtlProbe,
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
            probe: RtlProbe::default(),
        })
    }

    /// Every stage, up to one of them or all, on words from the ports; sticky flags of all that ran.
    fn run(&mut self, words: &Words, before: Option<Alone>) -> Flags {
        self.probe.clear();
        self.unit.one(
            words,
            before,
            Some(&self.texture),
            &mut self.state,
            &mut self.out,
            &mut self.probe,
        )
    }

    fn alone(&mut self, stage: Alone) -> Flags {
        let texture = Some(&self.texture);
        self.unit.alone(stage, &mut self.state, texture, &mut self.out, &mut self.probe)
    }

    fn extra(&mut self) -> Extra {
        let mut face = [0];
        Wire::Face.get(&mut self.state, &mut face);
        Extra { face: face[0], count: self.state.line.count[0], ..Extra::default() }
    }

    /// Fields of the registers that a stage writes in this unit. Which it writes depends on the configuration alone: an
    /// ordinary fragment shows it.
    fn outputs(&self, stage: Stage, out: &mut Vec<Field>) {
        let mut regs = Vec::new();
        for reg in registers(stage) {
            let seen = self.probe.get(reg).len();
            if seen > 0 {
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
pub struct EnvStage {
    lane: Lane,
    stage: Alone,
    wires: Vec<Wire>,
    shape: Shape,
}

/// The stage's name in the integer model.
fn alone(stage: Stage) -> Option<Alone> {
    Some(match stage {
        Stage::LocalFrame => Alone::LocalFrame,
        Stage::Bump => Alone::Bump,
        Stage::Reflect => Alone::Reflect,
        Stage::CubeFace => Alone::CubeFace,
        Stage::Jacobian => Alone::Jacobian,
        Stage::Roughness => Alone::Roughness,
        Stage::Covariance => Alone::Covariance,
        Stage::Eigen => Alone::Eigen,
        Stage::Footprint => Alone::Footprint,
        Stage::Address | Stage::Filter => Alone::Back,
        Stage::RayCone | Stage::Hit | Stage::SurfaceFootprint => return None,
    })
}

impl EnvStage {
    /// The bench of a stage.
    pub fn new(spec: &UnitSpec, stage: Stage, build: Build) -> Result<Self, InputError> {
        let mut lane = Lane::new(spec, build)?;
        let missing = || {
            InputError::new(
                stage.name(),
                "a unit with that stage behind wires of its own",
                "one that is built without it",
                "leave footprint.axis = longer-derivative, or a unit without bump and roughness, to `unit`",
            )
        };
        let at = alone(stage).ok_or_else(missing)?;
        let wires = lane.unit.wires(&lane.config, at).concat();
        if wires.is_empty() {
            return Err(missing());
        }
        lane.run(&ordinary(), Some(at));
        lane.probe.clear();
        lane.alone(at);
        let inputs = wires.iter().map(|wire| Field::wire(&lane.config, stage, *wire)).collect();
        let mut outputs = Vec::new();
        lane.outputs(stage, &mut outputs);
        Ok(Self { lane, stage: at, wires, shape: Shape { inputs, outputs } })
    }
}

impl Bench for EnvStage {
    fn shape(&self) -> &Shape {
        &self.shape
    }

    fn run(&mut self, input: &[i64], output: &mut [i64]) {
        let mut rest = input;
        for wire in &self.wires {
            let Some((here, more)) = rest.split_at_checked(wire.components()) else {
                return;
            };
            wire.set(&mut self.lane.state, here);
            rest = more;
        }
        let lane = &mut self.lane;
        lane.probe.clear();
        for wire in &self.wires {
            wire.put(&lane.config, &mut lane.state, &mut lane.probe);
        }
        let flags = lane.alone(self.stage);
        let extra = lane.extra();
        record(&self.shape, &lane.probe, flags, extra, output);
    }
}

impl Model for EnvStage {
    fn probe(&self) -> &RtlProbe {
        &self.lane.probe
    }

    fn config(&self) -> &Config {
        &self.lane.config
    }

    fn drive(&mut self, stimulus: &Stimulus, input: &mut [i64]) {
        let Stimulus::Fragment(words) = stimulus else {
            return;
        };
        self.lane.run(words, Some(self.stage));
        let mut rest = input;
        for wire in &self.wires {
            let Some((here, more)) = rest.split_at_mut_checked(wire.components()) else {
                return;
            };
            wire.get(&mut self.lane.state, here);
            rest = more;
        }
    }
}

/// The whole ENV operation.
pub struct EnvUnit {
    lane: Lane,
    shape: Shape,
}

impl EnvUnit {
    /// The bench of the operation.
    pub fn new(spec: &UnitSpec, build: Build) -> Result<Self, InputError> {
        let mut lane = Lane::new(spec, build)?;
        lane.run(&ordinary(), None);
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
            lane.outputs(stage, &mut outputs);
            if outputs[first..].len() == 1 {
                outputs.truncate(first);
            }
            for field in &mut outputs[first..] {
                field.name = format!("{}.{}", stage.name(), field.name);
            }
        }
        Ok(Self { lane, shape: Shape { inputs, outputs } })
    }

    /// The tables, to be changed by who tests the judges.
    pub fn roms(&mut self) -> &mut Roms {
        &mut self.lane.unit.roms
    }
}

impl Bench for EnvUnit {
    fn shape(&self) -> &Shape {
        &self.shape
    }

    fn run(&mut self, input: &[i64], output: &mut [i64]) {
        let mut numbers = input.iter().map(|x| x.cast_unsigned());
        let mut next = || numbers.next().unwrap_or(0);
        let mut three = || [next(), next(), next()];
        let mut words = Words {
            v: three(),
            n: three(),
            dv: [three(), three()],
            dn: [three(), three()],
            ..Words::default()
        };
        if self.lane.needs.frame() {
            words.h = three();
        }
        if self.lane.needs.bump {
            words.b = [next(), next()];
        }
        if self.lane.needs.rough {
            words.d = [next(), next(), next()];
        }
        let flags = self.lane.run(&words, None);
        let extra = self.lane.extra();
        record(&self.shape, &self.lane.probe, flags, extra, output);
    }
}

impl Model for EnvUnit {
    fn probe(&self) -> &RtlProbe {
        &self.lane.probe
    }

    fn config(&self) -> &Config {
        &self.lane.config
    }

    fn drive(&mut self, stimulus: &Stimulus, input: &mut [i64]) {
        let Stimulus::Fragment(words) = stimulus else {
            return;
        };
        let needs = self.lane.needs;
        let always = [words.v, words.n, words.dv[0], words.dv[1], words.dn[0], words.dn[1]];
        let h = words.h.into_iter().filter(|_| needs.frame());
        let b = words.b.into_iter().filter(|_| needs.bump);
        let d = words.d.into_iter().filter(|_| needs.rough);
        put_words(always.into_iter().flatten().chain(h).chain(b).chain(d), input);
    }
}
