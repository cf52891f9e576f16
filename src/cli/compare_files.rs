//! The files of `compare --out`: pictures, error maps, the row of three and `report.html`.

use std::path::Path;

use serde_json::Value;

use super::Failure;
use super::compare::{Args, Results};
use super::job::{Job, extra_pictures};
use super::output::{Origin, output_folder};
use crate::engine::Rung;
use crate::error::InputError;
use crate::image::temporary::OutputFolder;
use crate::image::whole::WholeFile;
use crate::image::write::{Sample, write_exr, write_png};
use crate::picture::Picture;
use crate::report::error_map::{error_map, mosaic};
use crate::report::html;
use crate::scene::registry::find;
use crate::settings::Settings;

/// The files of `--out`, all created before the work starts.
pub(super) struct OutFiles {
    engines: Vec<(Rung, WholeFile, WholeFile)>,
    maps: Vec<(Rung, Rung, WholeFile)>,
    row: Option<WholeFile>,
    /// Those of [`extra_pictures`].
    extra: Vec<(&'static str, WholeFile)>,
    report: WholeFile,
    /// Last, so that it is dropped after the temporaries in it.
    folder: OutputFolder,
}

impl OutFiles {
    /// Makes the folder and a temporary for each file of these engines.
    pub(super) fn create(folder: &Path, rungs: &[Rung], scene: &str) -> Result<Self, InputError> {
        let made = output_folder(folder)?;
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
        let mut pictures = Vec::new();
        for name in extra_pictures(find(scene)?.operation()) {
            pictures.push((*name, file(format!("{name}.png"))?));
        }
        let both = rungs.contains(&Rung::Rtl) && rungs.contains(&Rung::F64);
        Ok(Self {
            engines,
            maps,
            row: if both { Some(file("row.png".into())?) } else { None },
            extra: pictures,
            report: file("report.html".into())?,
            folder: made,
        })
    }

    /// Writes every file, then gives all of them their names.
    pub(super) fn write(
        self,
        args: &Args,
        origin: &Origin,
        job: &Job,
        settings: &Settings,
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
            let bytes =
                png(&map, 0.0, &origin.attributes(&format!("{}, difference {name}", args.scene)))?;
            done.push(put(file, &bytes)?);
            images.push((name, bytes));
        }
        if let (Some(file), Some(a), Some(b)) =
            (self.row, results.get(Rung::Rtl), results.get(Rung::F64))
        {
            let map = error_map(&a.picture, &b.picture, exposure)?;
            let row = mosaic(&[(&a.picture, "rtl"), (&b.picture, "f64"), (&map, "difference")], 8);
            let bytes = png(&row, exposure, &origin.attributes(&args.scene))?;
            done.push(put(file, &bytes)?);
        }
        let made = job.extra(
            settings,
            [Rung::Rtl, Rung::F64].map(|rung| results.get(rung)),
            results.get(Rung::Truth),
            results.caustics.as_ref(),
        );
        for (name, file) in self.extra {
            let Some((_, picture)) = made.iter().find(|(n, _)| *n == name) else {
                continue;
            };
            let data = ["iterations", "levels", "tiles"].contains(&name);
            let shown = if data { 0.0 } else { exposure };
            let attributes = origin.attributes(&format!("{}, {name}", args.scene));
            let bytes = png(picture, shown, &attributes)?;
            done.push(put(file, &bytes)?);
            images.push((name.to_string(), bytes));
        }
        done.push(put(self.report, html::page(value, &images).as_bytes())?);
        for file in done {
            file.commit()?;
        }
        self.folder.keep();
        Ok(())
    }
}
