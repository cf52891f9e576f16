// Registers of `cube_face`: rotated, inv_ma, u, v, face, flags.

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
