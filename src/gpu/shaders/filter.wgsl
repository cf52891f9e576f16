// Stage `filter`: trilinear probes and their weighted mean.

/// The two levels of a trilinear look-up and the weight of the second.
struct Levels {
    /// ⌊LOD⌋ and the level after it, at most the last of the chain.
    low: u32,
    high: u32,
    /// LOD − ⌊LOD⌋.
    fraction: f32,
}

/// Levels of an LOD from 0 to `levels` − 1.
fn levels_of(lod: f32, levels: u32) -> Levels {
    let low = floor(clamp(lod, 0.0, f32(levels - 1u)));
    let index = u32(low);
    return Levels(index, min(index + 1u, levels - 1u), lod - low);
}

/// The weight of a probe: 1, or a gaussian's from the table of every count.
fn probe_weight(index: u32, probes: u32) -> f32 {
    if policy.footprint_weights == FOOTPRINT_WEIGHTS_BOX {
        return 1.0;
    }
    return tables[probes * (probes - 1u) / 2u + index];
}

/// Sums the bilinear values of both levels over the probes, each with its weight, divides by the weights' sum and
/// mixes the levels by the LOD's fraction.
fn filter_cube(centre: Address, line: Footprint, levels: Levels) -> vec3f {
    var low = vec3f(0.0);
    var high = vec3f(0.0);
    var total = 0.0;
    for (var i = 0u; i < line.probes; i++) {
        let at = address(centre, line.step, i, line.probes);
        let weight = probe_weight(i, line.probes);
        total = total + weight;
        low = low + weight * bilinear(levels.low, at);
        if levels.fraction > 0.0 {
            high = high + weight * bilinear(levels.high, at);
        }
    }
    return combine(low, high, total, levels.fraction);
}

/// The same on a 2-D texture; `centre` and `step` count 2 a period.
fn filter_planar(centre: vec2f, line: Footprint, levels: Levels) -> vec3f {
    var low = vec3f(0.0);
    var high = vec3f(0.0);
    var total = 0.0;
    for (var i = 0u; i < line.probes; i++) {
        let at = planar_address(centre, line.step, i, line.probes);
        let weight = probe_weight(i, line.probes);
        total = total + weight;
        low = low + weight * planar_bilinear(levels.low, at);
        if levels.fraction > 0.0 {
            high = high + weight * planar_bilinear(levels.high, at);
        }
    }
    return combine(low, high, total, levels.fraction);
}

/// The levels' means, mixed.
fn combine(low: vec3f, high: vec3f, total: f32, fraction: f32) -> vec3f {
    if fraction > 0.0 {
        return mix_exactly(low / total, high / total, fraction);
    }
    return low / total;
}
