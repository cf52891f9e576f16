//! Stage `footprint`: how many probes, how wide, how far apart.

use super::flags::{Flag, Flags};
use super::real::Narrow;
use super::tap::{Tap, put};
use crate::base::num;
use crate::policy::{Count, FootprintPolicy, FootprintRule};
use crate::stage::Stage;

/// The mip chain that the footprint is measured against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Chain {
    /// Texels along an edge of level 0, at least 1.
    pub size: usize,
    /// Number of levels, at least 1.
    pub levels: usize,
}

/// The probes of a fragment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint<N> {
    /// Number of probes, at least 1.
    pub probes: u32,
    /// Level of detail, 0 … levels − 1.
    pub lod: N,
    /// Half the way from one probe to the next, in (u, v): probe i lies at
    /// centre + (2i + 1 − probes)·step.
    pub step: [N; 2],
}

/// The highest power of two that is at most `x` (x ≥ 1).
fn power_of_two_below(x: u32) -> u32 {
    1 << x.ilog2()
}

/// M = λ1·N/2, m = max(λ2·N/2, 1, M/most probes), count, LOD = log2 m and the step, in plain doubles
/// from the λ that are printed (unit.md section 4).
///
/// Every rule widens m so that its count fits: `pow2` by the largest power of two that fits in
/// `max_probes`, `feline` by (max + 1)/2. `feline` spaces its probes over 2(M − m) texels, ends
/// included; the others over λ1, at the middles of equal parts.
/// `moments` is the function below; it alone reads `spreads`, V_n of 1, 2, 3, … probes.
#[inline]
pub fn footprint<N: Narrow, T: Tap>(
    lambda: [N; 2],
    axis: [N; 2],
    chain: Chain,
    (policy, spreads): (&FootprintPolicy, &[f64]),
    flags: &mut Flags,
    tap: &mut T,
) -> Footprint<N> {
    if policy.policy == FootprintRule::Moments {
        return moments(lambda, axis, chain, (policy, spreads), flags, tap);
    }
    let number = N::from_f64;
    let (count, max) = (policy.count, policy.max_probes.max(1));
    let texels_per_unit = number(chain.size as f64) / number(2.0);
    let [length, minor] = lambda.map(|x| x * texels_per_unit);
    if length.is_beyond_range() || minor.is_beyond_range() {
        flags.insert(Flag::LengthSaturated);
    }
    let [length, minor] = [length, minor].map(N::saturated);
    let divisor = match count {
        Count::Ceil | Count::Round => number(f64::from(max)),
        Count::Pow2 => number(f64::from(power_of_two_below(max))),
        Count::Feline => (number(f64::from(max)) + number(1.0)) / number(2.0),
    };
    let width = minor.larger(number(1.0)).larger(length / divisor);
    let ratio = length / width;
    let ceil = whole((ratio - number(1.0 / 256.0)).ceil(), max);
    let probes = match count {
        Count::Ceil => ceil,
        Count::Round => whole((ratio + number(0.5)).floor(), max),
        Count::Pow2 => ceil.min(power_of_two_below(max)).next_power_of_two(),
        Count::Feline => whole((number(2.0) * ratio - number(0.5)).floor(), max),
    };
    let last = number(chain.levels.saturating_sub(1) as f64);
    // width is at least 1.
    let lod = -(-width.log2()).larger(-last);
    let half_spacing = match count {
        Count::Ceil | Count::Round | Count::Pow2 => {
            lambda[0] / (number(2.0) * number(f64::from(probes)))
        }
        Count::Feline if probes == 1 => number(0.0),
        Count::Feline => {
            // 2(M − m)/(P − 1) texels from probe to probe, half of it, 1/texels_per_unit each.
            let beyond = (length - width).larger(number(0.0));
            beyond / number(f64::from(probes - 1)) / texels_per_unit
        }
    };
    let step = axis.map(|x| half_spacing * x + number(0.0));
    let stage = Stage::Footprint;
    put(tap, stage, "length", &[length]);
    put(tap, stage, "width", &[width]);
    put(tap, stage, "probes", &[number(f64::from(probes))]);
    put(tap, stage, "lod", &[lod]);
    put(tap, stage, "step", &step);
    Footprint { probes, lod, step }
}

/// The line whose probes, with their own width, have the variance of the ellipse and of level 0's tent.
///
/// With Λ = (λ·N/2)² and V the spread of all probes: m² = max(1 + Λ2/κ, (Λ1 + κ + ½τ'V)/(1.5·τ'V + κ)),
/// R = Λ1 + κ − κm². Where R ≤ m², one probe with an eighth of R more; else the least n with
/// τ·V_n·(1.5m² − ½) ≥ R, τ·V_n in eighths as a whole number. LOD = ½·log2 m², spacing √(R/V_n).
fn moments<N: Narrow, T: Tap>(
    lambda: [N; 2],
    axis: [N; 2],
    chain: Chain,
    (policy, spreads): (&FootprintPolicy, &[f64]),
    flags: &mut Flags,
    tap: &mut T,
) -> Footprint<N> {
    let number = N::from_f64;
    let texels_per_unit = number(chain.size as f64) / number(2.0);
    let squares = lambda.map(|x| {
        let length = x * texels_per_unit;
        length * length
    });
    if squares.iter().any(|x| x.is_beyond_range()) {
        flags.insert(Flag::LengthSaturated);
    }
    let [major, minor] = squares.map(N::saturated);
    let kappa = number(f64::from(policy.kappa));
    let full = f64::from(policy.tau_cap) / 8.0 * spreads.last().copied().unwrap_or(0.0);
    let cap = (major + kappa + number(full / 2.0)) / (number(1.5 * full) + kappa);
    let width_sq = (number(1.0) + minor / kappa).larger(cap);
    let rest = (major + kappa - kappa * width_sq).larger(number(0.0));
    let (mut probes, mut half_spacing, mut probe_sq) = (1, number(0.0), width_sq);
    if rest > width_sq {
        let per_spread = number(3.0) * width_sq - number(1.0);
        let holds = |spread: &f64| {
            let eighths = (f64::from(policy.tau) * spread + 0.5).floor();
            number(eighths) * per_spread >= number(16.0) * rest
        };
        let index = spreads.iter().position(holds).unwrap_or(spreads.len().saturating_sub(1));
        probes = num::u32(index) + 1;
        let spread = spreads.get(index).copied().unwrap_or(0.0);
        if spread > 0.0 {
            half_spacing = (rest / number(spread)).sqrt() / number(2.0) / texels_per_unit;
        }
    } else {
        probe_sq = width_sq + rest / number(8.0);
    }
    let last = number(chain.levels.saturating_sub(1) as f64);
    // The width is at least 1.
    let lod = -(-(probe_sq.log2() / number(2.0))).larger(-last);
    let step = axis.map(|x| half_spacing * x + number(0.0));
    let stage = Stage::Footprint;
    put(tap, stage, "width_sq", &[probe_sq]);
    put(tap, stage, "rest", &[rest]);
    put(tap, stage, "probes", &[number(f64::from(probes))]);
    put(tap, stage, "lod", &[lod]);
    put(tap, stage, "step", &step);
    Footprint { probes, lod, step }
}

/// A whole number clamped to 1 … max.
fn whole<N: Narrow>(x: N, max: u32) -> u32 {
    let x = x.to_f64();
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped to 1 ..= max before the cast"
    )]
    let count = x.clamp(1.0, f64::from(max)) as u32;
    count
}
