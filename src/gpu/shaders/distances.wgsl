// Distances of the environment from the reference point. A negative one stands for infinity, which no shader may hold.

const INFINITE: f32 = -1.0;

/// A texel of the distance map, or across an edge of its face; beyond a corner the mean of the three that meet there.
fn distance_tap(face: u32, x: i32, y: i32) -> f32 {
    let size = i32(policy.distance_size);
    let inner = clamp(vec2i(x, y), vec2i(0), vec2i(size - 1));
    let own = textureLoad(distances, inner, face, 0u).r;
    let outside = vec2<bool>(x != inner.x, y != inner.y);
    if !(outside.x || outside.y) {
        return own;
    }
    if outside.x && outside.y {
        let one = across_edge(size, face, x, inner.y);
        let two = across_edge(size, face, inner.x, y);
        let first = textureLoad(distances, one.yz, one.x, 0u).r;
        let second = textureLoad(distances, two.yz, two.x, 0u).r;
        if own < 0.0 || first < 0.0 || second < 0.0 {
            return INFINITE;
        }
        return (own + first + second) / 3.0;
    }
    let other = across_edge(size, face, x, y);
    return textureLoad(distances, other.yz, other.x, 0u).r;
}

/// A place on the distance map: the texel to the upper left and the weights of its neighbours.
struct DistancePlace {
    face: u32,
    corner: vec2i,
    weight: vec2f,
}

fn distance_place(q: vec3f, look_up: u32) -> DistancePlace {
    let at = face_uv(q);
    let size = f32(policy.distance_size);
    var s = vec2f(
        texel_coordinate(at.u, policy.distance_size),
        texel_coordinate(at.v, policy.distance_size),
    );
    var low = -1.0;
    if look_up == HIT_LOOKUP_NEAREST {
        s = s + 0.5;
        low = 0.0;
    }
    let whole = clamp(floor(s), vec2f(low), vec2f(size - 1.0));
    return DistancePlace(at.face, vec2i(whole), s - whole);
}

/// A share of a sum that is infinite as soon as one of its parts with any weight is.
fn add_share(sum: f32, value: f32, weight: f32) -> f32 {
    if !(weight > 0.0) {
        return sum;
    }
    if sum < 0.0 || value < 0.0 {
        return INFINITE;
    }
    return sum + value * weight;
}

/// Half an edge over a component's magnitude; infinite for 0.
fn wall_distance(half_edge: f32, component: f32) -> f32 {
    if component == 0.0 {
        return MOST;
    }
    return half_edge / abs(component);
}

/// dist(q) in a unit direction that is already turned by the environment's rotation.
fn read_distance(direction_in: vec3f) -> f32 {
    let q = unit(direction_in);
    if policy.distance_kind == DISTANCE_SPHERE {
        return policy.half_edges.x;
    }
    if policy.distance_kind == DISTANCE_BOX {
        let x = wall_distance(policy.half_edges.x, q.x);
        let y = wall_distance(policy.half_edges.y, q.y);
        let z = wall_distance(policy.half_edges.z, q.z);
        return min(min(x, y), z);
    }
    let at = distance_place(q, policy.hit_lookup);
    if policy.hit_lookup == HIT_LOOKUP_NEAREST {
        return distance_tap(at.face, at.corner.x, at.corner.y);
    }
    let s = at.weight.x;
    let t = at.weight.y;
    var sum = 0.0;
    sum = add_share(sum, distance_tap(at.face, at.corner.x, at.corner.y), (1.0 - s) * (1.0 - t));
    sum = add_share(sum, distance_tap(at.face, at.corner.x + 1, at.corner.y), s * (1.0 - t));
    sum = add_share(sum, distance_tap(at.face, at.corner.x, at.corner.y + 1), (1.0 - s) * t);
    sum = add_share(sum, distance_tap(at.face, at.corner.x + 1, at.corner.y + 1), s * t);
    return sum;
}

/// The point of a texel of the distance map: its centre's direction times its distance; w is 0 where that is infinite.
fn distance_point(face: u32, x: i32, y: i32) -> vec4f {
    let distance = textureLoad(distances, vec2i(x, y), face, 0u).r;
    if distance < 0.0 {
        return vec4f(0.0);
    }
    let n = f32(policy.distance_size);
    let way = unit(direction(face, f32(2 * x + 1) / n - 1.0, f32(2 * y + 1) / n - 1.0));
    return vec4f(way * distance, 1.0);
}

/// A normal of the surface in direction q, of any length: exact for a box and a sphere; for a cube the cross product of
/// the diagonals of the four texels about q, inside of its face. Zero where there is none.
fn distance_normal(direction_in: vec3f) -> vec3f {
    let q = unit(direction_in);
    if policy.distance_kind == DISTANCE_BOX {
        let x = wall_distance(policy.half_edges.x, q.x);
        let y = wall_distance(policy.half_edges.y, q.y);
        let z = wall_distance(policy.half_edges.z, q.z);
        if x <= y && x <= z {
            return vec3f(sign(q.x), 0.0, 0.0);
        }
        if y <= z {
            return vec3f(0.0, sign(q.y), 0.0);
        }
        return vec3f(0.0, 0.0, sign(q.z));
    }
    if policy.distance_kind == DISTANCE_SPHERE || policy.distance_size < 2u {
        return q;
    }
    let at = distance_place(q, HIT_LOOKUP_BILINEAR);
    let corner = clamp(at.corner, vec2i(0), vec2i(i32(policy.distance_size) - 2));
    let a = distance_point(at.face, corner.x, corner.y);
    let b = distance_point(at.face, corner.x + 1, corner.y);
    let c = distance_point(at.face, corner.x, corner.y + 1);
    let d = distance_point(at.face, corner.x + 1, corner.y + 1);
    if min(min(a.w, b.w), min(c.w, d.w)) == 0.0 {
        return vec3f(0.0);
    }
    let first = d.xyz - a.xyz;
    let second = c.xyz - b.xyz;
    if is_zero(first) || is_zero(second) {
        return vec3f(0.0);
    }
    return cross3(unit(first), unit(second));
}
