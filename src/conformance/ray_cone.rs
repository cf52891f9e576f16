//! The harness of `ray_cone`: one operation on a cone.

use rtl_model::cone::{Angle, Cone, Width};
use rtl_model::fx::Flags;
use rtl_model::regs::Event;
use rtl_model::stages::ray_cone::{Cfg, ray_cone};

use super::field::{Field, Shape};
use super::harness::{Circuit, Extra, Harness, Numbers, put_words};
use super::stimuli::Stimulus;
use crate::engine::cones::rtl_step;
use crate::engine::probe::RtlProbe;
use crate::reference::ray_cone::Step;
use crate::stage::Stage;
use crate::unit::UnitSpec;

/// Names of the operations, in the order of their numbers.
pub const OPERATIONS: [&str; 4] = ["propagate", "reflect", "refract", "scatter"];

/// The harness of the stage.
#[must_use]
pub(super) fn harness(spec: &UnitSpec) -> Harness {
    let (config, stage) = (&spec.config, Stage::RayCone);
    let small = |name, text| Field::small(config, stage, name, text);
    let inputs = vec![
        Field::choice(stage, "operation", OPERATIONS.to_vec(), "what happens to the cone"),
        small("angle_in", "the cone's full angle"),
        small("width_in", "the cone's full width"),
        Field::words(
            stage,
            "operand",
            3,
            "distance; curvature; curvature, n_o and n_i; value of the BSDF. 0 where fewer",
        ),
        Field::count(stage, "ray", [0, 0xffff], "number of the ray, for stochastic stores"),
    ];
    let outputs = vec![
        small("angle", "full angle afterwards"),
        small("width", "full width afterwards"),
        Field::flags(stage, &[]),
    ];
    Harness::new(Shape { inputs, outputs }, config, Cfg::new(config))
}

/// A case: codes of the cone, the step, the ray's number.
pub(super) fn operation(input: &[i64]) -> ([u32; 2], Step, u64) {
    let mut numbers = Numbers::new(input);
    let operation = numbers.code();
    let cone = [numbers.code(), numbers.code()];
    let [first, second, third] = numbers.reals();
    let step = match operation {
        0 => Step::Propagate(first),
        1 => Step::Reflect(first),
        2 => Step::Refract { curvature: first, outside: second, inside: third },
        _ => Step::Scatter(first),
    };
    (cone, step, numbers.next().cast_unsigned())
}

impl Circuit for Cfg {
    fn run(&mut self, input: &[i64], _: &mut RtlProbe) -> (Flags, Extra) {
        let ([angle, width], step, ray) = operation(input);
        let (step, finite) = rtl_step(step);
        let mut flags = Flags::default();
        flags.event(Event::ConeNotFinite, !finite);
        let cone = Cone { angle: Angle(angle), width: Width(width) };
        let cone = ray_cone(self, cone, step, &mut self.dither(ray), &mut flags);
        let (angle, width) = (cone.angle.0.into(), cone.width.0.into());
        (flags, Extra { angle, width, ..Extra::default() })
    }

    fn drive(&mut self, stimulus: &Stimulus, input: &mut [i64]) {
        let Stimulus::Operation(operation, cone, operand) = stimulus else {
            return;
        };
        let words = cone.map(f64::to_bits);
        let stored = self.load(words, &mut self.dither(0), &mut Flags::default());
        let codes = [*operation, stored.angle.0.into(), stored.width.0.into()];
        let operand = operand.map(f64::to_bits);
        // Any ray: its number only decides stochastic stores.
        let ray = operand.iter().fold(*operation, |sum, word| sum ^ word) % 0x1_0000;
        put_words(codes.into_iter().chain(operand).chain([ray]), input);
    }
}
