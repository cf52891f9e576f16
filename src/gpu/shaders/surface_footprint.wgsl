// Stage `surface_footprint`: from a cone's width to ddx, ddy and D on a 2-D texture (Cline 2023).

/// From |D·N| = 0.999 on OptiX Toolkit takes D and N for parallel.
const OTK_LIMIT: f32 = 0.999;

/// A ray at a textured surface.
struct TexFragment {
    /// Direction of the ray and normal of the surface, of any length.
    d: vec3f,
    n: vec3f,
    /// ∂P/∂s and ∂P/∂t, or a triangle's edges B − A and C − A.
    tangents: array<vec3f, 2>,
    /// Whether it is a triangle; then (s, t) of B and of C less that of A.
    triangle: bool,
    st: array<vec2f, 2>,
}

/// A cone's ellipse on the surface and in the texture, and the registers on the way.
struct SurfaceFootprint {
    d_unit: vec3f,
    n_unit: vec3f,
    cosine: f32,
    across: vec3f,
    along: vec3f,
    /// dPdx and dPdy in world units.
    dp: array<vec3f, 2>,
    grad: array<vec3f, 2>,
    /// ddx and ddy: (∂s, ∂t) per pixel.
    dd: array<vec2f, 2>,
    /// D in texels of level 0: ∂s/∂x·W, ∂s/∂y·W, ∂t/∂x·H, ∂t/∂y·H.
    d: vec4f,
}

/// dPdx = unit(D − ⟨D,N⟩N)·|w|/max(|⟨D,N⟩|, 1/max_anisotropy), dPdy = unit(D × N)·|w|, and
/// ddx = (⟨dPdx,∇s⟩, ⟨dPdx,∇t⟩) with the surface gradients of s and t.
///
/// D ∥ N, or one of them 0: any orthogonal pair of length |w| across N, (0, 0, 1) for no N. With OptiX Toolkit's rules w
/// keeps its sign, and that pair is taken from |⟨D,N⟩| = 0.999 on.
fn surface_footprint(fragment: TexFragment, signed_width: f32, flags: ptr<function, u32>) -> SurfaceFootprint {
    var out: SurfaceFootprint;
    let otk = policy.cone_rules == CONE_RULES_OTK;
    let d = unit_or_zero(fragment.d);
    var n = unit_or_zero(fragment.n);
    let cosine = dot3(d, n);
    let crossed = cross3(d, n);
    let parallel = is_zero(crossed);
    if parallel {
        *flags |= FLAG_SURF_PARALLEL;
    }
    let flat_on = parallel || (otk && abs(cosine) >= OTK_LIMIT);
    if is_zero(n) {
        n = vec3f(0.0, 0.0, 1.0);
    }
    let across = unit_or_zero(select(crossed, beside(n), flat_on));
    let along = cross3(n, across);
    let width = select(abs(signed_width), signed_width, otk);
    let least = 1.0 / f32(policy.surface_footprint_max_anisotropy);
    let seen = select(max(abs(cosine), least), 1.0, flat_on);
    out.d_unit = d;
    out.n_unit = n;
    out.cosine = cosine;
    out.across = across;
    out.along = along;
    out.dp = array<vec3f, 2>((width / seen) * along, width * across);
    out.grad = gradients(fragment.tangents, flags);
    for (var i = 0; i < 2; i++) {
        let b = dot3(out.dp[i], out.grad[0]);
        let c = dot3(out.dp[i], out.grad[1]);
        if fragment.triangle {
            out.dd[i] = b * fragment.st[0] + c * fragment.st[1];
        } else {
            out.dd[i] = vec2f(b, c);
        }
    }
    let texel_count = vec2f(f32(policy.size_x), f32(policy.size_y));
    out.d = vec4f(
        out.dd[0].x * texel_count.x,
        out.dd[1].x * texel_count.x,
        out.dd[0].y * texel_count.y,
        out.dd[1].y * texel_count.y,
    );
    return out;
}

/// v/square; 0 where the divisor is 0.
fn over(v: vec3f, square: f32) -> vec3f {
    if square == 0.0 {
        return vec3f(0.0);
    }
    return v / square;
}

/// ∇s and ∇t on the surface. With g = ∂P/∂s × ∂P/∂t the normal equations give ∇s = ∂P/∂t × g/|g|² and
/// ∇t = g × ∂P/∂s/|g|²; the note's dot products are ∂P/∂s/|∂P/∂s|² and ∂P/∂t/|∂P/∂t|², which also stand in where g = 0.
fn gradients(tangents: array<vec3f, 2>, flags: ptr<function, u32>) -> array<vec3f, 2> {
    let s = tangents[0];
    let t = tangents[1];
    let g = cross3(s, t);
    let square = dot3(g, g);
    let gram = policy.cone_gradient == CONE_GRADIENT_GRAM;
    if gram && square == 0.0 {
        *flags |= FLAG_SURF_DEGENERATE;
    }
    if gram && square != 0.0 {
        return array<vec3f, 2>(over(cross3(t, g), square), over(cross3(g, s), square));
    }
    return array<vec3f, 2>(over(s, dot3(s, s)), over(t, dot3(t, t)));
}
