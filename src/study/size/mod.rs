//! The smallest unit that a scene needs: integer bits from the ranges that registers take, fraction bits and tables by a
//! search.
//!
//! The search shortens all words by the same number of bits as far as the bound allows, and then goes around: every
//! knob gives up one step (a bit, or half of a table) where the bound still holds, those that save most first, until a
//! whole round finds none. That last round is the proof: with any single knob one step shorter the bound breaks, or the
//! model refuses the unit.

mod ranges;
mod words;

use crate::engine::{EngineKind, Job};
use crate::error::InputError;
use crate::report::metrics::{self, Pair};
use crate::settings::Settings;
use crate::truth::TruthOptions;
use crate::unit::knobs::Value;
use crate::unit::{ReferenceAxis, UnitSpec, check};

use super::cost::CostModel;
use super::sweep::Sweep;
pub use ranges::{Range, Ranges};
pub use words::Word;

/// The bounds that a unit must keep against f64.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Goal {
    /// Largest difference in 8-bit steps.
    pub max_lsb8: Option<f64>,
    /// Least PSNR in dB.
    pub psnr_db: Option<f64>,
    /// Largest share of fragments that are more than one 8-bit step off.
    pub share: Option<f64>,
}

impl Goal {
    /// Whether a picture keeps the bound.
    #[must_use]
    pub fn holds(&self, pair: &Pair) -> bool {
        self.max_lsb8.is_none_or(|most| pair.max_lsb8 <= most)
            && self.psnr_db.is_none_or(|least| pair.psnr_db.is_none_or(|db| db >= least))
            && self.share.is_none_or(|most| pair.share_over_1_lsb8 <= most)
    }
}

/// The result of a unit one step shorter.
#[derive(Clone, Debug, PartialEq)]
pub enum Shorter {
    /// The bound breaks.
    Breaks(Box<Pair>),
    /// The model refuses the unit.
    Refused(String),
    /// The knob's least value is reached.
    Least,
}

/// A knob in the result.
#[derive(Clone, Debug, PartialEq)]
pub struct Sized {
    /// Its path.
    pub path: String,
    /// Value in the unit that the search began with, and at the end.
    pub values: [u32; 2],
    /// The effect of one step less.
    pub shorter: Shorter,
}

/// A sized unit.
#[derive(Debug)]
pub struct Found {
    /// The unit.
    pub spec: UnitSpec,
    /// How far it is from f64.
    pub pair: Pair,
    /// How far the unit that the search began with is.
    pub before: Pair,
    /// Every word and table that was searched.
    pub knobs: Vec<Sized>,
    /// Policies whose limits the scene never reaches: path, before, after. They change no result.
    pub trimmed: Vec<(String, u32, u32)>,
    /// Integer bits that the ranges decided: register, before, needed, after.
    pub integers: Vec<(String, [u32; 3])>,
    /// Units that were rendered.
    pub trials: u64,
    /// Rounds of the search, the last one without a step.
    pub rounds: u32,
}

/// How a search ended.
#[derive(Debug)]
pub enum Outcome {
    /// With a unit.
    Found(Box<Found>),
    /// With none: longer words and larger tables come no nearer than this. Policies are not searched.
    Beyond(Box<Pair>),
}

/// Options of the search.
#[derive(Clone, Debug)]
pub struct SizeOptions {
    /// The bound.
    pub goal: Goal,
    /// Bits that stay in addition to those that a register's range needs.
    pub margin: u32,
    /// Axis of the float reference.
    pub reference_axis: ReferenceAxis,
    /// Exposure in stops.
    pub exposure: f64,
    /// Decides which knob gives way first.
    pub cost: CostModel,
}

/// The search.
struct Search<'a> {
    bench: Sweep,
    options: &'a SizeOptions,
    trials: u64,
}

