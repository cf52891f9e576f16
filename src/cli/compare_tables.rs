//! The results of `compare`, as JSON and as tables on stdout.

use std::collections::BTreeMap;
use std::io::Write;

use rtl_model::regs::Reg;
use serde_json::{Map, Value, json};

use super::Failure;
use super::compare::{Args, Results};
use super::compare_summary;
use super::output::{Origin, unit_json};
use crate::base::num;
use crate::caustic::difference;
use crate::engine::gpu::check::StageChecks;
use crate::engine::job::lit::Caustics;
use crate::engine::registers::RegisterErrors;
use crate::engine::{EngineKind, Job};
use crate::report::motion::Motion;
use crate::report::table::{
    Table, count, digits, given, grouped, missing, places, significant, text, value, whole,
};
use crate::settings::Settings;
use crate::taken::Taken;
use crate::unit::UnitSpec;

#[expect(clippy::cast_precision_loss, reason = "counts become rates")]
pub(super) fn per(total: u64, parts: u64) -> f64 {
    total as f64 / parts.max(1) as f64
}

fn flags(results: &Results) -> BTreeMap<String, u64> {
    let rendered = results.get(EngineKind::Rtl).map(|r| r.flags.clone()).unwrap_or_default();
    results.load_flags.clone().into_iter().chain(rendered).collect()
}

/// The results as `--json` writes them and the report shows them.
pub(super) fn to_json(
    args: &Args,
    origin: &Origin,
    spec: &UnitSpec,
    job: &Job,
    results: &Results,
) -> Value {
    let fragments = job.fragments();
    let names = results.renderings.iter().map(|(kind, _)| kind.name().to_string());
    let engines: Map<String, Value> = names.zip(engines(results, fragments).json()).collect();
    let pairs: Vec<Value> =
        results.pairs.iter().map(|(a, b, p)| p.to_json(a.name(), b.name())).collect();
    let skipped = results.skipped.iter().map(|s| json!({"engine": s.kind.name(), "why": s.why}));
    let mut value = origin.object(json!({
        "scene": args.scene,
        "size": job.size(),
        "env": args.scene_args.env.as_ref().map(|p| p.display().to_string()),
        "inputs": results.inputs.iter().map(input_json).collect::<Vec<_>>(),
        "face_size": job.map().size(),
        "fragments": fragments,
        "unit": unit_json(spec),
        "engines": engines,
        "pairs": pairs,
        "motions": results.motions.iter().map(|(kind, motion)| motion_json(*kind, motion)).collect::<Vec<_>>(),
        "shift": args.shift,
        "registers": results.registers.as_ref().map_or(Vec::new(), |e| registers(e).json()),
        "stages": results.stages.as_ref().map(stages_json),
        "flags": flags(results),
        "caustic": results.caustics.as_ref().map(caustic_json),
        "skipped": skipped.collect::<Vec<_>>(),
        "adapter": results.adapter,
    }));
    if let Value::Object(map) = &mut value {
        // A run that has none of these has no key for it.
        let moved = args.shift.is_some();
        map.retain(|key, value| match key.as_str() {
            "motions" | "shift" => moved,
            "stages" | "caustic" => !value.is_null(),
            _ => true,
        });
    }
    value
}

/// An engine's motion against that of the truth.
fn motion_json(kind: EngineKind, m: &Motion) -> Value {
    let Motion { flicker_db, act, fragments } = m;
    json!({"a": kind.name(), "b": "truth", "flicker_db": flicker_db, "act": act, "fragments": fragments})
}

/// What an input file was taken for.
fn input_json(taken: &Taken) -> Value {
    json!({
        "option": taken.option,
        "file": taken.file,
        "kind": taken.kind,
        "from": taken.from,
        "transfer": taken.transfer,
        "window": taken.window,
        "remarks": taken.remarks,
        "decided_by": taken.flags,
        "line": taken.to_string(),
    })
}

