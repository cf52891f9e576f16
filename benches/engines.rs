//! Speed of the unit, stage by stage and whole, beside the float reference and a floor, in one run.
//!
//! Every part is the function that the engine runs, in the engine's order: a group of blocks, whose states are reused,
//! goes through all steps, and each is timed on its way. Parts and engines take turns, and the lowest of the rounds
//! counts. Only ratios within a run are meaningful.
//!
//!     taskset -c 1 cargo bench --bench engines               # all
//!     target/release/deps/engines-… --once SCENE             # the whole engine once, for counting instructions
//!
//! The run fails where the front end takes more than 1.15 times the sum of its stages, or the whole engine more than
//! 1.1 times its front and back end: then something else than the timed functions runs.
#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    clippy::cast_sign_loss,
    clippy::needless_range_loop,
    reason = "bench code on small numbers; loops over an index are what becomes vector code"
)]

mod support;

use std::hint::black_box;
use std::process::ExitCode;

use support::env::Env;
use support::{Table, others};

/// Rounds of each part.
const ROUNDS: usize = 15;

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().collect();
    if let Some(at) = args.iter().position(|a| a == "--once") {
        let env = Env::new(args.get(at + 1).map_or("sphere", String::as_str), 256);
        println!("{} fragments, {} probes", env.fragments(), black_box(env.whole()));
        return ExitCode::SUCCESS;
    }
    let mut table = Table::default();
    for (scene, size) in [("sphere", 256), ("scratches", 256), ("sphere", 512), ("scratches", 512)]
    {
        Env::new(scene, size).measure(ROUNDS, &mut table);
    }
    others::hit(ROUNDS, &mut table);
    others::tex(ROUNDS, &mut table);
    table.finish()
}
