// A 2-D texture with its mip chain, read by `textureLoad`, and its address modes.

/// x − p·round(x/p), the remainder of least magnitude. A coordinate's quotient is small, so that the product is exact.
fn nearest_remainder(x: f32, period: f32) -> f32 {
    return x - period * round(x / period);
}

/// A coordinate u = 2s − 1 that is left as it is from −1 to 1, brought back from beyond.
fn wrapped(u: f32, wrap: u32) -> f32 {
    if abs(u) <= 1.0 {
        return u;
    }
    if wrap == ADDRESS_WRAP_S_REPEAT {
        return nearest_remainder(u, 2.0);
    }
    if wrap == ADDRESS_WRAP_S_CLAMP {
        return clamp(u, -1.0, 1.0);
    }
    let turn = nearest_remainder(u, 4.0);
    if turn > 1.0 {
        return 2.0 - turn;
    }
    if turn < -1.0 {
        return -2.0 - turn;
    }
    return turn;
}

/// Where probe `index` of `probes` lies on the texture.
fn planar_address(centre: vec2f, step: vec2f, index: u32, probes: u32) -> vec2f {
    let offset = 2.0 * f32(index) + 1.0 - f32(probes);
    return vec2f(
        wrapped(centre.x + offset * step.x, policy.address_wrap_s),
        wrapped(centre.y + offset * step.y, policy.address_wrap_t),
    );
}

/// Columns and rows of a level.
fn planar_size(level: u32) -> vec2u {
    return max(vec2u(policy.size_x, policy.size_y) >> vec2u(level), vec2u(1u));
}

/// x modulo n, never negative.
fn modulo(x: i32, n: i32) -> i32 {
    return ((x % n) + n) % n;
}

/// The column or row that stands at `x`, which may lie outside.
fn wrapped_texel(x: i32, size: i32, wrap: u32) -> i32 {
    if wrap == ADDRESS_WRAP_S_REPEAT {
        return modulo(x, size);
    }
    if wrap == ADDRESS_WRAP_S_MIRROR {
        let turn = modulo(x, 2 * size);
        return min(turn, 2 * size - 1 - turn);
    }
    return clamp(x, 0, size - 1);
}

fn planar_tap(level: u32, x: i32, y: i32) -> vec3f {
    let size = vec2i(planar_size(level));
    let at = vec2i(wrapped_texel(x, size.x, policy.address_wrap_s), wrapped_texel(y, size.y, policy.address_wrap_t));
    return textureLoad(texels, at, 0u, level).rgb;
}

/// The bilinear value at a place of a level, −1 … 1 from edge to edge.
fn planar_bilinear(level: u32, at: vec2f) -> vec3f {
    let size = planar_size(level);
    let x = cell(at.x, size.x);
    let y = cell(at.y, size.y);
    let lt = planar_tap(level, x.low, y.low);
    let rt = planar_tap(level, x.low + 1, y.low);
    let lb = planar_tap(level, x.low, y.low + 1);
    let rb = planar_tap(level, x.low + 1, y.low + 1);
    return mix_exactly(mix_exactly(lt, rt, x.fraction), mix_exactly(lb, rb, x.fraction), y.fraction);
}
