// Faces of a cube map, ordered +X −X +Y −Y +Z −Z with (sc, tc, ma) as in WebGPU.

/// (sc, tc, |ma|) of a vector on a face.
fn on_face(face: u32, d: vec3f) -> vec3f {
    switch face {
        case 0u: { return vec3f(-d.z, -d.y, d.x); }
        case 1u: { return vec3f(d.z, -d.y, -d.x); }
        case 2u: { return vec3f(d.x, d.z, d.y); }
        case 3u: { return vec3f(d.x, -d.z, -d.y); }
        case 4u: { return vec3f(d.x, -d.y, d.z); }
        default: { return vec3f(-d.x, -d.y, -d.z); }
    }
}

/// The direction of the point (u, v) of a face; its major component is ±1.
fn direction(face: u32, u: f32, v: f32) -> vec3f {
    switch face {
        case 0u: { return vec3f(1.0, -v, -u); }
        case 1u: { return vec3f(-1.0, -v, u); }
        case 2u: { return vec3f(u, 1.0, v); }
        case 3u: { return vec3f(u, -1.0, -v); }
        case 4u: { return vec3f(u, -v, 1.0); }
        default: { return vec3f(-u, -v, -1.0); }
    }
}

/// The face that a direction meets; on equal magnitudes z wins over y wins over x.
fn major_face(d: vec3f) -> u32 {
    let size = abs(d);
    if size.z >= size.x && size.z >= size.y {
        return select(4u, 5u, d.z < 0.0);
    }
    if size.y >= size.x {
        return select(2u, 3u, d.y < 0.0);
    }
    return select(0u, 1u, d.x < 0.0);
}

/// The texel (face, column, row) that stands in for (x, y) of `face` where exactly one of x, y is −1 or `size`.
///
/// In half texels about the face's middle everything stays an integer: the edge texel's centre moved onto the edge
/// has the outer coordinate ±size and the inner one 2t + 1 − size.
fn across_edge(size: i32, face: u32, x: i32, y: i32) -> vec3i {
    let s = clamp(2 * x + 1 - size, -size, size);
    let t = clamp(2 * y + 1 - size, -size, size);
    var d: vec3i;
    switch face {
        case 0u: { d = vec3i(size, -t, -s); }
        case 1u: { d = vec3i(-size, -t, s); }
        case 2u: { d = vec3i(s, size, t); }
        case 3u: { d = vec3i(s, -size, -t); }
        case 4u: { d = vec3i(s, -t, size); }
        default: { d = vec3i(-s, -t, -size); }
    }
    // Two components have the magnitude `size`: the neighbour's major one is not this face's.
    let own = face / 2u;
    var other = 0u;
    if own != 0u && abs(d.x) == size {
        other = select(0u, 1u, d.x < 0);
    } else if own != 1u && abs(d.y) == size {
        other = select(2u, 3u, d.y < 0);
    } else {
        other = select(4u, 5u, d.z < 0);
    }
    var at: vec2i;
    switch other {
        case 0u: { at = vec2i(-d.z, -d.y); }
        case 1u: { at = vec2i(d.z, -d.y); }
        case 2u: { at = vec2i(d.x, d.z); }
        case 3u: { at = vec2i(d.x, -d.z); }
        case 4u: { at = vec2i(d.x, -d.y); }
        default: { at = vec2i(-d.x, -d.y); }
    }
    let place = clamp((at + size - 1) >> vec2u(1u), vec2i(0), vec2i(size - 1));
    return vec3i(i32(other), place);
}
