//! `trace SCENE --pixel X,Y`: every register, rtl beside f64.

use std::io::{IsTerminal as _, Write as _};

use rtl_model::Unit;
use rtl_model::fx::Flags;
use rtl_model::regs::Reg;
use serde_json::{Map, Value, json};

use super::job::Job;
use super::json_lines::Op;
use super::trace::{Args, TraceEngine, Tracer};
use super::{Failure, trace_hit, trace_tex};
use crate::base::num;
use crate::cube::{CubeMap, FACE_NAMES};
use crate::distance::Distance;
use crate::engine::hit::HitRtl;
use crate::engine::hit_subject::HitSubject;
use crate::engine::probe::{FloatProbe, RtlProbe, rtl};
use crate::engine::registers::error_lsb;
use crate::engine::tex::{value, words};
use crate::engine::tex_subject::{TexEngine, TexSubject};
use crate::engine::{Subject, encode};
use crate::error::InputError;
use crate::fragment::{Fragment, Tangents, TexFragment};
use crate::reference::{PlanarTexture, Prepared, Texture, env, tex};
use crate::report::table::{Align, Table, significant};
use crate::scene::tex::path::Look;
use crate::settings::Settings;
use crate::unit::{UnitSpec, refused};

/// Components of a register that fit on a row.
const SHOWN: usize = 6;

/// One pixel through both engines.
struct Traced {
    /// The input as a trace line has it.
    entries: Map<String, Value>,
    op: Op,
    mine: RtlProbe,
    theirs: FloatProbe,
    /// The table's last line.
    closing: String,
    map: CubeMap,
    distance: Option<Distance>,
    texture_size: Option<[usize; 2]>,
}

fn no_surface((x, y): (u32, u32)) -> InputError {
    InputError::new(
        "--pixel",
        "a pixel that shows the surface",
        format!("{x},{y}, which shows the background"),
        "choose another pixel",
    )
}

/// "rtl / f64" of what both found.
fn closing(face: [&str; 2], probes: [u32; 2], flags: [String; 2]) -> String {
    format!(
        "face {} / {}, probes {} / {}, flags [{}] / [{}]",
        face[0], face[1], probes[0], probes[1], flags[0], flags[1]
    )
}

fn trace_env(
    subject: Subject,
    spec: &UnitSpec,
    settings: &Settings,
    (x, y): (u32, u32),
) -> Result<Traced, InputError> {
    let Some(found) = subject.scene.fragments.iter().find(|f| f.pixel == [x, y]) else {
        return Err(no_surface((x, y)));
    };
    let fragment = found.fragment;
    let needs = encode::needs(&fragment);
    let size = num::u32(subject.map.size());
    let unit = Unit::new(&spec.config, needs, size).map_err(refused)?;
    let texture = encode::texture(&spec.config, &subject.map).map_err(refused)?;
    let mut mine = RtlProbe::default();
    let result = rtl(&unit, &spec.config, &fragment, Some(&texture), &mut mine);
    let mut theirs = FloatProbe::default();
    let reference = Texture::new(&subject.map);
    let there =
        env(&Prepared::new(settings), &fragment, subject.map.size(), Some(&reference), &mut theirs);
    let names: Vec<&str> = there.flags.names().collect();
    Ok(Traced {
        entries: entries(&fragment),
        op: Op::Env(fragment),
        mine,
        theirs,
        closing: closing(
            [FACE_NAMES[result.face], FACE_NAMES[there.face]],
            [num::u32(result.probes), there.probes],
            [result.flags.join(" "), names.join(" ")],
        ),
        map: subject.map,
        distance: None,
        texture_size: None,
    })
}

