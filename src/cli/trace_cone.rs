//! Trace lines with `"op":"cone"`: a ray cone through a list of steps.

use rtl_model::cone::{Cone, Dyadic};
use rtl_model::fx::Flags;
use rtl_model::regs::Event;
use rtl_model::stages::ray_cone::{self as rtl, Cfg};
use serde_json::value::RawValue;
use serde_json::{Map, Number, Value, json};

use super::json_lines::{self, Line, short};
use super::trace::TraceEngine;
use crate::base::num;
use crate::engine::cones::{event_names, rtl_step};
use crate::engine::probe::Code;
use crate::error::InputError;
use crate::reference::ray_cone as float;
use crate::unit::UnitSpec;

/// How the answer is computed and printed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Output {
    /// Engine.
    pub(super) engine: TraceEngine,
    /// Codes instead of decimals.
    pub(super) raw: bool,
}

/// Keys of a `cone` line beside `id` and `out`.
const KEYS: [&str; 3] = ["op", "cone", "steps"];
/// Most steps of a line.
const MAX_STEPS: usize = 65_536;

/// The line with its `out`; `None` where its `op` is another one.
pub(super) fn answer(
    spec: &UnitSpec,
    output: Output,
    subject: &str,
    number: usize,
    text: &str,
) -> Result<Option<String>, InputError> {
    let Some(line) = json_lines::with_op(text, "cone") else {
        return Ok(None);
    };
    line.only(subject, number, &KEYS)?;
    let fail = |key: &str, expected: &str, found: String| {
        json_lines::error(subject, number, key, expected, found)
    };
    let expected = "an array of 2 numbers, angle and width";
    let cone = line
        .find("cone")
        .ok_or_else(|| fail("cone", expected, "nothing".into()))
        .and_then(|v| json_lines::numbers(v).map_err(|found| fail("cone", expected, found)))?;
    let steps = steps(&line, &fail)?;
    let out = match output.engine {
        TraceEngine::Rtl => by_rtl(spec, cone, &steps, output.raw),
        TraceEngine::F64 => by_f64(spec, cone, &steps),
    };
    Ok(Some(line.with_out(&out)))
}

type Fail<'a> = dyn Fn(&str, &str, String) -> InputError + 'a;

/// The steps, each an object with one key.
fn steps(line: &Line, fail: &Fail<'_>) -> Result<Vec<float::Step>, InputError> {
    let list = "an array of steps";
    let raw = line.find("steps").ok_or_else(|| fail("steps", list, "nothing".into()))?;
    let items: Vec<&RawValue> =
        serde_json::from_str(raw.get()).map_err(|_| fail("steps", list, short(raw.get())))?;
    if items.len() > MAX_STEPS {
        return Err(fail("steps", &format!("at most {MAX_STEPS} steps"), items.len().to_string()));
    }
    items.iter().enumerate().map(|(i, item)| step(item, i, fail)).collect()
}

fn step(item: &RawValue, index: usize, fail: &Fail<'_>) -> Result<float::Step, InputError> {
    let place = format!("steps[{index}]");
    let expected = "one of {\"propagate\":d}, {\"reflect\":{\"k\":_}}, {\"refract\":{\"k\":_,\"no\":_,\"ni\":_}}, {\"scatter\":{\"f\":_}}";
    let wrong = || fail(&place, expected, short(item.get()));
    let entries = json_lines::entries(item.get()).map_err(|_| wrong())?;
    let [(name, value)] = entries.as_slice() else {
        return Err(wrong());
    };
    let fields = |names: &[&str]| -> Result<Vec<f64>, InputError> {
        let inner = json_lines::entries(value.get()).map_err(|_| wrong())?;
        if inner.len() != names.len() {
            return Err(wrong());
        }
        names
            .iter()
            .map(|name| {
                let (_, raw) = inner.iter().find(|(k, _)| k == name).ok_or_else(wrong)?;
                json_lines::number(raw.get()).map_err(|_| wrong())
            })
            .collect()
    };
    Ok(match name.as_str() {
        "propagate" => {
            float::Step::Propagate(json_lines::number(value.get()).map_err(|_| wrong())?)
        }
        "reflect" => float::Step::Reflect(fields(&["k"])?[0]),
        "refract" => {
            let f = fields(&["k", "no", "ni"])?;
            let positive = |x: f64| x > 0.0;
            if !(positive(f[1]) && positive(f[2])) {
                return Err(fail(&place, "refractive indices above 0", short(item.get())));
            }
            float::Step::Refract { curvature: f[0], outside: f[1], inside: f[2] }
        }
        "scatter" => {
            let f = fields(&["f"])?[0];
            if f < 0.0 {
                return Err(fail(&place, "a BSDF value of at least 0", short(item.get())));
            }
            float::Step::Scatter(f)
        }
        _ => return Err(wrong()),
    })
}

