//! `diff A B`: two pictures, the same metrics as `compare`; or two result files of `compare`.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use serde_json::json;

use super::output::{JsonTarget, Kind, write_picture};
use super::{Failure, diff_results};
use crate::error::InputError;
use crate::image::whole::WholeFile;
use crate::image::write::Sample;
use crate::image::{LoadOptions, load_planar};
use crate::picture::Picture;
use crate::report::error_map::error_map;
use crate::report::flip;
use crate::report::table::{fixed, significant};

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// First picture (EXR, HDR, PNG, JPEG) or result file (JSON).
    a: PathBuf,
    /// Second one of the same kind; the relative error is relative to this one.
    b: PathBuf,
    /// Error map.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Metrics as JSON; `-` is stdout.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Exposure in stops.
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, allow_negative_numbers = true)]
    exposure: f64,
    /// Largest image to read, in MiB of pixels.
    #[arg(long, value_name = "MIB", default_value_t = 512)]
    max_image_mb: u64,
    /// Fail (status 1) below this PSNR in dB.
    #[arg(long, value_name = "DB", allow_negative_numbers = true)]
    min_psnr: Option<f64>,
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    super::subject::check_exposure(args.exposure)?;
    if let Some(least) = args.min_psnr
        && !least.is_finite()
    {
        return Err(InputError::new(
            "--min-psnr",
            "a number of dB",
            least.to_string(),
            "write for instance --min-psnr 50",
        )
        .into());
    }
    let is_result = |path: &Path| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
    if is_result(&args.a) || is_result(&args.b) {
        return results(args);
    }
    let target = JsonTarget::open(args.json.as_deref())?;
    let map_file = match &args.out {
        None => None,
        Some(path) => Some((Kind::of(path)?, WholeFile::create(path)?)),
    };
    let a = load(&args.a, args.max_image_mb)?;
    let b = load(&args.b, args.max_image_mb)?;
    let pair = flip::compare_with_flip(&a, &b, args.exposure)?;
    if !target.takes_stdout() {
        let mut out = std::io::stdout().lock();
        writeln!(
            out,
            "PSNR {}, max {} 8-bit steps at {},{}, RMS {} steps, relative MSE {}, {} % of pixels more than one step off",
            pair.psnr_db.map_or("identical".into(), |db| format!("{} dB", fixed(db, 2))),
            significant(pair.max_lsb8, 3),
            pair.worst_pixel[0],
            pair.worst_pixel[1],
            significant(255.0 * pair.rmse, 3),
            significant(pair.rel_mse, 3),
            significant(100.0 * pair.share_over_1_lsb8, 3),
        )?;
    }
    if let Some((kind, file)) = map_file {
        let map = error_map(&a, &b, args.exposure)?;
        let attributes =
            [("software".to_string(), format!("tapline {}", env!("CARGO_PKG_VERSION")))];
        write_picture(file, kind, &map, 0.0, &attributes, Sample::Half)?;
    }
    let (name_a, name_b) = (args.a.display().to_string(), args.b.display().to_string());
    target.write(
        &json!({"version": env!("CARGO_PKG_VERSION"), "pairs": [pair.to_json(&name_a, &name_b)]}),
    )?;
    match (args.min_psnr, pair.psnr_db) {
        (Some(least), Some(db)) if db < least => {
            Err(Failure::Disagrees(format!("{db:.2} dB, below {least} dB")))
        }
        _ => Ok(()),
    }
}

/// Two result files: nothing of what concerns pictures applies.
fn results(args: &Args) -> Result<(), Failure> {
    for (flag, given) in [("--out", args.out.is_some()), ("--min-psnr", args.min_psnr.is_some())] {
        if given {
            return Err(InputError::new(
                flag,
                "two pictures beside it",
                "result files",
                "leave it out, or name two pictures",
            )
            .into());
        }
    }
    diff_results::run(&args.a, &args.b, JsonTarget::open(args.json.as_deref())?)
}

fn load(path: &Path, max_image_mb: u64) -> Result<Picture, InputError> {
    let subject = path.display().to_string();
    let options = LoadOptions { max_image_mb, ..LoadOptions::default() };
    let image = load_planar(path, &options)?;
    let indices = image.colour(&subject)?.planes();
    let mut picture = Picture::new(image.width, image.height);
    picture.covered.fill(true);
    for (i, rgb) in picture.rgb.iter_mut().enumerate() {
        *rgb = indices.map(|c| image.curve.0.decode(f64::from(image.channels[c].1[i])));
    }
    Ok(picture)
}
