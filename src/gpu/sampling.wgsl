// One look-up an invocation, by the device's own sampler.
//
// IMAGE and COORD are replaced: texture_2d<f32> and xy, or texture_cube<f32> and xyz.

struct Query {
    at: vec4<f32>,  // coordinates or direction; w: level of detail
    dx: vec4<f32>,  // derivative per pixel to the right
    dy: vec4<f32>,  // derivative per pixel downwards
}

@group(0) @binding(0) var<storage, read> queries: array<Query>;
@group(0) @binding(1) var<storage, read_write> colors: array<vec4<f32>>;
@group(0) @binding(2) var image: IMAGE;
@group(0) @binding(3) var filtering: sampler;

@compute @workgroup_size(64)
fn level(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < arrayLength(&queries) {
        let q = queries[id.x];
        colors[id.x] = textureSampleLevel(image, filtering, q.at.COORD, q.at.w);
    }
}

@compute @workgroup_size(64)
fn gradient(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < arrayLength(&queries) {
        let q = queries[id.x];
        colors[id.x] = textureSampleGrad(image, filtering, q.at.COORD, q.dx.COORD, q.dy.COORD);
    }
}

struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) at: vec3<f32>,
    @location(1) @interpolate(flat) dx: vec3<f32>,
    @location(2) @interpolate(flat) dy: vec3<f32>,
}

// Each query is an instance: two triangles over its 2 x 2 pixels, 64 quads a row.
@vertex
fn corner(@builtin(vertex_index) index: u32, @builtin(instance_index) instance: u32) -> Corner {
    let q = queries[instance];
    let rows = (arrayLength(&queries) + 63u) / 64u;
    let right = select(0u, 1u, index == 1u || index == 3u || index == 4u);
    let below = select(0u, 1u, index == 2u || index == 4u || index == 5u);
    let x = f32(instance % 64u + right) / 64.0;
    let y = f32(instance / 64u + below) / f32(rows);
    return Corner(vec4<f32>(2.0 * x - 1.0, 1.0 - 2.0 * y, 0.0, 1.0), q.at.xyz, q.dx.xyz, q.dy.xyz);
}

// The upper left pixel of a quad is at the query's place.
@fragment
fn quad(in: Corner) -> @location(0) vec4<f32> {
    let step = vec2<f32>(vec2<u32>(in.position.xy) & vec2<u32>(1u));
    return textureSample(image, filtering, (in.at + in.dx * step.x + in.dy * step.y).COORD);
}
