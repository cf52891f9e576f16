// Registers of `covariance`: k.

fn stage() {
    let d = take4();
    put3(covariance(d, take4()));
}