/// How fast each engine was and what it read.
fn engines(results: &Results, fragments: u64) -> Table {
    Table::of(
        &results.renderings,
        &[
            ("engine", "", &|(kind, _)| text(kind.name())),
            ("seconds", "seconds", &|(_, r)| digits(r.seconds, 3)),
            ("fragments/s", "fragments_per_second", &|(_, r)| {
                digits(per(fragments, 1) / r.seconds.max(1e-9), 3)
            }),
            ("probes/fragment", "", &|(_, r)| digits(per(r.probes, fragments), 3)),
            ("texels/fragment", "texels_per_fragment", &|(_, r)| {
                digits(per(r.texels, fragments), 3)
            }),
            ("", "probes_per_fragment", &|(_, r)| value(per(r.probes, fragments))),
            ("", "flags", &|(_, r)| value(&r.flags)),
            ("", "standard_error", &|(_, r)| given(r.standard_error)),
            ("", "beyond_f32", &|(_, r)| {
                let object =
                    |(fragments, pixel)| json!({"fragments": fragments, "first_pixel": pixel});
                given(r.beyond_f32.map(object))
            }),
            ("", "hit", &|(_, r)| {
                given(r.searches.as_ref().map(|s| {
                    json!({"status": s.status, "look_ups_per_ray": s.look_ups(), "overshot": s.overshot})
                }))
            }),
            ("", "tiles", &|(_, r)| {
                let tiles = r.texture_use.iter().flat_map(|u| &u.tiles);
                let tiles: Vec<Value> =
                    tiles.map(|t| json!({"total": t.total(), "by_level": t.counts()})).collect();
                given((!tiles.is_empty()).then_some(tiles))
            }),
        ],
    )
}

/// Touched tiles of 64 × 64 texels, texture by texture.
fn print_tiles(out: &mut impl Write, results: &Results) -> Result<(), Failure> {
    for (kind, r) in &results.renderings {
        let tiles = r.texture_use.iter().flat_map(|u| &u.tiles);
        for (index, tiles) in tiles.enumerate() {
            let by: Vec<String> = tiles.counts().iter().map(ToString::to_string).collect();
            writeln!(
                out,
                "{}: texture {index}: {} tiles of 64x64 texels ({} by level)",
                kind.name(),
                count(num::u64(tiles.total())),
                by.join(" ")
            )?;
        }
    }
    Ok(())
}

/// The ladder's name of a caustic's maker: `truth` is real rays.
fn caustic_json(caustics: &Caustics) -> Value {
    let names = caustics.by.iter().map(|(kind, _)| kind.name().to_string());
    let by: Map<String, Value> = names.zip(caustic(caustics).json()).collect();
    let pairs = caustics.by.iter().zip(caustics.by.iter().skip(1)).map(|((a, x), (b, y))| {
        json!({"a": a.name(), "b": b.name(), "relative_rms": difference(&x.map, &y.map)})
    });
    json!({"photons": caustics.photons, "engines": by, "pairs": pairs.collect::<Vec<_>>()})
}

/// The caustic, engine by engine, each beside the next.
fn caustic(caustics: &Caustics) -> Table {
    let next = caustics.by.iter().skip(1).map(|(_, next)| Some(next)).chain([None]);
    Table::of(
        caustics.by.iter().zip(next),
        &[
            ("caustic", "", &|((kind, _), _)| text(kind.name())),
            ("photons that landed", "landed", &|((_, c), _)| {
                whole(format!("{} of {}", c.landed, caustics.photons)).with(c.landed)
            }),
            ("their power (G)", "power_of_the_landed", &|((_, c), _)| {
                digits(c.power[1], 5).with(c.power)
            }),
            ("on the walls (G)", "power_on_the_walls", &|((_, c), _)| {
                digits(c.map.power()[1], 5).with(c.map.power())
            }),
            ("RMS from the next (%)", "", &|((_, c), next)| {
                let apart = next.map(|next| 100.0 * difference(&c.map, &next.map));
                apart.map_or(missing("-"), |a| digits(a, 3))
            }),
        ],
    )
}

