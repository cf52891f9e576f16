// From D to a colour: the stages that ENV and HIT share.

struct Filtered {
    color: vec3f,
    line: Footprint,
}

fn saturate_vec4(x: vec4f, flag: u32, flags: ptr<function, u32>) -> vec4f {
    return vec4f(saturate_vec3(x.xyz, flag, flags), saturate_f32(x.w, flag, flags));
}

/// K and the axes, saturated and flagged where they leave the range.
fn axes_of(d: vec4f, rough: vec4f, flags: ptr<function, u32>) -> Axes {
    let k = saturate_vec3(covariance(d, rough), FLAG_COVARIANCE_SATURATED, flags);
    var axes = eigen(k, d, rough);
    axes.lambda.x = saturate_f32(axes.lambda.x, FLAG_LAMBDA_SATURATED, flags);
    axes.lambda.y = saturate_f32(axes.lambda.y, FLAG_LAMBDA_SATURATED, flags);
    return axes;
}

fn back_end(facing: Facing, d_in: vec4f, rough: vec4f, flags: ptr<function, u32>) -> Filtered {
    let d = saturate_vec4(d_in, FLAG_DERIVATIVES_SATURATED, flags);
    let axes = axes_of(d, rough, flags);
    let chain = Chain(policy.size_x, policy.levels);
    let line = footprint(axes.lambda, axes.axis, chain, flags);
    let centre = Address(facing.face, facing.u, facing.v);
    let color = filter_cube(centre, line, levels_of(line.lod, policy.levels));
    return Filtered(color, line);
}

/// The results that every fused kernel ends with: colour, LOD, probes, flags.
fn put_filtered(filtered: Filtered, flags_in: u32) {
    var flags = flags_in;
    put3(saturate_vec3(filtered.color, FLAG_OVERFLOW, &flags));
    put(filtered.line.lod);
    put_u32(filtered.line.probes);
    put_u32(flags);
}
