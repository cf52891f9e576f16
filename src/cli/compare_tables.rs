//! What `compare` found, as JSON and as tables on stdout.

use crate::base::num;
use std::collections::BTreeMap;

use rtl_model::regs::Reg;
use serde_json::{Map, Value, json};

use super::Failure;
use super::compare::{Args, Results};
use super::job::{Caustics, Job};
use super::output::{Origin, unit_json};
use crate::caustic::difference;
use crate::engine::Rung;
use crate::engine::gpu::check::StageChecks;
use crate::engine::registers::{RegisterError, RegisterErrors};
use crate::report::table::{Align, Table, count, fixed, optional, significant};
use crate::settings::Settings;
use crate::unit::UnitSpec;

#[expect(clippy::cast_precision_loss, reason = "counts become rates")]
fn per(total: u64, parts: usize) -> f64 {
    total as f64 / parts.max(1) as f64
}

fn flags(results: &Results) -> BTreeMap<String, u64> {
    results.get(Rung::Rtl).map(|r| r.flags.clone()).unwrap_or_default()
}

fn compared(errors: &RegisterErrors) -> impl Iterator<Item = (Reg, &RegisterError)> {
    Reg::ALL.iter().copied().zip(&errors.registers).filter(|(_, e)| e.count > 0)
}

/// The results as `--json` writes them and the report shows them.
pub(super) fn to_json(
    args: &Args,
    origin: &Origin,
    spec: &UnitSpec,
    job: &Job,
    results: &Results,
) -> Value {
    let mut root = origin.json();
    let fragments = job.fragments();
    root.insert("scene".into(), json!(args.scene));
    root.insert("size".into(), json!(job.size()));
    root.insert("env".into(), json!(args.scene_args.env.as_ref().map(|p| p.display().to_string())));
    root.insert("face_size".into(), json!(job.map().size()));
    root.insert("fragments".into(), json!(fragments));
    root.insert("unit".into(), unit_json(spec));
    let mut engines = Map::new();
    for (rung, r) in &results.renderings {
        let mut engine = json!({
            "seconds": r.seconds,
            "fragments_per_second": per(num::u64(fragments), 1) / r.seconds.max(1e-9),
            "texels_per_fragment": per(r.texels, fragments),
            "probes_per_fragment": per(r.probes, fragments),
            "flags": r.flags,
        });
        if let (Some(error), Some(map)) = (r.standard_error, engine.as_object_mut()) {
            map.insert("standard_error".into(), json!(error));
        }
        if let (Some((fragments, first)), Some(map)) = (r.beyond_f32, engine.as_object_mut()) {
            let beyond = json!({"fragments": fragments, "first_pixel": first});
            map.insert("beyond_f32".into(), beyond);
        }
        if let (Some(searches), Some(map)) = (&r.searches, engine.as_object_mut()) {
            let hit = json!({
                "status": searches.status,
                "look_ups_per_ray": searches.look_ups(),
                "overshot": searches.overshot,
            });
            map.insert("hit".into(), hit);
        }
        let tiles = r.texture_use.as_ref().map(|u| &u.tiles);
        if let (Some(tiles), Some(map)) = (tiles.filter(|t| !t.is_empty()), engine.as_object_mut())
        {
            let by: Vec<Value> =
                tiles.iter().map(|t| json!({"total": t.total(), "by_level": t.counts()})).collect();
            map.insert("tiles".into(), json!(by));
        }
        engines.insert(rung.name().into(), engine);
    }
    root.insert("engines".into(), Value::Object(engines));
    let pairs = results.pairs.iter().map(|(a, b, p)| p.to_json(a.name(), b.name())).collect();
    root.insert("pairs".into(), Value::Array(pairs));
    let rows = results.registers.iter().flat_map(|errors| {
        compared(errors).map(|(reg, e)| {
            let info = reg.info();
            json!({"stage": info.stage, "register": info.name, "worst_lsb": e.worst_lsb, "mean_lsb": e.mean_lsb(), "pixel": e.pixel})
        })
    });
    root.insert("registers".into(), Value::Array(rows.collect()));
    if let Some(stages) = &results.stages {
        root.insert("stages".into(), stages_json(stages));
    }
    root.insert("flags".into(), json!(flags(results)));
    if let Some(caustics) = &results.caustics {
        root.insert("caustic".into(), caustic_json(caustics));
    }
    let skipped =
        results.skipped.iter().map(|s| json!({"engine": s.rung.name(), "why": s.why})).collect();
    root.insert("skipped".into(), Value::Array(skipped));
    root.insert("adapter".into(), json!(results.adapter));
    Value::Object(root)
}