/// The first ray of a pixel.
fn trace_ray(
    subject: HitSubject,
    spec: &UnitSpec,
    settings: &Settings,
    (x, y): (u32, u32),
) -> Result<Traced, InputError> {
    let Some(found) = subject.scene.rays.iter().find(|ray| ray.pixel == [x, y]) else {
        return Err(no_surface((x, y)));
    };
    let ray = found.fragment;
    let size = subject.map.size();
    let engine = HitRtl::new(spec, &subject.distance, Some(&subject.map), size)?;
    let mut mine = RtlProbe::default();
    let (here, face) = engine.trace(&ray, &mut mine);
    let mut theirs = FloatProbe::default();
    let there = subject.reference(settings).trace(&ray, &mut theirs);
    let env = there.env;
    let flags = env.map_or(there.hit.flags, |env| env.flags);
    let names: Vec<&str> = flags.names().collect();
    let search = format!(
        "search {} after {} look-ups / {} after {}; ",
        here.status.name(),
        here.iterations,
        there.hit.status.name(),
        there.hit.iterations
    );
    let mut entries = Map::new();
    entries.insert("op".into(), json!("hit"));
    entries.insert("x".into(), json!(ray.x));
    entries.insert("r".into(), json!(ray.r));
    if let Some(cone) = ray.cone {
        entries.insert("cone".into(), json!(cone));
    }
    Ok(Traced {
        entries,
        op: Op::Hit(ray),
        mine,
        theirs,
        closing: search
            + &closing(
                [face, env.map_or("-", |env| FACE_NAMES[env.face])],
                [here.probes, env.map_or(0, |env| env.probes)],
                [here.flags.join(" "), names.join(" ")],
            ),
        map: subject.map,
        distance: Some(subject.distance),
        texture_size: None,
    })
}

/// The first texture request of a pixel.
fn trace_look(
    subject: TexSubject,
    spec: &UnitSpec,
    settings: &Settings,
    (x, y): (u32, u32),
) -> Result<Traced, InputError> {
    let engine = TexEngine::new(spec, &subject)?;
    let [column, row] = [x, y].map(num::usize);
    let mut found: Option<(Look, [f64; 2])> = None;
    subject.each_look(&engine, settings, row, &mut |at, look, words, width| {
        if at == column && found.is_none() {
            let unit = &engine.textures[look.texture];
            found = Some((*look, [value(unit.unit.cone.angle(words.cone.angle)), width]));
        }
    });
    let Some((look, cone)) = found else {
        return Err(no_surface((x, y)));
    };
    // A line has derivatives; those of a triangle follow from its corners.
    let (dp_ds, dp_dt) = look.fragment.tangents.derivatives();
    let fragment = TexFragment { tangents: Tangents::Surface { dp_ds, dp_dt }, ..look.fragment };
    let unit = &engine.textures[look.texture];
    let cfg = &unit.unit.cone;
    let mut flags = Flags::default();
    let loaded = cfg.load(cone.map(f64::to_bits), &mut cfg.dither(0), &mut flags);
    let mut mine = RtlProbe::default();
    let (_, out) = unit.lanes::<1, _>(&[words(&fragment, loaded)], &mut mine);
    let texture = PlanarTexture::new(&subject.scene.textures[look.texture], settings.tex.wrap);
    let mut theirs = FloatProbe::default();
    let there = tex(
        &Prepared::new(settings),
        cone[1],
        &fragment,
        texture.level_size(0),
        Some(&texture),
        &mut theirs,
    );
    let names: Vec<&str> = there.flags.names().collect();
    let mut entries = Map::new();
    entries.insert("op".into(), json!("tex"));
    entries.insert("cone".into(), json!(cone));
    entries.insert("d".into(), json!(fragment.d));
    entries.insert("n".into(), json!(fragment.n));
    entries.insert("dp_ds".into(), json!(dp_ds));
    entries.insert("dp_dt".into(), json!(dp_dt));
    let probes = num::u32(out.probes[0]);
    Ok(Traced {
        entries,
        op: Op::Tex(fragment, cone),
        mine,
        theirs,
        closing: format!(
            "texture {}, {} bounces before; probes {probes} / {}, flags [{}] / [{}]",
            look.texture,
            look.bounce,
            there.probes,
            unit.flags(&out, 0).join(" "),
            names.join(" ")
        ),
        texture_size: Some(subject.scene.textures[look.texture].size()),
        map: subject.sky,
        distance: None,
    })
}

