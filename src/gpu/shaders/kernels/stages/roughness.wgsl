// Registers: d_scaled 3, v_dot_e 2, n_dot_e 2, dv_r 6, numerator 4, e 4, b 4.

fn stage() {
    var surface: Surface;
    surface.v = take3();
    surface.n_mod = take3();
    surface.frame.e1 = take3();
    surface.frame.e2 = take3();
    surface.reflection.n_dot_v = take();
    surface.facing = take_facing();
    let out = roughness(surface, take3(), policy.roughness_scale);
    put3(out.d_scaled);
    put2(out.v_dot_e);
    put2(out.n_dot_e);
    put3(out.dv_r[0]);
    put3(out.dv_r[1]);
    put_numerators(out.numerators);
    put4(out.e);
    put4(out.b);
}
