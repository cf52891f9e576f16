// Stage `address`: where a probe lies on the cube.

/// A point of the cube's surface.
struct Address {
    /// Face, 0…5.
    face: u32,
    /// sc/|ma| and tc/|ma| on that face.
    u: f32,
    v: f32,
}

/// The texel coordinate of a face coordinate: (u + 1)/2·N − ½; texel i has its centre at i.
fn texel_coordinate(u: f32, size: u32) -> f32 {
    return (u + 1.0) / 2.0 * f32(size) - 0.5;
}

/// Where probe `index` of `probes` lies on the plane of the centre's face: centre + (2·index + 1 − probes)·step.
fn probe_place(centre: Address, step: vec2f, index: u32, probes: u32) -> vec2f {
    let offset = 2.0 * f32(index) + 1.0 - f32(probes);
    return vec2f(centre.u + offset * step.x, centre.v + offset * step.y);
}

/// Face and coordinates of a direction that is not zero.
fn face_uv(d: vec3f) -> Address {
    let face = major_face(d);
    let axes = on_face(face, d);
    let ma = abs(axes.z);
    return Address(face, axes.x / ma, axes.y / ma);
}

/// The probe's address. Where it leaves the face (|u| or |v| > 1) the direction (1, u, v) of the plane chooses face
/// and coordinates anew.
fn address(centre: Address, step: vec2f, index: u32, probes: u32) -> Address {
    let place = probe_place(centre, step, index, probes);
    if abs(place.x) > 1.0 || abs(place.y) > 1.0 {
        return face_uv(direction(centre.face, place.x, place.y));
    }
    return Address(centre.face, place.x, place.y);
}
