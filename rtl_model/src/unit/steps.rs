//! An operation as a row of steps whose results can stay where they are.
//!
//! Each step writes its own arrays and reads those of the steps before it, so a unit that differs from
//! another one from a step on finds everything in front of that step in a kept state. Only the flags are
//! shared by all steps: a kept state has a copy of them behind each.

use core::hash::{Hash as _, Hasher};

use super::block::{NO_FLAGS, Ports, State};
use super::{HitState, HitUnit, TexState, TexUnit, Unit};
use crate::fx::Flags;
use crate::tap::Tap;

/// Most steps of an operation in front of the filter.
pub const MOST_STEPS: usize = 11;

/// Flags behind each step.
pub type Marks<const N: usize> = [[Flags; N]; MOST_STEPS];

impl<const N: usize> State<N> {
    /// A state that remembers the flags behind each step.
    #[must_use]
    pub fn kept() -> Self {
        Self { marks: Some([[NO_FLAGS; N]; MOST_STEPS]), ..Self::default() }
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
            && let Some(flags) = self.marks.as_ref().and_then(|m| m.get(before))
        {
            self.flags = *flags;
        }
        run(self);
        if let Some(mark) = self.marks.as_mut().and_then(|m| m.get_mut(number)) {
            *mark = self.flags;
        }
    }

    /// The flags behind a step of a kept state.
    pub(super) fn flags_behind(&self, number: usize) -> Option<&[Flags; N]> {
        self.marks.as_ref().and_then(|m| m.get(number))
    }
}

impl<const N: usize> HitState<N> {
    /// A state that remembers the flags behind each step.
    #[must_use]
    pub fn kept() -> Self {
        Self { env: State::kept(), ..Self::default() }
    }
}

impl<const N: usize> TexState<N> {
    /// A state that remembers the flags behind each step.
    #[must_use]
    pub fn kept() -> Self {
        Self { env: State::kept(), ..Self::default() }
    }
}

/// Steps of the ENV operation in front of the filter: its ports, nine stages, and the first half of
/// `jacobian`, which has a step of its own.
pub const ENV_STEPS: usize = 11;
/// Steps of the HIT operation: the search with its ports, the face, the footprint at the hit, and ENV's last three.
pub const HIT_STEPS: usize = 6;
/// Steps of the TEX operation: `surface_footprint` with its ports, and ENV's last three.
pub const TEX_STEPS: usize = 4;

impl Unit {
    /// [`Unit::fronts`] from step `first` on, over states in which the steps before it have run.
    #[inline(always)]
    pub fn fronts_from<const N: usize, T: Tap>(
        &self,
        first: usize,
        ports: &[Ports<N>],
        states: &mut [State<N>],
        tap: &mut T,
    ) {
        macro_rules! each {
            ($($number:literal $stage:ident)+) => { $(
                for (ports, state) in ports.iter().zip(states.iter_mut()) {
                    state.step($number, first, |state| self.$stage(ports, state, tap));
                }
            )+ };
        }
        each!(0 ports 1 local_frame 2 bump 3 reflect 4 cube_face 5 normal 6 jacobian 7 roughness 8 covariance
            9 eigen 10 footprint);
    }

    /// Feeds everything that the results of a step depend on, beside the steps before it, to a hasher.
    pub fn hash_step<H: Hasher>(&self, number: usize, hasher: &mut H) {
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

impl HitUnit {
    /// Like [`Unit::hash_step`]; the distances in memory are the caller's to tell apart.
    pub fn hash_step<H: Hasher>(&self, number: usize, hasher: &mut H) {
        let roms = &self.unit.roms;
        match number {
            0 => {
                (&self.hit, &self.cone).hash(hasher);
                (roms.recip.spec, roms.rsqrt.spec, roms.sqrt.spec).hash(hasher);
            }
            1 => self.unit.hash_step(4, hasher),
            2 => {
                (&self.footprint, &self.hit, &self.cone).hash(hasher);
                (roms.recip.spec, roms.rsqrt.spec).hash(hasher);
            }
            _ => self.unit.hash_step(number + 5, hasher),
        }
    }
}

impl TexUnit {
    /// Like [`Unit::hash_step`]; the requests with their cones are the caller's to tell apart.
    pub fn hash_step<H: Hasher>(&self, number: usize, hasher: &mut H) {
        let roms = &self.unit.roms;
        match number {
            0 => {
                (&self.surface, &self.cone, self.texels).hash(hasher);
                self.unit.address.hash(hasher);
                (roms.recip.spec, roms.rsqrt.spec).hash(hasher);
            }
            _ => self.unit.hash_step(number + 7, hasher),
        }
    }
}
