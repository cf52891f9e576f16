//! `fingerprint`: what a GPU's sampler does.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::Failure;
use super::args::AdapterArgs;
use super::output::{JsonTarget, output_folder};
use super::progress::Bar;
use crate::fingerprint::{self, Fingerprint};
use crate::gpu::AdapterFacts;
use crate::gpu::sampling::DeviceSampler;
use crate::image::temporary::OutputFolder;
use crate::image::whole::WholeFile;
use crate::image::write::write_png;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    adapter: AdapterArgs,
    /// Results as JSON; `-` is stdout.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Picture (a name that ends in .png), or a folder for fingerprint.png, fingerprint.json and fingerprint.txt.
    #[arg(long, value_name = "DIR|FILE.png")]
    out: Option<PathBuf>,
}

/// The files of `--out`, created before the work starts.
struct OutFiles {
    picture: WholeFile,
    /// JSON and text, in a folder.
    words: Option<(WholeFile, WholeFile)>,
    folder: Option<OutputFolder>,
}

impl OutFiles {
    fn create(path: &Path) -> Result<Self, Failure> {
        if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")) {
            return Ok(Self { picture: WholeFile::create(path)?, words: None, folder: None });
        }
        let folder = output_folder(path)?;
        let file = |name: &str| WholeFile::create(path.join(name));
        Ok(Self {
            picture: file("fingerprint.png")?,
            words: Some((file("fingerprint.json")?, file("fingerprint.txt")?)),
            folder: Some(folder),
        })
    }

    fn write(mut self, adapter: &str, found: &Fingerprint, value: &Value) -> Result<(), Failure> {
        use std::io::Write as _;
        let picture = fingerprint::draw(adapter, found);
        let text = [
            ("tapline.version", env!("CARGO_PKG_VERSION")),
            ("tapline.picture", "sampler fingerprint"),
            ("tapline.adapter", adapter),
        ]
        .map(|(k, v)| (k.to_string(), v.to_string()));
        self.picture.write_with(|w| write_png(w, &picture, 0.0, &text))?;
        let json = serde_json::to_string_pretty(value).map_err(std::io::Error::from)?;
        if let Some((json_file, text_file)) = &mut self.words {
            json_file.write_with(|w| writeln!(w, "{json}"))?;
            text_file.write_with(|w| fingerprint::print(w, adapter, found))?;
        }
        self.picture.commit()?;
        if let Some((json_file, text_file)) = self.words {
            json_file.commit()?;
            text_file.commit()?;
        }
        if let Some(folder) = self.folder {
            folder.keep();
        }
        Ok(())
    }
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let files = args.out.as_deref().map(OutFiles::create).transpose()?;
    let target = JsonTarget::open(args.json.as_deref())?;
    let gpu = args.adapter.open()?;
    let bar = Bar::new("fingerprint", fingerprint::STEPS);
    let found = fingerprint::fingerprint(&mut DeviceSampler::new(&gpu), &|_| bar.add(1))?;
    drop(bar);
    let title = gpu.adapter().title();
    let value = with_adapter(gpu.adapter(), fingerprint::to_json(&found));
    if !target.takes_stdout() {
        fingerprint::print(&mut std::io::stdout().lock(), &title, &found)?;
    }
    if let Some(files) = files {
        files.write(&title, &found, &value)?;
    }
    target.write(&value)
}

/// The findings behind the adapter's facts.
fn with_adapter(facts: &AdapterFacts, found: Value) -> Value {
    let mut value = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "seed": 0,
        "adapter": {
            "name": facts.name,
            "backend": facts.backend,
            "driver": facts.driver,
            "driver_info": facts.driver_info,
            "type": facts.kind,
        },
    });
    if let (Some(value), Value::Object(found)) = (value.as_object_mut(), found) {
        value.extend(found);
    }
    value
}
