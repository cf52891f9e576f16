// Arithmetic that every stage shares: sums in a fixed order, scales that are exact, flags.

/// The largest finite number.
const MOST: f32 = 3.4028234e38;

/// The flags of a fragment: bits of one word, in pipeline order.
const FLAG_NON_FINITE: u32 = 0x1u;
const FLAG_PARALLEL: u32 = 0x2u;
const FLAG_ZERO: u32 = 0x4u;
const FLAG_DERIVATIVES_SATURATED: u32 = 0x8u;
const FLAG_COVARIANCE_SATURATED: u32 = 0x10u;
const FLAG_LAMBDA_SATURATED: u32 = 0x20u;
const FLAG_LENGTH_SATURATED: u32 = 0x40u;
const FLAG_HIT_NOT_FINITE: u32 = 0x80u;
const FLAG_HIT_NO_DIRECTION: u32 = 0x100u;
const FLAG_HIT_NO_PLANE: u32 = 0x200u;
const FLAG_HIT_OVERSHOOT: u32 = 0x400u;
const FLAG_HIT_SATURATED: u32 = 0x800u;
const FLAG_SURF_NOT_FINITE: u32 = 0x1000u;
const FLAG_SURF_PARALLEL: u32 = 0x2000u;
const FLAG_SURF_DEGENERATE: u32 = 0x4000u;
const FLAG_SURF_SATURATED: u32 = 0x8000u;

/// ⟨a, b⟩, summed from the left.
fn dot3(a: vec3f, b: vec3f) -> f32 {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// a × b.
fn cross3(a: vec3f, b: vec3f) -> vec3f {
    return vec3f(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

/// The environment's rotation applied to a vector.
fn transform(a: vec3f) -> vec3f {
    if policy.rotated == 0u {
        return a;
    }
    return vec3f(
        dot3(policy.rotation_0.xyz, a),
        dot3(policy.rotation_1.xyz, a),
        dot3(policy.rotation_2.xyz, a),
    );
}

/// The rotation's transpose applied to a vector.
fn transform_back(a: vec3f) -> vec3f {
    if policy.rotated == 0u {
        return a;
    }
    return a.x * policy.rotation_0.xyz + a.y * policy.rotation_1.xyz + a.z * policy.rotation_2.xyz;
}

/// The largest magnitude of a component.
fn largest(a: vec3f) -> f32 {
    return max(max(abs(a.x), abs(a.y)), abs(a.z));
}

fn is_zero(a: vec3f) -> bool {
    return a.x == 0.0 && a.y == 0.0 && a.z == 0.0;
}

/// Whether a number is an infinity or no number: told by its bits, as arithmetic may take both for impossible.
fn beyond_range(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7f800000u) == 0x7f800000u;
}

/// The number itself, or the largest of its sign where it is beyond the range; raises `flag` there.
fn saturate_f32(x: f32, flag: u32, flags: ptr<function, u32>) -> f32 {
    if beyond_range(x) {
        *flags |= flag;
        return select(MOST, -MOST, (bitcast<u32>(x) >> 31u) == 1u);
    }
    return x;
}

fn saturate_vec3(x: vec3f, flag: u32, flags: ptr<function, u32>) -> vec3f {
    return vec3f(saturate_f32(x.x, flag, flags), saturate_f32(x.y, flag, flags), saturate_f32(x.z, flag, flags));
}

/// 2^−e of a positive number 2^e·m, 1 ≤ m < 2, as far as both are normal: a product with it is exact.
fn power_to_one(x: f32) -> f32 {
    let exponent = clamp((bitcast<u32>(x) >> 23u) & 0xffu, 1u, 253u);
    return bitcast<f32>((254u - exponent) << 23u);
}

/// |v|, whatever the size of its components.
fn length_of(v: vec3f) -> f32 {
    let most = largest(v);
    if most == 0.0 {
        return 0.0;
    }
    let scale = power_to_one(most);
    let scaled = v * scale;
    return sqrt(dot3(scaled, scaled)) * power_to_one(scale);
}

/// v/|v|; +z where v is zero.
fn unit(v: vec3f) -> vec3f {
    let most = largest(v);
    if most == 0.0 {
        return vec3f(0.0, 0.0, 1.0);
    }
    let scaled = v * power_to_one(most);
    return scaled / sqrt(dot3(scaled, scaled));
}

/// v/|v|; 0 where v is zero.
fn unit_or_zero(v: vec3f) -> vec3f {
    if is_zero(v) {
        return v;
    }
    return unit(v);
}

/// e_k × v, k the smallest |v_k| (ties z, y, x).
fn beside(v: vec3f) -> vec3f {
    let size = abs(v);
    if size.z <= size.x && size.z <= size.y {
        return vec3f(-v.y, v.x, 0.0);
    }
    if size.y <= size.x {
        return vec3f(v.z, 0.0, -v.x);
    }
    return vec3f(0.0, -v.z, v.y);
}
