// Registers: d_unit 3, n_unit 3, cosine, across 3, along 3, dp_dx 3, dp_dy 3, grad_s 3, grad_t 3, ddx 2, ddy 2, d 4,
// flags u32.

fn stage() {
    var flags = 0u;
    let width = take();
    let out = surface_footprint(take_fragment(), width, &flags);
    put3(out.d_unit);
    put3(out.n_unit);
    put(out.cosine);
    put3(out.across);
    put3(out.along);
    put3(out.dp[0]);
    put3(out.dp[1]);
    put3(out.grad[0]);
    put3(out.grad[1]);
    put2(out.dd[0]);
    put2(out.dd[1]);
    put4(out.d);
    put_u32(flags);
}
