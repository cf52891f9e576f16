// Stage `footprint`: how many probes, how wide, how far apart.

/// The mip chain that the footprint is measured against.
struct Chain {
    /// Texels along an edge of level 0, at least 1.
    size: u32,
    /// Number of levels, at least 1.
    levels: u32,
}

/// The probes of a fragment.
struct Footprint {
    /// Number of probes, at least 1.
    probes: u32,
    /// Level of detail, 0 … levels − 1.
    lod: f32,
    /// Half the way from one probe to the next: probe i lies at centre + (2i + 1 − probes)·step.
    step: vec2f,
    /// M and m in texels of level 0.
    length: f32,
    width: f32,
}

/// The highest power of two that is at most `x` (x ≥ 1).
fn power_of_two_below(x: u32) -> u32 {
    return 1u << firstLeadingBit(x);
}

/// A whole number clamped to 1 … most.
fn whole(x: f32, most: u32) -> u32 {
    return u32(clamp(x, 1.0, f32(most)));
}

/// M = λ1·N/2, m = max(λ2·N/2, 1, M/most probes), count, LOD = log2 m and the step.
///
/// Every rule widens m so that its count fits: `pow2` by the largest power of two that fits in `max_probes`, `feline`
/// by (max + 1)/2. `feline` spaces its probes over 2(M − m) texels, ends included; the others over λ1, at the middles
/// of equal parts.
fn footprint(lambda: vec2f, axis: vec2f, chain: Chain, flags: ptr<function, u32>) -> Footprint {
    let most = policy.footprint_max_probes;
    let texels_per_unit = f32(chain.size) / 2.0;
    let length = saturate_f32(lambda.x * texels_per_unit, FLAG_LENGTH_SATURATED, flags);
    let minor = saturate_f32(lambda.y * texels_per_unit, FLAG_LENGTH_SATURATED, flags);
    var divisor = f32(most);
    if policy.footprint_count == FOOTPRINT_COUNT_POW2 {
        divisor = f32(power_of_two_below(most));
    } else if policy.footprint_count == FOOTPRINT_COUNT_FELINE {
        divisor = (f32(most) + 1.0) / 2.0;
    }
    let width = max(max(minor, 1.0), length / divisor);
    let ratio = length / width;
    let ceiling = whole(ceil(ratio - 1.0 / 256.0), most);
    var probes = ceiling;
    if policy.footprint_count == FOOTPRINT_COUNT_ROUND {
        probes = whole(floor(ratio + 0.5), most);
    } else if policy.footprint_count == FOOTPRINT_COUNT_POW2 {
        let fits = min(ceiling, power_of_two_below(most));
        let below = power_of_two_below(fits);
        probes = select(2u * below, below, below == fits);
    } else if policy.footprint_count == FOOTPRINT_COUNT_FELINE {
        probes = whole(floor(2.0 * ratio - 0.5), most);
    }
    let lod = clamp(log2(width), 0.0, f32(chain.levels - 1u));
    var half_spacing = lambda.x / (2.0 * f32(probes));
    if policy.footprint_count == FOOTPRINT_COUNT_FELINE {
        half_spacing = 0.0;
        if probes > 1u {
            half_spacing = max(length - width, 0.0) / f32(probes - 1u) / texels_per_unit;
        }
    }
    return Footprint(probes, lod, half_spacing * axis, length, width);
}
