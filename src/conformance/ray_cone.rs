//! The bench of `ray_cone`: one operation on a cone.

use rtl_model::Config;
use rtl_model::cone::{Angle, Cone, Dyadic, Width};
use rtl_model::fx::Flags;
use rtl_model::regs::Event;
use rtl_model::stages::ray_cone::{Cfg, Step, ray_cone};

use super::bench::{Bench, Model, flag_bits, put_words};
use super::field::{Field, Shape};
use super::stimuli::Stimulus;
use super::tex::small;
use crate::base::num;
use crate::engine::probe::RtlProbe;
use crate::stage::Stage;
use crate::unit::UnitSpec;

/// Names of the operations, in the order of their numbers.
pub const OPERATIONS: [&str; 4] = ["propagate", "reflect", "refract", "scatter"];

/// One operation of a cone.
pub struct ConeBench {
    cfg: Cfg,
    config: Config,
    shape: Shape,
    probe: RtlProbe,
}

impl ConeBench {
    /// The bench of the stage.
    #[must_use]
    pub fn new(spec: &UnitSpec) -> Self {
        let (config, stage) = (&spec.config, Stage::RayCone);
        let inputs = vec![
            Field::choice(stage, "operation", OPERATIONS.to_vec(), "what happens to the cone"),
            small(config, stage, "angle_in", "the cone's full angle"),
            small(config, stage, "width_in", "the cone's full width"),
            Field::words(
                stage,
                "operand",
                3,
                "distance; curvature; curvature, n_o and n_i; value of the BSDF. 0 where fewer",
            ),
            Field::count(stage, "ray", [0, 0xffff], "number of the ray, for stochastic stores"),
        ];
        let outputs = vec![
            small(config, stage, "angle", "full angle afterwards"),
            small(config, stage, "width", "full width afterwards"),
            Field::flags(stage, &[]),
        ];
        Self {
            cfg: Cfg::new(config),
            config: config.clone(),
            shape: Shape { inputs, outputs },
            probe: RtlProbe::default(),
        }
    }
}

/// The operation of a case's numbers, and whether its operands were finite.
#[must_use]
pub fn step(input: &[i64]) -> (Step, bool) {
    let used = match input.first() {
        Some(2) => 3,
        _ => 1,
    };
    let mut finite = true;
    let mut operand = |k: usize| {
        let word = input.get(3 + k).map_or(0, |x| x.cast_unsigned());
        let (value, is_finite) = Dyadic::binary64(word);
        finite &= is_finite || k >= used;
        value
    };
    let [first, second, third] = [0, 1, 2].map(&mut operand);
    let step = match input.first() {
        Some(0) => Step::Propagate(first),
        Some(1) => Step::Reflect(first),
        Some(2) => Step::Refract { curvature: first, outside: second, inside: third },
        _ => Step::Scatter(first),
    };
    (step, finite)
}

impl Bench for ConeBench {
    fn shape(&self) -> &Shape {
        &self.shape
    }

    fn run(&mut self, input: &[i64], output: &mut [i64]) {
        let code = |k: usize| num::u32(input.get(k).copied().unwrap_or(0));
        let cone = Cone { angle: Angle(code(1)), width: Width(code(2)) };
        let (step, finite) = step(input);
        let mut flags = Flags::default();
        flags.event(Event::ConeNotFinite, !finite);
        let mut dither = self.cfg.dither(input.get(6).map_or(0, |x| x.cast_unsigned()));
        let cone = ray_cone(&self.cfg, cone, step, &mut dither, &mut flags);
        let flags = flag_bits(&self.shape, Stage::RayCone, flags);
        let numbers = [cone.angle.0.into(), cone.width.0.into(), flags];
        for (out, number) in output.iter_mut().zip(numbers) {
            *out = number;
        }
    }
}

impl Model for ConeBench {
    fn probe(&self) -> &RtlProbe {
        &self.probe
    }

    fn config(&self) -> &Config {
        &self.config
    }

    fn drive(&mut self, stimulus: &Stimulus, input: &mut [i64]) {
        let Stimulus::Operation(operation, cone, operand) = stimulus else {
            return;
        };
        let words = cone.map(f64::to_bits);
        let stored = self.cfg.load(words, &mut self.cfg.dither(0), &mut Flags::default());
        let codes = [*operation, stored.angle.0.into(), stored.width.0.into()];
        let operand = operand.map(f64::to_bits);
        // Any ray: its number only decides stochastic stores.
        let ray = operand.iter().fold(*operation, |sum, word| sum ^ word) % 0x1_0000;
        put_words(codes.into_iter().chain(operand).chain([ray]), input);
    }
}
