// Stage `local_frame`: the tangent vectors e1 and e2.

/// The local frame and what its derivatives need.
struct Frame {
    /// The main direction that was used: h, or a unit axis where h ∥ n.
    h: vec3f,
    /// h × n.
    crossed: vec3f,
    /// Unit vector along h × n (zero where n = 0).
    direction: vec3f,
    /// 1/|h × n| (0 where n = 0).
    inv_length: f32,
    /// |n|.
    n_length: f32,
    /// e1, as long as n.
    e1: vec3f,
    /// e2, as long as n.
    e2: vec3f,
}

/// e1 = (h × n)/|h × n|·|n|, e2 = (n × e1)/|n| (Schilling, appendix A; both are as long as n).
///
/// Where h × n is zero, h is replaced by the axis e_k with the smallest |n_k| (on equal magnitudes z wins over y
/// over x) and the flag is raised; n = 0 gives e1 = e2 = 0.
fn local_frame(n: vec3f, h: vec3f, flags: ptr<function, u32>) -> Frame {
    var used = h;
    var c = cross3(h, n);
    if is_zero(c) {
        *flags |= FLAG_PARALLEL;
        let size = abs(n);
        if size.z <= size.x && size.z <= size.y {
            used = vec3f(0.0, 0.0, 1.0);
        } else if size.y <= size.x {
            used = vec3f(0.0, 1.0, 0.0);
        } else {
            used = vec3f(1.0, 0.0, 0.0);
        }
        c = cross3(used, n);
    }
    let length = sqrt(dot3(c, c));
    var inv_length = 0.0;
    if length != 0.0 {
        inv_length = 1.0 / length;
    }
    let n_length = sqrt(dot3(n, n));
    let direction = inv_length * c;
    let e1 = n_length * direction;
    let e2 = cross3(n, direction);
    return Frame(used, c, direction, inv_length, n_length, e1, e2);
}