impl Search<'_> {
    fn settings(&self, spec: &UnitSpec) -> Settings {
        spec.settings(self.options.reference_axis)
    }

    /// How far a unit is from f64.
    fn pair(&mut self, spec: &UnitSpec) -> Result<Pair, InputError> {
        check(spec)?;
        let settings = self.settings(spec);
        self.trials += 1;
        let (rendering, ..) = self.bench.render(spec, true)?;
        let truth = TruthOptions::default();
        let reference = self.bench.reference_picture(EngineKind::F64, &settings, &truth)?;
        metrics::compare(&rendering.picture, reference, self.options.exposure)
    }

    /// The unit's distance if it is legal and keeps the bound.
    fn keeps(&mut self, spec: &UnitSpec) -> Option<Pair> {
        let pair = self.pair(spec).ok()?;
        self.options.goal.holds(&pair).then_some(pair)
    }

    fn gates(&self, spec: &UnitSpec) -> f64 {
        let cost = &self.options.cost;
        cost.sheet(&spec.config, self.bench.job().operation()).total().gates(&cost.cells)
    }

    /// A unit that keeps the bound: the given one, or one with larger tables and longer words; else the best that was
    /// found.
    fn begin(&mut self, base: &UnitSpec) -> Result<Result<UnitSpec, Pair>, InputError> {
        let mut spec = base.clone();
        let first = self.pair(&spec)?;
        if self.options.goal.holds(&first) {
            return Ok(Ok(spec));
        }
        let mut best = first;
        for entries in [64, 128, 256, 512, 1024] {
            if self.options.reference_axis == ReferenceAxis::Table
                || spec.config.tables.eigen.entries >= entries
            {
                continue;
            }
            spec.config.tables.eigen.entries = entries;
            let pair = self.pair(&spec)?;
            if self.options.goal.holds(&pair) {
                return Ok(Ok(spec));
            }
            if pair.max_lsb8 < best.max_lsb8 {
                best = pair;
            }
        }
        for bits in 1..=4 {
            let mut longer = spec.clone();
            for format in &mut longer.config.formats {
                format.frac += bits;
            }
            // Registers that would not fit stay as they are.
            for (index, format) in spec.config.formats.iter().enumerate() {
                let mut alone = spec.clone();
                alone.config.formats[index].frac += bits;
                if check(&alone).is_err() {
                    longer.config.formats[index] = *format;
                }
            }
            // Words that fit one by one may not fit together.
            let Ok(pair) = self.pair(&longer) else { break };
            if self.options.goal.holds(&pair) {
                return Ok(Ok(longer));
            }
            if pair.max_lsb8 < best.max_lsb8 {
                best = pair;
            }
        }
        Ok(Err(best))
    }

    /// Shortens all words by the same number of bits, as far as the bound allows.
    fn together(&mut self, spec: &UnitSpec, words: &[Word]) -> UnitSpec {
        let shorter = |bits: u32| {
            let mut out = spec.clone();
            for word in words.iter().filter(|w| w.is_fraction()) {
                let value = word.get(&out);
                let mut tried = out.clone();
                word.set(&mut tried, value.saturating_sub(bits));
                if check(&tried).is_ok() {
                    out = tried;
                }
            }
            out
        };
        let (mut low, mut high) = (0, 24);
        while high - low > 1 {
            let middle = u32::midpoint(low, high);
            if self.keeps(&shorter(middle)).is_some() {
                low = middle;
            } else {
                high = middle;
            }
        }
        shorter(low)
    }

    /// The effect of one step less of a word.
    fn shorter(&mut self, spec: &UnitSpec, word: &Word) -> (Option<UnitSpec>, Shorter) {
        let Some(next) = word.below(word.get(spec)) else {
            return (None, Shorter::Least);
        };
        let mut tried = spec.clone();
        word.set(&mut tried, next);
        match self.pair(&tried) {
            Err(error) => (None, Shorter::Refused(error.to_string())),
            Ok(pair) if self.options.goal.holds(&pair) => {
                (Some(tried), Shorter::Breaks(Box::new(pair)))
            }
            Ok(pair) => (None, Shorter::Breaks(Box::new(pair))),
        }
    }

    /// Rounds until no word can give up a step; returns what each one's step would do at the end.
    fn around(&mut self, spec: &mut UnitSpec, words: &[Word]) -> (Vec<Shorter>, u32) {
        let mut rounds = 0;
        loop {
            rounds += 1;
            let now = self.gates(spec);
            let mut order: Vec<(usize, f64)> = words
                .iter()
                .enumerate()
                .map(|(index, word)| {
                    let mut less = spec.clone();
                    let gain = word.below(word.get(spec)).map(|next| {
                        word.set(&mut less, next);
                        now - self.gates(&less)
                    });
                    (index, gain.unwrap_or(0.0))
                })
                .collect();
            order.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
            let mut results = vec![Shorter::Least; words.len()];
            let mut moved = false;
            for (index, _) in order {
                let (next, result) = self.shorter(spec, &words[index]);
                if let Some(next) = next {
                    *spec = next;
                    moved = true;
                }
                results[index] = result;
            }
            if !moved {
                return (results, rounds);
            }
        }
    }
}

