//! The steps of ENV, and how a state keeps their results.
//!
//! Only the flags are shared by all steps: a kept state has a copy of them behind each.

use core::hash::{Hash, Hasher};

use super::Unit;
use super::block::{Block, NO_FLAGS, Ports, State, Words};
use super::operation::{BlockOf, Memory, Operation};
use crate::fx::Flags;
use crate::tap::Tap;

/// Most steps of an operation in front of the filter: ENV has them.
const MOST_STEPS: usize = Unit::STEPS;

/// An operation's steps from one list: a row holds what a step runs and what its results depend on, besides the steps
/// before it and the memory. The steps leave out blocks for which `used` is false.
macro_rules! steps {
    (
        |$unit:ident, $front:ident, $env:ident, $memory:ident, $tap:ident| if |$number:ident| $used:expr;
        $($run:expr => $reads:expr;)+
    ) => {
        const STEPS: usize = [$(stringify!($run)),+].len();

        #[inline(always)]
        fn steps<const N: usize, T: Tap>(
            &self,
            first: usize,
            $memory: &Memory,
            blocks: &mut [BlockOf<Self, N>],
            $tap: &mut T,
        ) {
            let ($unit, mut next) = (self, 0);
            let _ = $memory;
            $(
                let $number = next;
                next += 1;
                for Block { front: $front, env: $env } in blocks.iter_mut() {
                    let _ = &$front;
                    if $used {
                        $env.step($number, first, |$env| $run);
                    }
                }
            )+
            let _ = next;
        }

        fn hash_step<H: Hasher>(&self, number: usize, hasher: &mut H) {
            let ($unit, mut next) = (self, 0);
            $(
                if number == next {
                    $reads.hash(hasher);
                }
                next += 1;
            )+
            let _ = next;
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

    /// Runs a step unless it lies in front of `first`: its results are there then. The first one that runs finds
    /// the flags as they were behind the step before it.
    #[inline(always)]
    pub(super) fn step(&mut self, number: usize, first: usize, run: impl FnOnce(&mut Self)) {
        if number < first {
            return;
        }
        if number == first
            && let Some(before) = number.checked_sub(1)
            && let Some(flags) = self.step_flags.as_ref().and_then(|f| f.get(before))
        {
            self.flags = *flags;
        }
        run(self);
        if let Some(kept) = self.step_flags.as_mut().and_then(|f| f.get_mut(number)) {
            *kept = self.flags;
        }
    }
}

impl Operation for Unit {
    type Words = Words;
    type Front<const N: usize> = Ports<N>;

    fn unit(&self) -> &Unit {
        self
    }

    #[inline(always)]
    fn put<const N: usize>(&self, words: &Words, front: &mut Ports<N>, lane: usize) {
        self.put_words(words, front, lane);
    }

    steps! { |unit, front, env, memory, tap| if |_number| true;
        unit.ports(front, env, tap) => (
            (unit.needs, &unit.reflect.v, &unit.reflect.n, &unit.jacobian.dv, &unit.normal.dn),
            unit.frame.as_ref().map(|frame| (&frame.n, &frame.h)),
            unit.bump.as_ref().map(|bump| &bump.b),
            unit.roughness.as_ref().map(|rough| &rough.d),
        );
        unit.local_frame(env, tap) => (&unit.frame, unit.roms.rsqrt.spec, unit.roms.sqrt.spec);
        unit.bump(env, tap) => &unit.bump;
        unit.reflect(env, tap) => (&unit.reflect, unit.bump_frac);
        unit.cube_face(env, tap) => unit.face_reads();
        unit.normal_derivative(env, tap) => (&unit.normal, unit.roms.recip.spec);
        unit.jacobian(env, tap) => &unit.jacobian;
        unit.roughness(env, tap) => &unit.roughness;
        unit.covariance(env, tap) => unit.covariance_reads();
        unit.eigen(env, tap) => unit.eigen_reads();
        unit.footprint(env, tap) => unit.footprint_reads();
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
