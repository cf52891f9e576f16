// Stage `hit`: where a ray meets the surface of a distance map, and the footprint there.

/// A ray on its way: the state of the loop, and the registers of its last turn.
struct Search {
    x: vec3f,
    /// The unit direction.
    r: vec3f,
    /// Where it is: the ray parameter along `r`, and the point (the unit direction where the ray escaped).
    d: f32,
    l: vec3f,
    /// Look-ups in the loop.
    iterations: u32,
    status: u32,
    /// Whether the search has ended.
    done: bool,
    /// dist(R), and (d, ratio) of the last undershoot and of the last overshoot, if there was one.
    far: f32,
    under: vec2f,
    over: vec2f,
    overshot: bool,
    /// Which side the last result was on: −1, 0 (none), 1.
    side: i32,
    /// dist(l), |l|, |l|/dist(l) and the step of the last turn; dist(x), |x|, the ratio there and 0 before the first.
    radius: f32,
    length: f32,
    ratio: f32,
    step: f32,
}

/// f = |l|/dist(l): 0 where the distance is infinite, the largest number where it is 0.
fn ratio_of(length: f32, distance: f32) -> f32 {
    if distance == 0.0 {
        return MOST;
    }
    if distance < 0.0 {
        return 0.0;
    }
    var beyond = 0u;
    return saturate_f32(length / distance, 0u, &beyond);
}

/// −1 for an undershoot, 1 for an overshoot, 0 within the tolerance.
fn side_of(f: f32) -> i32 {
    return select(0, 1, f > 1.0 + policy.tau) - select(0, 1, f < 1.0 - policy.tau);
}

/// The search before its first look-up in the loop.
fn hit_begin(x: vec3f, direction: vec3f, flags: ptr<function, u32>) -> Search {
    var ray: Search;
    ray.x = x;
    if is_zero(direction) {
        *flags |= FLAG_HIT_NO_DIRECTION;
    }
    ray.r = unit(direction);
    ray.l = x;
    ray.status = STATUS_MAX_ITERATIONS;
    ray.far = read_distance(transform(ray.r));
    ray.length = length_of(x);
    if ray.length != 0.0 {
        ray.radius = read_distance(transform(x));
        ray.ratio = ratio_of(ray.length, ray.radius);
    }
    let p_un = ray.ratio;
    let begins = side_of(p_un);
    if begins == 0 || (begins > 0 && policy.hit_outside == HIT_OUTSIDE_STOP) {
        ray.status = select(STATUS_OUTSIDE, STATUS_AT_SURFACE, begins == 0);
        ray.done = true;
        return ray;
    }
    if ray.far < 0.0 {
        ray.status = STATUS_ESCAPED;
        ray.l = ray.r;
        ray.done = true;
        return ray;
    }
    ray.under = vec2f(0.0, p_un);
    return hit_move(ray, ray.far * (1.0 - p_un), flags);
}

/// The ray at parameter d.
fn hit_move(before: Search, d: f32, flags: ptr<function, u32>) -> Search {
    var ray = before;
    let l = ray.x + ray.r * d;
    ray.d = saturate_f32(d, FLAG_HIT_SATURATED, flags);
    ray.l = saturate_vec3(l, FLAG_HIT_SATURATED, flags);
    return ray;
}

/// One turn of the loop: a look-up and, unless it converged or stalled, the move.
fn hit_step(before: Search, flags: ptr<function, u32>) -> Search {
    var ray = before;
    ray.length = length_of(ray.l);
    ray.radius = read_distance(transform(ray.l));
    let f = ratio_of(ray.length, ray.radius);
    ray.ratio = f;
    ray.iterations = ray.iterations + 1u;
    let side = side_of(f);
    if side == 0 {
        ray.status = STATUS_CONVERGED;
        ray.done = true;
        return ray;
    }
    if side > 0 {
        *flags |= FLAG_HIT_OVERSHOOT;
    }
    var stalled = false;
    ray = next_step(ray, f, side, &stalled);
    let next = ray.d + ray.step;
    if stalled || next == ray.d {
        ray.status = STATUS_STALLED;
        ray.done = true;
        return ray;
    }
    return hit_move(ray, next, flags);
}

