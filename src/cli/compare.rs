//! `compare`: the accuracy ladder of a scene, register errors, flags, speed, pictures.

use std::collections::BTreeMap;
use std::path::PathBuf;

use rtl_model::regs::Reg;
use rtl_model::unit::Needs;
use serde_json::{Map, Value, json};

use super::args::{RunArgs, SceneArgs, UnitArgs};
use super::bounds::{self, Bound};
use super::output::{JsonTarget, Origin, unit_json};
use super::progress::Bar;
use super::{Failure, subject};
use crate::engine::float::{EwaEngine, F64Engine, TruthEngine};
use crate::engine::registers::{self, RegisterErrors};
use crate::engine::rtl::RtlEngine;
use crate::engine::{Engine, Rendering, Rung, Subject};
use crate::error::InputError;
use crate::image::temporary::OutputFolder;
use crate::image::whole::WholeFile;
use crate::image::write::{Sample, write_exr, write_png};
use crate::picture::Picture;
use crate::report::error_map::{error_map, mosaic};
use crate::report::html;
use crate::report::metrics::{self, Pair};
use crate::report::table::{Align, Table, count, fixed, optional, significant};
use crate::settings::Settings;
use crate::truth::TruthOptions;
use crate::unit::UnitSpec;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Built-in scene; `tapline scenes` lists them.
    #[arg(default_value = "scratches")]
    scene: String,
    /// Engines, in any order: rtl, gpu, f64, ewa, truth. All that are there if not given.
    #[arg(long, value_delimiter = ',', value_enum)]
    engines: Vec<Rung>,
    /// Folder for pictures, error maps and report.html; made if it is not there.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Results as JSON; `-` is stdout.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Fail (status 1) where the PSNR of two engines is below a bound, such as rtl:f64=50.
    #[arg(long, value_name = "A:B=DB")]
    min_psnr: Vec<String>,
    /// Fail (status 1) where two engines differ by more 8-bit steps than a bound, such as rtl:f64=2.
    #[arg(long, value_name = "A:B=STEPS")]
    max_lsb8: Vec<String>,
    /// Samples a pixel in the first round of `truth`.
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(4..=65536))]
    samples: u32,
    #[command(flatten)]
    unit: UnitArgs,
    #[command(flatten)]
    scene_args: SceneArgs,
    #[command(flatten)]
    run: RunArgs,
}

/// Why an engine is not among the results.
struct Skipped {
    rung: Rung,
    why: &'static str,
}

struct Results {
    renderings: Vec<(Rung, Rendering)>,
    pairs: Vec<(Rung, Rung, Pair)>,
    registers: Option<RegisterErrors>,
    skipped: Vec<Skipped>,
}

impl Results {
    fn get(&self, rung: Rung) -> Option<&Rendering> {
        self.renderings
            .iter()
            .find(|(r, _)| *r == rung)
            .map(|(_, r)| r)
    }
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    args.scene_args.refuse_later()?;
    subject::check_exposure(args.scene_args.exposure)?;
    args.run.prepare()?;
    let (rungs, skipped) = choose(&args.engines)?;
    let min_psnr = parse_bounds("--min-psnr", &args.min_psnr, &rungs)?;
    let max_lsb8 = parse_bounds("--max-lsb8", &args.max_lsb8, &rungs)?;
    let spec = args.unit.load()?;
    let settings = args.run.settings(&spec);
    // The folder first: the JSON file may lie in it.
    let files = match &args.out {
        None => None,
        Some(folder) => Some(OutFiles::create(folder, &rungs)?),
    };
    let json_target = JsonTarget::open(args.json.as_deref())?;
    let subject = subject::load(&args.scene, &args.scene_args, &settings)?;
    if subject.scene.fragments.is_empty() {
        return Err(InputError::new(
            "--size",
            "a picture in which a pixel centre meets the surface",
            "no fragment at all",
            "ask for a larger picture",
        )
        .into());
    }

    let origin = Origin::new(&spec);
    let mut results = render_all(args, &rungs, &spec, &settings, &subject)?;
    results.skipped = skipped;
    let value = to_json(args, &origin, &spec, &subject, &results);
    if !json_target.takes_stdout() {
        unless_closed(print_tables(args, &spec, &subject, &results, &settings))?;
    }
    if let Some(files) = files {
        files.write(args, &origin, &results, &value)?;
    }
    unless_closed(json_target.write(&value))?;
    judge(args, &results, &min_psnr, &max_lsb8)
}

