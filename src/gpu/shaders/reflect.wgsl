// Stage `reflect`: the reflected direction.

/// The reflected direction and the products that the derivatives use again.
struct Reflection {
    /// The direction; its length is |v|·|n|².
    v_r: vec3f,
    /// ⟨n, v⟩.
    n_dot_v: f32,
    /// ⟨n, n⟩.
    n_dot_n: f32,
}

/// v_r = 2n⟨v, n⟩ − v⟨n, n⟩ with n the modified normal (Schilling, eq. 4). Nothing is normalised.
///
/// It takes the place of WGSL's own `reflect`, which wants a unit normal.
fn reflect(v: vec3f, n: vec3f) -> Reflection {
    let n_dot_v = dot3(n, v);
    let n_dot_n = dot3(n, n);
    let v_r = (2.0 * n_dot_v) * n - n_dot_n * v;
    return Reflection(v_r, n_dot_v, n_dot_n);
}
