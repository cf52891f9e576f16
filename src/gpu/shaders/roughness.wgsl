// Stage `roughness`: the roughness ellipse carried to the face.

/// s·B' and the registers on the way to it.
struct Rough {
    /// s·B', row by row.
    b: vec4f,
    d_scaled: vec3f,
    v_dot_e: vec2f,
    n_dot_e: vec2f,
    dv_r: array<vec3f, 2>,
    numerators: array<vec2f, 2>,
    /// G·A·J_n·[e1 e2], row by row.
    e: vec4f,
}

/// s·B' = G·A·J_n·[e1 e2]·(s·B), B = [d1 d2; 0 d3] (Schilling, eq. 10 and 11).
fn roughness(surface: Surface, d: vec3f, s: f32) -> Rough {
    var out: Rough;
    out.d_scaled = s * d;
    let basis = array<vec3f, 2>(surface.frame.e1, surface.frame.e2);
    for (var i = 0; i < 2; i++) {
        let e = basis[i];
        let v_dot_e = dot3(surface.v, e);
        let n_dot_e = dot3(surface.n_mod, e);
        let half = by_normal(surface, e, v_dot_e, n_dot_e);
        let dv_r = transform(2.0 * half);
        let numerators = numerator(surface.facing, dv_r);
        out.v_dot_e[i] = v_dot_e;
        out.n_dot_e[i] = n_dot_e;
        out.dv_r[i] = dv_r;
        out.numerators[i] = numerators;
        out.e[i] = numerators.x * surface.facing.inv_ma;
        out.e[i + 2] = numerators.y * surface.facing.inv_ma;
    }
    let d_scaled = out.d_scaled;
    out.b = vec4f(
        out.e.x * d_scaled.x,
        out.e.x * d_scaled.y + out.e.y * d_scaled.z,
        out.e.z * d_scaled.x,
        out.e.z * d_scaled.y + out.e.w * d_scaled.z,
    );
    return out;
}
