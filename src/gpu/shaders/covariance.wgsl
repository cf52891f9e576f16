// Stage `covariance`: K, the quadratic form of the footprint.

/// m·mᵀ = (a, b; b, c) of a 2×2 matrix given row by row.
fn outer(m: vec4f) -> vec3f {
    return vec3f(m.x * m.x + m.y * m.y, m.x * m.z + m.y * m.w, m.z * m.z + m.w * m.w);
}

/// K = D·Dᵀ + (sB')(sB')ᵀ = (a, b; b, c) (Schilling, eq. 3 corrected, 12 and 13); `rough` is 0 without roughness.
fn covariance(d: vec4f, rough: vec4f) -> vec3f {
    var k = outer(d);
    if policy.rough != 0u {
        k = k + outer(rough);
    }
    return k;
}
