// Registers: cone 2.

fn stage() {
    let cone = take2();
    let kind = take_u32();
    put2(ray_cone(cone, ConeStep(kind, take3())));
}
