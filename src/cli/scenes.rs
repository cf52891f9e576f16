//! `scenes`: what is built in and which stages each needs.

use std::io::Write as _;
use std::path::PathBuf;

use serde_json::json;

use super::Failure;
use super::output::JsonTarget;
use crate::scene::SCENES;
use crate::scene::hit::HIT_SCENES;
use crate::scene::tex::TEX_SCENES;
use crate::stage::Stage;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// The list as JSON; `-` is stdout.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let target = JsonTarget::open(args.json.as_deref())?;
    if !target.takes_stdout() {
        let mut out = std::io::stdout().lock();
        for scene in SCENES.iter().chain(HIT_SCENES).chain(TEX_SCENES) {
            writeln!(out, "{}: {}", scene.name, scene.description)?;
            writeln!(out, "    operations: {}", scene.operations.join(" "))?;
            let names: Vec<&str> = scene.stages.iter().map(|s| s.name()).collect();
            writeln!(out, "    stages: {}", names.join(" "))?;
            let unused: Vec<&str> =
                Stage::ALL.iter().filter(|s| !scene.stages.contains(s)).map(|s| s.name()).collect();
            if !unused.is_empty() {
                let with_bump =
                    if scene.operations.contains(&"env") { " (with --bump they are)" } else { "" };
                writeln!(out, "    not built: {}{with_bump}", unused.join(" "))?;
            }
        }
    }
    let list: Vec<_> = SCENES
        .iter()
        .chain(HIT_SCENES)
        .chain(TEX_SCENES)
        .map(|s| {
            let stages: Vec<&str> = s.stages.iter().map(|s| s.name()).collect();
            json!({"name": s.name, "description": s.description, "operations": s.operations, "stages": stages})
        })
        .collect();
    target.write(&json!({"version": env!("CARGO_PKG_VERSION"), "scenes": list}))
}
