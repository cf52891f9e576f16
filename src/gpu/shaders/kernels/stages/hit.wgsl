// Registers: r 3, radius; of every look-up and before the first: length, radius, ratio, step, d, l 3, status u32, done u32;
// tangent 6, width, d 4, flags u32.

fn put_turn(ray: Search) {
    put(ray.length);
    put(ray.radius);
    put(ray.ratio);
    put(ray.step);
    put(ray.d);
    put3(ray.l);
    put_u32(ray.status);
    put_u32(select(0u, 1u, ray.done));
}

fn stage() {
    var flags = 0u;
    let x = take3();
    let r = take3();
    let cone = take2();
    var ray = hit_begin(x, r, &flags);
    put3(ray.r);
    put(ray.far);
    put_turn(ray);
    for (var k = 0u; k < policy.hit_iterations; k++) {
        if !ray.done {
            ray.step = 0.0;
            ray = hit_step(ray, &flags);
        }
        put_turn(ray);
    }
    let facing = cube_face(ray.l, &flags);
    let t = hit_tangents(ray, &flags);
    let width = hit_width(ray, cone);
    put3(t[0]);
    put3(t[1]);
    put(width);
    put4(hit_footprint(facing, t, width, ray.status == STATUS_ESCAPED));
    put_u32(flags);
}
