// Stage `jacobian`: D, the derivatives of the face coordinates by screen position.

/// The inputs of the derivatives.
struct Derivatives {
    /// ∂v by x and by y.
    dv: array<vec3f, 2>,
    /// ∂n by x and by y, of the interpolated normal.
    dn: array<vec3f, 2>,
}

/// The surface at the fragment.
struct Surface {
    /// Direction to the eye.
    v: vec3f,
    /// Interpolated normal.
    n: vec3f,
    /// Modified normal (n without a bump).
    n_mod: vec3f,
    /// Frame and offsets, with a bump.
    frame: Frame,
    b: vec2f,
    /// Reflected direction.
    reflection: Reflection,
    /// Where it meets the cube.
    facing: Facing,
}

/// D and the registers on the way to it.
struct Jacobian {
    /// [∂u/∂x, ∂u/∂y], [∂v/∂x, ∂v/∂y].
    d: vec4f,
    /// ⟨n,∂n⟩/⟨n,n⟩ of the interpolated normal.
    along: vec2f,
    dn_mod: array<vec3f, 2>,
    n_dot_dv: vec2f,
    v_dot_dn: vec2f,
    n_dot_dn: vec2f,
    dv_r: array<vec3f, 2>,
    /// |ma|·∂u and |ma|·∂v, by x and by y.
    numerators: array<vec2f, 2>,
}

/// D = G·A·(J_v·∂v + J_n·∂n_mod), J_v = 2nnᵀ − ⟨n,n⟩I, J_n = 2⟨n,v⟩I + 2nvᵀ − 2vnᵀ, n the modified normal
/// (Schilling, eq. 5, 6, 8, 9, with the signs of the faces and ∂n_mod by `policy.jacobian_dnmod`).
fn jacobian(surface: Surface, derivatives: Derivatives) -> Jacobian {
    var out = normal_derivatives(surface, derivatives);
    let n = surface.n_mod;
    for (var i = 0; i < 2; i++) {
        let dv = derivatives.dv[i];
        let dn = out.dn_mod[i];
        let n_dot_dv = dot3(n, dv);
        let v_dot_dn = dot3(surface.v, dn);
        let n_dot_dn = dot3(n, dn);
        let by_v = (2.0 * n_dot_dv) * n - surface.reflection.n_dot_n * dv;
        let by_n = 2.0 * by_normal(surface, dn, v_dot_dn, n_dot_dn);
        let dv_r = transform(by_v + by_n);
        let numerators = numerator(surface.facing, dv_r);
        out.n_dot_dv[i] = n_dot_dv;
        out.v_dot_dn[i] = v_dot_dn;
        out.n_dot_dn[i] = n_dot_dn;
        out.dv_r[i] = dv_r;
        out.numerators[i] = numerators;
        out.d[i] = numerators.x * surface.facing.inv_ma;
        out.d[i + 2] = numerators.y * surface.facing.inv_ma;
    }
    return out;
}

/// ½·J_n·d = ⟨n,v⟩d + n⟨v,d⟩ − v⟨n,d⟩ with the two products given.
fn by_normal(surface: Surface, d: vec3f, v_dot_d: f32, n_dot_d: f32) -> vec3f {
    let first = surface.reflection.n_dot_v * d;
    let second = v_dot_d * surface.n_mod;
    return (first + second) - n_dot_d * surface.v;
}

/// ∂n_mod by x and y under the policy.
fn normal_derivatives(surface: Surface, derivatives: Derivatives) -> Jacobian {
    var out: Jacobian;
    out.dn_mod = derivatives.dn;
    if policy.bump == 0u {
        return out;
    }
    if policy.jacobian_dnmod != JACOBIAN_DNMOD_PAPER {
        let n = surface.n;
        let n_dot_n = dot3(n, n);
        for (var i = 0; i < 2; i++) {
            var along = 0.0;
            if n_dot_n != 0.0 {
                along = dot3(n, derivatives.dn[i]) / n_dot_n;
            }
            out.along[i] = along;
            out.dn_mod[i] = derivatives.dn[i] - along * n;
        }
    }
    if policy.jacobian_dnmod == JACOBIAN_DNMOD_FRAME {
        for (var i = 0; i < 2; i++) {
            let dn = out.dn_mod[i];
            let de = frame_derivatives(surface.n, surface.frame, dn);
            let turn = surface.b.x * de[0] + surface.b.y * de[1];
            out.dn_mod[i] = dn + turn;
        }
    }
    return out;
}

/// ∂e1 and ∂e2 while n changes by dn ⟂ n and h stays.
///
/// With c = h × n and ĉ = c/|c|: ∂ĉ = (∂c − ĉ⟨ĉ,∂c⟩)/|c|, ∂c = h × dn; e1 = |n|ĉ and e2 = n × ĉ, and |n| does not
/// change because dn ⟂ n.
fn frame_derivatives(n: vec3f, frame: Frame, dn: vec3f) -> array<vec3f, 2> {
    let dc = cross3(frame.h, dn);
    let across = dc - dot3(frame.direction, dc) * frame.direction;
    let turn = frame.inv_length * across;
    return array<vec3f, 2>(
        frame.n_length * turn,
        cross3(dn, frame.direction) + cross3(n, turn),
    );
}
