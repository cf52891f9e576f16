//! Taps: who listens to the registers. Tracing costs nothing when nobody does.

use crate::regs::Reg;

/// A listener to register writes.
pub trait Tap {
    /// One component of a register of one lane: value = `raw · 2^−frac` in true units, the
    /// pre-normalisation's powers of two included.
    fn put(&mut self, lane: usize, reg: Reg, component: usize, raw: i64, frac: i64);
}

/// Nobody listens.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoTap;

impl Tap for NoTap {
    #[inline(always)]
    fn put(&mut self, _: usize, _: Reg, _: usize, _: i64, _: i64) {}
}
