//! Trace lines of the operation `tex`: a cone's footprint on a textured surface.

use rtl_model::fx::Flags;
use rtl_model::regs::{Event, Reg};
use serde_json::{Map, Value, json};

use super::json_lines::{self, Line};
use super::trace::{TraceEngine, Tracer};
use crate::base::num;
use crate::engine::cones::event_names;
use crate::engine::probe::RtlProbe;
use crate::engine::tex::{TexRtl, words};
use crate::error::InputError;
use crate::fragment::{Tangents, TexFragment};
use crate::reference::{NoTap, tex};

/// Keys of a `tex` line beside `id` and `out`.
const KEYS: [&str; 6] = ["op", "cone", "d", "n", "dp_ds", "dp_dt"];

/// A request and its cone.
struct Request {
    fragment: TexFragment,
    cone: [f64; 2],
}

fn read(line: &Line, subject: &str, number: usize) -> Result<Request, InputError> {
    line.only(subject, number, &KEYS)?;
    fn array<const N: usize>(
        line: &Line,
        (subject, number): (&str, usize),
        key: &str,
    ) -> Result<[f64; N], InputError> {
        let fail = |found| {
            let expected = format!("an array of {N} numbers");
            json_lines::error(subject, number, key, &expected, found)
        };
        let value = line.find(key).ok_or_else(|| fail("nothing".into()))?;
        json_lines::numbers(value).map_err(fail)
    }
    let place = (subject, number);
    Ok(Request {
        cone: array(line, place, "cone")?,
        fragment: TexFragment {
            d: array(line, place, "d")?,
            n: array(line, place, "n")?,
            tangents: Tangents::Surface {
                dp_ds: array(line, place, "dp_ds")?,
                dp_dt: array(line, place, "dp_dt")?,
            },
            st: [0.5; 2],
        },
    })
}

/// The line with its `out`; `None` where its `op` is another one.
pub(super) fn answer(
    tracer: &mut Tracer,
    subject: &str,
    number: usize,
    text: &str,
) -> Result<Option<String>, InputError> {
    let Some(line) = json_lines::with_op(text, "tex") else {
        return Ok(None);
    };
    let request = read(&line, subject, number)?;
    let out = out(tracer, &request.fragment, request.cone)?;
    Ok(Some(line.with_out(&out)))
}

/// The `out` object of a request.
pub(super) fn out(
    tracer: &mut Tracer,
    fragment: &TexFragment,
    cone: [f64; 2],
) -> Result<Map<String, Value>, InputError> {
    let request = Request { fragment: *fragment, cone };
    match tracer.engine {
        TraceEngine::Rtl => by_rtl(tracer, &request),
        TraceEngine::F64 => Ok(by_f64(tracer, &request)),
    }
}

fn by_rtl(tracer: &mut Tracer, request: &Request) -> Result<Map<String, Value>, InputError> {
    if tracer.tex.is_none() {
        let size = tracer.texture_size.map(num::u32);
        tracer.tex = Some(TexRtl::sized(&tracer.spec, size)?);
    }
    let mut out = Map::new();
    let Some(engine) = &tracer.tex else {
        return Ok(out);
    };
    let cfg = &engine.unit.cone;
    let mut loaded = Flags::default();
    let cone = request.cone.map(f64::to_bits);
    let cone = cfg.load(cone, &mut cfg.dither(0), &mut loaded);
    let mut probe = RtlProbe::default();
    let (_, results) = engine.lanes::<1, _>(&[words(&request.fragment, cone)], &mut probe);
    let mut flags: Vec<String> = event_names(loaded).map(str::to_string).collect();
    flags.extend(engine.flags(&results, 0));
    tracer.probe = probe;
    let mut put = |key: &str, reg: Reg| {
        out.insert(key.into(), Value::Array(tracer.codes(reg)));
    };
    put("dp_dx", Reg::SurfDpDx);
    put("dp_dy", Reg::SurfDpDy);
    put("ddx", Reg::SurfDdx);
    put("ddy", Reg::SurfDdy);
    put("K", Reg::CovK);
    put("lambda", Reg::EigenLambda);
    put("axis", Reg::EigenAxis);
    out.insert("probes".into(), json!(results.probes[0]));
    let lod = tracer.codes(Reg::FootLod).into_iter().next();
    out.insert("lod".into(), lod.unwrap_or(Value::Null));
    out.insert("flags".into(), json!(flags));
    Ok(out)
}

fn by_f64(tracer: &Tracer, request: &Request) -> Map<String, Value> {
    let found = tex(
        &tracer.prepared,
        request.cone[1],
        &request.fragment,
        tracer.texture_size,
        None,
        &mut NoTap,
    );
    let mut flags: Vec<&str> = found.flags.names().collect();
    if !request.cone[0].is_finite() {
        flags.insert(0, Event::ConeNotFinite.name());
    }
    let mut out = Map::new();
    out.insert("dp_dx".into(), json!(found.dp[0]));
    out.insert("dp_dy".into(), json!(found.dp[1]));
    out.insert("ddx".into(), json!(found.dd[0]));
    out.insert("ddy".into(), json!(found.dd[1]));
    out.insert("K".into(), json!(found.k));
    out.insert("lambda".into(), json!(found.lambda));
    out.insert("axis".into(), json!(found.axis));
    out.insert("probes".into(), json!(found.probes));
    out.insert("lod".into(), json!(found.lod));
    out.insert("flags".into(), json!(flags));
    out
}
