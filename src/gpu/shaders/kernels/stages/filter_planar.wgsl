// Registers: color 3; of every probe: place 2, bilinear 6.

fn stage() {
    let centre = take2();
    var line: Footprint;
    line.step = take2();
    line.probes = take_u32();
    line.lod = take();
    let levels = levels_of(line.lod, policy.levels);
    put3(filter_planar(centre, line, levels));
    for (var i = 0u; i < line.probes; i++) {
        let at = planar_address(centre, line.step, i, line.probes);
        put2(at);
        put3(planar_bilinear(levels.low, at));
        put3(planar_bilinear(levels.high, at));
    }
}
