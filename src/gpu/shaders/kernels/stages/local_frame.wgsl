// Registers: h 3, cross 3, inv_length, e1 3, e2 3, flags u32.

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
