//! The common part of the operations: words come into a block of lanes, steps leave their results there, the filter ends it.

use core::fmt::Debug;
use core::hash::Hasher;
use core::ops::Range;

use lanes::{Runs, Scalar, Simd, Task};

use super::Unit;
use super::block::{Block, Results};
use crate::distance::DistanceMemory;
use crate::stages::filter::Corner;
use crate::tap::Tap;
use crate::texture::Texture;

/// What operations read from memory.
#[derive(Clone, Debug, Default)]
pub struct Memory {
    /// Texels; without any an operation ends in front of the filter.
    pub texture: Option<Texture>,
    /// Distances, which HIT alone looks up.
    pub distances: DistanceMemory,
}

/// A block of an operation.
pub type BlockOf<O, const N: usize> = Block<<O as Operation>::Front<N>, N>;

/// A step of an operation over several blocks.
struct Step<'a, O: Operation, const K: usize, const N: usize, T> {
    unit: &'a O,
    first: usize,
    memory: &'a Memory,
    blocks: &'a mut [BlockOf<O, N>],
    tap: &'a mut T,
}

impl<O: Operation, const K: usize, const N: usize, T: Tap> Task for Step<'_, O, K, N, T> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        for block in self.blocks {
            if self.unit.runs(K, block) {
                block.env.begin(K, self.first);
                self.unit.step::<K, S, N, T>(simd, self.memory, block, self.tap);
                block.env.end(K);
            }
        }
    }
}

/// The end of an operation for a block: [`Operation::finish`].
#[derive(Debug)]
pub struct Finish<'a, O: Operation, const N: usize, T> {
    /// The compiled unit.
    pub unit: &'a O,
    /// The block behind its steps.
    pub block: &'a BlockOf<O, N>,
    /// What the filter reads.
    pub memory: &'a Memory,
    /// The results.
    pub out: &'a mut Results<N>,
    /// Who listens.
    pub tap: &'a mut T,
}

impl<O: Operation, const N: usize, T: Tap> Task for Finish<'_, O, N, T> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        self.unit.finish(simd, self.block, self.memory, self.out, self.tap);
    }
}

/// One of the unit's operations: ENV ([`Unit`]), HIT ([`super::HitUnit`]), TEX ([`super::TexUnit`]).
///
/// Each is a row of steps. A step writes its own arrays and reads those of the steps before it, so a unit that
/// differs from another one from a step on finds everything in front of that step in a kept block.
pub trait Operation: Sync {
    /// One request as binary64 words.
    type Words: Copy + Debug + Send + Sync;
    /// The words of a block's lanes and the results of the operation's own stages; ENV's are in its state.
    type Front<const N: usize>: Clone + Debug + Default + Send + Sync;

    /// Steps in front of the filter.
    const STEPS: usize;

    /// The stages of ENV that the operation ends with.
    fn unit(&self) -> &Unit;

    /// Puts the words of one request into a lane of a block; the first step takes them through the ports.
    fn put<const N: usize>(&self, words: &Self::Words, block: &mut BlockOf<Self, N>, lane: usize);

    /// Step `K` for a block.
    fn step<const K: usize, S: Simd, const N: usize, T: Tap>(
        &self,
        simd: S,
        memory: &Memory,
        block: &mut BlockOf<Self, N>,
        tap: &mut T,
    );

    /// Whether a block needs a step.
    fn runs<const N: usize>(&self, number: usize, block: &BlockOf<Self, N>) -> bool;

    /// A row of steps, over blocks in which the steps before have run: each step for all blocks before the next, so
    /// that its code is fetched once, and as a function of its own at `level`. A tap that listens cannot tell the
    /// blocks apart.
    fn steps<const N: usize, T: Tap>(
        &self,
        level: impl Runs,
        steps: Range<usize>,
        memory: &Memory,
        blocks: &mut [BlockOf<Self, N>],
        tap: &mut T,
    ) where
        Self: Sized,
    {
        macro_rules! each {
            ($($k:literal)+) => {
                const { assert!(Self::STEPS <= [$($k),+].len(), "a step without a row") };
                $(if $k < Self::STEPS && steps.contains(&$k) {
                    let first = steps.start;
                    level.run(Step::<Self, $k, N, T> { unit: self, first, memory, blocks, tap });
                })+
            };
        }
        each!(0 1 2 3 4 5 6 7 8 9 10);
    }

    /// Feeds everything that the results of a step depend on, apart from the steps before it and the memory, to a hasher.
    fn hash_step<H: Hasher>(&self, number: usize, hasher: &mut H);

    /// The end of a run after the steps: the filter of the block's lanes, or without a texture their probe counts and flags.
    #[inline(always)]
    fn finish<S: Simd, const N: usize, T: Tap>(
        &self,
        simd: S,
        block: &BlockOf<Self, N>,
        memory: &Memory,
        out: &mut Results<N>,
        tap: &mut T,
    ) {
        self.unit().back(simd, &block.env, memory.texture.as_ref(), out, tap);
    }

    /// Fills a block anew with up to `N` requests.
    #[inline(always)]
    fn load<const N: usize>(&self, words: &[Self::Words], block: &mut BlockOf<Self, N>) {
        block.env.len = words.len().min(N);
        for (lane, words) in words.iter().enumerate().take(N) {
            self.put(words, block, lane);
        }
    }

    /// The whole operation for a block.
    #[inline(always)]
    fn run<const N: usize, T: Tap>(
        &self,
        memory: &Memory,
        block: &mut BlockOf<Self, N>,
        out: &mut Results<N>,
        tap: &mut T,
    ) where
        Self: Sized,
    {
        let blocks = core::slice::from_mut(block);
        self.steps(Scalar, 0..Self::STEPS, memory, blocks, tap);
        self.finish(Scalar, block, memory, out, tap);
    }

    /// Whether the unit may run with a tap whose `STANDARD` is true: every register rounds half-even and saturates.
    fn is_standard(&self) -> bool {
        self.unit().standard
    }

    /// The first texel of each bilinear footprint of a lane, as a cache of tiles sees it.
    #[inline(always)]
    fn touched_corners<const N: usize>(
        &self,
        block: &BlockOf<Self, N>,
        lane: usize,
        texture: &Texture,
        each: &mut dyn FnMut(Corner),
    ) {
        self.unit().corners(&block.env, lane, texture, each);
    }
}
