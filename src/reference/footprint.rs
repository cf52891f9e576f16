//! Stage `footprint`: how many probes, how wide, how far apart.

use super::flags::{Flag, Flags};
use super::real::Narrow;
use super::tap::{Tap, put};
use crate::policy::{Count, FootprintPolicy};
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
#[inline]
pub fn footprint<N: Narrow, T: Tap>(
    lambda: [N; 2],
    axis: [N; 2],
    chain: Chain,
    policy: &FootprintPolicy,
    flags: &mut Flags,
    tap: &mut T,
) -> Footprint<N> {
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
