//! Probes of the level of detail under anisotropy.

use super::levels::{self, Fit, lod_on, lods, query, random, rank};
use super::rho::axes;
use crate::base::named::named;
use crate::error::InputError;
use crate::sampler::{Query, Shape, Source, State, TextureUnit, alone};

/// The clamps that are probed.
pub const CLAMPS: [u16; 5] = [1, 2, 4, 8, 16];
/// Steps in an octave of the ratio.
const STEPS: usize = 8;
/// Octaves of the ratio.
const OCTAVES: usize = 5;
/// Skewed pairs of derivatives.
const SKEWED: usize = 128;

named! {
    /// How many taps a line has.
    pub enum Count {
        /// ⌈ratio⌉.
        Ceil = "ceil(ratio)",
        /// ⌊ratio + ½⌋.
        Round = "round(ratio)",
        /// ⌊ratio⌋.
        Floor = "floor(ratio)",
        /// The next even number, or 1.
        Even = "next even number of ratio",
        /// The next power of two.
        PowerOfTwo = "next power of two of ratio",
    }
}

impl Count {
    /// Taps of a ratio under a clamp.
    #[must_use]
    pub fn of(self, ratio: f64, clamp: u16) -> f64 {
        // Equal axes differ by the rounding of f32: 2^−8 of a tap costs none.
        let r = ratio - libm::exp2(-8.0);
        let n = match self {
            Self::Ceil => r.ceil(),
            Self::Round => (ratio + 0.5).floor(),
            Self::Floor => (ratio + libm::exp2(-8.0)).floor(),
            Self::Even if r <= 1.0 => 1.0,
            Self::Even => 2.0 * (r / 2.0).ceil(),
            Self::PowerOfTwo => libm::exp2(libm::log2(r.max(1.0)).ceil()),
        };
        n.clamp(1.0, clamp.into())
    }
}

/// Which level of detail an elongated footprint gets: P and p are its longer and shorter length in texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Width {
    /// Level 0: derivatives are not looked at.
    Zero,
    /// log2 P, as without anisotropy.
    Major,
    /// log2 p, however long the line.
    Minor,
    /// log2 max(p, P/clamp).
    Clamped,
    /// log2 (P/taps).
    PerTap(Count),
}

named! {
    /// What P and p are.
    pub enum Lengths {
        /// Of the two derivatives.
        Derivatives = "lengths of dx and dy",
        /// Of the ellipse's axes.
        Ellipse = "axes of the ellipse",
    }
}

named! {
    /// Whether two levels are mixed.
    pub enum Mix {
        /// Two levels by the fraction of λ.
        Between = "two levels mixed",
        /// The level below alone.
        Floor = "one level, rounded down",
        /// The nearest level alone.
        Nearest = "one level, the nearest",
    }
}

/// A rule for the level of detail under a clamp.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct LodRule {
    /// Which width counts.
    pub width: Width,
    /// Of what.
    pub lengths: Lengths,
    /// Whether two levels are mixed.
    pub mix: Mix,
}

impl LodRule {
    /// In words.
    #[must_use]
    pub fn name(self) -> String {
        let width = self.width.name();
        match self.width {
            Width::Zero => width,
            Width::Major | Width::Minor | Width::Clamped | Width::PerTap(_) => {
                format!("{width}, {}; {}", self.lengths.name(), self.mix.name())
            }
        }
    }

    /// λ of a pair of derivatives in texels by one octave of a curve; `major` is the length without anisotropy.
    #[must_use]
    pub fn lod(self, octave: &[f64], clamp: u16, major: f64, [dx, dy]: [[f64; 2]; 2]) -> f64 {
        let width = match self.width {
            Width::Major => major,
            Width::Zero | Width::Minor | Width::Clamped | Width::PerTap(_) => {
                self.texels(clamp, dx, dy)
            }
        };
        let lod = lod_on(octave, libm::log2(width));
        match self.mix {
            Mix::Between => lod,
            Mix::Floor => lod.floor(),
            Mix::Nearest => (lod + 0.5).floor(),
        }
    }

    /// The width in texels.
    fn texels(self, clamp: u16, dx: [f64; 2], dy: [f64; 2]) -> f64 {
        let (long, short, _) = self.lengths.of(dx, dy);
        match self.width {
            Width::Zero => 1.0,
            Width::Major => long,
            Width::Minor => short,
            Width::Clamped => short.max(long / f64::from(clamp)),
            Width::PerTap(count) => long / count.of(ratio(long, short), clamp),
        }
    }
}

/// Longer over shorter, at most 1024.
#[must_use]
pub fn ratio(long: f64, short: f64) -> f64 {
    long / short.max(long / 1024.0).max(f64::MIN_POSITIVE)
}

