//! `scenes`: the built-in scenes and the stages that each needs.

use std::io::Write as _;
use std::path::PathBuf;

use serde_json::json;

use super::Failure;
use super::output::JsonTarget;
use crate::operation::Operation;
use crate::scene::registry;
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
        for scene in registry::all() {
            let operation = scene.operation();
            let names =
                |stages: Vec<Stage>| stages.iter().map(|s| s.name()).collect::<Vec<_>>().join(" ");
            writeln!(out, "{}: {}", scene.name, scene.description)?;
            writeln!(out, "    operations: {}", operation.name())?;
            writeln!(out, "    stages: {}", names(operation.stages()))?;
            let unused: Vec<Stage> =
                Stage::ALL.into_iter().filter(|s| !operation.runs(*s)).collect();
            if !unused.is_empty() {
                let env = matches!(operation, Operation::Env(_));
                let with_bump = if env { " (with --bump they are)" } else { "" };
                writeln!(out, "    not built: {}{with_bump}", names(unused))?;
            }
        }
    }
    let list: Vec<_> = registry::all()
        .map(|s| {
            let operation = s.operation();
            let stages: Vec<&str> = operation.stages().iter().map(|s| s.name()).collect();
            json!({"name": s.name, "description": s.description, "operations": [operation.name()], "stages": stages})
        })
        .collect();
    target.write(&json!({"version": env!("CARGO_PKG_VERSION"), "scenes": list}))
}
