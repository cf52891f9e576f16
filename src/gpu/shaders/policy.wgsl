// What every stage is told beside its operands: the unit's choices and the sizes of the maps.

/// Numbers of the choices; the order is that of `rtl_model/src/policy.rs`.
const DNMOD_PAPER: u32 = 0u;
const DNMOD_NORMAL: u32 = 1u;
const DNMOD_FRAME: u32 = 2u;
const MINOR_PAPER: u32 = 0u;
const MINOR_DET: u32 = 1u;
const AXIS_TABLE: u32 = 0u;
const AXIS_EXACT: u32 = 1u;
const AXIS_LONGER: u32 = 2u;
const COUNT_CEIL: u32 = 0u;
const COUNT_ROUND: u32 = 1u;
const COUNT_POW2: u32 = 2u;
const COUNT_FELINE: u32 = 3u;
const METHOD_FALSE_POSITION: u32 = 0u;
const METHOD_SECANT: u32 = 1u;
const METHOD_ILLINOIS: u32 = 2u;
const LOOK_UP_NEAREST: u32 = 0u;
const LOOK_UP_BILINEAR: u32 = 1u;
const FOOTPRINT_DISC: u32 = 0u;
const FOOTPRINT_PLANE: u32 = 1u;
const OUTSIDE_STOP: u32 = 0u;
const OUTSIDE_HLSL: u32 = 1u;
const DISTANCE_CUBE: u32 = 0u;
const DISTANCE_BOX: u32 = 1u;
const DISTANCE_SPHERE: u32 = 2u;
const RULES_NOTE: u32 = 0u;
const RULES_OTK: u32 = 1u;
const DIFFUSE_ANGLE: u32 = 0u;
const DIFFUSE_EXCHANGED: u32 = 1u;
const GRADIENT_OTK: u32 = 0u;
const GRADIENT_GRAM: u32 = 1u;
const CONE_ENV_OTK: u32 = 0u;
const CONE_ENV_EXACT: u32 = 1u;
const WRAP_REPEAT: u32 = 0u;
const WRAP_CLAMP: u32 = 1u;
const WRAP_MIRROR: u32 = 2u;
const LENS_PINHOLE: u32 = 0u;
const LENS_THIN: u32 = 1u;
const LENS_ORTHOGRAPHIC: u32 = 2u;

struct Policy {
    /// Rows of the environment's rotation; used where `rotated` is not 0.
    rotation_0: vec4f,
    rotation_1: vec4f,
    rotation_2: vec4f,
    /// Half edges of a box of distances; x is a sphere's radius.
    half_edges: vec4f,
    /// The camera: half the view rectangle to the right and up, from the eye to its middle (w: the lens's width).
    camera_u: vec4f,
    camera_v: vec4f,
    camera_w: vec4f,
    /// Fragments of this dispatch, words of one's input and of one's output.
    fragments: u32,
    input_words: u32,
    output_words: u32,
    rotated: u32,
    /// Whether fragments have a bump, and a roughness.
    bump: u32,
    rough: u32,
    roughness_scale: f32,
    dnmod: u32,
    minor: u32,
    axis: u32,
    count: u32,
    max_probes: u32,
    /// Texels along a face's edge (columns and rows of a 2-D texture) and levels of the chain.
    size_x: u32,
    size_y: u32,
    levels: u32,
    /// Whether probes have weights of their own, and where they start in `tables`.
    weighted: u32,
    weights: u32,
    /// The angle table, where the axis is to come from it: where it starts in `tables`, its bins, its order.
    angled: u32,
    angles: u32,
    boundaries: u32,
    angle_order: u32,
    tan_step: f32,
    iterations: u32,
    hit_method: u32,
    tau: f32,
    look_up: u32,
    hit_footprint: u32,
    outside: u32,
    distance_kind: u32,
    distance_size: u32,
    cone_env: u32,
    cone_rules: u32,
    set_diffuse: u32,
    max_anisotropy: u32,
    gradient: u32,
    wrap_x: u32,
    wrap_y: u32,
    /// Cones of a ray (1 or 2), whether only distances change them, and the camera's lens and picture.
    cones: u32,
    by_distance: u32,
    lens: u32,
    columns: u32,
    rows: u32,
    /// Fills the struct to a multiple of 16 bytes.
    unused_0: u32,
    unused_1: u32,
}
