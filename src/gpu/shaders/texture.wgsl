// A cube map as an array texture of six layers with its mip chain, read by `textureLoad`.

/// a + (b − a)·f: a constant stays what it is.
fn mix_exactly(a: vec3f, b: vec3f, f: f32) -> vec3f {
    return a + (b - a) * f;
}

/// The left one of two taps and the weight of the right one.
struct Cell {
    low: i32,
    fraction: f32,
}

fn cell(u: f32, size: u32) -> Cell {
    let s = clamp(texel_coordinate(u, size), -0.5, f32(size) - 0.5);
    let low = floor(s);
    return Cell(i32(low), s - low);
}

/// Texels along an edge of a level.
fn level_size(level: u32) -> u32 {
    return max(policy.size_x >> level, 1u);
}

/// A texel of a face, or across one of its edges; beyond a corner the mean of the three that meet there.
fn tap(level: u32, face: u32, x: i32, y: i32) -> vec3f {
    let size = i32(level_size(level));
    let inner = clamp(vec2i(x, y), vec2i(0), vec2i(size - 1));
    let own = textureLoad(texels, inner, face, level).rgb;
    let outside = vec2<bool>(x != inner.x, y != inner.y);
    if !(outside.x || outside.y) {
        return own;
    }
    if outside.x && outside.y {
        let one = across_edge(size, face, x, inner.y);
        let two = across_edge(size, face, inner.x, y);
        let sum = textureLoad(texels, one.yz, one.x, level).rgb + textureLoad(texels, two.yz, two.x, level).rgb;
        return (sum + own) / 3.0;
    }
    let other = across_edge(size, face, x, y);
    return textureLoad(texels, other.yz, other.x, level).rgb;
}

/// The bilinear value at a point of the cube.
fn bilinear(level: u32, at: Address) -> vec3f {
    let size = level_size(level);
    let x = cell(at.u, size);
    let y = cell(at.v, size);
    let lt = tap(level, at.face, x.low, y.low);
    let rt = tap(level, at.face, x.low + 1, y.low);
    let lb = tap(level, at.face, x.low, y.low + 1);
    let rb = tap(level, at.face, x.low + 1, y.low + 1);
    return mix_exactly(mix_exactly(lt, rt, x.fraction), mix_exactly(lb, rb, x.fraction), y.fraction);
}
