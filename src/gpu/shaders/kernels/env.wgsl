// The ENV operation in one kernel.

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if !begin(id.x) {
        return;
    }
    var flags = 0u;
    var surface: Surface;
    surface.v = take3();
    surface.n = take3();
    let dv_dx = take3();
    let dv_dy = take3();
    let dn_dx = take3();
    let dn_dy = take3();
    let derivatives = Derivatives(array<vec3f, 2>(dv_dx, dv_dy), array<vec3f, 2>(dn_dx, dn_dy));
    let h = take3();
    surface.b = take2();
    let factors = take3();
    surface.n_mod = surface.n;
    if (policy.bump | policy.rough) != 0u {
        surface.frame = local_frame(surface.n, h, &flags);
    }
    if policy.bump != 0u {
        surface.n_mod = bump(surface.n, surface.frame, surface.b);
    }
    surface.reflection = reflect(surface.v, surface.n_mod);
    surface.reflection.v_r = saturate_vec3(surface.reflection.v_r, FLAG_OVERFLOW, &flags);
    surface.facing = cube_face(surface.reflection.v_r, &flags);
    let d = jacobian(surface, derivatives).d;
    var rough = vec4f(0.0);
    if policy.rough != 0u {
        let carried = roughness(surface, factors, policy.roughness_scale).b;
        rough = saturate_vec4(carried, FLAG_OVERFLOW, &flags);
    }
    put_filtered(back_end(surface.facing, d, rough, &flags), flags);
}
