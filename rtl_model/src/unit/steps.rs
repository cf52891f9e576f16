//! The steps of ENV, and how a state keeps their results.
//!
//! Only the flags are shared by all steps: a kept state has a copy of them behind each.

use core::hash::{Hash, Hasher};

use lanes::Simd;

use super::block::{Block, NO_FLAGS, State, Words};
use super::operation::{BlockOf, Memory, Operation};
use super::{EnvBlock, Unit};
use crate::fx::Flags;
use crate::tap::Tap;

/// Most steps of an operation in front of the filter: ENV has them.
const MOST_STEPS: usize = Unit::STEPS;

/// An operation's steps from one list: a row holds its number, what the step runs and what its results depend on,
/// besides the steps before it and the memory. The steps leave out blocks for which `used` is false.
macro_rules! steps {
    (
        |$unit:ident, $simd:ident, $front:ident, $env:ident, $memory:ident, $tap:ident| if |$number:ident| $used:expr;
        $($k:literal: $run:expr => $reads:expr;)+
    ) => {
        const STEPS: usize = [$($k),+].len();

        #[inline(always)]
        fn step<const K: usize, S: Simd, const N: usize, T: Tap>(
            &self,
            $simd: S,
            $memory: &Memory,
            block: &mut BlockOf<Self, N>,
            $tap: &mut T,
        ) {
            let ($unit, _) = (self, $memory);
            let Block { front: $front, env: $env } = block;
            let _ = &$front;
            match K {
                $($k => $run,)+
                _ => {}
            }
        }

        #[inline(always)]
        fn runs<const N: usize>(&self, $number: usize, block: &BlockOf<Self, N>) -> bool {
            let Block { front: $front, env: $env } = block;
            let _ = (&$front, &$env, $number);
            $used
        }

        fn hash_step<H: Hasher>(&self, number: usize, hasher: &mut H) {
            let $unit = self;
            match number {
                $($k => $reads.hash(hasher),)+
                _ => {}
            }
        }
    };
}
pub(super) use steps;

/// Flags behind each step.
pub(super) type StepFlags<const N: usize> = [[Flags; N]; MOST_STEPS];

impl<const N: usize> State<N> {
    /// A state that remembers the flags behind each step.
    pub(super) fn kept() -> Self {
        Self { step_flags: Some([[NO_FLAGS; N]; MOST_STEPS]), ..Self::default() }
    }

    /// Before a step: the first one that runs finds the flags as they were behind the step before it. A closure
    /// around the step would not inherit the instructions that it runs under.
    #[inline(always)]
    pub(super) fn begin(&mut self, number: usize, first: usize) {
        if number == first
            && let Some(before) = number.checked_sub(1)
            && let Some(flags) = self.step_flags.as_ref().and_then(|f| f.get(before))
        {
            self.flags = *flags;
        }
    }

    /// Behind a step.
    #[inline(always)]
    pub(super) fn end(&mut self, number: usize) {
        if let Some(kept) = self.step_flags.as_mut().and_then(|f| f.get_mut(number)) {
            *kept = self.flags;
        }
    }
}

impl Operation for Unit {
    type Words = Words;
    type Front<const N: usize> = ();

    fn unit(&self) -> &Unit {
        self
    }

    #[inline(always)]
    fn put<const N: usize>(&self, words: &Words, block: &mut EnvBlock<N>, lane: usize) {
        self.put_words(words, &mut block.env.words, lane);
    }

    steps! { |unit, simd, front, env, memory, tap| if |_number| true;
        0: {
            env.flags = [NO_FLAGS; N];
            unit.ports(simd, env, tap);
        } => (
            (unit.needs, &unit.reflect.v, &unit.reflect.n, &unit.jacobian.dv, &unit.normal.dn),
            unit.frame.as_ref().map(|frame| (&frame.n, &frame.h)),
            unit.bump.as_ref().map(|bump| &bump.b),
            unit.roughness.as_ref().map(|rough| &rough.d),
        );
        1: unit.local_frame(simd, env, tap) => (&unit.frame, unit.roms.rsqrt.spec, unit.roms.sqrt.spec);
        2: unit.bump(simd, env, tap) => &unit.bump;
        3: unit.reflect(simd, env, tap) => (&unit.reflect, unit.bump_frac);
        4: unit.cube_face(simd, env, tap) => unit.face_reads();
        5: unit.normal_derivative(simd, env, tap) => (&unit.normal, unit.roms.recip.spec);
        6: unit.jacobian(simd, env, tap) => &unit.jacobian;
        7: unit.roughness(simd, env, tap) => &unit.roughness;
        8: unit.covariance(simd, env, tap) => unit.covariance_reads();
        9: unit.eigen(simd, env, tap) => unit.eigen_reads();
        10: unit.footprint(simd, env, tap) => unit.footprint_reads();
    }
}

/// What the steps depend on that ENV shares with the other operations.
impl Unit {
    pub(super) fn face_reads(&self) -> impl Hash {
        (&self.face, self.roms.recip.spec)
    }

    pub(super) fn covariance_reads(&self) -> impl Hash {
        (&self.covariance, self.block_d)
    }

    pub(super) fn eigen_reads(&self) -> impl Hash {
        let roms = &self.roms;
        let angle = (roms.angle.spec, roms.angle.placement);
        (&self.eigen, roms.rsqrt.spec, roms.sqrt.spec, roms.recip.spec, angle)
    }

    pub(super) fn footprint_reads(&self) -> impl Hash {
        (&self.footprint, self.roms.log2.spec)
    }
}
