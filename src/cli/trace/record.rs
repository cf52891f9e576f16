//! The result of a request from either engine, and the `out` object that shows it.

use rtl_model::cone::Cone;
use rtl_model::regs::Reg;
use rtl_model::stages::ray_cone::Cfg;
use serde_json::{Map, Value, json};

use crate::cube::FACE_NAMES;
use crate::engine::probe::{Code, FloatProbe, RtlProbe};
use crate::engine::registers::error_lsb;
use crate::policy::HitStatus;

/// A component of a register: exact in the unit, a double in the reference.
#[derive(Clone, Copy, Debug)]
pub(super) enum Number {
    Code(Code),
    Float(f64),
}

impl Number {
    /// The number as JSON has it; "inf" where it is not finite, as d of a ray that escaped.
    fn json(self, raw: bool) -> Value {
        match self {
            Self::Code(code) if !code.is_written() => Value::Null,
            Self::Code(code) if raw => json!({"raw": code.raw, "frac": code.frac}),
            Self::Code(code) => {
                Value::Number(serde_json::Number::from_string_unchecked(code.decimal()))
            }
            Self::Float(x) if x.is_finite() => json!(x),
            Self::Float(_) => json!("inf"),
        }
    }

    /// The value to the nearest double; nothing where the component was skipped.
    pub(super) fn value(self) -> Option<f64> {
        match self {
            Self::Code(code) => code.is_written().then(|| code.value()),
            Self::Float(x) => Some(x),
        }
    }

    /// How many LSB of the unit's register it is from the reference's.
    pub(super) fn error_lsb(self, reference: Self) -> Option<f64> {
        match (self, reference) {
            (Self::Code(code), Self::Float(x)) if code.is_written() => Some(error_lsb(code, x)),
            _ => None,
        }
    }
}

/// Every register that was written for a request.
#[derive(Clone, Copy, Debug)]
pub(super) enum Registers<'a> {
    Rtl(&'a RtlProbe),
    F64(&'a FloatProbe),
}

impl Registers<'_> {
    /// The components of a register; empty where its stage was not built.
    pub(super) fn get(&self, reg: Reg) -> Vec<Number> {
        match self {
            Self::Rtl(probe) => probe.get(reg).iter().copied().map(Number::Code).collect(),
            Self::F64(probe) => probe.get(reg).iter().copied().map(Number::Float).collect(),
        }
    }
}

/// How the search of a ray ended.
#[derive(Clone, Copy, Debug)]
pub(super) struct Search {
    pub(super) d: Number,
    pub(super) l: [Number; 3],
    pub(super) iterations: u32,
    pub(super) status: HitStatus,
    pub(super) ratio: Option<Number>,
}

/// A cone after its last step.
#[derive(Clone, Debug)]
pub(super) struct ConeEnd {
    /// Angle and width.
    pub(super) cone: [Number; 2],
    /// Both codes in one word: eight hexadecimal digits, or sixteen for two codes of 32 bits.
    pub(super) packed: String,
}

impl ConeEnd {
    /// `state` as words of the unit's format, beside the numbers that an engine has.
    pub(super) fn new(cfg: &Cfg, state: Cone, cone: [Number; 2]) -> Self {
        let word = state.pack(cfg.format, cfg.order);
        let digits = if cfg.format.width() > 16 { 16 } else { 8 };
        Self { cone, packed: format!("0x{word:0digits$x}") }
    }
}

/// Where a footprint lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// On a face of a cube map.
    Face(usize),
    /// On a textured surface.
    Surface,
}

/// The answer to a request, of one shape for both engines and all operations.
#[derive(Clone, Debug)]
pub(super) struct Record<'a> {
    pub(super) registers: Registers<'a>,
    pub(super) cone: Option<ConeEnd>,
    pub(super) search: Option<Search>,
    /// Where the footprint lies; nothing where none was asked for.
    pub(super) place: Option<Place>,
    pub(super) probes: u32,
    pub(super) flags: Vec<String>,
}

impl<'a> Record<'a> {
    /// A record of registers and flags alone.
    pub(super) fn new(registers: Registers<'a>, flags: Vec<String>) -> Self {
        Self { registers, cone: None, search: None, place: None, probes: 0, flags }
    }

    /// The face's name.
    pub(super) fn face(&self) -> &'static str {
        match self.place {
            Some(Place::Face(face)) => FACE_NAMES[face],
            Some(Place::Surface) | None => "-",
        }
    }

    /// The `out` object; codes instead of decimals where `raw`.
    pub(super) fn out(&self, raw: bool) -> Map<String, Value> {
        let mut out = Map::new();
        let array = |reg: Reg| -> Vec<Value> {
            self.registers.get(reg).into_iter().map(|n| n.json(raw)).collect()
        };
        let first = |reg: Reg| array(reg).into_iter().next().unwrap_or(Value::Null);
        let mut put = |key: &str, value: Value| out.insert(key.into(), value);
        if let Some(end) = &self.cone {
            put("cone", json!(end.cone.map(|n| n.json(raw))));
            put("packed", json!(end.packed));
        }
        if let Some(search) = &self.search {
            put("d", search.d.json(raw));
            put("l", json!(search.l.map(|n| n.json(raw))));
            put("iterations", json!(search.iterations));
            put("status", json!(search.status.name()));
            put("ratio", search.ratio.map_or(Value::Null, |n| n.json(raw)));
        }
        match self.place {
            None => {}
            Some(Place::Face(face)) => {
                put("face", json!(FACE_NAMES[face]));
                put("u", first(Reg::FaceU));
                put("v", first(Reg::FaceV));
                put("D", array(Reg::JacD).chunks(2).map(<[Value]>::to_vec).collect());
            }
            Some(Place::Surface) => {
                put("dp_dx", json!(array(Reg::SurfDpDx)));
                put("dp_dy", json!(array(Reg::SurfDpDy)));
                put("ddx", json!(array(Reg::SurfDdx)));
                put("ddy", json!(array(Reg::SurfDdy)));
            }
        }
        if let Some(place) = self.place {
            put("K", json!(array(Reg::CovK)));
            put("lambda", json!(array(Reg::EigenLambda)));
            put("axis", json!(array(Reg::EigenAxis)));
            put("probes", json!(self.probes));
            put("lod", first(Reg::FootLod));
            let color = array(Reg::FilterColor);
            if place != Place::Surface && !color.is_empty() {
                put("color", json!(color));
            }
        }
        put("flags", json!(self.flags));
        out
    }

    /// Every register as `stage.name`.
    pub(super) fn registers(&self, raw: bool) -> Value {
        let mut map = Map::new();
        for reg in Reg::ALL {
            let numbers = self.registers.get(*reg);
            if !numbers.is_empty() {
                let numbers = numbers.into_iter().map(|n| n.json(raw)).collect();
                map.insert(reg.to_string(), numbers);
            }
        }
        Value::Object(map)
    }
}
