//! Staircases: how finely a fraction becomes a weight, and how it is rounded.

use crate::base::num;
use std::fmt;

/// Points of a sweep over a fraction 0…1, both ends included.
pub const SWEEP: u32 = 4096;
/// Most bits that a staircase is looked for with: a step must span several points of the sweep.
const MOST_BITS: u32 = 10;

/// How a fraction becomes a weight of some bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rounding {
    /// The step below.
    Floor,
    /// The nearest step, the upper one of two.
    Nearest,
    /// The nearest step, the even one of two.
    NearestEven,
}

impl Rounding {
    /// Every rounding.
    pub const ALL: [Self; 3] = [Self::Floor, Self::Nearest, Self::NearestEven];
}

/// A fraction's resolution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Steps {
    /// Multiples of 2^−bits.
    Bits {
        /// Fraction bits.
        bits: u32,
        /// Which step a fraction takes.
        rounding: Rounding,
    },
    /// No steps that the sweep sees.
    Smooth,
}

impl Steps {
    /// The weight that a fraction becomes.
    #[must_use]
    pub fn weight(self, fraction: f64) -> f64 {
        match self {
            Self::Smooth => fraction,
            Self::Bits { bits, rounding } => {
                let one = f64::from(1u32 << bits.min(31));
                let scaled = fraction * one;
                let step = match rounding {
                    Rounding::Floor => scaled.floor(),
                    Rounding::Nearest => (scaled + 0.5).floor(),
                    Rounding::NearestEven => scaled.round_ties_even(),
                };
                step / one
            }
        }
    }

    /// Size of a step; of a smooth weight, that of the sweep.
    #[must_use]
    pub fn size(self) -> f64 {
        match self {
            Self::Smooth => 1.0 / f64::from(SWEEP),
            Self::Bits { bits, .. } => 1.0 / f64::from(1u32 << bits.min(31)),
        }
    }
}

impl fmt::Display for Steps {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Smooth => write!(f, "no steps (finer than 1/{SWEEP})"),
            Self::Bits { bits, rounding } => {
                let how = match rounding {
                    Rounding::Floor => "rounded down",
                    Rounding::Nearest => "rounded to nearest",
                    Rounding::NearestEven => "rounded to nearest, ties to even",
                };
                write!(f, "{} steps ({bits} bits), {how}", 1u32 << (*bits).min(31))
            }
        }
    }
}

/// A measured staircase.
#[derive(Clone, Debug)]
pub struct Staircase {
    /// The weights at fractions k/[`SWEEP`], k = 0…[`SWEEP`].
    pub weights: Vec<f64>,
    /// Different weights among them.
    pub distinct: usize,
    /// The rule that comes closest.
    pub steps: Steps,
    /// Largest distance of a weight from the rule's.
    pub worst: f64,
    /// Points whose weight is more than half a step away from the rule's.
    pub off: usize,
    /// Whether no weight is below its predecessor.
    pub rising: bool,
    /// Fractions where the weight first exceeds its first value, and where it first has its last one.
    pub turns: [f64; 2],
}

/// Smallest number of bits, up to 10, of which all values are multiples of 2^−bits to within an eighth of a step of 10 bits;
/// nothing where they are not.
#[must_use]
pub fn grid_bits(values: &[f64]) -> Option<u32> {
    (0..=MOST_BITS).find(|bits| {
        let one = f64::from(1u32 << bits);
        values.iter().all(|v| (v * one - (v * one).round()).abs() / one < libm::exp2(-13.0))
    })
}

/// Fraction of point k of a sweep.
#[must_use]
pub fn fraction(k: usize) -> f64 {
    num::u64(k) as f64 / f64::from(SWEEP)
}

/// Finds the rule behind the weights of a sweep: of all rules of up to 10 bits and of none at all, the one with the
/// smallest mean distance. `colors` is how many steps a colour has, where it has few: rules are rounded to them before they
/// are compared.
///
/// Weights of b bits lie a quarter of a step from smooth ones on average, so b bits are told from none as long as the
/// output's own rounding stays below 2^−b/4.
#[must_use]
pub fn staircase(weights: Vec<f64>, colors: Option<f64>) -> Staircase {
    let mut sorted = weights.clone();
    sorted.sort_by(f64::total_cmp);
    sorted.dedup();
    let mut rules = vec![Steps::Smooth];
    for bits in 1..=MOST_BITS {
        for rounding in Rounding::ALL {
            rules.push(Steps::Bits { bits, rounding });
        }
    }
    let distances = |rule: Steps| {
        let points = weights.iter().enumerate();
        let shown = move |w: f64| colors.map_or(w, |n| (w * n).round() / n);
        points.map(move |(k, w)| (w - shown(rule.weight(fraction(k)))).abs())
    };
    let total = |rule: &Steps| distances(*rule).sum::<f64>();
    let steps =
        rules.into_iter().min_by(|a, b| total(a).total_cmp(&total(b))).unwrap_or(Steps::Smooth);
    Staircase {
        distinct: sorted.len(),
        worst: distances(steps).fold(0.0, f64::max),
        off: distances(steps).filter(|d| *d > steps.size() / 2.0).count(),
        steps,
        rising: weights.windows(2).all(|w| w[0] <= w[1]),
        turns: [
            weights.iter().position(|w| *w > weights[0]),
            weights.iter().position(|w| Some(w) == weights.last()),
        ]
        .map(|k| k.map_or(1.0, fraction)),
        weights,
    }
}