impl Width {
    /// In words.
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Self::Zero => "level 0: the derivatives are ignored".into(),
            Self::Major => "log2 of the longer length, as without anisotropy".into(),
            Self::Minor => "log2 of the shorter length, whatever the clamp".into(),
            Self::Clamped => "log2 max(shorter, longer/clamp)".into(),
            Self::PerTap(count) => format!("log2(longer/taps), taps = {}", count.name()),
        }
    }
}

impl Lengths {
    /// P, p and the direction of P, in texels.
    #[must_use]
    pub fn of(self, dx: [f64; 2], dy: [f64; 2]) -> (f64, f64, [f64; 2]) {
        if self == Self::Ellipse {
            return axes(dx, dy);
        }
        let (a, b) = (libm::hypot(dx[0], dx[1]), libm::hypot(dy[0], dy[1]));
        let (long, short, d) = if a >= b { (a, b, dx) } else { (b, a, dy) };
        (long, short, d.map(|c| c / long.max(f64::MIN_POSITIVE)))
    }
}

/// Every rule, the plainer ones first.
#[must_use]
pub fn rules() -> Vec<LodRule> {
    let mut widths = vec![Width::Zero, Width::Major, Width::Minor, Width::Clamped];
    widths.extend(Count::ALL.map(Width::PerTap));
    let mut rules = Vec::new();
    for mix in Mix::ALL {
        for lengths in [Lengths::Derivatives, Lengths::Ellipse] {
            for width in &widths {
                rules.push(LodRule { width: *width, lengths, mix });
            }
        }
    }
    rules
}

/// Levels of detail under one clamp.
#[derive(Clone, Debug)]
pub struct Levels {
    /// The clamp.
    pub clamp: u16,
    /// Given derivatives, or a quad's.
    pub source: Source,
    /// (ratio, λ) for a footprint 4 texels wide along a row of texels.
    pub sweep: Vec<[f64; 2]>,
    /// Rules by how well they explain sweeps of three widths and skewed pairs, the best first.
    pub rules: Vec<Fit<LodRule>>,
}

/// Sweeps the ratio at three widths and adds skewed pairs of derivatives.
pub fn levels(
    unit: &mut dyn TextureUnit,
    octave: &[f64],
    clamp: u16,
    source: Source,
) -> Result<Levels, InputError> {
    let mut cases = Vec::new();
    for width in [4.0, 3.0, 2.5] {
        for i in 0..=STEPS * OCTAVES {
            let ratio = libm::exp2(i as f64 / STEPS as f64);
            cases.push(([width * ratio, 0.0], [0.0, width]));
        }
    }
    for i in 0..SKEWED as u64 {
        let r = |j| random(0x5000 + 16 * i + j);
        let scale = libm::exp2(3.0 + r(4));
        cases.push(([2.0 * r(0) * scale, r(1) * scale], [r(2) * scale, r(3) * scale]));
    }
    let queries: Vec<Query> = cases.iter().map(|(dx, dy)| query(*dx, *dy)).collect();
    let seen = lods(unit, State::trilinear(clamp), source, &queries)?;
    let ratio = |i: usize| libm::exp2(i as f64 / STEPS as f64);
    let sweep = (0..=STEPS * OCTAVES).map(|i| [ratio(i), seen[i]]).collect();
    let cases: Vec<_> = cases.into_iter().zip(seen).collect();
    let most = (levels::LEVELS - 1) as f64;
    let rules = rank(&rules(), &cases, |rule, (dx, dy)| {
        let (major, _, _) = rule.lengths.of(*dx, *dy);
        rule.lod(octave, clamp, major, [*dx, *dy]).min(most)
    });
    Ok(Levels { clamp, source, sweep, rules })
}

/// Whether a look-up with given derivatives depends on what its neighbours look up: four neighbours 4 texels apart with equal
/// derivatives of 8 texels, against the same look-ups alone. Returns λ of the first, both ways.
pub fn beside_neighbours(unit: &mut dyn TextureUnit, clamp: u16) -> Result<[f64; 2], InputError> {
    let image = levels::numbered(Shape::Planar, levels::SIZE, levels::LEVELS);
    let shift = 4.0 / levels::SIZE as f32;
    let queries: Vec<Query> = [[0.0, 0.0], [shift, 0.0], [0.0, shift], [shift, shift]]
        .map(|[x, y]| {
            let mut q = query([8.0, 0.0], [0.0, 8.0]);
            q.at[0] += x;
            q.at[1] += y;
            q
        })
        .to_vec();
    let state = State::trilinear(clamp);
    let together = unit.sample(&image, state, Source::Gradient, &queries)?;
    let apart = alone(unit, &image, state, Source::Gradient, &queries)?;
    Ok([apart[0][0], together[0][0]].map(f64::from))
}
