//! Runs blocks of requests under the widest vector instructions of the machine.
//!
//! Every step of an operation and its end is a task of its own, compiled once for each level. All of it
//! is integer arithmetic: the bits are the same.

use lanes::Scalar;
pub use lanes::{Level, Runs};
use rtl_model::unit::{Block, BlockOf, Finish, Memory, Operation, Results};
use rtl_model::{NoTap, NoTapStandard, Tap};

/// Requests in a block.
pub const LANES: usize = 32;

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
    fn group<T: Tap>(
        &mut self,
        level: impl Runs,
        first: usize,
        group: &mut [BlockOf<O, LANES>],
        out: &mut Results<LANES>,
        tap: &mut T,
    ) {
        let (unit, memory) = (self.unit, self.memory);
        unit.steps(level, first..O::STEPS, memory, group, tap);
        for block in group {
            level.run(Finish { unit, block, memory, out, tap });
            (self.each)(block, out);
        }
    }

    /// Runs all of them. A unit with other roundings or wider registers is rarely run, and compiled without the
    /// wider instructions to keep builds short.
    pub fn run(mut self, level: Level) {
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
                self.group(level, first, group, &mut out, &mut NoTapStandard);
            } else {
                self.group(Scalar, first, group, &mut out, &mut NoTap);
            }
        }
    }
}
