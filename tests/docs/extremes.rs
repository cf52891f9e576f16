//! The tables of docs/studies/extremes.md that lie between `<!-- rows -->` and `<!-- end -->`: each row of the
//! specification's section 8 by the papers' formulas as they are printed, by the default unit and by the float reference.
//! `TAPLINE_BLESS=1` writes them.

use std::fmt::Write as _;

use rtl_model::Unit;
use rtl_model::fx::Flags;
use rtl_model::regs::Reg;
use rtl_model::stages::ray_cone::{Cfg, ray_cone};
use support::{golden, house};
use tapline::base::dual::dot;
use tapline::conformance::extremes::{self, Request};
use tapline::conformance::ray_cone::OPERATIONS;
use tapline::cube::{FACE_AXES, FACE_NAMES, major_face};
use tapline::distance::Distance;
use tapline::engine::cones::{event_names, rtl_step};
use tapline::engine::encode;
use tapline::engine::hit::{HitF64, HitResult, HitRtl};
use tapline::engine::probe::{RtlProbe, rtl};
use tapline::engine::tex::{TexRtl, value, words};
use tapline::fragment::{Fragment, HitFragment, Tangents, TexFragment};
use tapline::reference::{self, NoTap, Prepared, ray_cone as float};
use tapline::unit::{ReferenceAxis, UnitSpec};

/// Face size, and columns and rows of the texture.
const SIZE: u32 = 256;
/// Half edges of the room that the rays are in.
const ROOM: [f64; 3] = [3.0, 2.0, 4.0];

fn length(v: [f64; 3]) -> f64 {
    dot(v, v).sqrt()
}

/// A row of a table.
struct Row {
    name: String,
    /// The paper's formulas as they are written, in doubles.
    paper: String,
    rtl: String,
    f64: String,
    flags: Vec<String>,
}

/// A number in a table's cell: four decimals, or two digits and a power of ten.
fn number(x: f64) -> String {
    if x != 0.0 && (x.abs() < 1e-3 || x.abs() >= 1e5) {
        return format!("{x:.1e}");
    }
    let text = format!("{x:.4}");
    match text.trim_end_matches('0').trim_end_matches('.') {
        "-0" | "" => "0".into(),
        short => short.into(),
    }
}

/// "finite", or the names of what is not.
fn finite(values: &[(&str, f64)]) -> String {
    let wrong: Vec<String> = values
        .iter()
        .filter(|(_, x)| !x.is_finite())
        .map(|(name, x)| format!("{name} = {x}").to_lowercase())
        .collect();
    if wrong.is_empty() { "finite".into() } else { wrong.join(", ") }
}

