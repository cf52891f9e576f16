//! `fingerprint`: the rules of a GPU's sampler.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::Failure;
use super::args::AdapterArgs;
use super::output::{JsonTarget, output_folder};
use super::progress::Bar;
use crate::error::InputError;
use crate::fingerprint::{self, Fingerprint};
use crate::gpu::AdapterFacts;
use crate::gpu::sampling::DeviceSampler;
use crate::image::whole::{WholeFile, commit_all};
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

/// The picture, and with a folder the JSON and the text.
fn create(out: &Path) -> Result<Vec<WholeFile>, InputError> {
    if out.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")) {
        return Ok(vec![WholeFile::create(out)?]);
    }
    let folder = output_folder(out)?;
    let names = ["fingerprint.png", "fingerprint.json", "fingerprint.txt"];
    names.into_iter().map(|name| folder.file(name)).collect()
}

fn write(
    mut files: Vec<WholeFile>,
    adapter: &str,
    found: &Fingerprint,
    value: &Value,
) -> Result<(), InputError> {
    let text = [
        ("tapline.version", env!("CARGO_PKG_VERSION")),
        ("tapline.picture", "sampler fingerprint"),
        ("tapline.adapter", adapter),
    ]
    .map(|(k, v)| (k.to_string(), v.to_string()));
    for (index, file) in files.iter_mut().enumerate() {
        file.write_with(|w| match index {
            0 => write_png(w, &fingerprint::draw(adapter, found), 0.0, &text),
            1 => writeln!(w, "{value:#}"),
            _ => fingerprint::print(w, adapter, found),
        })?;
    }
    commit_all(files)
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let files = args.out.as_deref().map(create).transpose()?;
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
        write(files, &title, &found, &value)?;
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