fn object(angle: Value, width: Value, packed: String, flags: &[&str]) -> Map<String, Value> {
    let mut out = Map::new();
    out.insert("cone".into(), json!([angle, width]));
    out.insert("packed".into(), json!(packed));
    out.insert("flags".into(), json!(flags));
    out
}

/// Eight digits, or sixteen for two codes of 32 bits.
fn packed(cfg: &Cfg, cone: Cone) -> String {
    let word = cone.pack(cfg.format, cfg.order);
    if cfg.format.width() > 16 { format!("0x{word:016x}") } else { format!("0x{word:08x}") }
}

fn by_rtl(spec: &UnitSpec, cone: [f64; 2], steps: &[float::Step], raw: bool) -> Map<String, Value> {
    let cfg = Cfg::new(&spec.config);
    let mut dither = cfg.dither(0);
    let mut flags = Flags::default();
    let mut state = cfg.load(cone.map(f64::to_bits), &mut dither, &mut flags);
    for step in steps {
        let (step, finite) = rtl_step(*step);
        flags.event(Event::ConeNotFinite, !finite);
        state = rtl::ray_cone(&cfg, state, step, &mut dither, &mut flags);
    }
    let number = |x: Dyadic| {
        let m = num::i64(x.m);
        let code = Code { raw: if x.negative { -m } else { m }, frac: -x.e };
        if raw {
            json!({"raw": code.raw, "frac": code.frac})
        } else {
            Value::Number(Number::from_string_unchecked(code.decimal()))
        }
    };
    object(
        number(cfg.angle(state.angle)),
        number(cfg.width(state.width)),
        packed(&cfg, state),
        &event_names(flags).collect::<Vec<_>>(),
    )
}

fn by_f64(spec: &UnitSpec, cone: [f64; 2], steps: &[float::Step]) -> Map<String, Value> {
    let knobs = &spec.config.cone;
    let finite = |x: f64| {
        if x.is_nan() { 0.0 } else { x.clamp(-f64::MAX, f64::MAX) + 0.0 }
    };
    let mut state =
        float::Cone { angle: float::Angle(finite(cone[0])), width: float::Width(finite(cone[1])) };
    let operands = |step: &float::Step| match *step {
        float::Step::Propagate(x) | float::Step::Reflect(x) | float::Step::Scatter(x) => {
            [x, 0.0, 0.0]
        }
        float::Step::Refract { curvature, outside, inside } => [curvature, outside, inside],
    };
    let numbers = steps.iter().flat_map(operands).chain(cone);
    let strange = numbers.into_iter().any(|x| !x.is_finite());
    let mut flags = Flags::default();
    flags.event(Event::ConeNotFinite, strange);
    for step in steps {
        state = float::ray_cone(state, *step, knobs.rules, knobs.set_diffuse);
        // Only what is beyond the range becomes its end.
        let at_end = |x: f64| x.abs() >= f64::MAX;
        flags.event(Event::ConeAngleSaturated, at_end(state.angle.0));
        flags.event(Event::ConeWidthSaturated, at_end(state.width.0));
    }
    // The packed word is the rounded pair; its own overflow shows in the word alone.
    let cfg = Cfg::new(&spec.config);
    let words = [state.angle.0, state.width.0].map(f64::to_bits);
    let codes = cfg.load(words, &mut cfg.dither(0), &mut Flags::default());
    object(
        json!(state.angle.0),
        json!(state.width.0),
        packed(&cfg, codes),
        &event_names(flags).collect::<Vec<_>>(),
    )
}