/// Limits that the scene never reaches, lowered to the values that it does reach. No result changes.
fn trim(spec: &mut UnitSpec, ranges: &Ranges) -> Vec<(String, u32, u32)> {
    let mut out = Vec::new();
    let mut lower = |path: &str, now: u32, most: u32, spec: &mut UnitSpec| {
        let value = Value::Integer(most.max(1).into());
        if most < now && spec.set(path, &value).is_ok() {
            out.push((path.to_string(), now, most.max(1)));
        }
    };
    // At the limit itself m may have been widened: then it stays.
    let probes = spec.config.policy.footprint.max_probes;
    lower("footprint.max_probes", probes, ranges.probes, spec);
    // Where nothing searches there is no limit to lower.
    if ranges.searches && ranges.look_ups > 0 {
        let look_ups = spec.config.policy.hit.iterations;
        lower("hit.iterations", look_ups, ranges.look_ups, spec);
    }
    out
}

/// Finds the smallest unit for a scene.
///
/// # Errors
/// The given unit is refused.
pub fn size(
    job: Job,
    base: &UnitSpec,
    options: &SizeOptions,
) -> Result<(Outcome, Sweep), InputError> {
    let mut search = Search { bench: Sweep::new(job), options, trials: 0 };
    let before = search.pair(base)?;
    let mut spec = match search.begin(base)? {
        Ok(spec) => spec,
        Err(best) => return Ok((Outcome::Beyond(Box::new(best)), search.bench)),
    };
    let untrimmed = spec.clone();
    let ranges = Ranges::of(search.bench.job(), &spec)?;
    let mut trimmed = trim(&mut spec, &ranges);
    if search.keeps(&spec).is_none() {
        // Only a limit that did matter could do that.
        spec = untrimmed;
        trimmed.clear();
    }
    let texel = (ranges.texel_int + options.margin).min(spec.config.policy.texel.int);
    if texel < spec.config.policy.texel.int {
        let before = std::mem::replace(&mut spec.config.policy.texel.int, texel);
        trimmed.push(("texel.int".into(), before, texel));
    }
    let start = spec.clone();
    let integers = fit_integers(&mut search, &mut spec, &ranges, options.margin);
    let words = words::all(&spec, &ranges, options.reference_axis);
    spec = search.together(&spec, &words);
    let (shorter, rounds) = search.around(&mut spec, &words);
    let pair = search.pair(&spec)?;
    let knobs = words
        .iter()
        .zip(shorter)
        .map(|(word, shorter)| Sized {
            path: word.path(),
            values: [word.get(&start), word.get(&spec)],
            shorter,
        })
        .collect();
    let found =
        Found { spec, pair, before, knobs, trimmed, integers, trials: search.trials, rounds };
    Ok((Outcome::Found(Box::new(found)), search.bench))
}

/// Integer bits from the ranges, register by register where the bound objects to all at once.
fn fit_integers(
    search: &mut Search<'_>,
    spec: &mut UnitSpec,
    ranges: &Ranges,
    margin: u32,
) -> Vec<(String, [u32; 3])> {
    let wanted: Vec<(rtl_model::regs::Reg, u32, u32)> = ranges
        .fixed()
        .filter_map(|(reg, range)| {
            let format = spec.config.format(reg);
            let needed = range.int_bits(format.frac);
            let fitted = (needed + margin).min(format.int);
            (fitted < format.int).then_some((reg, needed, fitted))
        })
        .collect();
    let mut tried = spec.clone();
    for (reg, _, fitted) in &wanted {
        tried.config.formats[reg.index()].int = *fitted;
    }
    if search.keeps(&tried).is_none() {
        tried = spec.clone();
        for (reg, _, fitted) in &wanted {
            let mut alone = tried.clone();
            alone.config.formats[reg.index()].int = *fitted;
            if search.keeps(&alone).is_some() {
                tried = alone;
            }
        }
    }
    let before = std::mem::replace(spec, tried);
    wanted
        .iter()
        .map(|(reg, needed, _)| {
            let int = |s: &UnitSpec| s.config.format(*reg).int;
            (reg.to_string(), [int(&before), *needed, int(spec)])
        })
        .collect()
}
