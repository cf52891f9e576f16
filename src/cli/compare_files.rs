//! The files of `compare --out`: pictures, error maps, the row of three and `report.html`.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::Path;

use serde_json::Value;

use super::Failure;
use super::compare::{Args, Results};
use super::extra::{Drawing, Extra};
use super::output::{Origin, output_folder};
use crate::engine::{EngineKind, Job};
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
    pub(super) fn create(
        folder: &Path,
        kinds: &[EngineKind],
        scene: &str,
    ) -> Result<Self, InputError> {
        let folder = output_folder(folder)?;
        let mut names = vec!["report.html".to_string()];
        for kind in kinds {
            names.extend(["exr", "png"].map(|ending| format!("{}.{ending}", kind.name())));
        }
        names.extend(kinds.windows(2).map(|p| format!("{}-{}.png", p[0].name(), p[1].name())));
        names.extend(
            Extra::of(find(scene)?.operation()).iter().map(|e| format!("{}.png", e.name())),
        );
        if kinds.contains(&EngineKind::Rtl) && kinds.contains(&EngineKind::F64) {
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
        for (kind, r) in &results.renderings {
            let (name, what) = (kind.name(), format!("{} by {}", args.scene, kind.name()));
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
        let drawing = Drawing::new(job, settings, results);
        for extra in Extra::of(job.operation()) {
            if let Some(picture) = drawing.picture(*extra) {
                let (name, exposure) = (extra.name(), if extra.is_data() { 0.0 } else { exposure });
                show(name, &format!("{}, {name}", args.scene), &picture, exposure)?;
            }
        }
        if let (Some(a), Some(b)) = (results.get(EngineKind::Rtl), results.get(EngineKind::F64)) {
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
