//! `cones`: studies of ray cones by command.

use crate::base::num;
use std::io::Write as _;
use std::path::PathBuf;

use serde_json::{Value, json};

use super::args::{SceneArgs, UnitArgs};
use super::output::{JsonTarget, Origin, output_folder, unit_json};
use super::progress::Bar;
use super::{Failure, subject};
use crate::cone_study::{cube, formats, tiles};
use crate::engine::tex_subject::TexSubject;
use crate::image::whole::commit_all;
use crate::image::write::write_png;
use crate::picture::Picture;
use crate::report::error_map::mosaic;
use crate::report::table::{Align, Table, count, fixed, significant};
use crate::scene::tex;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(subcommand)]
    study: Study,
}

#[derive(Debug, clap::Subcommand)]
enum Study {
    /// Touched 64x64 tiles: cones against distance, two cones against one, vases against lined ones.
    Tiles(TilesArgs),
    /// Level-of-detail error and tiles by bounce, for every format of the cones' registers.
    Formats(FormatsArgs),
    /// OptiX Toolkit's constant gradient on a cube map against the exact one.
    Cube(CubeArgs),
}

/// Flags of the studies that trace scenes.
#[derive(Debug, clap::Args)]
struct Common {
    /// Results as JSON; `-` is stdout.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    unit: UnitArgs,
    #[command(flatten)]
    scene: SceneArgs,
}

#[derive(Debug, clap::Args)]
struct TilesArgs {
    /// Folder for a picture of each comparison; made if it is not there.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    common: Common,
}

#[derive(Debug, clap::Args)]
struct FormatsArgs {
    /// Scene with ray cones.
    #[arg(default_value = "vases")]
    name: String,
    /// Most bounces of a path; paths go on to it however little they still weigh.
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(0..=256))]
    bounces: u32,
    #[command(flatten)]
    common: Common,
}

#[derive(Debug, clap::Args)]
struct CubeArgs {
    /// Places from a face's middle to its edge, and to its corner.
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=1000))]
    steps: u32,
    /// Results as JSON; `-` is stdout.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    match &args.study {
        Study::Tiles(args) => run_tiles(args),
        Study::Formats(args) => run_formats(args),
        Study::Cube(args) => run_cube(args),
    }
}

