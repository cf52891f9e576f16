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
        /// Numbers of one to three bits that are set: sums and products fall halfway between two codes, or one unit beside.
        Ties = "ties",
    }
}

impl Class {
    /// Whether it tells anything of a subject: the words of an operation have their own extremes.
    #[must_use]
    pub const fn concerns(self, subject: Subject) -> bool {
        let own = matches!(self, Self::Corners | Self::Ties);
        !(own && matches!(subject, Subject::Env | Subject::Hit | Subject::Tex))
    }

    const fn salt(self) -> u64 {
        match self {
            Self::Ordinary => 0x6f72_6469,
            Self::Exponents => 0x6578_706f,
            Self::Patterns => 0x7061_7474,
            Self::Extremes => 0x6578_7472,
            Self::Corners => 0x636f_726e,
            Self::Ties => 0x7469_6573,
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
        Class::Ordinary | Class::Patterns | Class::Corners | Class::Ties => {
            ordinary(subject, &mut random)
        }
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
    if class == Class::Ties {
        ties(model, &mut random, input);
    }
}

/// Puts numbers of few bits in place of codes, mantissas and words. A quarter of the cases changes one field in two alone.
fn ties(model: &Harness, random: &mut Random, input: &mut [i64]) {
    let some = random.index(4) == 0;
    let mut numbers = input.iter_mut();
    for field in &model.shape().inputs {
        let skip = some && random.index(2) == 0;
        for number in numbers.by_ref().take(field.components) {
            let few = match field.meaning {
                _ if skip => *number,
                Meaning::Code(_) | Meaning::Mantissa(_) => few_bits(field, random),
                // The fraction of a binary64 word, under its own sign and exponent.
                Meaning::Word => {
                    let fraction = few(52, random).unsigned_abs() & ((1 << 52) - 1);
                    (*number & !((1 << 52) - 1)) | fraction.cast_signed()
                }
                Meaning::Fraction(_)
                | Meaning::Power
                | Meaning::Choice(_)
                | Meaning::Count(..)
                | Meaning::Flags(_)
                | Meaning::Small => *number,
            };
            let [low, high] = field.range;
            *number = few.clamp(low, high);
        }
    }
}

/// A number of a field with few bits set.
fn few_bits(field: &Field, random: &mut Random) -> i64 {
    let bits = field.bits - u32::from(field.signed);
    let x = few(bits, random);
    if field.signed && random.index(2) == 0 { -x } else { x }
}

/// A sum of one to three powers of two below 2^bits, the last with either sign; sometimes 0 or the least unit besides.
fn few(bits: u32, random: &mut Random) -> i64 {
    let power = |random: &mut Random| 1_i64 << random.index(num::usize(bits.clamp(1, 62)));
    let first = power(random);
    match random.index(8) {
        0 => 0,
        1..=3 => first,
        4 => first | power(random),
        5 => (first - power(random)).abs(),
        6 => first | power(random) | power(random),
        _ => first | 1,
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

/// The cases of a vector file: every extreme, every pattern, corners, ties, then ordinary numbers and exponents
/// by turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Schedule {
    extremes: u64,
    patterns: u64,
    corners: u64,
    ties: u64,
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
        let ties = match level {
            _ if !Class::Ties.concerns(subject) => 0,
            1 => 1024,
            _ => 8192,
        };
        Self { extremes, patterns, corners, ties, level, seed }
    }

    /// Cases that cover the level.
    #[must_use]
    pub fn cases(&self) -> u64 {
        let more = if self.level > 1 { 4096 } else { 256 };
        self.extremes + self.patterns + self.corners + self.ties + more
    }

    /// Case `index`.
    #[must_use]
    pub fn place(&self, index: u64) -> Place {
        let mut index = index;
        for (class, count) in [
            (Class::Extremes, self.extremes),
            (Class::Patterns, self.patterns),
            (Class::Corners, self.corners),
            (Class::Ties, self.ties),
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
