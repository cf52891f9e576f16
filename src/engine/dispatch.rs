//! Runs integer code under the widest vector instructions of the machine.
//!
//! The stages are always inlined, so that a [`Task`] is compiled once for each set of instructions. All
//! of it is integer arithmetic: the bits are the same.

use rtl_model::unit::{Block, BlockOf, Memory, Operation, Results};
use rtl_model::{NoTap, NoTapStandard, Tap};

/// Requests in a block.
pub const LANES: usize = 32;

/// Which instructions a task runs under.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// What the target guarantees.
    Baseline,
    /// AVX2 with BMI1, BMI2 and LZCNT.
    #[cfg(target_arch = "x86_64")]
    Avx2,
}

impl Level {
    /// The widest level that this machine runs.
    #[must_use]
    pub fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("lzcnt")
        {
            return Self::Avx2;
        }
        Self::Baseline
    }

    /// Every level that this machine runs, the narrowest first.
    #[must_use]
    pub fn available() -> Vec<Self> {
        let best = Self::detect();
        if best == Self::Baseline { vec![best] } else { vec![Self::Baseline, best] }
    }
}

/// Something to run; its `run` must be `#[inline(always)]`.
pub trait Task {
    /// Its results.
    type Output;

    /// Does it.
    fn run(self) -> Self::Output;
}

/// Runs a task under the instructions of `level`.
pub fn run<T: Task>(level: Level, task: T) -> T::Output {
    #[cfg(target_arch = "x86_64")]
    if level == Level::Avx2 && Level::detect() == Level::Avx2 {
        // SAFETY: `detect` has just found the features that `run_avx2` enables.
        return unsafe { run_avx2(task) };
    }
    let _ = level;
    task.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt")]
fn run_avx2<T: Task>(task: T) -> T::Output {
    task.run()
}

/// Blocks whose stages run side by side, so that a stage's code is fetched once for all of them.
pub const GROUP: usize = 4;

/// Where the blocks of an operation come from.
#[derive(Debug)]
pub enum Source<'a, O: Operation> {
    /// Requests, through the whole operation.
    Words(&'a [O::Words]),
    /// Blocks that stay from unit to unit, from this step on.
    Kept(&'a mut [BlockOf<O, LANES>], usize),
}

/// Takes a block that has run, and its results.
pub type Each<'a, O> = &'a mut dyn FnMut(&BlockOf<O, LANES>, &Results<LANES>);

/// Blocks through an operation.
pub struct Blocks<'a, O: Operation> {
    /// The compiled unit.
    pub unit: &'a O,
    /// Its inputs.
    pub memory: &'a Memory,
    /// The blocks.
    pub source: Source<'a, O>,
    /// Sees every block.
    pub each: Each<'a, O>,
}

impl<O: Operation> Blocks<'_, O> {
    /// Runs a group from a step on.
    #[inline(always)]
    fn group<T: Tap>(
        &mut self,
        first: usize,
        group: &mut [BlockOf<O, LANES>],
        out: &mut Results<LANES>,
        tap: &mut T,
    ) {
        self.unit.steps(first, self.memory, group, tap);
        for block in group {
            self.unit.finish(block, self.memory, out, tap);
            (self.each)(block, out);
        }
    }

    /// A group on a unit with other roundings or wider registers: rarely run, and compiled without the
    /// wider instructions to keep builds short.
    #[cold]
    #[inline(never)]
    fn group_of_any_formats(
        &mut self,
        first: usize,
        group: &mut [BlockOf<O, LANES>],
        out: &mut Results<LANES>,
    ) {
        self.group(first, group, out, &mut NoTap);
    }
}

impl<O: Operation> Task for Blocks<'_, O> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let mut source = std::mem::replace(&mut self.source, Source::Words(&[]));
        let mut passing: Vec<BlockOf<O, LANES>> = Vec::new();
        let mut out = Results::default();
        loop {
            let (group, first) = match &mut source {
                Source::Words(words) if !words.is_empty() => {
                    let (now, later) = words.split_at(words.len().min(GROUP * LANES));
                    let used = now.len().div_ceil(LANES);
                    if passing.len() < used {
                        passing.resize_with(used, Block::default);
                    }
                    for (words, block) in now.chunks(LANES).zip(&mut passing) {
                        self.unit.load(words, block);
                    }
                    *words = later;
                    (&mut passing[..used], 0)
                }
                Source::Kept(blocks, first) if !blocks.is_empty() => {
                    let used = blocks.len().min(GROUP);
                    let (now, later) = std::mem::take(blocks).split_at_mut(used);
                    *blocks = later;
                    (now, *first)
                }
                Source::Words(_) | Source::Kept(..) => return,
            };
            if self.unit.is_standard() {
                self.group(first, group, &mut out, &mut NoTapStandard);
            } else {
                self.group_of_any_formats(first, group, &mut out);
            }
        }
    }
}
