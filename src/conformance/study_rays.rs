//! The extremes of rays: HIT in a room, ray cones, and their footprints on 2-D textures.

use rtl_model::fx::Flags;
use rtl_model::regs::Reg;
use rtl_model::stages::ray_cone::{Cfg, ray_cone};

use super::extremes::{Request, hit, tex as requests};
use super::ray_cone::OPERATIONS as NAMES;
use super::stimuli::OPERATIONS;
use super::study::{Row, dot, number};
use crate::base::num;
use crate::distance::Distance;
use crate::engine::cones::{event_names, rtl_step};
use crate::engine::hit::{HitF64, HitResult, HitRtl};
use crate::engine::probe::RtlProbe;
use crate::engine::tex::{TexRtl, value, words};
use crate::error::InputError;
use crate::fragment::{HitFragment, Tangents, TexFragment};
use crate::reference::ray_cone as float;
use crate::reference::{self, NoTap, Prepared};
use crate::unit::{ReferenceAxis, UnitSpec};

/// Half edges of the room that the rays are in.
const ROOM: [f64; 3] = [3.0, 2.0, 4.0];
/// Texels of the texture.
const SIZE: [u32; 2] = [256, 256];

fn length(v: [f64; 3]) -> f64 {
    dot(v, v).sqrt()
}

/// "finite", or the names of what is not.
pub(super) fn finite(values: &[(&str, f64)]) -> String {
    let wrong: Vec<String> = values
        .iter()
        .filter(|(_, x)| !x.is_finite())
        .map(|(name, x)| format!("{name} = {x}").to_lowercase())
        .collect();
    if wrong.is_empty() { "finite".into() } else { wrong.join(", ") }
}

/// The function `Hit` of Szirmay-Kalos et al. as it is printed (`r1` and `rl` one variable, `pov` 0 at first), in doubles, with R made
/// unit: the d that it returns, or what has no value on the way.
fn hlsl(ray: &HitFragment, iterations: u32) -> String {
    let room = |q: [f64; 3]| {
        let most = [0, 1, 2].map(|i| q[i].abs() / ROOM[i]);
        length(q) / most[0].max(most[1]).max(most[2])
    };
    let size = length(ray.r);
    let r = ray.r.map(|c| c / size);
    let at = |d: f64| [0, 1, 2].map(|i| ray.x[i] + r[i] * d);
    let radius = room(r);
    let mut under = (0.0, length(ray.x) / room(ray.x));
    let mut over = (0.0, 0.0);
    let mut d = radius * (1.0 - under.1);
    for _ in 0..iterations {
        let l = at(d);
        let ratio = length(l) / room(l);
        if ratio < 0.999 {
            under = (d, ratio);
            d += if over.0 == 0.0 {
                radius * (1.0 - ratio)
            } else {
                (d - over.0) * (1.0 - ratio) / (ratio - over.1)
            };
        } else if ratio > 1.001 {
            over = (d, ratio);
            d += (d - under.0) * (1.0 - ratio) / (ratio - under.1);
        }
    }
    match finite(&[("dist(r)", radius), ("|x|/dist(x)", under.1), ("d", d)]).as_str() {
        "finite" => format!("d {}", number(d)),
        wrong => wrong.into(),
    }
}

fn found(r: &HitResult) -> String {
    let [x, y, z] = r.l.map(number);
    format!(
        "d {} l ({x}, {y}, {z}) {} after {}, {} probes",
        number(r.d),
        r.status.name(),
        r.iterations,
        r.probes
    )
}

/// Every row of HIT by the printed HLSL, the integer model and the float reference.
pub fn searches(spec: &UnitSpec) -> Result<Vec<Row>, InputError> {
    let settings = spec.settings(ReferenceAxis::Exact);
    let room = Distance::Box(ROOM);
    let rtl = HitRtl::new(spec, &room, None, 256)?;
    let f64 = HitF64::new(&settings, &room, None, 256);
    let (names, rays): (Vec<_>, Vec<_>) = hit().into_iter().unzip();
    let floats = f64.filter(&rays, &|_| {});
    let rows = names.into_iter().zip(&rays).zip(&floats);
    let rows = rows.map(|((name, ray), float)| {
        let mine = rtl.trace(ray, &mut RtlProbe::default()).0;
        Row {
            name: name.into(),
            paper: hlsl(ray, spec.config.policy.hit.iterations),
            rtl: found(&mine),
            f64: found(float),
            flags: mine.flags,
        }
    });
    Ok(rows.collect())
}

