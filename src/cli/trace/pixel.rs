//! `trace SCENE --pixel X,Y`: every register, rtl next to f64.

use std::io::{IsTerminal as _, Write as _};

use rtl_model::regs::Reg;
use serde_json::{Value, json};

use super::record::{Number, Place, Record};
use super::request::Request;
use super::{Memories, TraceEngine, Tracer};
use crate::base::num;
use crate::cli::Failure;
use crate::engine::Job;
use crate::engine::job::tex::TexEngine;
use crate::engine::tex::value;
use crate::error::InputError;
use crate::fragment::{Tangents, TexFragment};
use crate::report::table::{Table, digits, missing, significant, text};
use crate::settings::Settings;
use crate::unit::UnitSpec;

/// Components of a register that fit on a row.
const SHOWN: usize = 6;

/// How a pixel is printed.
pub(super) struct Output {
    /// Engine of the JSON line.
    pub(super) engine: TraceEngine,
    /// Codes instead of decimals.
    pub(super) raw: bool,
    /// A JSON line even on a terminal.
    pub(super) line: bool,
}

/// The first request of a pixel with the memories that it reads, and what the table says of it.
fn first(
    job: Job,
    spec: &UnitSpec,
    pixel: [u32; 2],
) -> Result<Option<(Request, Memories, String)>, InputError> {
    let [column, row] = pixel.map(num::usize);
    Ok(match job {
        Job::Env(subject) => {
            let found = subject.scene.fragments.iter().find(|f| f.pixel == pixel);
            let request = found.map(|found| Request::Env(found.fragment));
            request.map(|request| (request, Memories::of_map(Some(subject.map), 1), String::new()))
        }
        Job::Hit(subject) => {
            let found = subject.scene.rays.iter().find(|ray| ray.pixel == pixel);
            let request = found.map(|found| Request::Hit(found.fragment));
            let memories = Memories {
                distance: Some(subject.distance),
                ..Memories::of_map(Some(subject.map), 1)
            };
            request.map(|request| (request, memories, String::new()))
        }
        Job::Tex(mut subject) => {
            let engine = TexEngine::new(spec, &subject)?;
            let mut found = None;
            subject.each_look(&engine, row, &mut |at, look, words, width| {
                if at == column && found.is_none() {
                    let unit = &engine.textures[look.texture].unit;
                    found = Some((*look, [value(unit.cone.angle(words.cone.angle)), width]));
                }
            });
            found.map(|(look, cone)| {
                // A line has derivatives; those of a triangle follow from its corners.
                let (dp_ds, dp_dt) = look.fragment.tangents.derivatives();
                let tangents = Tangents::Surface { dp_ds, dp_dt };
                let map = subject.scene.textures.swap_remove(look.texture);
                let memories = Memories {
                    texture_size: map.size(),
                    planar: Some(map),
                    ..Memories::of_map(Some(subject.sky), 1)
                };
                let about = format!("texture {}, {} bounces before; ", look.texture, look.bounce);
                (Request::Tex(TexFragment { tangents, ..look.fragment }, cone), memories, about)
            })
        }
    })
}

pub(super) fn run(
    job: Job,
    (spec, settings): (&UnitSpec, &Settings),
    scene: &str,
    (x, y): (u32, u32),
    output: &Output,
) -> Result<(), Failure> {
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
    let Some((request, memories, about)) = first(job, spec, [x, y])? else {
        return Err(InputError::new(
            "--pixel",
            "a pixel that shows the surface",
            format!("{x},{y}, which shows the background"),
            "choose another pixel",
        )
        .into());
    };
    let tracer = |engine| Tracer::new(engine, spec, settings, &memories);
    let mut out = std::io::stdout().lock();
    if output.line || !out.is_terminal() {
        let mut tracer = tracer(output.engine)?;
        let record = tracer.answer(&request)?;
        let mut fields = record.out(output.raw);
        fields.insert("registers".into(), record.registers(output.raw));
        fields.insert("version".into(), json!(env!("CARGO_PKG_VERSION")));
        fields.insert("unit_hash".into(), json!(spec.hash()));
        fields.insert("seed".into(), json!(0));
        let mut object = request.entries();
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
    let [mut rtl, mut f64] = [tracer(TraceEngine::Rtl)?, tracer(TraceEngine::F64)?];
    let (rtl, f64) = (rtl.answer(&request)?, f64.answer(&request)?);
    writeln!(out, "{}", table(&rtl, &f64))?;
    writeln!(out, "{about}{}", closing(&rtl, &f64))?;
    Ok(())
}

/// Every register of the unit beside the reference's.
fn table(rtl: &Record<'_>, f64: &Record<'_>) -> Table {
    let shown = |numbers: &[Number]| {
        let values: Vec<f64> = numbers.iter().filter_map(|n| n.value()).collect();
        let more = if values.len() > SHOWN { " …" } else { "" };
        let shown: Vec<String> = values.iter().take(SHOWN).map(|v| significant(*v, 5)).collect();
        text(format!("{}{more}", shown.join(" ")))
    };
    let registers = Reg::ALL.iter().map(|reg| (reg, [rtl, f64].map(|r| r.registers.get(*reg))));
    Table::of(
        registers.filter(|(_, [mine, _])| !mine.is_empty()),
        &[
            ("register", "", &|(reg, _)| text(reg)),
            ("rtl", "", &|(_, [mine, _])| shown(mine)),
            ("f64", "", &|(_, [_, theirs])| shown(theirs)),
            ("error (LSB)", "", &|(_, [mine, theirs])| {
                let pairs = mine.iter().zip(theirs);
                let errors = pairs.filter_map(|(mine, exact)| mine.error_lsb(*exact));
                let worst = errors.fold(0.0, f64::max);
                if theirs.is_empty() { missing("-") } else { digits(worst, 3) }
            }),
        ],
    )
}

/// "rtl / f64" of what both found.
fn closing(rtl: &Record<'_>, f64: &Record<'_>) -> String {
    let mut text = String::new();
    if let (Some(rtl), Some(f64)) = (rtl.search, f64.search) {
        text += &format!(
            "search {} after {} look-ups / {} after {}; ",
            rtl.status.name(),
            rtl.iterations,
            f64.status.name(),
            f64.iterations
        );
    }
    if rtl.place != Some(Place::Surface) {
        text += &format!("face {} / {}, ", rtl.face(), f64.face());
    }
    text + &format!(
        "probes {} / {}, flags [{}] / [{}]",
        rtl.probes,
        f64.probes,
        rtl.flags.join(" "),
        f64.flags.join(" ")
    )
}
