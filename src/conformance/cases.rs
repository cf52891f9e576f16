//! The cases of a subject: by class, seed and index, each one reproducible alone.

use super::field::{Field, Meaning};
use super::harness::{Device as _, Harness};
use super::patterns;
use super::stimuli::{exponents, extreme, ordinary, rows};
use super::subject::Subject;
use crate::base::named::named;
use crate::base::num;
use crate::base::random::Random;

named! {
    /// The class of a case: which numbers it puts to the test.
    pub enum Class {
        /// As pictures have them.
        Ordinary = "ordinary",
        /// Exponents of every size, and ratios between operands.
        Exponents = "exponents",
        /// Patterns at one number (level 1) or two (level 2) of an ordinary case.
        Patterns = "patterns",
        /// Rows of the specification's section 8, turned by the cube's 48 symmetries.
        Extremes = "extremes",
        /// Every number at an end of its range, at zero or next to it: the largest products and sums.
        Corners = "corners",
    }
}

impl Class {
    /// Whether it tells anything of a subject: the words of an operation have their own extremes.
    #[must_use]
    pub const fn concerns(self, subject: Subject) -> bool {
        !matches!((self, subject), (Self::Corners, Subject::Env | Subject::Hit | Subject::Tex))
    }

    const fn salt(self) -> u64 {
        match self {
            Self::Ordinary => 0x6f72_6469,
            Self::Exponents => 0x6578_706f,
            Self::Patterns => 0x7061_7474,
            Self::Extremes => 0x6578_7472,
            Self::Corners => 0x636f_726e,
        }
    }
}

/// A case by its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Class.
    pub class: Class,
    /// Level: how many numbers carry a pattern.
    pub level: u32,
    /// Seed.
    pub seed: u64,
    /// Index within class and seed.
    pub index: u64,
}

/// The numbers of a case that a harness of `subject` takes.
pub fn fill(model: &mut Harness, subject: Subject, place: Place, input: &mut [i64]) {
    let Place { class, level, seed, index } = place;
    let mut random = Random::of_case(seed, class.salt(), index);
    let stimulus = match class {
        Class::Ordinary | Class::Patterns | Class::Corners => ordinary(subject, &mut random),
        Class::Exponents => exponents(subject, &mut random),
        Class::Extremes => extreme(subject, index, &mut random),
    };
    model.drive(&stimulus, input);
    if class == Class::Patterns {
        sweep(model, level, index, &mut random, input);
    }
    if class == Class::Corners {
        corners(model, index, &mut random, input);
    }
}

/// Puts every number at a corner; powers of two stay what the stages before made of them. Cases 0 and
/// 1 have all numbers at the low and at the high end. In every second case after them a field's
/// numbers are all the same.
fn corners(model: &Harness, index: u64, random: &mut Random, input: &mut [i64]) {
    let mut numbers = input.iter_mut();
    for field in &model.shape().inputs {
        let [low, high] = field.range;
        let ends = [low, high, 0.clamp(low, high), 1.clamp(low, high), (-1).clamp(low, high)];
        let same = ends[if index < 2 { num::usize(index) } else { random.index(3) }];
        for number in numbers.by_ref().take(field.components) {
            let own =
                if index.is_multiple_of(2) || index < 2 { same } else { random.one_of(&ends) };
            if !matches!(field.meaning, Meaning::Power | Meaning::Fraction(_)) {
                *number = own;
            }
        }
    }
}

/// Patterns that class `Patterns` has at a level before it starts again with other numbers around them.
#[must_use]
pub fn sweep_len(model: &Harness, level: u32) -> u64 {
    let shape = model.shape();
    shape.inputs.iter().map(|f| patterns::count(f, level) * num::u64(f.components)).sum()
}

/// The cases of a vector file: every extreme, every pattern, corners, then ordinary numbers and exponents
/// by turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Schedule {
    extremes: u64,
    patterns: u64,
    corners: u64,
    level: u32,
    seed: u64,
}

impl Schedule {
    /// The schedule of a subject: at level 2 the extremes in all of the cube's symmetries.
    #[must_use]
    pub fn new(model: &Harness, subject: Subject, level: u32, seed: u64) -> Self {
        let turns = if level > 1 { 48 } else { 1 };
        let (extremes, patterns) = (rows(subject) * turns, sweep_len(model, level));
        let corners = match level {
            _ if !Class::Corners.concerns(subject) => 0,
            1 => 128,
            _ => 2048,
        };
        Self { extremes, patterns, corners, level, seed }
    }

    /// Cases that cover the level.
    #[must_use]
    pub fn cases(&self) -> u64 {
        let more = if self.level > 1 { 4096 } else { 256 };
        self.extremes + self.patterns + self.corners + more
    }

    /// Case `index`.
    #[must_use]
    pub fn place(&self, index: u64) -> Place {
        let mut index = index;
        for (class, count) in [
            (Class::Extremes, self.extremes),
            (Class::Patterns, self.patterns),
            (Class::Corners, self.corners),
        ] {
            if index < count {
                return Place { class, level: self.level, seed: self.seed, index };
            }
            index -= count;
        }
        let class = if index.is_multiple_of(2) { Class::Ordinary } else { Class::Exponents };
        let index = index / 2;
        Place { class, level: self.level, seed: self.seed, index }
    }
}

/// Puts a pattern at the number and with the kind that `index` says; at level 2 another one, at random.
fn sweep(model: &Harness, level: u32, index: u64, random: &mut Random, input: &mut [i64]) {
    let shape = model.shape();
    let total = sweep_len(model, level).max(1);
    let mut rest = index % total;
    let mut at = 0;
    'found: for field in &shape.inputs {
        for _ in 0..field.components {
            let count = patterns::count(field, level);
            if rest < count {
                put(field, level, rest, random, &mut input[at]);
                break 'found;
            }
            rest -= count;
            at += 1;
        }
    }
    if level > 1 {
        let mut other = random.index(input.len());
        for field in &shape.inputs {
            if other < field.components {
                let k = random.below(patterns::count(field, level));
                let first: usize = shape
                    .inputs
                    .iter()
                    .take_while(|f| f.name != field.name)
                    .map(|f| f.components)
                    .sum();
                put(field, level, k, random, &mut input[first + other]);
                break;
            }
            other -= field.components;
        }
    }
}

fn put(field: &Field, level: u32, k: u64, random: &mut Random, number: &mut i64) {
    let pattern = patterns::pattern(field, level, k, random);
    *number = if field.meaning == Meaning::Power {
        (*number + pattern).clamp(field.range[0], field.range[1])
    } else {
        pattern
    };
}