/// A reader of stdout that has gone changes neither the files nor the verdict.
fn unless_closed(result: Result<(), Failure>) -> Result<(), Failure> {
    match result {
        Err(Failure::Closed) => Ok(()),
        other => other,
    }
}

/// The engines asked for, in the ladder's order, and what is left out.
fn choose(asked: &[Rung]) -> Result<(Vec<Rung>, Vec<Skipped>), InputError> {
    let why = "not built in this version";
    if asked.contains(&Rung::Gpu) {
        return Err(InputError::new(
            "--engines",
            "engines that are there: rtl, f64, ewa, truth",
            "gpu, which is not built in this version",
            "leave gpu out",
        ));
    }
    if asked.is_empty() {
        let rungs = Rung::ALL.into_iter().filter(|r| *r != Rung::Gpu).collect();
        return Ok((
            rungs,
            vec![Skipped {
                rung: Rung::Gpu,
                why,
            }],
        ));
    }
    Ok((
        Rung::ALL
            .into_iter()
            .filter(|r| asked.contains(r))
            .collect(),
        Vec::new(),
    ))
}

fn parse_bounds(name: &str, texts: &[String], rungs: &[Rung]) -> Result<Vec<Bound>, InputError> {
    let bounds = texts
        .iter()
        .map(|t| bounds::parse(name, t))
        .collect::<Result<Vec<_>, _>>()?;
    for bound in &bounds {
        for rung in [bound.a, bound.b] {
            if !rungs.contains(&rung) {
                return Err(InputError::new(
                    name,
                    "engines that this run renders",
                    format!("`{}`", rung.name()),
                    "name it in --engines",
                ));
            }
        }
    }
    Ok(bounds)
}

fn render_all(
    args: &Args,
    rungs: &[Rung],
    spec: &UnitSpec,
    settings: &Settings,
    subject: &Subject,
) -> Result<Results, Failure> {
    let needs = subject.scene.fragments.first().map_or(
        Needs {
            bump: false,
            rough: false,
        },
        |f| crate::engine::encode::needs(&f.fragment),
    );
    let rtl = if rungs.contains(&Rung::Rtl) {
        Some(RtlEngine::new(spec, needs, &subject.map)?)
    } else {
        None
    };
    let f64_engine = F64Engine {
        settings: settings.clone(),
    };
    let ewa = EwaEngine {
        settings: settings.clone(),
    };
    let truth = TruthEngine {
        settings: settings.clone(),
        options: TruthOptions {
            samples: args.samples,
            max_samples: args.samples.saturating_mul(4),
            ..TruthOptions::default()
        },
    };
    let total = crate::engine::to_u64(subject.scene.fragments.len());
    let mut renderings = Vec::new();
    for rung in rungs {
        let engine: &dyn Engine = match (rung, &rtl) {
            (Rung::Rtl, Some(rtl)) => rtl,
            (Rung::Rtl | Rung::Gpu, _) => continue,
            (Rung::F64, _) => &f64_engine,
            (Rung::Ewa, _) => &ewa,
            (Rung::Truth, _) => &truth,
        };
        let bar = Bar::new(rung.name(), total);
        renderings.push((*rung, engine.render(subject, &|n| bar.add(n))));
    }
    let mut pairs = Vec::new();
    for pair in renderings.windows(2) {
        if let [(a, ra), (b, rb)] = pair {
            let metrics =
                metrics::compare_with_flip(&ra.picture, &rb.picture, args.scene_args.exposure)?;
            pairs.push((*a, *b, metrics));
        }
    }
    let registers = match &rtl {
        Some(rtl) if rungs.contains(&Rung::F64) => {
            let bar = Bar::new("registers", total);
            Some(registers::compare(rtl, settings, subject, &|n| bar.add(n)))
        }
        Some(_) | None => None,
    };
    Ok(Results {
        renderings,
        pairs,
        registers,
        skipped: Vec::new(),
    })
}

#[expect(clippy::cast_precision_loss, reason = "counts become rates")]
fn per(total: u64, parts: usize) -> f64 {
    total as f64 / parts.max(1) as f64
}

fn flags(results: &Results) -> BTreeMap<String, u64> {
    results
        .get(Rung::Rtl)
        .map(|r| r.flags.clone())
        .unwrap_or_default()
}

fn compared(errors: &RegisterErrors) -> impl Iterator<Item = (Reg, &registers::RegisterError)> {
    Reg::ALL
        .iter()
        .copied()
        .zip(&errors.registers)
        .filter(|(_, e)| e.count > 0)
}