/// Every row of the cones' operations by OTK's formulas as the note writes them, in doubles, by the registers and by the float reference.
pub fn cones(spec: &UnitSpec) -> Vec<Row> {
    let cfg = Cfg::new(&spec.config);
    let knobs = &spec.config.policy.cone;
    let rows = OPERATIONS.into_iter().map(|(operation, [a, w], [x, y, z])| {
        let name = usize::try_from(operation).ok().and_then(|k| NAMES.get(k));
        let name = name.copied().unwrap_or("propagate");
        let operands = if operation == 2 { vec![x, y, z] } else { vec![x] };
        let operands: Vec<String> = operands.into_iter().map(number).collect();
        let pi = std::f64::consts::PI;
        let (step, note) = match operation {
            0 => (float::Step::Propagate(x), [a, w + a * x]),
            1 => (float::Step::Reflect(x), [a + 2.0 * x * w.abs(), w]),
            2 => (
                float::Step::Refract { curvature: x, outside: y, inside: z },
                [y / z * (a + x * w.abs()) - x * w.abs(), w],
            ),
            _ => (float::Step::Scatter(x), [a + 0.25 * (1.0 / (pi * x)).min(1.0), w]),
        };
        let mut flags = Flags::default();
        let mut dither = cfg.dither(0);
        let cone = cfg.load([a, w].map(f64::to_bits), &mut dither, &mut flags);
        let cone = ray_cone(&cfg, cone, rtl_step(step).0, &mut dither, &mut flags);
        let start = float::Cone { angle: float::Angle(a), width: float::Width(w) };
        let theirs = float::ray_cone(start, step, knobs.rules, knobs.set_diffuse);
        let pair = |angle: f64, width: f64| format!("α {} w {}", number(angle), number(width));
        Row {
            name: format!("{name} {} of ({}, {})", operands.join(", "), number(a), number(w)),
            paper: match finite(&[("α", note[0]), ("w", note[1])]).as_str() {
                "finite" => pair(note[0], note[1]),
                wrong => wrong.into(),
            },
            rtl: pair(value(cfg.angle(cone.angle)), value(cfg.width(cone.width))),
            f64: pair(theirs.angle.0, theirs.width.0),
            flags: event_names(flags).map(str::to_string).collect(),
        }
    });
    rows.collect()
}

fn fragment(r: &Request) -> TexFragment {
    let [first, second] = r.tangents;
    TexFragment {
        d: r.d,
        n: r.n,
        tangents: match r.edge {
            None => Tangents::Surface { dp_ds: first, dp_dt: second },
            Some([s_b, s_c, t_b, t_c]) => {
                Tangents::Triangle { edges: r.tangents, st: [[s_b, t_b], [s_c, t_c]] }
            }
        },
        st: r.st,
    }
}

/// OTK's note: dPdx = normalize(D − (D·N)N)·|w|/|D·N|, and its quotients by |∂P/∂s|² and |∂P/∂t|².
fn note(r: &Request) -> String {
    let unit = |v: [f64; 3]| {
        let size = length(v);
        v.map(|c| c / size)
    };
    let (d, n) = (unit(r.d), unit(r.n));
    let cosine = dot(d, n);
    let flat = unit([0, 1, 2].map(|i| d[i] - cosine * n[i]));
    let stretch = r.width.abs() / cosine.abs();
    let by = |t: [f64; 3]| dot(flat, t) * stretch / dot(t, t);
    finite(&[
        ("normalize(d − (d·n)n)", flat[0] + flat[1] + flat[2]),
        ("|w|/|d·n|", stretch),
        ("∂s", by(r.tangents[0])),
        ("∂t", by(r.tangents[1])),
    ])
}

/// Every row of TEX by OTK's note, the integer model and the float reference.
pub fn textures(spec: &UnitSpec) -> Result<Vec<Row>, InputError> {
    let settings = spec.settings(ReferenceAxis::Exact);
    let prepared = Prepared::new(&settings);
    let engine = TexRtl::sized(spec, SIZE)?;
    let cfg = &engine.unit.cone;
    let rows = requests().into_iter().map(|(name, request)| {
        let fragment = fragment(&request);
        let mut flags = Flags::default();
        let ports = [0.0, request.width].map(f64::to_bits);
        let cone = cfg.load(ports, &mut cfg.dither(0), &mut flags);
        let mut probe = RtlProbe::default();
        let (_, out) = engine.lanes::<1, _>(&[words(&fragment, cone)], &mut probe);
        let register = |reg: Reg, k: usize| probe.get(reg).get(k).map_or(0.0, |c| c.value());
        let size = SIZE.map(num::usize);
        let theirs = reference::tex(&prepared, request.width, &fragment, size, None, &mut NoTap);
        let text = |dd: [f64; 4], lambda: [f64; 2], probes: i64, lod: f64| {
            let [a, b, c, d] = dd.map(number);
            let [l, m] = lambda.map(number);
            format!("ddx ({a}, {b}) ddy ({c}, {d}) λ {l}, {m} {probes} × LOD {}", number(lod))
        };
        let [x, y] = theirs.dd;
        let mut names: Vec<String> = event_names(flags).map(str::to_string).collect();
        names.extend(engine.flag_names(out.flags[0]));
        Row {
            name: name.into(),
            paper: note(&request),
            rtl: text(
                [
                    register(Reg::SurfDdx, 0),
                    register(Reg::SurfDdx, 1),
                    register(Reg::SurfDdy, 0),
                    register(Reg::SurfDdy, 1),
                ],
                [register(Reg::EigenLambda, 0), register(Reg::EigenLambda, 1)],
                out.probes[0],
                register(Reg::FootLod, 0),
            ),
            f64: text([x[0], x[1], y[0], y[1]], theirs.lambda, theirs.probes.into(), theirs.lod),
            flags: names,
        }
    });
    Ok(rows.collect())
}