/// Touched tiles of 64 × 64 texels, texture by texture.
fn print_tiles(out: &mut impl std::io::Write, results: &Results) -> Result<(), Failure> {
    for (rung, r) in &results.renderings {
        let tiles = r.texture_use.iter().flat_map(|u| &u.tiles);
        for (index, tiles) in tiles.enumerate() {
            let by: Vec<String> = tiles.counts().iter().map(ToString::to_string).collect();
            writeln!(
                out,
                "{}: texture {index}: {} tiles of 64x64 texels ({} by level)",
                rung.name(),
                count(num::u64(tiles.total())),
                by.join(" ")
            )?;
        }
    }
    Ok(())
}

/// The ladder's name of a caustic's maker: `truth` is real rays.
fn caustic_json(caustics: &Caustics) -> Value {
    let mut by = Map::new();
    for (rung, caustic) in &caustics.by {
        by.insert(
            rung.name().into(),
            json!({
                "landed": caustic.landed,
                "power_of_the_landed": caustic.power,
                "power_on_the_walls": caustic.map.power(),
            }),
        );
    }
    let pairs: Vec<Value> = caustics
        .by
        .windows(2)
        .map(|pair| {
            let [(a, x), (b, y)] = pair else {
                return Value::Null;
            };
            json!({"a": a.name(), "b": b.name(), "relative_rms": difference(&x.map, &y.map)})
        })
        .collect();
    json!({"photons": caustics.photons, "engines": by, "pairs": pairs})
}

/// The caustic, engine by engine.
fn print_caustic(out: &mut impl std::io::Write, caustics: &Caustics) -> Result<(), Failure> {
    let mut table = Table::new(&[
        ("caustic", Align::Left),
        ("photons that landed", Align::Right),
        ("their power (G)", Align::Right),
        ("on the walls (G)", Align::Right),
        ("RMS from the next (%)", Align::Right),
    ]);
    for (i, (rung, caustic)) in caustics.by.iter().enumerate() {
        let apart =
            caustics.by.get(i + 1).map(|(_, next)| 100.0 * difference(&caustic.map, &next.map));
        table.row([
            rung.name().to_string(),
            format!("{} of {}", caustic.landed, caustics.photons),
            significant(caustic.power[1], 5),
            significant(caustic.map.power()[1], 5),
            apart.map_or("-".into(), |a| significant(a, 3)),
        ]);
    }
    writeln!(out, "{table}")?;
    Ok(())
}

/// The registers of the stages' own kernels, as JSON.
fn stages_json(stages: &StageChecks) -> Value {
    let rows: Vec<Value> = stages
        .rows
        .iter()
        .filter(|r| r.compared > 0)
        .map(|r| {
            json!({
                "stage": r.stage.name(), "register": r.register, "compared": r.compared,
                "worst_ulp": r.worst_ulp, "worst_share": r.worst_share, "undecided": r.undecided,
                "unbounded": r.unbounded, "unexplained": r.unexplained,
            })
        })
        .collect();
    let first = stages.first.as_ref().map(|d| {
        json!({
            "stage": d.stage.name(), "register": d.register, "pixel": d.pixel,
            "rtl": d.rtl, "gpu": d.gpu, "f64": d.f64, "tolerance": d.tolerance, "operands": d.operands,
        })
    });
    json!({"fragments": stages.fragments, "registers": rows, "first_difference": first})
}

