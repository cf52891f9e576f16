// Registers of `ray_cone`: the cone after one step.

fn stage() {
    let cone = take2();
    let kind = take_u32();
    put2(ray_cone(cone, ConeStep(kind, take3())));
}