/// The registers of the stages' own kernels.
fn stages(stages: &StageChecks) -> Table {
    Table::of(
        stages.rows.iter().filter(|r| r.compared > 0),
        &[
            ("register (gpu - f64, stage by stage)", "", &|r| {
                text(format!("{}.{}", r.stage.name(), r.register))
            }),
            ("", "stage", &|r| value(r.stage.name())),
            ("", "register", &|r| value(r.register)),
            ("compared", "compared", &|r| grouped(r.compared)),
            ("worst (2^-23 of it)", "worst_ulp", &|r| digits(r.worst_ulp, 3)),
            ("worst (of tolerance)", "worst_share", &|r| digits(r.worst_share, 3)),
            ("undecided", "undecided", &|r| grouped(r.undecided)),
            ("no bound", "unbounded", &|r| grouped(r.unbounded)),
            ("unexplained", "unexplained", &|r| grouped(r.unexplained)),
        ],
    )
}

fn stages_json(found: &StageChecks) -> Value {
    let first = found.first.as_ref().map(|d| {
        json!({
            "stage": d.stage.name(), "register": d.register, "pixel": d.pixel,
            "rtl": d.rtl, "gpu": d.gpu, "f64": d.f64, "tolerance": d.tolerance, "operands": d.operands,
        })
    });
    let registers = stages(found).json();
    json!({"fragments": found.fragments, "registers": registers, "first_difference": first})
}

/// The registers of the stages' own kernels, and the first that nothing explains.
fn print_stages(out: &mut impl Write, found: &StageChecks, whole: bool) -> Result<(), Failure> {
    if whole {
        writeln!(out, "\n{}", stages(found))?;
    }
    let Some(d) = &found.first else {
        writeln!(out, "gpu - f64: no difference of a stage's register is unexplained")?;
        return Ok(());
    };
    let [x, y] = d.pixel;
    let (stage, register) = (d.stage.name(), d.register);
    writeln!(out, "first unexplained difference: {stage}.{register} at pixel {x},{y}")?;
    for (name, values) in [("gpu", &d.gpu), ("f64", &d.f64), ("tolerance", &d.tolerance)] {
        writeln!(out, "  {name:9} {values:?}")?;
    }
    if let Some(rtl) = &d.rtl {
        writeln!(out, "  rtl       {rtl:?} (behind its own stages)")?;
    }
    let operands: Vec<String> = d.operands.iter().map(|w| format!("{w:08x}")).collect();
    writeln!(out, "  operands  {}", operands.join(" "))?;
    Ok(())
}

/// How the searches of the HIT operation ended, by engine.
fn searches(results: &Results) -> Table {
    Table::of(
        results.renderings.iter().filter_map(|(kind, r)| Some((kind, r.searches.as_ref()?))),
        &[
            ("search", "", &|(kind, _)| text(kind.name())),
            ("look-ups/ray", "", &|(_, s)| digits(s.look_ups(), 3)),
            ("rays with an overshoot", "", &|(_, s)| grouped(s.overshot)),
            ("rays by status", "", &|(_, s)| {
                let status = s.status.iter().map(|(name, n)| format!("{name} {}", count(*n)));
                text(status.collect::<Vec<_>>().join(", "))
            }),
        ],
    )
}

/// How far each engine is from the next.
fn ladder(results: &Results) -> Table {
    Table::of(
        &results.pairs,
        &[
            ("pair", "", &|(a, b, _)| text(format!("{} - {}", a.name(), b.name()))),
            ("PSNR (dB)", "", &|(.., p)| {
                p.psnr_db.map_or(missing("identical"), |db| places(db, 2))
            }),
            ("max (8-bit steps)", "", &|(.., p)| digits(p.max_lsb8, 3)),
            ("RMS (8-bit steps)", "", &|(.., p)| digits(255.0 * p.rmse, 3)),
            ("rel. MSE", "", &|(.., p)| digits(p.rel_mse, 3)),
            (">1 step (%)", "", &|(.., p)| digits(100.0 * p.share_over_1_lsb8, 3)),
            ("FLIP", "", &|(.., p)| p.flip.map_or(missing("-"), |f| digits(f, 3))),
        ],
    )
}

/// Each engine's motion against that of the truth.
fn motions(results: &Results) -> Table {
    Table::of(
        &results.motions,
        &[
            ("motion", "", &|(kind, _)| text(format!("{} - truth", kind.name()))),
            ("flicker (dB)", "", &|(_, m)| {
                m.flicker_db.map_or(missing("identical"), |db| places(db, 2))
            }),
            ("act", "", &|(_, m)| m.act.map_or(missing("-"), |act| places(act, 3))),
            ("fragments", "", &|(_, m)| grouped(num::u64(m.fragments))),
        ],
    )
}