/// The step after ratio `f` on `side`, by the method of the unit; `stalled` where there is none.
fn next_step(before: Search, f: f32, side: i32, stalled: ptr<function, bool>) -> Search {
    var ray = before;
    let again = ray.side == side;
    ray.side = side;
    let previous = ray.under;
    let halves = policy.hit_method == HIT_METHOD_ILLINOIS && again;
    var other: vec2f;
    if side > 0 {
        ray.over = vec2f(ray.d, f);
        ray.overshot = true;
        if halves {
            ray.under.y = 0.5 + ray.under.y / 2.0;
        }
        other = ray.under;
    } else {
        ray.under = vec2f(ray.d, f);
        if ray.overshot && halves {
            ray.over.y = 0.5 + ray.over.y / 2.0;
        }
        other = ray.over;
    }
    if ray.overshot {
        let low = min(ray.under.x, ray.over.x);
        let high = max(ray.under.x, ray.over.x);
        // A bracket of at most one unit of the last place.
        if next_up(low) >= high {
            ray.step = 0.0;
            return ray;
        }
        ray.step = between(ray.d, f, other, stalled);
        return ray;
    }
    if policy.hit_method == HIT_METHOD_SECANT && f > previous.y {
        ray.step = min(between(ray.d, f, previous, stalled), 4.0 * ray.far);
        return ray;
    }
    // Eq. 2: towards the far point.
    ray.step = ray.far * (1.0 - f);
    return ray;
}

/// Eq. 3: (d − d0)(1 − f)/(f − p); stalled where the denominator is 0.
fn between(d: f32, f: f32, other: vec2f, stalled: ptr<function, bool>) -> f32 {
    let span = f - other.y;
    if span == 0.0 {
        *stalled = true;
        return 0.0;
    }
    return (d - other.x) * ((1.0 - f) / span);
}

/// The next larger number.
fn next_up(x: f32) -> f32 {
    if x == 0.0 {
        return 1.1754944e-38;
    }
    let bits = bitcast<u32>(x);
    return bitcast<f32>(select(bits + 1u, bits - 1u, x < 0.0));
}

/// The search of Szirmay-Kalos et al. 2005 (eq. 1–3 corrected).
fn hit(x: vec3f, direction: vec3f, flags: ptr<function, u32>) -> Search {
    var ray = hit_begin(x, direction, flags);
    for (var k = 0u; k < policy.hit_iterations; k++) {
        if ray.done {
            break;
        }
        ray = hit_step(ray, flags);
    }
    return ray;
}

/// The tangents of the footprint: t1 = unit(e_k × R), t2 = R × t1, moved onto the wall's plane if that is asked.
fn hit_tangents(ray: Search, flags: ptr<function, u32>) -> array<vec3f, 2> {
    let r = ray.r;
    let t1 = unit(beside(r));
    var t = array<vec3f, 2>(t1, cross3(r, t1));
    if policy.hit_footprint != HIT_FOOTPRINT_PLANE || ray.status == STATUS_ESCAPED {
        return t;
    }
    let found = distance_normal(transform(unit(ray.l)));
    if is_zero(found) {
        *flags |= FLAG_HIT_NO_PLANE;
        return t;
    }
    let n = unit(transform_back(found));
    let along = dot3(n, r);
    let least = 1.0 / f32(policy.footprint_max_probes);
    let cosine = select(max(along, least), min(along, -least), along < 0.0);
    for (var i = 0; i < 2; i++) {
        let slope = dot3(n, t[i]) / cosine;
        t[i] = t[i] - r * slope;
    }
    return t;
}

/// |w| of the cone at the hit; where the ray escaped, |w|/|l| tends to |α|.
fn hit_width(ray: Search, cone: vec2f) -> f32 {
    if ray.status == STATUS_ESCAPED {
        return abs(cone.x);
    }
    return min(abs(cone.y + cone.x * ray.d), MOST);
}

/// D = G(l)·|w|·[t1 t2], row by row; for a bare cone under `cone.env = otk` OptiX Toolkit's constant.
fn hit_footprint(facing: Facing, t: array<vec3f, 2>, width: f32, escaped: bool) -> vec4f {
    if escaped && policy.cone_env == CONE_ENV_OTK {
        // 2α/π per [0, 1] of a face.
        let constant = 1.2732395 * width;
        return vec4f(constant, 0.0, 0.0, constant);
    }
    let first = numerator(facing, transform(t[0]));
    let second = numerator(facing, transform(t[1]));
    return vec4f(
        first.x * facing.inv_ma * width,
        second.x * facing.inv_ma * width,
        first.y * facing.inv_ma * width,
        second.y * facing.inv_ma * width,
    );
}
