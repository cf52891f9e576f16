//! The files of `compare --out`: pictures, error maps, the row of three and `report.html`.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::Path;

use serde_json::Value;

use super::Failure;
use super::compare::{Args, Results};
use super::job::{Job, extra_pictures};
use super::output::{Origin, output_folder};
use crate::engine::Rung;
use crate::error::InputError;
use crate::image::whole::{OutputFolder, WholeFile, commit_all};
use crate::image::write::{Sample, write_exr, write_png};
use crate::picture::Picture;
use crate::report::error_map::{error_map, mosaic};
use crate::report::html;
use crate::scene::registry::find;
use crate::settings::Settings;

/// The files of `--out`, all checked before the work starts.
pub(super) struct OutFiles {
    files: BTreeMap<String, WholeFile>,
    pub(super) folder: OutputFolder,
}

impl OutFiles {
    /// The files that these engines make.
    pub(super) fn create(folder: &Path, rungs: &[Rung], scene: &str) -> Result<Self, InputError> {
        let folder = output_folder(folder)?;
        let mut names = vec!["report.html".to_string()];
        for rung in rungs {
            names.extend(["exr", "png"].map(|ending| format!("{}.{ending}", rung.name())));
        }
        names.extend(rungs.windows(2).map(|p| format!("{}-{}.png", p[0].name(), p[1].name())));
        names.extend(
            extra_pictures(find(scene)?.operation()).iter().map(|name| format!("{name}.png")),
        );
        if rungs.contains(&Rung::Rtl) && rungs.contains(&Rung::F64) {
            names.push("row.png".into());
        }
        let file = |name: String| Ok((name.clone(), folder.file(name)?));
        let files = names.into_iter().map(file).collect::<Result<_, InputError>>()?;
        Ok(Self { files, folder })
    }

    /// Writes every file, then gives all of them their names.
    pub(super) fn write(
        mut self,
        args: &Args,
        origin: &Origin,
        job: &Job,
        settings: &Settings,
        results: &Results,
        value: &Value,
    ) -> Result<(), Failure> {
        let exposure = args.scene_args.exposure;
        let mut done = Vec::new();
        let mut put = |name: &str, write: &dyn Fn(&mut Vec<u8>) -> std::io::Result<()>| {
            let Some(mut file) = self.files.remove(name) else { return Ok(()) };
            file.write_with(write)?;
            done.push(file);
            Ok::<_, InputError>(())
        };
        let mut images = Vec::new();
        let mut show = |name: &str, what: &str, picture: &Picture, exposure: f64| {
            let mut bytes = Vec::new();
            write_png(&mut bytes, picture, exposure, &origin.attributes(what))?;
            images.push((name.to_string(), bytes));
            Ok::<_, Failure>(())
        };
        for (rung, r) in &results.renderings {
            let (name, what) = (rung.name(), format!("{} by {}", args.scene, rung.name()));
            let attributes = origin.attributes(&what);
            put(&format!("{name}.exr"), &|w| write_exr(w, &r.picture, &attributes, Sample::Float))?;
            show(name, &what, &r.picture, exposure)?;
        }
        for pair in results.renderings.windows(2) {
            let [(a, ra), (b, rb)] = pair else { continue };
            let map = error_map(&ra.picture, &rb.picture, exposure)?;
            let name = format!("{}-{}", a.name(), b.name());
            show(&name, &format!("{}, difference {name}", args.scene), &map, 0.0)?;
        }
        let made = job.extra(
            settings,
            [Rung::Rtl, Rung::F64].map(|rung| results.get(rung)),
            results.get(Rung::Truth),
            results.caustics.as_ref(),
        );
        for (name, picture) in &made {
            let data = ["iterations", "levels", "tiles"].contains(name);
            let exposure = if data { 0.0 } else { exposure };
            show(name, &format!("{}, {name}", args.scene), picture, exposure)?;
        }
        if let (Some(a), Some(b)) = (results.get(Rung::Rtl), results.get(Rung::F64)) {
            let map = error_map(&a.picture, &b.picture, exposure)?;
            let row = mosaic(&[(&a.picture, "rtl"), (&b.picture, "f64"), (&map, "difference")], 8);
            let attributes = origin.attributes(&args.scene);
            put("row.png", &|w| write_png(w, &row, exposure, &attributes))?;
        }
        for (name, png) in &images {
            put(&format!("{name}.png"), &|w| w.write_all(png))?;
        }
        put("report.html", &|w| w.write_all(html::page(value, &images).as_bytes()))?;
        commit_all(done)?;
        Ok(())
    }
}
