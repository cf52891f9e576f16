// Registers: along 2, dn_mod 6, n_dot_dv 2, v_dot_dn 2, n_dot_dn 2, dv_r 6, numerator 4, d 4.

fn stage() {
    var surface: Surface;
    surface.v = take3();
    surface.n = take3();
    surface.n_mod = take3();
    surface.frame.h = take3();
    surface.frame.direction = take3();
    surface.frame.inv_length = take();
    surface.frame.n_length = take();
    surface.b = take2();
    surface.reflection.n_dot_v = take();
    surface.reflection.n_dot_n = take();
    surface.facing = take_facing();
    let dv_dx = take3();
    let dv_dy = take3();
    let dn_dx = take3();
    let dn_dy = take3();
    let derivatives = Derivatives(array<vec3f, 2>(dv_dx, dv_dy), array<vec3f, 2>(dn_dx, dn_dy));
    let out = jacobian(surface, derivatives);
    put2(out.along);
    put3(out.dn_mod[0]);
    put3(out.dn_mod[1]);
    put2(out.n_dot_dv);
    put2(out.v_dot_dn);
    put2(out.n_dot_dn);
    put3(out.dv_r[0]);
    put3(out.dv_r[1]);
    put_numerators(out.numerators);
    put4(out.d);
}
