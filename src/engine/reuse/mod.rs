//! Results that stay from unit to unit: a sweep changes one knob at a time, and everything in front of the first
//! register that the knob reaches is there already.
//!
//! The key of a step is the hash of its own compiled configuration and of the key of the step before it; two units
//! with the same key have the same results there. Kept states are run again, in place, from the first step whose
//! key differs; a lone run and a run from kept states give the same bits.

mod kept;
pub mod lines;
pub mod tex;

pub use kept::{Kept, KeptEnv, KeptHit};

use std::hash::{Hash, Hasher};

use rtl_model::unit::Operation;

use crate::base::hash::Fnv64;

/// FNV-1a behind the standard library's interface.
#[derive(Clone, Copy, Debug, Default)]
pub struct StepHasher(Fnv64);

impl Hasher for StepHasher {
    fn finish(&self) -> u64 {
        self.0.finish()
    }

    fn write(&mut self, bytes: &[u8]) {
        self.0 = self.0.write(bytes);
    }
}

/// The keys of an operation's steps.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Keys(Vec<u64>);

impl Keys {
    /// Keys of an operation's steps behind inputs with the key `inputs`.
    #[must_use]
    pub fn of<O: Operation>(unit: &O, inputs: u64) -> Self {
        let mut before = inputs;
        let key = |number| {
            let mut hasher = StepHasher::default();
            before.hash(&mut hasher);
            unit.hash_step(number, &mut hasher);
            before = hasher.finish();
            before
        };
        Self((0..O::STEPS).map(key).collect())
    }

    /// The first step whose results differ from those that `kept` stand for; the number of steps where none does.
    #[must_use]
    pub fn first_changed(&self, kept: &Self) -> usize {
        let pairs = self.0.iter().zip(&kept.0);
        pairs.take_while(|(a, b)| a == b).count()
    }

    /// The last step's key: the filter starts from its registers.
    #[must_use]
    pub fn last(&self) -> u64 {
        self.0.last().copied().unwrap_or(0)
    }
}

/// Most fragments, rays or requests whose registers are kept: one takes about a kilobyte. Larger pictures run anew for
/// every unit.
const MOST_KEPT: u64 = 1 << 19;

/// The parts of a picture that were computed again, and those that were kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Saved {
    /// Steps that were not run again.
    pub kept: usize,
    /// Steps in front of the filter.
    pub steps: usize,
}