fn run_tiles(args: &TilesArgs) -> Result<(), Failure> {
    let Common { json, unit, scene } = &args.common;
    scene.refuse_distance()?;
    let target = JsonTarget::open(json.as_deref())?;
    let spec = unit.load()?;
    let options = subject::options(scene)?;
    let mut files = Vec::new();
    if let Some(out) = &args.out {
        let folder = output_folder(out)?;
        for pair in tiles::COMPARISONS {
            files.push(folder.file(format!("{}.png", pair.name))?);
        }
    }
    let floor = subject::load_texture(scene)?;
    let sky = subject::load_sky(scene)?;
    let mut table = Table::new(&[
        ("scene", Align::Left),
        ("variant", Align::Left),
        ("requests", Align::Right),
        ("tiles", Align::Right),
        ("of level 0", Align::Right),
        ("texels", Align::Right),
        ("ratio", Align::Right),
        ("note's tiles", Align::Right),
        ("note's ratio", Align::Right),
    ]);
    let mut rows = Vec::new();
    let mut files = files.into_iter();
    let mut done = Vec::new();
    for pair in tiles::COMPARISONS {
        let mut both = Vec::new();
        for variant in &pair.variants {
            let pixels = num::u64(options.width * options.height);
            let bar = Bar::new(&format!("{} {}", pair.name, variant.label), pixels);
            let maps = (floor.as_ref(), &sky);
            both.push(tiles::render(variant, &spec, &options, maps, &|n| bar.add(n))?);
        }
        let first = both.first().map_or(1, |t| t.tiles()[0]).max(1) as f64;
        let note_first = pair.variants[0].note;
        for (variant, taken) in pair.variants.iter().zip(&both) {
            let [all, finest] = taken.tiles();
            let ratio = all as f64 / first;
            let note_ratio = match (variant.note, note_first) {
                (Some(n), Some(of)) => Some(f64::from(n) / f64::from(of)),
                _ => None,
            };
            table.row([
                pair.name.to_string(),
                variant.label.to_string(),
                count(taken.requests),
                count(num::u64(all)),
                count(num::u64(finest)),
                count(taken.rendering.texels),
                fixed(ratio, 2),
                variant.note.map_or("-".into(), |n| n.to_string()),
                note_ratio.map_or("-".into(), |r| fixed(r, 2)),
            ]);
            let by: Vec<Value> = taken
                .rendering
                .texture_use
                .iter()
                .flat_map(|u| &u.tiles)
                .map(|t| json!({"total": t.total(), "by_level": t.counts()}))
                .collect();
            rows.push(json!({
                "comparison": pair.name, "variant": variant.label, "scene": variant.scene,
                "cone.metric": variant.metric.name(), "cone.count": variant.cones,
                "requests": taken.requests, "tiles": all, "textures": by,
                "texels": taken.rendering.texels, "ratio": ratio, "note_tiles": variant.note,
                "note_ratio": note_ratio,
            }));
        }
        if let Some(mut file) = files.next() {
            let picture = side_by_side(&pair, &both);
            let origin = Origin::new(&spec);
            let attributes = origin.attributes(&format!("tiles of {}", pair.name));
            file.write_with(|w| write_png(w, &picture, scene.exposure, &attributes))?;
            done.push(file);
        }
    }
    commit_all(done)?;
    let mut root = Origin::new(&spec).json();
    root.insert("size".into(), json!([options.width, options.height]));
    root.insert("unit".into(), unit_json(&spec));
    root.insert("rows".into(), Value::Array(rows));
    if !target.takes_stdout() {
        let mut out = std::io::stdout().lock();
        writeln!(
            out,
            "{}x{}; tapline {}, unit {}, seed 0; ratios to the first of each pair\n\n{table}",
            options.width,
            options.height,
            env!("CARGO_PKG_VERSION"),
            spec.hash()
        )?;
    }
    target.write(&Value::Object(root))
}

/// Both pictures, both in level colours, both textures' tiles.
fn side_by_side(pair: &tiles::Comparison, both: &[tiles::Taken]) -> Picture {
    let mut shown: Vec<(Picture, String)> = Vec::new();
    for (variant, taken) in pair.variants.iter().zip(both) {
        shown.push((taken.rendering.picture.clone(), variant.label.to_string()));
    }
    for (variant, taken) in pair.variants.iter().zip(both) {
        if let Some(used) = &taken.rendering.texture_use {
            let label = format!("{}: levels", variant.label);
            shown.push((used.levels.clone(), label));
        }
    }
    for taken in both {
        if let Some(first) = taken.rendering.texture_use.as_ref().and_then(|u| u.tiles.first()) {
            shown.push((first.picture(), format!("{} tiles", taken.tiles()[0])));
        }
    }
    let row: Vec<(&Picture, &str)> = shown.iter().map(|(p, l)| (p, l.as_str())).collect();
    mosaic(&row, 8)
}