fn to_json(
    args: &Args,
    origin: &Origin,
    spec: &UnitSpec,
    subject: &Subject,
    results: &Results,
) -> Value {
    let mut root = origin.json();
    let fragments = subject.scene.fragments.len();
    root.insert("scene".into(), json!(args.scene));
    root.insert(
        "size".into(),
        json!([subject.scene.width, subject.scene.height]),
    );
    root.insert(
        "env".into(),
        json!(
            args.scene_args
                .env
                .as_ref()
                .map(|p| p.display().to_string())
        ),
    );
    root.insert("face_size".into(), json!(subject.map.size()));
    root.insert("fragments".into(), json!(fragments));
    root.insert("unit".into(), unit_json(spec));
    let mut engines = Map::new();
    for (rung, r) in &results.renderings {
        let mut engine = json!({
            "seconds": r.seconds,
            "fragments_per_second": per(super::super::engine::to_u64(fragments), 1) / r.seconds.max(1e-9),
            "texels_per_fragment": per(r.texels, fragments),
            "probes_per_fragment": per(r.probes, fragments),
            "flags": r.flags,
        });
        if let (Some(error), Some(map)) = (r.standard_error, engine.as_object_mut()) {
            map.insert("standard_error".into(), json!(error));
        }
        engines.insert(rung.name().into(), engine);
    }
    root.insert("engines".into(), Value::Object(engines));
    let pairs = results
        .pairs
        .iter()
        .map(|(a, b, p)| p.to_json(a.name(), b.name()))
        .collect();
    root.insert("pairs".into(), Value::Array(pairs));
    let rows = results.registers.iter().flat_map(|errors| {
        compared(errors).map(|(reg, e)| {
            let info = reg.info();
            json!({"stage": info.stage, "register": info.name, "worst_lsb": e.worst_lsb, "mean_lsb": e.mean_lsb(), "pixel": e.pixel})
        })
    });
    root.insert("registers".into(), Value::Array(rows.collect()));
    root.insert("flags".into(), json!(flags(results)));
    let skipped = results
        .skipped
        .iter()
        .map(|s| json!({"engine": s.rung.name(), "why": s.why}))
        .collect();
    root.insert("skipped".into(), Value::Array(skipped));
    root.insert("adapter".into(), Value::Null);
    Value::Object(root)
}

fn print_tables(
    args: &Args,
    spec: &UnitSpec,
    subject: &Subject,
    results: &Results,
    settings: &Settings,
) -> Result<(), Failure> {
    use std::io::Write as _;
    let mut out = std::io::stdout().lock();
    let fragments = subject.scene.fragments.len();
    let env = args
        .scene_args
        .env
        .as_ref()
        .map_or("procedural environment".into(), |p| p.display().to_string());
    let size = subject.map.size();
    writeln!(
        out,
        "{} {}x{}, {} fragments; {env}, 6 faces of {size}x{size}; tapline {}, unit {}, seed 0",
        args.scene,
        subject.scene.width,
        subject.scene.height,
        count(super::super::engine::to_u64(fragments)),
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
            significant(
                per(super::super::engine::to_u64(fragments), 1) / r.seconds.max(1e-9),
                3,
            ),
            significant(per(r.probes, fragments), 3),
            significant(per(r.texels, fragments), 3),
        ]);
    }
    writeln!(out, "{speed}")?;
    if let Some(error) = results.get(Rung::Truth).and_then(|r| r.standard_error) {
        writeln!(
            out,
            "truth: RMS standard error {} (linear)",
            significant(error, 3)
        )?;
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
            "{} fragments on another face, {} with another probe count: not compared behind that",
            count(errors.other_face),
            count(errors.other_count)
        )?;
    }
    for (name, n) in flags(results) {
        writeln!(out, "flag {name}: {} fragments", count(n))?;
    }
    for s in &results.skipped {
        writeln!(out, "not checked: {} ({})", s.rung.name(), s.why)?;
    }
    Ok(())
}

fn judge(
    args: &Args,
    results: &Results,
    min_psnr: &[Bound],
    max_lsb8: &[Bound],
) -> Result<(), Failure> {
    let pair = |bound: &Bound| -> Result<Option<Pair>, Failure> {
        let (Some(a), Some(b)) = (results.get(bound.a), results.get(bound.b)) else {
            return Ok(None);
        };
        Ok(Some(metrics::compare(
            &a.picture,
            &b.picture,
            args.scene_args.exposure,
        )?))
    };
    let mut broken = Vec::new();
    for bound in min_psnr {
        if let Some(db) = pair(bound)?.and_then(|p| p.psnr_db)
            && db < bound.limit
        {
            broken.push(format!(
                "{} - {}: {db:.2} dB, below {} dB",
                bound.a.name(),
                bound.b.name(),
                bound.limit
            ));
        }
    }
    for bound in max_lsb8 {
        if let Some(p) = pair(bound)?
            && p.max_lsb8 > bound.limit
        {
            broken.push(format!(
                "{} - {}: {:.3} 8-bit steps at pixel {},{}, above {}",
                bound.a.name(),
                bound.b.name(),
                p.max_lsb8,
                p.worst_pixel[0],
                p.worst_pixel[1],
                bound.limit
            ));
        }
    }
    if broken.is_empty() {
        Ok(())
    } else {
        Err(Failure::Disagrees(broken.join("; ")))
    }
}

