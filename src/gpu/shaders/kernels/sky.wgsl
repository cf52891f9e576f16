// A bare cone into the environment: a path that leaves a scene of the TEX operation.

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if !begin(id.x) {
        return;
    }
    var flags = 0u;
    let from_camera = take3();
    let first = take_u32();
    let count = take_u32();
    var ray: Search;
    ray.r = unit(take3());
    ray.status = STATUS_ESCAPED;
    let cone = walk(from_camera, first, count, true);
    let facing = cube_face(ray.r, &flags);
    let t = hit_tangents(ray, &flags);
    let width = saturate_f32(hit_width(ray, cone), FLAG_OVERFLOW, &flags);
    let d = hit_footprint(facing, t, width, true);
    put_filtered(back_end(facing, d, vec4f(0.0), &flags), flags);
}
