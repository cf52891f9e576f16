//! The details of chosen rows in a report: pictures, error map, ladder, register errors, footprints.
//!
//! [`gather`] renders a row once more and puts everything into one JSON object; `section.rs` needs nothing else.

use rtl_model::regs::Reg;
use serde_json::{Value, json};

use super::view::view;
use crate::base::num;
use crate::engine::Rung;
use crate::error::InputError;
use crate::image::write::write_png;
use crate::picture::Picture;
use crate::report::error_map::{colour_of_steps, error_map};
use crate::report::escape::base64;
use crate::report::metrics;
use crate::settings::Settings;
use crate::srgb::srgb_decode;
use crate::stage::Stage;
use crate::study::bench::{Bench, Measuring, Scene};
use crate::unit::{UnitSpec, check};

/// Renders a row once more.
///
/// # Errors
/// The unit is refused, or pictures that cannot be compared.
pub fn gather(
    bench: &mut Bench,
    row: &Value,
    spec: &UnitSpec,
    settings: &Settings,
    how: &Measuring,
    pixels: &[[u32; 2]],
) -> Result<Value, InputError> {
    let (rendering, ..) = bench.render(spec, settings, true)?;
    let mut pictures = vec![("the unit", png(&rendering.picture, how.exposure))];
    let mut ladder = Vec::new();
    let mut above = (Rung::Rtl, rendering.picture.clone());
    let mut worst = [0, 0];
    for rung in [Rung::F64, Rung::Ewa, Rung::Truth] {
        if rung == Rung::Truth && !how.against.contains(&rung) {
            continue;
        }
        let below = bench.reference_picture(rung, settings, &how.truth).clone();
        let pair = metrics::compare(&above.1, &below, how.exposure)?;
        if rung == Rung::F64 {
            worst = pair.worst_pixel;
            pictures.push(("f64", png(&below, how.exposure)));
            let map = error_map(&above.1, &below, how.exposure)?;
            pictures.push(("difference, 8-bit steps", png(&map, 0.0)));
        }
        ladder.push(pair.to_json(above.0.name(), rung.name()));
        above = (rung, below);
    }
    if let Some(picture) = counts(bench) {
        pictures.push(("probes, dark 1, white most", png(&picture, 0.0)));
    }
    if let (Scene::Hit(s), Some(searches)) = (bench.scene(), &rendering.searches) {
        let pixels = s.scene.rays.iter().map(|r| r.pixel);
        let size = [s.scene.width, s.scene.height];
        let numbers = searches.iterations.iter().map(|n| f64::from(*n));
        pictures.push(("look-ups, dark 0, white most", png(&ramp(size, pixels.zip(numbers)), 0.0)));
    }
    if let Some(used) = &rendering.texture_use {
        pictures.push(("levels of detail", png(&used.levels, 0.0)));
    }
    let parts = attribution(bench, spec, settings, how)?;
    let mut wanted: Vec<[u32; 2]> = pixels.to_vec();
    if wanted.is_empty() {
        wanted = vec![worst, longest(bench, settings, how).unwrap_or(worst)];
        wanted.dedup();
    }
    let views: Vec<Value> = wanted
        .iter()
        .filter_map(|pixel| view(bench.scene(), spec, settings, *pixel).transpose())
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

/// Numbers from dark to white by their share of the largest.
fn ramp(size: [usize; 2], numbers: impl Iterator<Item = ([u32; 2], f64)>) -> Picture {
    let numbers: Vec<([u32; 2], f64)> = numbers.collect();
    let most = numbers.iter().fold(1.0f64, |most, (_, n)| most.max(*n));
    let mut picture = Picture::new(size[0], size[1]);
    picture.rgb.fill([0.1; 3]);
    for ([x, y], n) in numbers {
        let at = num::usize(y) * size[0] + num::usize(x);
        if picture.covered[at] {
            continue;
        }
        picture.covered[at] = true;
        let colour = colour_of_steps(libm::exp2(16.0 * n / most - 8.0));
        picture.rgb[at] = colour.map(|c| srgb_decode(f64::from(c) / 255.0));
    }
    picture
}

/// Probes of each pixel's first request.
fn counts(bench: &Bench) -> Option<Picture> {
    let (pixels, size): (Vec<[u32; 2]>, _) = match bench.scene() {
        Scene::Env(s) => {
            (s.scene.fragments.iter().map(|f| f.pixel).collect(), [s.scene.width, s.scene.height])
        }
        Scene::Hit(s) => {
            (s.scene.rays.iter().map(|r| r.pixel).collect(), [s.scene.width, s.scene.height])
        }
        Scene::Tex(_) => return None,
    };
    let mut probes = Vec::new();
    bench.lines(&mut |line| probes.push(line.probes as f64));
    Some(ramp(size, pixels.into_iter().zip(probes)))
}

/// The pixel with the longest probe line of several probes.
fn longest(bench: &mut Bench, settings: &Settings, how: &Measuring) -> Option<[u32; 2]> {
    let lines = bench.reference_lines(settings, &how.truth).to_vec();
    let best = lines.iter().enumerate().filter(|(_, l)| (4..=12).contains(&l.probes));
    let (index, _) = best.max_by(|a, b| {
        (a.1.texels[0] / a.1.texels[1].max(1.0))
            .total_cmp(&(b.1.texels[0] / b.1.texels[1].max(1.0)))
    })?;
    match bench.scene() {
        Scene::Env(s) => s.scene.fragments.get(index).map(|f| f.pixel),
        Scene::Hit(s) => s.scene.rays.get(index).map(|r| r.pixel),
        Scene::Tex(_) => None,
    }
}

/// What longer words of one stage alone would buy, and larger tables: PSNR against f64.
fn attribution(
    bench: &mut Bench,
    spec: &UnitSpec,
    settings: &Settings,
    how: &Measuring,
) -> Result<Vec<Value>, InputError> {
    let mut out = Vec::new();
    let mut add = |part: &str, spec: &UnitSpec, bench: &mut Bench| -> Result<(), InputError> {
        let (rendering, ..) = bench.render(spec, settings, true)?;
        let reference = bench.reference_picture(Rung::F64, settings, &how.truth);
        let pair = metrics::compare(&rendering.picture, reference, how.exposure)?;
        out.push(json!({"part": part, "psnr_db": pair.psnr_db, "mean_lsb8": pair.mean_lsb8}));
        Ok(())
    };
    add("the unit", spec, bench)?;
    let stages = how.cost.sheet(&spec.config, bench.scene().operation()).stages;
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
