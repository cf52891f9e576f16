// Registers: rotated 3, inv_ma, u, v, face u32, flags u32.

fn stage() {
    var flags = 0u;
    let facing = cube_face(take3(), &flags);
    put3(facing.rotated);
    put(facing.inv_ma);
    put(facing.u);
    put(facing.v);
    put_u32(facing.face);
    put_u32(flags);
}
