//! Taps: listeners to the registers of a run. Without a listener tracing costs nothing.

use crate::regs::Reg;

/// A listener to register writes.
///
/// The type also says how much of the arithmetic is compiled: where `STANDARD` is true, writes are
/// compiled for registers that round half-even and saturate, and products for registers of at most 32
/// bits. Only a unit that keeps to that ([`crate::unit::Operation::is_standard`]) may be run with such a tap.
pub trait Tap {
    /// Whether every register rounds half-even and saturates, and is narrow where products are compiled so.
    const STANDARD: bool = false;
    /// Whether anybody listens; where false, `put` need not be called.
    const ACTIVE: bool = true;

    /// One component of a register of one lane: value = `raw · 2^−frac` in true units, the
    /// pre-normalisation's powers of two included.
    fn put(&mut self, lane: usize, reg: Reg, component: usize, raw: i64, frac: i64);
}

/// Nobody listens.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoTap;

impl Tap for NoTap {
    const ACTIVE: bool = false;

    #[inline(always)]
    fn put(&mut self, _: usize, _: Reg, _: usize, _: i64, _: i64) {}
}

/// Nobody listens, every register rounds half-even and saturates, and products are narrow.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoTapStandard;

impl Tap for NoTapStandard {
    const STANDARD: bool = true;
    const ACTIVE: bool = false;

    #[inline(always)]
    fn put(&mut self, _: usize, _: Reg, _: usize, _: i64, _: i64) {}
}
