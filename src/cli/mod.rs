//! The command line: one file per subcommand.

mod args;
mod bounds;
mod budget;
mod bump_file;
mod compare;
mod compare_files;
mod compare_motion;
mod compare_summary;
mod compare_tables;
mod conform;
mod cost;
mod diff;
mod diff_results;
mod extra;
#[cfg(feature = "gpu")]
mod fingerprint;
#[cfg(feature = "gpu")]
mod gpu;
mod impostor;
mod job;
mod output;
mod progress;
mod removed;
mod render;
mod scenes;
mod size;
mod study;
mod study_report;
mod study_slurm;
mod study_table;
mod subject;
mod tables;
mod trace;
mod unit;
pub mod untrusted;
mod vectors;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::error::InputError;

/// Prints a warning on stderr. Control characters, which a file name or a file's contents may bring, are escaped;
/// a closed stderr is no reason to stop.
fn note(text: &str) {
    use std::io::Write as _;
    let mut line = String::from("tapline: ");
    for c in text.chars() {
        if c.is_control() {
            line.extend(c.escape_default());
        } else {
            line.push(c);
        }
    }
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}

/// Why a command did not end with status 0.
#[derive(Debug)]
pub enum Failure {
    /// Usage or input: status 2.
    Input(InputError),
    /// The command ran and found a disagreement: status 1.
    Disagrees(String),
    /// Whoever read the output has gone: not worth a word.
    Closed,
}

impl From<InputError> for Failure {
    fn from(error: InputError) -> Self {
        Self::Input(error)
    }
}

impl From<std::io::Error> for Failure {
    fn from(error: std::io::Error) -> Self {
        if error.kind() == std::io::ErrorKind::BrokenPipe {
            Self::Closed
        } else {
            Self::Input(InputError::new(
                "output",
                "a stream that can be written",
                error.to_string(),
                "check the disk and the pipe",
            ))
        }
    }
}

/// Bit-accurate simulator of a texture unit for filtered environment maps.
#[derive(Debug, Parser)]
#[command(name = "tapline", version, propagate_version = true, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Render a scene with every engine and print how far each is from the next.
    Compare(compare::Args),
    /// Render one picture with one engine.
    Render(render::Args),
    /// Every register of one fragment, or of each line of a file.
    Trace(trace::Args),
    /// The built-in scenes and the stages that they need.
    Scenes(scenes::Args),
    /// Print or check a unit.
    Unit(unit::Args),
    /// Print a table's contents.
    Tables(tables::Args),
    /// Compare two pictures, or two result files of `compare`.
    Diff(diff::Args),
    /// Test vectors for a stage or the unit: write them, or judge a device's.
    Vectors(vectors::Args),
    /// Sweep knobs over scenes; put parts together, print tables.
    Study(study::Args),
    /// What a unit costs in gates, and the cost model's knobs.
    Cost(cost::Args),
    /// The smallest unit that a scene needs for a bound on its error.
    Size(size::Args),
    /// Write a scene's distance impostor.
    Impostor(impostor::Args),
    /// Run named suites of seeded cases on every engine.
    Conform(conform::Args),
    /// Bound of every register beside the worst error seen; whose words a scene's error comes from.
    Budget(budget::Args),
    /// What a GPU's sampler does: weights, levels of detail, anisotropic taps, cube seams.
    #[cfg(feature = "gpu")]
    Fingerprint(fingerprint::Args),
    /// The GPU adapters that are there.
    #[cfg(feature = "gpu")]
    Gpu(gpu::Args),
}

/// The command line's own definition, from which docs/commands.md is written.
#[must_use]
pub fn command() -> clap::Command {
    use clap::CommandFactory as _;
    Cli::command()
}

/// Runs the command line; the exit status is 0 (done, agrees), 1 (disagrees) or 2 (usage, input).
#[must_use]
pub fn run() -> ExitCode {
    crate::base::quiet::install_quiet_panic_hook();
    if let Err(error) = removed::check(std::env::args_os().skip(1)) {
        note(&error.to_string());
        return ExitCode::from(2);
    }
    let cli = Cli::parse();
    let result = match &cli.command {
        Command::Compare(args) => compare::run(args),
        Command::Render(args) => render::run(args),
        Command::Trace(args) => trace::run(args),
        Command::Scenes(args) => scenes::run(args),
        Command::Unit(args) => unit::run(args),
        Command::Tables(args) => tables::run(args),
        Command::Diff(args) => diff::run(args),
        Command::Vectors(args) => vectors::run(args),
        Command::Study(args) => study::run(args),
        Command::Cost(args) => cost::run(args),
        Command::Size(args) => size::run(args),
        Command::Impostor(args) => impostor::run(args),
        Command::Conform(args) => conform::run(args),
        Command::Budget(args) => budget::run(args),
        #[cfg(feature = "gpu")]
        Command::Fingerprint(args) => fingerprint::run(args),
        #[cfg(feature = "gpu")]
        Command::Gpu(args) => gpu::run(args),
    };
    match result {
        Ok(()) | Err(Failure::Closed) => ExitCode::SUCCESS,
        Err(Failure::Disagrees(what)) => {
            note(&what);
            ExitCode::from(1)
        }
        Err(Failure::Input(error)) => {
            note(&error.to_string());
            ExitCode::from(2)
        }
    }
}
