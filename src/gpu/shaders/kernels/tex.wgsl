// The TEX operation in one kernel: the cones' way from the camera, the footprint on the surface, a 2-D texture.

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if !begin(id.x) {
        return;
    }
    var flags = 0u;
    let from_camera = take3();
    let first = take_u32();
    let count = take_u32();
    let fragment = take_fragment();
    let st = take2();
    let cone = walk(from_camera, first, count, false);
    let width = saturate_f32(cone.y, FLAG_OVERFLOW, &flags);
    let surface = surface_footprint(fragment, width, &flags);
    let d = saturate_vec4(surface.d, FLAG_SURF_SATURATED, &flags);
    let axes = axes_of(d, vec4f(0.0), &flags);
    // λ counts in texels: 2 texels are 2.
    var line = footprint(axes.lambda, axes.axis, Chain(2u, policy.levels), &flags);
    line.step = line.step * vec2f(2.0 / f32(policy.size_x), 2.0 / f32(policy.size_y));
    let centre = 2.0 * st - 1.0;
    let color = filter_planar(centre, line, levels_of(line.lod, policy.levels));
    put_filtered(Filtered(color, line), flags);
}
