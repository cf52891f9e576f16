//! `trace SCENE --pixel X,Y`: every register, rtl beside f64.

use std::io::{IsTerminal as _, Write as _};

use rtl_model::Unit;
use rtl_model::regs::Reg;
use serde_json::{Map, Value, json};

use super::trace::{Args, TraceEngine, Tracer};
use super::{Failure, subject};
use crate::engine::encode;
use crate::engine::probe::{FloatProbe, RtlProbe, rtl};
use crate::engine::registers::error_lsb;
use crate::error::InputError;
use crate::fragment::Fragment;
use crate::reference::{Prepared, Texture, env};
use crate::report::table::{Align, Table, significant};
use crate::unit::{UnitSpec, refused};

/// Components of a register that fit on a row.
const SHOWN: usize = 6;

pub(super) fn run(
    args: &Args,
    spec: UnitSpec,
    scene: &str,
    (x, y): (u32, u32),
) -> Result<(), Failure> {
    let settings = args.run.settings(&spec);
    let subject = subject::load(scene, &args.scene_args, &settings)?;
    let inside = |c: u32, n: usize| usize::try_from(c).is_ok_and(|c| c < n);
    if !inside(x, subject.scene.width) || !inside(y, subject.scene.height) {
        return Err(InputError::new(
            "--pixel",
            format!(
                "a pixel of the {}x{} picture",
                subject.scene.width, subject.scene.height
            ),
            format!("{x},{y}"),
            "columns and rows count from 0, top left",
        )
        .into());
    }
    let Some(found) = subject.scene.fragments.iter().find(|f| f.pixel == [x, y]) else {
        return Err(InputError::new(
            "--pixel",
            "a pixel that shows the surface",
            format!("{x},{y}, which shows the background"),
            "choose another pixel",
        )
        .into());
    };
    let fragment = found.fragment;
    let needs = encode::needs(&fragment);
    let size = u32::try_from(subject.map.size()).unwrap_or(u32::MAX);
    let unit = Unit::new(&spec.config, needs, size).map_err(refused)?;
    let texture = encode::texture(&spec.config, &subject.map).map_err(refused)?;
    let mut mine = RtlProbe::default();
    let result = rtl(&unit, &spec.config, &fragment, Some(&texture), &mut mine);
    let mut theirs = FloatProbe::default();
    let reference = Texture::new(&subject.map);
    let there = env(
        &Prepared::new(&settings),
        &fragment,
        subject.map.size(),
        Some(&reference),
        &mut theirs,
    );

    let mut out = std::io::stdout().lock();
    if args.lines || !out.is_terminal() {
        let hash = spec.hash();
        let mut tracer = Tracer::new(args, spec, Some(subject.map), 1)?;
        let mut object = entries(&fragment);
        let mut fields = tracer.out(&fragment)?;
        fields.insert("registers".into(), registers(args, &mine, &theirs));
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
            let shown: Vec<String> = values
                .iter()
                .take(SHOWN)
                .map(|v| significant(*v, 5))
                .collect();
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
            join(
                codes
                    .iter()
                    .filter(|c| c.is_written())
                    .map(|c| c.value())
                    .collect(),
            ),
            join(floats.to_vec()),
            if floats.is_empty() {
                "-".into()
            } else {
                significant(worst, 3)
            },
        ]);
    }
    writeln!(out, "{table}")?;
    let names: Vec<&str> = there.flags.names().collect();
    writeln!(
        out,
        "face {} / {}, probes {} / {}, flags [{}] / [{}]",
        crate::cube::FACE_NAMES[result.face],
        crate::cube::FACE_NAMES[there.face],
        result.probes,
        there.probes,
        result.flags.join(" "),
        names.join(" ")
    )?;
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
            map.insert(
                format!("{}.{}", info.stage, info.name),
                Value::Array(values),
            );
        }
    }
    Value::Object(map)
}
