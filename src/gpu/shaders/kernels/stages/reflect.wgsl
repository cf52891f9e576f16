// Registers: n_dot_v, n_dot_n, v_r 3.

fn stage() {
    let v = take3();
    let n = take3();
    let reflection = reflect(v, n);
    put(reflection.n_dot_v);
    put(reflection.n_dot_n);
    put3(reflection.v_r);
}
