//! Taps: listeners to the registers while a fragment passes through the stages.

use super::real::Real;
use crate::stage::Stage;

/// Receives every register of a fragment, in pipeline order.
pub trait Tap {
    /// Whether anything is recorded. Where it is false, traces cost nothing.
    const ACTIVE: bool = true;

    /// One component of one register, in true units, always finite.
    fn put(&mut self, stage: Stage, register: &'static str, component: usize, value: f64);

    /// The same with the error that the arithmetic tracks.
    fn put_with_error(
        &mut self,
        stage: Stage,
        register: &'static str,
        component: usize,
        value: f64,
        _error: f64,
    ) {
        self.put(stage, register, component, value);
    }

    /// A flag that the fragment raised, once per fragment.
    fn event(&mut self, name: &'static str);
}

/// The tap that records nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoTap;

impl Tap for NoTap {
    const ACTIVE: bool = false;

    fn put(&mut self, _: Stage, _: &'static str, _: usize, _: f64) {}

    fn event(&mut self, _: &'static str) {}
}

/// Puts all components of a register.
pub(super) fn put<R: Real, T: Tap>(
    tap: &mut T,
    stage: Stage,
    register: &'static str,
    values: &[R],
) {
    if T::ACTIVE {
        for (component, value) in values.iter().enumerate() {
            tap.put_with_error(stage, register, component, value.to_f64(), value.error());
        }
    }
}