/// Equations 4, 6, 16, 17 and 20 as the paper writes them, in doubles, with K from exact arithmetic.
fn paper(fragment: &Fragment, k: [f64; 3]) -> String {
    let (v, n) = (fragment.v, fragment.n);
    let (nv, nn) = (dot(n, v), dot(n, n));
    let v_r = [0, 1, 2].map(|i| 2.0 * n[i] * nv - v[i] * nn);
    let face = major_face(v_r);
    let [(s, sign_s), _, (m, _)] = FACE_AXES[face];
    let u = sign_s * v_r[s] / v_r[m].abs();
    let [a, b, c] = k;
    let root = ((c - a) * (c - a) + 4.0 * b * b).sqrt();
    let major = (f64::midpoint(a + c, root)).sqrt();
    let minor = ((a + c - root) / 2.0).sqrt();
    let tangent = 2.0 * b / (c - a);
    finite(&[("u", u), ("λ1", major), ("λ2", minor), ("tan 2α", tangent)])
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

/// A register that was written on the way.
fn register(probe: &RtlProbe, reg: Reg, component: usize) -> f64 {
    probe.get(reg).get(component).map_or(0.0, |code| code.value())
}

/// Rows of ENV.
fn env(spec: &UnitSpec) -> Vec<Row> {
    let prepared = Prepared::new(&spec.settings(ReferenceAxis::Exact));
    let text = |(face, at): (usize, [f64; 2]),
                lambda: [f64; 2],
                axis: [f64; 2],
                fetch: (i64, f64)| {
        let [u, v] = at.map(number);
        let [l, m] = lambda.map(number);
        let [x, y] = axis.map(number);
        let (probes, lod) = (fetch.0, number(fetch.1));
        format!("{} ({u}, {v}) λ {l}, {m} axis ({x}, {y}) {probes} × LOD {lod}", FACE_NAMES[face])
    };
    let row = |(name, f): (&str, Fragment)| {
        let unit = Unit::new(&spec.config, encode::needs(&f), SIZE).unwrap();
        let mut probe = RtlProbe::default();
        let out = rtl(&unit, &spec.config, &f, None, &mut probe);
        let of = |reg| [register(&probe, reg, 0), register(&probe, reg, 1)];
        let at = [register(&probe, Reg::FaceU, 0), register(&probe, Reg::FaceV, 0)];
        let lod = register(&probe, Reg::FootLod, 0);
        let there = reference::env(&prepared, &f, SIZE as usize, None, &mut NoTap);
        let fetch = (i64::from(there.probes), there.lod);
        Row {
            name: name.into(),
            paper: paper(&f, there.k),
            rtl: text((out.face, at), of(Reg::EigenLambda), of(Reg::EigenAxis), (out.probes, lod)),
            f64: text((there.face, [there.u, there.v]), there.lambda, there.axis, fetch),
            flags: out.flags,
        }
    };
    extremes::env().into_iter().map(row).collect()
}

/// Rows of HIT.
fn hits(spec: &UnitSpec) -> Vec<Row> {
    let settings = spec.settings(ReferenceAxis::Exact);
    let room = Distance::Box(ROOM);
    let rtl = HitRtl::new(spec, &room, None, 256).unwrap();
    let f64 = HitF64::new(&settings, &room, None, 256);
    let row = |(name, ray): (&str, HitFragment)| {
        let mine = rtl.trace(&ray, &mut RtlProbe::default()).0;
        Row {
            name: name.into(),
            paper: hlsl(&ray, spec.config.policy.hit.iterations),
            rtl: found(&mine),
            f64: found(&f64.filter(&[ray], &|_| {})[0]),
            flags: mine.flags,
        }
    };
    extremes::hit().into_iter().map(row).collect()
}

/// Rows of the cones' operations; the formulas are OTK's as its note writes them.
fn cones(spec: &UnitSpec) -> Vec<Row> {
    let cfg = Cfg::new(&spec.config);
    let knobs = &spec.config.policy.cone;
    let pair = |angle: f64, width: f64| format!("α {} w {}", number(angle), number(width));
    let row = |(operation, [a, w], [x, y, z]): (u64, [f64; 2], [f64; 3])| {
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
        let name = OPERATIONS[usize::try_from(operation).unwrap()];
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
    };
    extremes::CONES.into_iter().map(row).collect()
}

/// Rows of TEX.
fn textures(spec: &UnitSpec) -> Vec<Row> {
    let prepared = Prepared::new(&spec.settings(ReferenceAxis::Exact));
    let engine = TexRtl::sized(spec, [SIZE; 2]).unwrap();
    let cfg = &engine.unit.cone;
    let text = |dd: [f64; 4], lambda: [f64; 2], probes: i64, lod: f64| {
        let [a, b, c, d] = dd.map(number);
        let [l, m] = lambda.map(number);
        format!("ddx ({a}, {b}) ddy ({c}, {d}) λ {l}, {m} {probes} × LOD {}", number(lod))
    };
    let row = |(name, request): (&str, Request)| {
        let fragment = fragment(&request);
        let mut flags = Flags::default();
        let ports = [0.0, request.width].map(f64::to_bits);
        let cone = cfg.load(ports, &mut cfg.dither(0), &mut flags);
        let mut probe = RtlProbe::default();
        let (_, out) = engine.lanes::<1, _>(&[words(&fragment, cone)], &mut probe);
        let of = |reg| [register(&probe, reg, 0), register(&probe, reg, 1)];
        let ([a, b], [c, d]) = (of(Reg::SurfDdx), of(Reg::SurfDdy));
        let lod = register(&probe, Reg::FootLod, 0);
        let size = [SIZE as usize; 2];
        let theirs = reference::tex(&prepared, request.width, &fragment, size, None, &mut NoTap);
        let [x, y] = theirs.dd;
        let events = event_names(flags).map(str::to_string);
        Row {
            name: name.into(),
            paper: note(&request),
            rtl: text([a, b, c, d], of(Reg::EigenLambda), out.probes[0], lod),
            f64: text([x[0], x[1], y[0], y[1]], theirs.lambda, theirs.probes.into(), theirs.lod),
            flags: events.chain(engine.flag_names(out.flags[0])).collect(),
        }
    };
    extremes::tex().into_iter().map(row).collect()
}

#[test]
fn the_rows_of_the_extremes_are_what_both_engines_and_the_printed_formulas_make_of_them() {
    let spec = UnitSpec::default();
    let tables = [
        ("ENV", env(&spec)),
        ("HIT", hits(&spec)),
        ("Ray cones", cones(&spec)),
        ("TEX", textures(&spec)),
    ];
    let mut new = String::new();
    for (title, rows) in &tables {
        writeln!(new, "### {title}\n").unwrap();
        writeln!(new, "| row | the paper's formulas in doubles | rtl | f64 | flags of rtl |")
            .unwrap();
        writeln!(new, "|---|---|---|---|---|").unwrap();
        let cell = |text: &str| text.replace('|', "\\|");
        for row in rows {
            let f64 = if row.rtl == row.f64 { "the same" } else { &row.f64 };
            let (name, paper, flags) = (cell(&row.name), cell(&row.paper), row.flags.join(" "));
            writeln!(new, "| {name} | {paper} | {} | {f64} | {flags} |", row.rtl).unwrap();
        }
        writeln!(new).unwrap();
    }
    let path = house::root("docs/studies/extremes.md");
    let text = house::read(&path).replace("\r\n", "\n");
    let (before, rest) = text.split_once("<!-- rows -->\n").expect("a block of rows");
    let (_, behind) = rest.split_once("<!-- end -->\n").expect("its end");
    let new = format!("{before}<!-- rows -->\n{new}<!-- end -->\n{behind}");
    if new != text {
        let bless = std::env::var_os(golden::BLESS).is_some();
        panic!("{}", golden::compare(&path, &new, bless).unwrap_err());
    }
}

/// λ2 by eq. 17 on a K that was rounded to binary32, as a shader has it: the document's column.
#[test]
fn equation_17_in_binary32_is_off_by_what_the_document_says() {
    let text = house::read(&house::root("docs/studies/extremes.md"));
    let rows = text.lines().filter_map(|line| {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let [_, anisotropy, _, _, single, _, _, _] = cells.as_slice() else { return None };
        Some((anisotropy.parse::<f64>().ok()?, single.parse::<f64>().ok()?))
    });
    let mut count = 0;
    for (anisotropy, said) in rows {
        let (l, m) = (0.75, 0.75 / anisotropy);
        let mut worst = 0.0f64;
        for turn in 0..181u8 {
            let angle = std::f64::consts::PI * (f64::from(turn) + 0.37) / 181.0;
            let (sin, cos) = (libm::sin(angle), libm::cos(angle));
            let k = [
                l * l * cos * cos + m * m * sin * sin,
                (l * l - m * m) * cos * sin,
                l * l * sin * sin + m * m * cos * cos,
            ];
            #[expect(clippy::cast_possible_truncation, reason = "binary32 is what is asked for")]
            let [a, b, c] = k.map(|x| x as f32);
            let root = ((c - a) * (c - a) + 4.0 * b * b).sqrt();
            let minor = f64::from(((a + c - root) / 2.0).max(0.0).sqrt());
            worst = worst.max((minor - m).abs() / m);
        }
        // Two digits are printed.
        assert!((worst - said).abs() <= 0.051 * worst, "{anisotropy}: {worst} {said}");
        count += 1;
    }
    assert_eq!(count, 10);
}
