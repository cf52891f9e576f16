// Registers: root, lambda_sq 2, lambda 2, axis 2.

fn stage() {
    let k = take3();
    let d = take4();
    let axes = eigen(k, d, take4());
    put(axes.root);
    put2(axes.lambda_sq);
    put2(axes.lambda);
    put2(axes.axis);
}
