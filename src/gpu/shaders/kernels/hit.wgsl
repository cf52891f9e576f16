// The HIT operation in one kernel: the search, and ENV's stages at its end.

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if !begin(id.x) {
        return;
    }
    var flags = 0u;
    let x = take3();
    let r = take3();
    let cone = take2();
    let has_cone = take_u32() != 0u;
    let ray = hit(x, r, &flags);
    let escaped = ray.status == STATUS_ESCAPED;
    var filtered: Filtered;
    if has_cone {
        let facing = cube_face(ray.l, &flags);
        let t = hit_tangents(ray, &flags);
        let d = hit_footprint(facing, t, hit_width(ray, cone), escaped);
        filtered = back_end(facing, d, vec4f(0.0), &flags);
    }
    put_filtered(filtered, flags);
    put(ray.d);
    put3(ray.l);
    put_u32(ray.iterations);
    put_u32(ray.status);
    put(ray.ratio);
}
