//! Runs integer code under the widest vector instructions of the machine.
//!
//! The stages are always inlined, so that a [`Task`] is compiled once for each set of instructions. All
//! of it is integer arithmetic: the bits are the same.

use rtl_model::unit::{Ports, Results, State, Words};
use rtl_model::{NoTap, NoTapStandard, Tap, Texture, Unit};

/// Fragments in a block.
pub const LANES: usize = 32;

/// Which instructions a task runs under.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// What the target guarantees.
    Baseline,
    /// AVX2 with BMI1, BMI2 and LZCNT.
    #[cfg(target_arch = "x86_64")]
    Avx2,
}

impl Level {
    /// The widest level that this machine runs.
    #[must_use]
    pub fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("lzcnt")
        {
            return Self::Avx2;
        }
        Self::Baseline
    }

    /// Every level that this machine runs, the narrowest first.
    #[must_use]
    pub fn available() -> Vec<Self> {
        let best = Self::detect();
        if best == Self::Baseline {
            vec![best]
        } else {
            vec![Self::Baseline, best]
        }
    }
}

/// Something to run; its `run` must be `#[inline(always)]`.
pub trait Task {
    /// What it yields.
    type Output;

    /// Does it.
    fn run(self) -> Self::Output;
}

/// Runs a task under the instructions of `level`.
pub fn run<T: Task>(level: Level, task: T) -> T::Output {
    #[cfg(target_arch = "x86_64")]
    if level == Level::Avx2 && Level::detect() == Level::Avx2 {
        // SAFETY: `detect` has just found the features that `run_avx2` enables.
        return unsafe { run_avx2(task) };
    }
    let _ = level;
    task.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt")]
fn run_avx2<T: Task>(task: T) -> T::Output {
    task.run()
}

/// Blocks of fragments through the whole unit; `each` sees the results of every block.
pub struct Blocks<'a, F> {
    /// The unit.
    pub unit: &'a Unit,
    /// Fragments of all blocks.
    pub words: &'a [Words],
    /// Texel memory.
    pub texture: Option<&'a Texture>,
    /// Takes the results of a block and how many lanes are in use.
    pub each: F,
}

/// Blocks whose stages run side by side, so that a stage's code is fetched once for all of them.
pub const GROUP: usize = 4;

/// What a group of blocks passes through.
struct Group {
    ports: [Ports<LANES>; GROUP],
    states: [State<LANES>; GROUP],
    out: Results<LANES>,
}

impl<F: FnMut(&Results<LANES>, usize)> Blocks<'_, F> {
    /// Runs a group.
    #[inline(always)]
    fn group<T: Tap>(&mut self, words: &[Words], group: &mut Group, tap: &mut T) {
        let used = words.len().div_ceil(LANES).min(GROUP);
        for (words, ports) in words.chunks(LANES).zip(&mut group.ports) {
            ports.len = 0;
            for words in words {
                self.unit.load(ports, words);
            }
        }
        let (ports, states) = (&group.ports[..used], &mut group.states[..used]);
        self.unit.fronts(ports, states, tap);
        for (ports, state) in ports.iter().zip(states) {
            self.unit
                .finish(state, ports.len, self.texture, &mut group.out, tap);
            (self.each)(&group.out, ports.len);
        }
    }

    /// A group on a unit with other roundings or wider registers: rarely run, and compiled without the
    /// wider instructions to keep builds short.
    #[cold]
    #[inline(never)]
    fn group_of_any_formats(&mut self, words: &[Words], group: &mut Group) {
        self.group(words, group, &mut NoTap);
    }
}

impl<F: FnMut(&Results<LANES>, usize)> Task for Blocks<'_, F> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let mut group = Box::new(Group {
            ports: Default::default(),
            states: Default::default(),
            out: Results::default(),
        });
        for words in self.words.chunks(GROUP * LANES) {
            if self.unit.is_standard() {
                self.group(words, &mut group, &mut NoTapStandard);
            } else {
                self.group_of_any_formats(words, &mut group);
            }
        }
    }
}
