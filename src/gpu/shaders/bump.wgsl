// Stage `bump`: the normal moved by the bump map.

/// n_mod = n + b1·e1 + b2·e2 (Schilling, above eq. 4).
fn bump(n: vec3f, frame: Frame, b: vec2f) -> vec3f {
    return n + b.x * frame.e1 + b.y * frame.e2;
}