/// Registers of rtl against the reference's.
fn registers(errors: &RegisterErrors) -> Table {
    Table::of(
        Reg::ALL.iter().map(|reg| reg.info()).zip(&errors.registers).filter(|(_, e)| e.count > 0),
        &[
            ("register (rtl - f64)", "", &|(reg, _)| text(format!("{}.{}", reg.stage, reg.name))),
            ("", "stage", &|(reg, _)| value(reg.stage.name())),
            ("", "register", &|(reg, _)| value(reg.name)),
            ("worst (LSB)", "worst_lsb", &|(_, e)| digits(e.worst_lsb, 3)),
            ("mean (LSB)", "mean_lsb", &|(_, e)| digits(e.mean_lsb(), 3)),
            ("pixel of the worst", "pixel", &|(_, e)| {
                whole(format!("{},{}", e.pixel[0], e.pixel[1])).with(e.pixel)
            }),
        ],
    )
}

/// The results as tables on stdout.
pub(super) fn print_tables(
    args: &Args,
    spec: &UnitSpec,
    job: &Job,
    results: &Results,
    settings: &Settings,
) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    let fragments = job.fragments();
    let origin = match &args.scene_args.texture {
        Some(_) => job.origin().replace("procedural textures, ", ""),
        None => job.origin().to_owned(),
    };
    let env = args.scene_args.env.as_ref().map_or(origin, |p| p.display().to_string());
    let size = job.map().size();
    let [width, height] = job.size();
    writeln!(
        out,
        "{} {width}x{height}, {} fragments; {env}, 6 faces of {size}x{size}; tapline {}, unit {}, seed 0",
        args.scene,
        count(fragments),
        env!("CARGO_PKG_VERSION"),
        spec.hash()
    )?;
    for input in &results.inputs {
        writeln!(out, "{input}")?;
    }
    writeln!(out)?;
    compare_summary::print(&mut out, spec, job, results, args.scene_args.exposure)?;
    let axis = if settings.reference_table.is_some() {
        "the angle table's axis"
    } else {
        "the exact axis"
    };
    writeln!(
        out,
        "f64 and ewa use {axis}; probes of f64 carry the trilinear filter's own blur, which ewa has not\n"
    )?;
    for table in [ladder(results), motions(results), engines(results, fragments), searches(results)]
    {
        if !table.is_empty() {
            writeln!(out, "{table}")?;
        }
    }
    print_tiles(&mut out, results)?;
    if let Some(caustics) = &results.caustics {
        writeln!(out, "{}", caustic(caustics))?;
    }
    if let Some(error) = results.get(EngineKind::Truth).and_then(|r| r.standard_error) {
        writeln!(out, "truth: RMS standard error {} (linear)", significant(error, 3))?;
    }
    if let (true, Some(errors)) = (args.registers, &results.registers) {
        writeln!(out, "\n{}", registers(errors))?;
        writeln!(
            out,
            "{} fragments on another face, {} with another probe count, {} with a probe on another texel: \
             not compared behind that",
            count(errors.other_face),
            count(errors.other_count),
            count(errors.other_texel)
        )?;
        if errors.other_search > 0 {
            let rays = count(errors.other_search);
            writeln!(out, "{rays} rays whose search went another way: not compared at all")?;
        }
    }
    if let Some(stages) = &results.stages {
        print_stages(&mut out, stages, args.registers)?;
    }
    for (name, n) in flags(results) {
        writeln!(out, "flag {name}: {} fragments", count(n))?;
    }
    if let Some(adapter) = &results.adapter {
        writeln!(out, "gpu: {adapter}")?;
    }
    for (kind, r) in &results.renderings {
        if let Some((fragments, [x, y])) = r.beyond_f32 {
            writeln!(
                out,
                "{}: {} fragments left the range of f32, the first at pixel {x},{y}",
                kind.name(),
                count(fragments)
            )?;
        }
    }
    for s in &results.skipped {
        writeln!(out, "not checked: {} ({})", s.kind.name(), s.why)?;
    }
    Ok(())
}
