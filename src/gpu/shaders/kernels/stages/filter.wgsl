// Registers: color 3; of every probe: face u32, place 2, bilinear 6.

fn stage() {
    let face = take_u32();
    let place = take2();
    var line: Footprint;
    line.step = take2();
    line.probes = take_u32();
    line.lod = take();
    let levels = levels_of(line.lod, policy.levels);
    let centre = Address(face, place.x, place.y);
    put3(filter_cube(centre, line, levels));
    for (var i = 0u; i < line.probes; i++) {
        let at = address(centre, line.step, i, line.probes);
        put_u32(at.face);
        put(at.u);
        put(at.v);
        put3(bilinear(levels.low, at));
        put3(bilinear(levels.high, at));
    }
}