pub(super) fn run(
    args: &Args,
    spec: UnitSpec,
    scene: &str,
    (x, y): (u32, u32),
) -> Result<(), Failure> {
    let settings = args.run.settings(&spec);
    let job = Job::load(scene, &args.scene_args, &settings)?;
    let inside = |c: u32, n: usize| usize::try_from(c).is_ok_and(|c| c < n);
    let [width, height] = job.size();
    if !inside(x, width) || !inside(y, height) {
        return Err(InputError::new(
            "--pixel",
            format!("a pixel of the {width}x{height} picture"),
            format!("{x},{y}"),
            "columns and rows count from 0, top left",
        )
        .into());
    }
    let traced = match job {
        Job::Env(subject) => trace_env(*subject, &spec, &settings, (x, y))?,
        Job::Hit(subject) => trace_ray(*subject, &spec, &settings, (x, y))?,
        Job::Tex(subject) => trace_look(*subject, &spec, &settings, (x, y))?,
    };
    let (mine, theirs) = (&traced.mine, &traced.theirs);

    let mut out = std::io::stdout().lock();
    if args.lines || !out.is_terminal() {
        let hash = spec.hash();
        let mut tracer = Tracer::new(args.mode(&spec), spec, Some(traced.map), 1)?;
        tracer.distance = traced.distance;
        if let Some(size) = traced.texture_size {
            tracer.texture_size = size;
        }
        let mut object = traced.entries;
        let mut fields = match &traced.op {
            Op::Env(fragment) => tracer.out(fragment)?,
            Op::Hit(ray) => trace_hit::out(&mut tracer, ray)?,
            Op::Tex(fragment, cone) => trace_tex::out(&mut tracer, fragment, *cone)?,
        };
        fields.insert("registers".into(), registers(args, mine, theirs));
        fields.insert("version".into(), json!(env!("CARGO_PKG_VERSION")));
        fields.insert("unit_hash".into(), json!(hash));
        fields.insert("seed".into(), json!(0));
        object.insert("out".into(), Value::Object(fields));
        writeln!(out, "{}", Value::Object(object))?;
        return Ok(());
    }
    writeln!(
        out,
        "{scene} pixel {x},{y}; tapline {}, unit {}, seed 0",
        env!("CARGO_PKG_VERSION"),
        spec.hash()
    )?;
    let mut table = Table::new(&[
        ("register", Align::Left),
        ("rtl", Align::Left),
        ("f64", Align::Left),
        ("error (LSB)", Align::Right),
    ]);
    for reg in Reg::ALL {
        let codes = mine.get(*reg);
        if codes.is_empty() {
            continue;
        }
        let floats = theirs.get(*reg);
        let info = reg.info();
        let join = |values: Vec<f64>| {
            let more = if values.len() > SHOWN { " …" } else { "" };
            let shown: Vec<String> =
                values.iter().take(SHOWN).map(|v| significant(*v, 5)).collect();
            format!("{}{more}", shown.join(" "))
        };
        let worst = codes
            .iter()
            .zip(floats)
            .filter(|(c, _)| c.is_written())
            .map(|(c, f)| error_lsb(*c, *f))
            .fold(0.0, f64::max);
        table.row([
            format!("{}.{}", info.stage, info.name),
            join(codes.iter().filter(|c| c.is_written()).map(|c| c.value()).collect()),
            join(floats.to_vec()),
            if floats.is_empty() { "-".into() } else { significant(worst, 3) },
        ]);
    }
    writeln!(out, "{table}")?;
    writeln!(out, "{}", traced.closing)?;
    Ok(())
}

/// The fragment as a trace line has it.
fn entries(f: &Fragment) -> Map<String, Value> {
    let mut map = Map::new();
    map.insert("op".into(), json!("env"));
    for (key, value) in [
        ("v", f.v),
        ("n", f.n),
        ("dv_dx", f.dv_dx),
        ("dv_dy", f.dv_dy),
        ("dn_dx", f.dn_dx),
        ("dn_dy", f.dn_dy),
    ] {
        map.insert(key.into(), json!(value));
    }
    if let Some(h) = f.h {
        map.insert("h".into(), json!(h));
    }
    if let Some(b) = f.bump {
        map.insert("bump".into(), json!(b));
    }
    if let Some(d) = f.rough {
        map.insert("rough".into(), json!(d));
    }
    map
}

/// Every register as `stage.name`: components of the chosen engine.
fn registers(args: &Args, mine: &RtlProbe, theirs: &FloatProbe) -> Value {
    let mut map = Map::new();
    for reg in Reg::ALL {
        let info = reg.info();
        let values: Vec<Value> = match args.engine {
            TraceEngine::Rtl => mine
                .get(*reg)
                .iter()
                .map(|c| {
                    if !c.is_written() {
                        Value::Null
                    } else if args.raw {
                        json!({"raw": c.raw, "frac": c.frac})
                    } else {
                        Value::Number(serde_json::Number::from_string_unchecked(c.decimal()))
                    }
                })
                .collect(),
            TraceEngine::F64 => theirs.get(*reg).iter().map(|v| json!(v)).collect(),
        };
        if !values.is_empty() {
            map.insert(format!("{}.{}", info.stage, info.name), Value::Array(values));
        }
    }
    Value::Object(map)
}
