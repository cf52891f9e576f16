//! What the rows of the bench are made of.

pub(crate) mod env;
mod floor;
pub(crate) mod others;

use std::process::ExitCode;
use std::time::Instant;

/// Runs `work` and notes its seconds in `lowest` where they are fewer than before.
pub(crate) fn time<R>(lowest: &mut f64, work: impl FnOnce() -> R) -> R {
    let start = Instant::now();
    let out = work();
    *lowest = lowest.min(start.elapsed().as_secs_f64());
    out
}

/// Lowest seconds of each piece of a part.
#[derive(Clone, Default)]
pub(crate) struct Lowest(Vec<f64>);

impl Lowest {
    /// Notes the seconds of a piece.
    pub(crate) fn note(&mut self, piece: usize, seconds: f64) {
        if piece == self.0.len() {
            self.0.push(seconds);
        }
        self.0[piece] = self.0[piece].min(seconds);
    }

    /// Seconds of all pieces.
    pub(crate) fn seconds(&self) -> f64 {
        self.0.iter().sum()
    }
}

/// Runs `work` on a pool of `n` threads.
pub(crate) fn threads<R: Send>(n: usize, work: impl FnOnce() -> R + Send) -> R {
    // Pools are kept: making one costs more than a part.
    static POOLS: [std::sync::OnceLock<rayon::ThreadPool>; 2] =
        [const { std::sync::OnceLock::new() }; 2];
    POOLS[n - 1]
        .get_or_init(|| rayon::ThreadPoolBuilder::new().num_threads(n).build().expect("threads"))
        .install(work)
}

/// Whether two threads have a core each.
pub(crate) fn two_cores() -> bool {
    std::thread::available_parallelism().is_ok_and(|n| n.get() > 1)
}

/// What is printed, and what must hold.
#[derive(Default)]
pub(crate) struct Table {
    broken: Vec<String>,
}

impl Table {
    /// A heading and the table's head.
    pub(crate) fn head(&mut self, title: &str, columns: &[&str]) {
        println!("\n{title}\n");
        println!("| part | {} |", columns.join(" | "));
        println!("|---|{}", "--:|".repeat(columns.len()));
    }

    /// A row; a number that is not finite stays out.
    pub(crate) fn row(&mut self, name: &str, numbers: &[f64], digits: usize) {
        let cells: Vec<String> = numbers
            .iter()
            .map(|x| if x.is_finite() { format!("{x:.digits$}") } else { String::new() })
            .collect();
        println!("| {name} | {} |", cells.join(" | "));
    }

    /// Notes what is wrong unless `a` is at most `limit` times `b`.
    pub(crate) fn at_most(&mut self, what: &str, a: f64, limit: f64, b: f64) {
        if a > limit * b {
            self.broken.push(format!("{what}: {:.2}, at most {limit}", a / b));
        }
    }

    /// The verdict.
    pub(crate) fn finish(self) -> ExitCode {
        for line in &self.broken {
            eprintln!("FAILED {line}");
        }
        if self.broken.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
    }
}
