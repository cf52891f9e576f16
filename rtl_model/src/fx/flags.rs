//! Sticky flags and counts: one bit a register, one bit an event.

use crate::regs::{Event, Reg};

/// Flags of one fragment: which registers left their range, which events happened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flags {
    /// Bit `Reg::index` is set where that register saturated or wrapped.
    pub overflow: u128,
    /// Bit `Event::index` is set where that event happened.
    pub events: u64,
}

impl Flags {
    /// Whether nothing happened.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.overflow == 0 && self.events == 0
    }

    /// Sets the bit of a register where `over`.
    #[inline(always)]
    pub fn register(&mut self, reg: Reg, over: bool) {
        self.overflow |= u128::from(over) << reg.index();
    }

    /// Sets the bit of an event where `happened`.
    #[inline(always)]
    pub fn event(&mut self, event: Event, happened: bool) {
        self.events |= u64::from(happened) << event.index();
    }

    /// Whether the register's bit is set.
    #[must_use]
    pub fn has(self, reg: Reg) -> bool {
        self.overflow >> reg.index() & 1 == 1
    }

    /// Whether the event's bit is set.
    #[must_use]
    pub fn has_event(self, event: Event) -> bool {
        self.events >> event.index() & 1 == 1
    }
}

/// Counts of flagged fragments per register and event.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FlagCounts {
    /// Fragments per register, by `Reg::index`.
    pub overflow: [u64; Reg::COUNT],
    /// Fragments per event, by `Event::index`.
    pub events: [u64; Event::COUNT],
}

impl Default for FlagCounts {
    fn default() -> Self {
        Self { overflow: [0; Reg::COUNT], events: [0; Event::COUNT] }
    }
}

impl FlagCounts {
    /// Counts one fragment's flags.
    #[inline]
    pub fn add(&mut self, flags: Flags) {
        if flags.is_empty() {
            return;
        }
        for (reg, count) in Reg::ALL.iter().zip(&mut self.overflow) {
            *count += u64::from(flags.has(*reg));
        }
        for (event, count) in Event::ALL.iter().zip(&mut self.events) {
            *count += u64::from(flags.has_event(*event));
        }
    }

    /// Adds another engine's or thread's counts.
    pub fn merge(&mut self, other: &Self) {
        for (a, b) in self.overflow.iter_mut().zip(&other.overflow) {
            *a += b;
        }
        for (a, b) in self.events.iter_mut().zip(&other.events) {
            *a += b;
        }
    }
}
