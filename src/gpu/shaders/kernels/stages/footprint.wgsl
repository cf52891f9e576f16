// Registers: length, width, probes u32, lod, step 2, flags u32.

fn stage() {
    var flags = 0u;
    let lambda = take2();
    let axis = take2();
    let size = take_u32();
    let line = footprint(lambda, axis, Chain(size, policy.levels), &flags);
    put(line.length);
    put(line.width);
    put_u32(line.probes);
    put(line.lod);
    put2(line.step);
    put_u32(flags);
}
