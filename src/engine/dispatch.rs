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
        if best == Self::Baseline { vec![best] } else { vec![Self::Baseline, best] }
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

/// Where blocks of fragments come from.
#[derive(Debug)]
pub enum Source<'a> {
    /// Fragments, through the whole unit.
    Words(&'a [Words]),
    /// Groups that stay from unit to unit, from this step on.
    Kept(&'a mut [Box<Group>], usize),
}

/// Blocks of fragments through the unit; `each` sees the results of every block.
pub struct Blocks<'a, F> {
    /// The unit.
    pub unit: &'a Unit,
    /// Fragments of all blocks.
    pub source: Source<'a>,
    /// Texel memory.
    pub texture: Option<&'a Texture>,
    /// Takes the results of a block and how many lanes are in use.
    pub each: F,
}

/// Blocks whose stages run side by side, so that a stage's code is fetched once for all of them.
pub const GROUP: usize = 4;

/// What a group of blocks passes through.
#[derive(Debug)]
pub struct Group {
    ports: [Ports<LANES>; GROUP],
    states: [State<LANES>; GROUP],
    out: Results<LANES>,
}

impl Group {
    fn passing() -> Box<Self> {
        Box::new(Self {
            ports: Default::default(),
            states: Default::default(),
            out: Results::default(),
        })
    }

    /// A group of up to `GROUP · LANES` fragments whose results stay; nothing has run yet.
    #[must_use]
    pub fn kept(unit: &Unit, words: &[Words]) -> Box<Self> {
        let mut group = Box::new(Self {
            ports: Default::default(),
            states: std::array::from_fn(|_| State::kept()),
            out: Results::default(),
        });
        group.load(unit, words);
        group
    }

    /// What the steps have left of each block, and how many of its lanes are in use.
    pub fn blocks(&self) -> impl Iterator<Item = (&State<LANES>, usize)> {
        let lanes = self.ports.iter().map(|p| p.len).filter(|n| *n > 0);
        self.states.iter().zip(lanes)
    }

    fn load(&mut self, unit: &Unit, words: &[Words]) {
        let mut chunks = words.chunks(LANES);
        for ports in &mut self.ports {
            ports.len = 0;
            for words in chunks.next().unwrap_or_default() {
                unit.load(ports, words);
            }
        }
    }
}

impl<F: FnMut(&Results<LANES>, usize)> Blocks<'_, F> {
    /// Runs a group from a step on.
    #[inline(always)]
    fn group<T: Tap>(&mut self, first: usize, group: &mut Group, tap: &mut T) {
        let used = group.ports.iter().filter(|p| p.len > 0).count();
        let (ports, states) = (&group.ports[..used], &mut group.states[..used]);
        self.unit.fronts_from(first, ports, states, tap);
        for (ports, state) in ports.iter().zip(states) {
            self.unit.finish(state, ports.len, self.texture, &mut group.out, tap);
            (self.each)(&group.out, ports.len);
        }
    }

    /// A group on a unit with other roundings or wider registers: rarely run, and compiled without the
    /// wider instructions to keep builds short.
    #[cold]
    #[inline(never)]
    fn group_of_any_formats(&mut self, first: usize, group: &mut Group) {
        self.group(first, group, &mut NoTap);
    }
}

impl<F: FnMut(&Results<LANES>, usize)> Task for Blocks<'_, F> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let mut source = std::mem::replace(&mut self.source, Source::Words(&[]));
        let mut passing = matches!(source, Source::Words(_)).then(Group::passing);
        let mut number = 0;
        loop {
            let (group, first) = match (&mut source, &mut passing) {
                (Source::Words(words), Some(group)) if !words.is_empty() => {
                    let (now, later) = words.split_at(words.len().min(GROUP * LANES));
                    group.load(self.unit, now);
                    *words = later;
                    (group, 0)
                }
                (Source::Kept(groups, first), _) if number < groups.len() => {
                    number += 1;
                    (&mut groups[number - 1], *first)
                }
                (Source::Words(_) | Source::Kept(..), _) => return,
            };
            if self.unit.is_standard() {
                self.group(first, group, &mut NoTapStandard);
            } else {
                self.group_of_any_formats(first, group);
            }
        }
    }
}
