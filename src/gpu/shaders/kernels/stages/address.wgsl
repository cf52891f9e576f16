// Registers: u, v, face u32, place 2, s 4.

fn stage() {
    let face = take_u32();
    let place = take2();
    let centre = Address(face, place.x, place.y);
    let step = take2();
    let index = take_u32();
    let probes = take_u32();
    let low = take_u32();
    let high = take_u32();
    put2(probe_place(centre, step, index, probes));
    let at = address(centre, step, index, probes);
    put_u32(at.face);
    put(at.u);
    put(at.v);
    put2(vec2f(texel_coordinate(at.u, low), texel_coordinate(at.v, low)));
    put2(vec2f(texel_coordinate(at.u, high), texel_coordinate(at.v, high)));
}
