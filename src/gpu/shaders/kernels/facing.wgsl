// A facing as an operand of the stages behind it.

fn take_facing() -> Facing {
    let face = take_u32();
    let inv_ma = take();
    let u = take();
    let v = take();
    return Facing(face, inv_ma, u, v, vec3f(0.0));
}

/// Columns of a pair of numerators, row by row.
fn put_numerators(numerators: array<vec2f, 2>) {
    put4(vec4f(numerators[0].x, numerators[1].x, numerators[0].y, numerators[1].y));
}
