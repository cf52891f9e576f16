// Stage `cube_face`: the face, 1/|ma| and the coordinates on the face.

/// Where a direction meets the cube.
struct Facing {
    /// Face, 0…5 for +x −x +y −y +z −z.
    face: u32,
    /// 1/|ma|; 0 where the direction is zero.
    inv_ma: f32,
    /// sc/|ma|.
    u: f32,
    /// tc/|ma|.
    v: f32,
    /// The looked-up direction.
    rotated: vec3f,
}

/// Face, 1/|ma|, u = sc/|ma| and v = tc/|ma| of A·v_r.
///
/// On equal magnitudes z wins over y over x. v_r = 0 gives +z, u = v = 0 and 1/|ma| = 0, so that all derivatives
/// become 0, and raises the flag.
fn cube_face(v_r: vec3f, flags: ptr<function, u32>) -> Facing {
    let d = transform(v_r);
    let face = major_face(d);
    let axes = on_face(face, d);
    let ma = abs(axes.z);
    if ma == 0.0 {
        *flags |= FLAG_ZERO;
        return Facing(face, 0.0, 0.0, 0.0, d);
    }
    return Facing(face, 1.0 / ma, axes.x / ma, axes.y / ma, d);
}

/// G without its factor 1/|ma|: (∂sc − u·∂|ma|, ∂tc − v·∂|ma|) of a derivative of the direction.
fn numerator(facing: Facing, derivative: vec3f) -> vec2f {
    let axes = on_face(facing.face, derivative);
    return vec2f(axes.x - facing.u * axes.z, axes.y - facing.v * axes.z);
}
