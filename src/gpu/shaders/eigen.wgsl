// Stage `eigen`: the axes of the ellipse.

/// The axes of the footprint.
struct Axes {
    /// λ1, λ2 (under `longer-derivative` λ2 can be the larger).
    lambda: vec2f,
    /// Direction of λ1: unit, first component > 0, or (0, 1).
    axis: vec2f,
    lambda_sq: vec2f,
    root: f32,
}

/// λ² = ½(a + c ± √((c − a)² + 4b²)) (Schilling, eq. 16 and 17) and the direction of the major axis.
///
/// K is shifted by a power of two before it is squared, as the unit's shared exponent does, and the results are
/// shifted back: exact, and no square leaves the range. `EIGEN_MINOR_DET` takes λ2² = det K/λ1² instead of eq. 17. K
/// isotropic gives (1, 0). `FOOTPRINT_AXIS_LONGER_DERIVATIVE` takes the longest of the columns of [D, s·B'] (the first
/// of equal ones) for λ1 and its direction, and the sum of the squares of the others for λ2².
fn eigen(k: vec3f, d: vec4f, rough: vec4f) -> Axes {
    let scale = power_to_one(max(max(abs(k.x), abs(k.y)), abs(k.z)));
    let a = k.x * scale;
    let b = k.y * scale;
    let c = k.z * scale;
    let two_b = b + b;
    let difference = c - a;
    let root = sqrt(difference * difference + two_b * two_b);
    var out: Axes;
    let back = power_to_one(scale);
    out.root = root * back;
    if policy.footprint_axis == FOOTPRINT_AXIS_LONGER_DERIVATIVE {
        return longer_derivative(d, rough, out);
    }
    let major = 0.5 * (a + c + root);
    var minor = 0.0;
    if policy.eigen_minor == EIGEN_MINOR_PAPER {
        minor = 0.5 * (a + c - root);
    } else if major != 0.0 {
        minor = (a * c - b * b) / major;
    }
    minor = max(minor, 0.0);
    if policy.angled != 0u {
        out.axis = table_axis(difference, two_b, root);
    } else {
        out.axis = exact_axis(difference, two_b, root);
    }
    out.lambda_sq = vec2f(major * back, minor * back);
    out.lambda = sqrt(out.lambda_sq);
    return out;
}

/// The eigenvector of the larger eigenvalue, from the one of its two forms that cancels nothing.
fn exact_axis(difference: f32, two_b: f32, root: f32) -> vec2f {
    if root == 0.0 {
        return vec2f(1.0, 0.0);
    }
    // (long, short) is the eigenvector with its larger component first; |short| ≤ long.
    let slope = two_b / (root + abs(difference));
    let long = 1.0 / sqrt(1.0 + slope * slope);
    let short = slope * long;
    if difference < 0.0 {
        return vec2f(long, short);
    }
    return with_first_positive(short, long);
}

/// (short, long) turned so that its first component is positive, or (0, 1).
fn with_first_positive(short: f32, long: f32) -> vec2f {
    if short > 0.0 {
        return vec2f(short, long);
    }
    if short < 0.0 {
        return vec2f(-short, -long);
    }
    return vec2f(0.0, 1.0);
}

/// The axis from the table: r1 = (cos α, −sin α) where c − a < 0, r2 = (sin α, cos α) elsewhere, with the sign of α
/// that of 2b/(c − a) (Schilling, eq. 18 to 20, roles corrected).
fn table_axis(difference: f32, two_b: f32, root: f32) -> vec2f {
    if root == 0.0 {
        return vec2f(1.0, 0.0);
    }
    let doubled = vec2f(abs(difference) / root, abs(two_b) / root);
    let entry = look_up_angle(doubled);
    let negative = ((two_b < 0.0) != (difference < 0.0)) && two_b != 0.0;
    let sin = select(entry.y, -entry.y, negative);
    if difference < 0.0 {
        return vec2f(entry.x, 0.0 - sin);
    }
    return with_first_positive(sin, entry.x);
}

/// Cosine and sine that stand at a place of the angle table.
fn angle_entry(place: u32) -> vec2f {
    let at = policy.angles + 2u * place;
    return vec2f(tables[at], tables[at + 1u]);
}

/// Cosine and sine of |α| from those of |2α|: the nearest entry (order 0), or its two neighbours mixed by
/// tan(2α − 2θ)/tan(step) (order 1). The table holds the bins' boundaries, then their entries and the one after the
/// last, then those of twice the angle.
fn look_up_angle(doubled: vec2f) -> vec2f {
    var bin = 0u;
    while bin < policy.boundaries {
        let boundary = angle_entry(bin);
        if doubled.y * boundary.x <= doubled.x * boundary.y {
            break;
        }
        bin = bin + 1u;
    }
    let low = angle_entry(policy.boundaries + bin);
    if policy.angle_order == 0u {
        return low;
    }
    let theta = angle_entry(2u * policy.boundaries + 2u + bin);
    let up = doubled.y * theta.x - doubled.x * theta.y;
    let down = doubled.x * theta.x + doubled.y * theta.y;
    let fraction = clamp(up / down / policy.tan_step, 0.0, 1.0);
    let high = angle_entry(policy.boundaries + bin + 1u);
    return low + (high - low) * fraction;
}

/// λ1², λ2² and the axis from the longest column; columns are those of D, then those of s·B'.
fn longer_derivative(d: vec4f, rough: vec4f, start: Axes) -> Axes {
    let columns = array<vec2f, 4>(d.xz, d.yw, rough.xz, rough.yw);
    var squares: vec4f;
    for (var i = 0; i < 4; i++) {
        squares[i] = columns[i].x * columns[i].x + columns[i].y * columns[i].y;
    }
    var longest = 0;
    for (var i = 1; i < 4; i++) {
        if squares[i] > squares[longest] {
            longest = i;
        }
    }
    var rest = 0.0;
    for (var i = 0; i < 4; i++) {
        if i != longest {
            rest = rest + squares[i];
        }
    }
    let column = columns[longest];
    let length = sqrt(squares[longest]);
    var out = start;
    if length == 0.0 {
        out.axis = vec2f(1.0, 0.0);
    } else if column.x == 0.0 {
        out.axis = vec2f(0.0, 1.0);
    } else {
        let turned = column / length;
        out.axis = select(turned, -turned, turned.x < 0.0);
    }
    out.lambda_sq = vec2f(squares[longest], rest);
    out.lambda = sqrt(out.lambda_sq);
    return out;
}
