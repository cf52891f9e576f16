//! The details of chosen rows in a report: pictures, error map, ladder, register errors, footprints.
//!
//! [`gather`] renders a row once more and puts everything into one JSON object; `section.rs` needs nothing else.

use rtl_model::regs::Reg;
use serde_json::{Value, json};

use super::view::view;
use crate::engine::EngineKind;
use crate::error::InputError;
use crate::image::write::write_png;
use crate::picture::Picture;
use crate::report::error_map::{error_map, ramp};
use crate::report::escape::base64;
use crate::report::metrics;
use crate::settings::Settings;
use crate::stage::Stage;
use crate::study::sweep::{Measuring, Sweep};
use crate::unit::{UnitSpec, check};

/// Renders a row once more.
///
/// # Errors
/// The unit is refused, or pictures that cannot be compared.
pub fn gather(
    bench: &mut Sweep,
    row: &Value,
    spec: &UnitSpec,
    settings: &Settings,
    how: &Measuring,
    pixels: &[[u32; 2]],
) -> Result<Value, InputError> {
    let (rendering, ..) = bench.render(spec, true)?;
    let mut pictures = vec![("the unit", png(&rendering.picture, how.exposure))];
    let mut ladder = Vec::new();
    let mut above = (EngineKind::Rtl, rendering.picture.clone());
    let mut worst = [0, 0];
    for kind in [EngineKind::F64, EngineKind::Ewa, EngineKind::Truth] {
        if kind == EngineKind::Truth && !how.against.contains(&kind) {
            continue;
        }
        let below = bench.reference_picture(kind, settings, &how.truth)?.clone();
        let pair = metrics::compare(&above.1, &below, how.exposure)?;
        if kind == EngineKind::F64 {
            worst = pair.worst_pixel;
            pictures.push(("f64", png(&below, how.exposure)));
            let map = error_map(&above.1, &below, how.exposure)?;
            pictures.push(("difference, 8-bit steps", png(&map, 0.0)));
        }
        ladder.push(pair.to_json(above.0.name(), kind.name()));
        above = (kind, below);
    }
    if let Some(picture) = counts(bench) {
        pictures.push(("probes, dark 1, white most", png(&picture, 0.0)));
    }
    if let Some(searches) = &rendering.searches {
        let job = bench.job();
        let numbers = searches.iterations.iter().map(|n| f64::from(*n));
        let picture = ramp(job.size(), job.pixels().into_iter().zip(numbers));
        pictures.push(("look-ups, dark 0, white most", png(&picture, 0.0)));
    }
    if let Some(used) = &rendering.texture_use {
        pictures.push(("levels of detail", png(&used.levels, 0.0)));
    }
    let parts = attribution(bench, spec, settings, how)?;
    let mut wanted: Vec<[u32; 2]> = pixels.to_vec();
    if wanted.is_empty() {
        wanted = vec![worst, longest(bench, settings, how)?.unwrap_or(worst)];
        wanted.dedup();
    }
    let views: Vec<Value> = wanted
        .iter()
        .filter_map(|pixel| view(bench.job(), spec, settings, *pixel).transpose())
        .collect::<Result<_, _>>()?;
    let pictures: Vec<Value> = pictures
        .into_iter()
        .map(|(name, png)| json!({"name": name, "png": base64(&png)}))
        .collect();
    Ok(
        json!({"row": row["row"], "scene": row["scene"], "set": row["set"], "command": row["command"],
        "pictures": pictures, "ladder": ladder, "attribution": parts, "footprints": views}),
    )
}

fn png(picture: &Picture, exposure: f64) -> Vec<u8> {
    let mut out = Vec::new();
    // Memory takes everything; a picture without pixels gives no file.
    let _ = write_png(&mut out, picture, exposure, &[]);
    out
}

/// Probes of each pixel's first request.
fn counts(bench: &Sweep) -> Option<Picture> {
    let (pixels, mut probes) = (bench.job().pixels(), Vec::new());
    bench.lines(&mut |line| probes.push(line.probes as f64));
    (!pixels.is_empty()).then(|| ramp(bench.job().size(), pixels.into_iter().zip(probes)))
}

/// The pixel with the longest probe line of several probes.
fn longest(
    bench: &mut Sweep,
    settings: &Settings,
    how: &Measuring,
) -> Result<Option<[u32; 2]>, InputError> {
    let lines = bench.reference_lines(settings, &how.truth)?.to_vec();
    let best = lines.iter().enumerate().filter(|(_, l)| (4..=12).contains(&l.probes));
    let most = best.max_by(|a, b| {
        (a.1.texels[0] / a.1.texels[1].max(1.0))
            .total_cmp(&(b.1.texels[0] / b.1.texels[1].max(1.0)))
    });
    Ok(most.and_then(|(index, _)| bench.job().pixels().get(index).copied()))
}

/// What longer words of one stage alone would buy, and larger tables: PSNR against f64.
fn attribution(
    bench: &mut Sweep,
    spec: &UnitSpec,
    settings: &Settings,
    how: &Measuring,
) -> Result<Vec<Value>, InputError> {
    let mut out = Vec::new();
    let mut add = |part: &str, spec: &UnitSpec, bench: &mut Sweep| -> Result<(), InputError> {
        let (rendering, ..) = bench.render(spec, true)?;
        let reference = bench.reference_picture(EngineKind::F64, settings, &how.truth)?;
        let pair = metrics::compare(&rendering.picture, reference, how.exposure)?;
        out.push(json!({"part": part, "psnr_db": pair.psnr_db, "mean_lsb8": pair.mean_lsb8}));
        Ok(())
    };
    add("the unit", spec, bench)?;
    let stages = how.cost.sheet(&spec.config, bench.job().operation()).stages;
    for (stage, _) in stages {
        let mut longer = spec.clone();
        for reg in Reg::ALL.iter().filter(|reg| reg.info().stage == stage) {
            for bits in [8, 6, 4, 2, 1] {
                let mut tried = longer.clone();
                tried.config.formats[reg.index()].frac += bits;
                if check(&tried).is_ok() {
                    longer = tried;
                    break;
                }
            }
        }
        if stage == Stage::Filter {
            (longer.config.policy.filter.weight_bits, longer.config.policy.filter.lod_bits) =
                (8, 8);
        }
        add(stage.name(), &longer, bench)?;
    }
    let mut larger = spec.clone();
    larger.config.tables.eigen.entries = 1024;
    if check(&larger).is_ok() {
        add("angle table", &larger, bench)?;
    }
    let mut larger = spec.clone();
    let tables = &mut larger.config.tables;
    for table in [&mut tables.recip, &mut tables.rsqrt, &mut tables.sqrt, &mut tables.log2] {
        (table.entries, table.order, table.frac) = (256, 2, 26);
    }
    if check(&larger).is_ok() {
        add("other tables", &larger, bench)?;
    }
    Ok(out)
}
