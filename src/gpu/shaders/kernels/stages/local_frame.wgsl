// Registers of `local_frame`: h, cross, inv_length, e1, e2, flags.

fn stage() {
    var flags = 0u;
    let n = take3();
    let h = take3();
    let frame = local_frame(n, h, &flags);
    put3(frame.h);
    put3(frame.crossed);
    put(frame.inv_length);
    put3(frame.e1);
    put3(frame.e2);
    put_u32(flags);
}
