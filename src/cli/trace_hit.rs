//! Trace lines of the operation `hit`.

use rtl_model::regs::Reg;
use serde_json::{Map, Value, json};

use super::trace::{TraceEngine, Tracer};
use crate::engine::hit::{HitF64, HitRtl};
use crate::engine::probe::{Code, RtlProbe};
use crate::error::InputError;
use crate::fragment::HitFragment;
use crate::policy::HitStatus;
use crate::reference::NoTap;

/// The integer model, compiled for the first line.
pub(super) type Rtl = HitRtl;

/// The `out` object of a ray.
pub(super) fn out(
    tracer: &mut Tracer,
    ray: &HitFragment,
) -> Result<Map<String, Value>, InputError> {
    let Some(distance) = &tracer.distance else {
        return Err(InputError::new(
            "--distance",
            "a distance map for the operation \"hit\"",
            "none",
            "add --distance, such as --distance box:4,3,2.5",
        ));
    };
    match tracer.engine {
        TraceEngine::Rtl => {
            if tracer.hit.is_none() {
                let map = tracer.map.as_ref();
                tracer.hit = Some(HitRtl::new(&tracer.spec, distance, map, tracer.face_size)?);
            }
            Ok(rtl(tracer, ray))
        }
        TraceEngine::F64 => {
            let map = tracer.map.as_ref();
            let engine = HitF64::new(&tracer.settings, distance, map, tracer.face_size);
            Ok(float(&engine, ray, map.is_some()))
        }
    }
}

/// A number; "inf" where it is not finite, as d of a ray that escaped.
fn number(value: f64) -> Value {
    if value.is_finite() { json!(value) } else { json!("inf") }
}

fn rtl(tracer: &mut Tracer, ray: &HitFragment) -> Map<String, Value> {
    let mut out = Map::new();
    let Some(engine) = tracer.hit.take() else {
        return out;
    };
    let mut probe = RtlProbe::default();
    let (state, results) = engine.lanes::<1, _>(std::slice::from_ref(ray), &mut probe);
    let result = engine.result(&state, &results, 0, ray.cone.is_some());
    let escaped = result.status == HitStatus::Escaped;
    let scale = engine.memory.scale;
    let frac = |reg: Reg| i64::from(engine.config.format(reg).frac);
    let d = if escaped {
        json!("inf")
    } else {
        let raw = state.hit.d[0];
        tracer.code(Code { raw, frac: frac(Reg::HitD) - scale })
    };
    let l_frac = if escaped { frac(Reg::HitR) } else { frac(Reg::HitL) - scale };
    let l = state.hit.l.map(|[raw]| tracer.code(Code { raw, frac: l_frac }));
    let ratio = state.hit.ratio[0]
        .map_or(Value::Null, |raw| tracer.code(Code { raw, frac: frac(Reg::HitRatio) }));
    out.insert("d".into(), d);
    out.insert("l".into(), json!(l));
    out.insert("iterations".into(), json!(result.iterations));
    out.insert("status".into(), json!(result.status.name()));
    out.insert("ratio".into(), ratio);
    if ray.cone.is_some() {
        tracer.probe = probe;
        let face = crate::cube::FACE_NAMES[state.env.face.face[0]];
        let textured = engine.texture.is_some();
        tracer.env_codes(&mut out, face, result.probes.into(), textured);
    }
    out.insert("flags".into(), json!(result.flags));
    tracer.hit = Some(engine);
    out
}

fn float(engine: &HitF64<'_>, ray: &HitFragment, textured: bool) -> Map<String, Value> {
    let both = engine.trace(ray, &mut NoTap);
    let hit = both.hit;
    let mut out = Map::new();
    out.insert("d".into(), number(hit.d));
    out.insert("l".into(), json!(hit.l.map(number)));
    out.insert("iterations".into(), json!(hit.iterations));
    out.insert("status".into(), json!(hit.status.name()));
    out.insert("ratio".into(), hit.ratio.map_or(Value::Null, number));
    if let Some(env) = &both.env {
        Tracer::env_values(&mut out, env, textured);
    }
    let flags = both.env.map_or(hit.flags, |env| env.flags);
    let names: Vec<&str> = flags.names().collect();
    out.insert("flags".into(), json!(names));
    out
}