fn run_formats(args: &FormatsArgs) -> Result<(), Failure> {
    let Common { json, unit, scene } = &args.common;
    scene.refuse_distance()?;
    let target = JsonTarget::open(json.as_deref())?;
    let spec = unit.load()?;
    let options = subject::options(scene)?;
    let floor = subject::load_texture(scene)?;
    let sky = subject::load_sky(scene)?;
    let mut scene = tex::build(&args.name, &options, floor)?;
    scene.notes.iter().for_each(|note| super::note(note));
    scene.bounces = args.bounces;
    scene.endless = true;
    let subject = TexSubject::new(scene, sky);
    let steps = num::u64(formats::FORMATS.len() * options.height);
    let bar = Bar::new("formats", steps);
    let found = formats::study(&subject, &spec, &|n| bar.add(n))?;
    drop(bar);
    let mut table = Table::new(&[
        ("cones", Align::Left),
        ("from bounce", Align::Right),
        ("requests", Align::Right),
        ("LOD error p50", Align::Right),
        ("p95", Align::Right),
        ("p99", Align::Right),
        ("max", Align::Right),
        ("bias", Align::Right),
        ("2 levels off (%)", Align::Right),
        ("w error p50 (%)", Align::Right),
        ("p95 (%)", Align::Right),
        ("tiles", Align::Right),
        ("by doubles", Align::Right),
    ]);
    let mut rows = Vec::new();
    for row in &found {
        let (name, _, _) = formats::FORMATS[row.format];
        let far = 100.0 * row.far as f64 / row.requests.max(1) as f64;
        let [p50, p95, p99, max] = row.lod_error.map(|e| significant(e, 2));
        let [w50, w95] = row.width_error.map(|e| significant(100.0 * e, 2));
        table.row([
            name.to_string(),
            row.bounce.to_string(),
            count(num::u64(row.requests)),
            p50,
            p95,
            p99,
            max,
            significant(row.bias, 2),
            significant(far, 2),
            w50,
            w95,
            count(num::u64(row.tiles)),
            count(num::u64(row.reference_tiles)),
        ]);
        rows.push(json!({
            "cones": name, "from_bounce": row.bounce, "requests": row.requests,
            "lod_error": {"p50": row.lod_error[0], "p95": row.lod_error[1], "p99": row.lod_error[2], "max": row.lod_error[3]},
            "lod_bias": row.bias, "two_levels_off": row.far,
            "width_error": {"p50": row.width_error[0], "p95": row.width_error[1]},
            "tiles": row.tiles, "tiles_by_doubles": row.reference_tiles,
        }));
    }
    let mut root = Origin::new(&spec).json();
    root.insert("scene".into(), json!(args.name));
    root.insert("size".into(), json!([options.width, options.height]));
    root.insert("bounces".into(), json!(args.bounces));
    root.insert("unit".into(), unit_json(&spec));
    root.insert("rows".into(), Value::Array(rows));
    if !target.takes_stdout() {
        let mut out = std::io::stdout().lock();
        writeln!(
            out,
            "{} {}x{}, up to {} bounces; tapline {}, unit {}, seed 0; errors against cones in doubles\n\n{table}",
            args.name,
            options.width,
            options.height,
            args.bounces,
            env!("CARGO_PKG_VERSION"),
            spec.hash()
        )?;
    }
    target.write(&Value::Object(root))
}

fn run_cube(args: &CubeArgs) -> Result<(), Failure> {
    let target = JsonTarget::open(args.json.as_deref())?;
    let rows = cube::rows(args.steps);
    let mut table = Table::new(&[
        ("u", Align::Right),
        ("v", Align::Right),
        ("exact λ1/α", Align::Right),
        ("exact λ2/α", Align::Right),
        ("constant/α", Align::Right),
        ("over λ1 (%)", Align::Right),
        ("over λ2 (%)", Align::Right),
        ("over √(λ1λ2) (%)", Align::Right),
    ]);
    let mut values = Vec::new();
    for row in &rows {
        let [a, b, mean] = row.errors().map(|e| 100.0 * e);
        table.row([
            fixed(row.place[0], 3),
            fixed(row.place[1], 3),
            fixed(row.exact[0], 4),
            fixed(row.exact[1], 4),
            fixed(row.constant, 4),
            fixed(a, 1),
            fixed(b, 1),
            fixed(mean, 1),
        ]);
        values.push(json!({
            "u": row.place[0], "v": row.place[1], "exact": row.exact, "constant": row.constant,
            "over_major": a / 100.0, "over_minor": b / 100.0, "over_mean": mean / 100.0,
        }));
    }
    let spec = crate::unit::UnitSpec::default();
    let mut root = Origin::new(&spec).json();
    root.insert("rows".into(), Value::Array(values));
    if !target.takes_stdout() {
        let mut out = std::io::stdout().lock();
        writeln!(
            out,
            "a cone of 0.01 rad on face +z, in units of u, v in [-1, 1]; tapline {}\n\n{table}",
            env!("CARGO_PKG_VERSION")
        )?;
    }
    target.write(&Value::Object(root))
}
