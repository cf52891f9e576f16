// Registers: k 3.

fn stage() {
    let d = take4();
    put3(covariance(d, take4()));
}
