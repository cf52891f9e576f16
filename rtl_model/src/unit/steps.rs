//! The steps of ENV, and how a state keeps their results.
//!
//! Only the flags are shared by all steps: a kept state has a copy of them behind each.

use core::hash::{Hash as _, Hasher};

use super::Unit;
use super::block::{NO_FLAGS, Ports, State, Words};
use super::operation::{BlockOf, Memory, Operation};
use crate::fx::Flags;
use crate::tap::Tap;

/// Most steps of an operation in front of the filter.
const MOST_STEPS: usize = 11;

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

    /// The ports, nine stages, and the first half of `jacobian`, which has a step of its own.
    const STEPS: usize = MOST_STEPS;

    fn unit(&self) -> &Unit {
        self
    }

    #[inline(always)]
    fn put<const N: usize>(&self, words: &Words, front: &mut Ports<N>, lane: usize) {
        self.put_words(words, front, lane);
    }

    #[inline(always)]
    fn steps<const N: usize, T: Tap>(
        &self,
        first: usize,
        _: &Memory,
        blocks: &mut [BlockOf<Self, N>],
        tap: &mut T,
    ) {
        for block in blocks.iter_mut() {
            block.env.step(0, first, |env| self.ports(&block.front, env, tap));
        }
        macro_rules! each {
            ($($number:literal $stage:ident)+) => { $(
                for block in blocks.iter_mut() {
                    block.env.step($number, first, |env| self.$stage(env, tap));
                }
            )+ };
        }
        each!(1 local_frame 2 bump 3 reflect 4 cube_face 5 normal 6 jacobian 7 roughness 8 covariance 9 eigen
            10 footprint);
    }

    fn hash_step<H: Hasher>(&self, number: usize, hasher: &mut H) {
        let roms = &self.roms;
        self.needs.hash(hasher);
        match number {
            0 => {
                (&self.reflect.v, &self.reflect.n).hash(hasher);
                (&self.jacobian.dv, &self.normal.dn).hash(hasher);
                self.frame.as_ref().map(|f| (&f.n, &f.h)).hash(hasher);
                self.bump.as_ref().map(|b| &b.b).hash(hasher);
                self.roughness.as_ref().map(|r| &r.d).hash(hasher);
            }
            1 => (&self.frame, roms.rsqrt.spec, roms.sqrt.spec).hash(hasher),
            2 => self.bump.hash(hasher),
            3 => (&self.reflect, self.bump_frac).hash(hasher),
            4 => (&self.face, roms.recip.spec).hash(hasher),
            5 => (&self.normal, roms.recip.spec).hash(hasher),
            6 => self.jacobian.hash(hasher),
            7 => self.roughness.hash(hasher),
            8 => (&self.covariance, self.block_d).hash(hasher),
            9 => {
                (&self.eigen, roms.rsqrt.spec, roms.sqrt.spec).hash(hasher);
                (roms.recip.spec, roms.angle.spec, roms.angle.placement).hash(hasher);
            }
            _ => (&self.footprint, roms.log2.spec).hash(hasher),
        }
    }
}
