// The bindings of the kernels: words of the operands in, words of the results out, maps and tables.

@group(0) @binding(0) var<uniform> policy: Policy;
@group(0) @binding(1) var<storage, read> input: array<u32>;
@group(0) @binding(2) var<storage, read_write> output: array<u32>;
@group(0) @binding(3) var texels: texture_2d_array<f32>;
@group(0) @binding(4) var distances: texture_2d_array<f32>;
@group(0) @binding(5) var<storage, read> tables: array<f32>;
@group(0) @binding(6) var<storage, read> steps: array<f32>;

/// A flag in addition to those of the float reference: a value left the range of f32 on the way.
const FLAG_OVERFLOW: u32 = 0x10000u;

var<private> source: u32;
var<private> sink: u32;

/// Starts an invocation; false where there is no fragment for it.
fn begin(index: u32) -> bool {
    source = index * policy.input_words;
    sink = index * policy.output_words;
    return index < policy.fragments;
}

fn take_u32() -> u32 {
    source = source + 1u;
    return input[source - 1u];
}

fn take() -> f32 {
    return bitcast<f32>(take_u32());
}

fn take2() -> vec2f {
    let x = take();
    return vec2f(x, take());
}

fn take3() -> vec3f {
    let xy = take2();
    return vec3f(xy, take());
}

fn take4() -> vec4f {
    let xy = take2();
    return vec4f(xy, take2());
}

fn put_u32(value: u32) {
    output[sink] = value;
    sink = sink + 1u;
}

fn put(value: f32) {
    put_u32(bitcast<u32>(value));
}

fn put2(value: vec2f) {
    put(value.x);
    put(value.y);
}

fn put3(value: vec3f) {
    put2(value.xy);
    put(value.z);
}

fn put4(value: vec4f) {
    put2(value.xy);
    put2(value.zw);
}