/// The files of `--out`, all created before the work starts.
struct OutFiles {
    engines: Vec<(Rung, WholeFile, WholeFile)>,
    maps: Vec<(Rung, Rung, WholeFile)>,
    row: Option<WholeFile>,
    report: WholeFile,
    /// Last, so that it is dropped after the temporaries in it.
    folder: OutputFolder,
}

impl OutFiles {
    fn create(folder: &std::path::Path, rungs: &[Rung]) -> Result<Self, InputError> {
        let made = OutputFolder::create(folder).map_err(|e| {
            InputError::new(
                folder.display().to_string(),
                "a folder that can be made",
                e.to_string(),
                "check the path of --out",
            )
        })?;
        let file = |name: String| WholeFile::create(folder.join(name));
        let mut engines = Vec::new();
        for rung in rungs {
            engines.push((
                *rung,
                file(format!("{}.exr", rung.name()))?,
                file(format!("{}.png", rung.name()))?,
            ));
        }
        let mut maps = Vec::new();
        for pair in rungs.windows(2) {
            if let [a, b] = pair {
                maps.push((*a, *b, file(format!("{}-{}.png", a.name(), b.name()))?));
            }
        }
        let both = rungs.contains(&Rung::Rtl) && rungs.contains(&Rung::F64);
        Ok(Self {
            engines,
            maps,
            row: if both {
                Some(file("row.png".into())?)
            } else {
                None
            },
            report: file("report.html".into())?,
            folder: made,
        })
    }

    fn write(
        self,
        args: &Args,
        origin: &Origin,
        results: &Results,
        value: &Value,
    ) -> Result<(), Failure> {
        let exposure = args.scene_args.exposure;
        let png = |picture: &Picture,
                   exposure: f64,
                   attributes: &[(String, String)]|
         -> Result<Vec<u8>, Failure> {
            let mut bytes = Vec::new();
            write_png(&mut bytes, picture, exposure, attributes)?;
            Ok(bytes)
        };
        // All are written before the first gets its name.
        let mut done = Vec::new();
        let put = |mut file: WholeFile, bytes: &[u8]| -> Result<WholeFile, Failure> {
            use std::io::Write as _;
            file.write_with(|w| w.write_all(bytes))?;
            Ok(file)
        };
        let mut images = Vec::new();
        for (rung, mut exr, png_file) in self.engines {
            let Some(r) = results.get(rung) else { continue };
            let attributes = origin.attributes(&format!("{} by {}", args.scene, rung.name()));
            exr.write_with(|w| write_exr(w, &r.picture, &attributes, Sample::Float))?;
            done.push(exr);
            let bytes = png(&r.picture, exposure, &attributes)?;
            done.push(put(png_file, &bytes)?);
            images.push((rung.name().to_string(), bytes));
        }
        for (a, b, file) in self.maps {
            let (Some(ra), Some(rb)) = (results.get(a), results.get(b)) else {
                continue;
            };
            let map = error_map(&ra.picture, &rb.picture, exposure)?;
            let name = format!("{}-{}", a.name(), b.name());
            let bytes = png(
                &map,
                0.0,
                &origin.attributes(&format!("{}, difference {name}", args.scene)),
            )?;
            done.push(put(file, &bytes)?);
            images.push((name, bytes));
        }
        if let (Some(file), Some(a), Some(b)) =
            (self.row, results.get(Rung::Rtl), results.get(Rung::F64))
        {
            let map = error_map(&a.picture, &b.picture, exposure)?;
            let row = mosaic(
                &[
                    (&a.picture, "rtl"),
                    (&b.picture, "f64"),
                    (&map, "difference"),
                ],
                8,
            );
            let bytes = png(&row, exposure, &origin.attributes(&args.scene))?;
            done.push(put(file, &bytes)?);
        }
        done.push(put(self.report, html::page(value, &images).as_bytes())?);
        for file in done {
            file.commit()?;
        }
        self.folder.keep();
        Ok(())
    }
}