/// The registers of the stages' own kernels, and the first that nothing explains.
fn print_stages(out: &mut impl std::io::Write, stages: &StageChecks) -> Result<(), Failure> {
    let mut table = Table::new(&[
        ("register (gpu - f64, stage by stage)", Align::Left),
        ("compared", Align::Right),
        ("worst (2^-23 of it)", Align::Right),
        ("worst (of tolerance)", Align::Right),
        ("undecided", Align::Right),
        ("no bound", Align::Right),
        ("unexplained", Align::Right),
    ]);
    for r in stages.rows.iter().filter(|r| r.compared > 0) {
        table.row([
            format!("{}.{}", r.stage.name(), r.register),
            count(r.compared),
            significant(r.worst_ulp, 3),
            significant(r.worst_share, 3),
            count(r.undecided),
            count(r.unbounded),
            count(r.unexplained),
        ]);
    }
    writeln!(out, "\n{table}")?;
    let Some(d) = &stages.first else {
        writeln!(out, "no difference of a stage's register is unexplained")?;
        return Ok(());
    };
    let [x, y] = d.pixel;
    writeln!(
        out,
        "first unexplained difference: {}.{} at pixel {x},{y}",
        d.stage.name(),
        d.register
    )?;
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
fn print_searches(out: &mut impl std::io::Write, results: &Results) -> Result<(), Failure> {
    let mut table = Table::new(&[
        ("search", Align::Left),
        ("look-ups/ray", Align::Right),
        ("rays with an overshoot", Align::Right),
        ("rays by status", Align::Left),
    ]);
    for (rung, r) in &results.renderings {
        let Some(searches) = &r.searches else {
            continue;
        };
        let status: Vec<String> =
            searches.status.iter().map(|(name, n)| format!("{name} {}", count(*n))).collect();
        table.row([
            rung.name().to_string(),
            significant(searches.look_ups(), 3),
            count(searches.overshot),
            status.join(", "),
        ]);
    }
    if !table.is_empty() {
        writeln!(out, "{table}")?;
    }
    Ok(())
}

/// The results as tables on stdout.
pub(super) fn print_tables(
    args: &Args,
    spec: &UnitSpec,
    job: &Job,
    results: &Results,
    settings: &Settings,
) -> Result<(), Failure> {
    use std::io::Write as _;
    let mut out = std::io::stdout().lock();
    let fragments = job.fragments();
    let env =
        args.scene_args.env.as_ref().map_or(job.environment().into(), |p| p.display().to_string());
    let size = job.map().size();
    let [width, height] = job.size();
    writeln!(
        out,
        "{} {width}x{height}, {} fragments; {env}, 6 faces of {size}x{size}; tapline {}, unit {}, seed 0",
        args.scene,
        count(num::u64(fragments)),
        env!("CARGO_PKG_VERSION"),
        spec.hash()
    )?;
    let axis = if settings.reference_table.is_some() {
        "the angle table's axis"
    } else {
        "the exact axis"
    };
    writeln!(
        out,
        "f64 and ewa use {axis}; probes of f64 carry the trilinear filter's own blur, which ewa has not\n"
    )?;

    let mut ladder = Table::new(&[
        ("pair", Align::Left),
        ("PSNR (dB)", Align::Right),
        ("max (8-bit steps)", Align::Right),
        ("RMS (8-bit steps)", Align::Right),
        ("rel. MSE", Align::Right),
        (">1 step (%)", Align::Right),
        ("FLIP", Align::Right),
    ]);
    for (a, b, p) in &results.pairs {
        ladder.row([
            format!("{} - {}", a.name(), b.name()),
            p.psnr_db.map_or("identical".into(), |db| fixed(db, 2)),
            significant(p.max_lsb8, 3),
            significant(255.0 * p.rmse, 3),
            significant(p.rel_mse, 3),
            significant(100.0 * p.share_over_1_lsb8, 3),
            optional(p.flip.map(|f| significant(f, 3))),
        ]);
    }
    if !ladder.is_empty() {
        writeln!(out, "{ladder}")?;
    }
    let mut speed = Table::new(&[
        ("engine", Align::Left),
        ("seconds", Align::Right),
        ("fragments/s", Align::Right),
        ("probes/fragment", Align::Right),
        ("texels/fragment", Align::Right),
    ]);
    for (rung, r) in &results.renderings {
        speed.row([
            rung.name().to_string(),
            significant(r.seconds, 3),
            significant(per(num::u64(fragments), 1) / r.seconds.max(1e-9), 3),
            significant(per(r.probes, fragments), 3),
            significant(per(r.texels, fragments), 3),
        ]);
    }
    writeln!(out, "{speed}")?;
    print_searches(&mut out, results)?;
    print_tiles(&mut out, results)?;
    if let Some(caustics) = &results.caustics {
        print_caustic(&mut out, caustics)?;
    }
    if let Some(error) = results.get(Rung::Truth).and_then(|r| r.standard_error) {
        writeln!(out, "truth: RMS standard error {} (linear)", significant(error, 3))?;
    }
    if let Some(errors) = &results.registers {
        let mut table = Table::new(&[
            ("register (rtl - f64)", Align::Left),
            ("worst (LSB)", Align::Right),
            ("mean (LSB)", Align::Right),
            ("pixel of the worst", Align::Right),
        ]);
        for (reg, e) in compared(errors) {
            let info = reg.info();
            table.row([
                format!("{}.{}", info.stage, info.name),
                significant(e.worst_lsb, 3),
                significant(e.mean_lsb(), 3),
                format!("{},{}", e.pixel[0], e.pixel[1]),
            ]);
        }
        writeln!(out, "\n{table}")?;
        writeln!(
            out,
            "{} fragments on another face, {} with another probe count, {} with a probe on another texel: \
             not compared behind that",
            count(errors.other_face),
            count(errors.other_count),
            count(errors.other_texel)
        )?;
        if errors.other_search > 0 {
            writeln!(
                out,
                "{} rays whose search went another way: not compared at all",
                count(errors.other_search)
            )?;
        }
    }
    if let Some(stages) = &results.stages {
        print_stages(&mut out, stages)?;
    }
    for (name, n) in flags(results) {
        writeln!(out, "flag {name}: {} fragments", count(n))?;
    }
    if let Some(adapter) = &results.adapter {
        writeln!(out, "gpu: {adapter}")?;
    }
    for (rung, r) in &results.renderings {
        if let Some((fragments, [x, y])) = r.beyond_f32 {
            writeln!(
                out,
                "{}: {} fragments left the range of f32, the first at pixel {x},{y}",
                rung.name(),
                count(fragments)
            )?;
        }
    }
    for s in &results.skipped {
        writeln!(out, "not checked: {} ({})", s.rung.name(), s.why)?;
    }
    Ok(())
}
