// Registers: n_mod 3.

fn stage() {
    var frame: Frame;
    let n = take3();
    frame.e1 = take3();
    frame.e2 = take3();
    put3(bump(n, frame, take2()));
}
