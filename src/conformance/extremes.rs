//! The extremes of the specification (section 8) as inputs of the three operations, each with its name.

use crate::fragment::{Fragment, HitFragment};

/// A fragment that looks straight on: v = n = +z, nothing moves.
pub const PLAIN: Fragment = Fragment {
    v: [0.0, 0.0, 1.0],
    n: [0.0, 0.0, 1.0],
    dv_dx: [0.0; 3],
    dv_dy: [0.0; 3],
    dn_dx: [0.0; 3],
    dn_dy: [0.0; 3],
    h: None,
    bump: None,
    rough: None,
};

/// D = [[p, q], [r, s]] seen straight on, where D = (2∂n_x, −2∂n_y).
#[must_use]
pub fn straight([[p, q], [r, s]]: [[f64; 2]; 2]) -> Fragment {
    Fragment { dn_dx: [p / 2.0, -r / 2.0, 0.0], dn_dy: [q / 2.0, -s / 2.0, 0.0], ..PLAIN }
}

/// The next double away from zero.
fn up(x: f64) -> f64 {
    f64::from_bits(x.to_bits() + 1)
}

/// The next double towards zero.
fn down(x: f64) -> f64 {
    f64::from_bits(x.to_bits().saturating_sub(1))
}

/// With tangent vectors, bump and roughness.
fn rough(bump: [f64; 2], rough: [f64; 3]) -> Fragment {
    Fragment {
        h: Some([1.0, 0.25, 0.125]),
        bump: Some(bump),
        rough: Some(rough),
        dn_dx: [0.01, 0.0, 0.0],
        dn_dy: [0.0, 0.01, 0.0],
        ..PLAIN
    }
}

/// v with a reflection along (x, y, z): n = +z, v = (−x, −y, z).
fn along([x, y, z]: [f64; 3]) -> Fragment {
    Fragment { v: [-x, -y, z], dn_dx: [0.01, 0.0, 0.0], dn_dy: [0.0, 0.01, 0.0], ..PLAIN }
}

/// Rows of ENV.
#[must_use]
pub fn env() -> Vec<(&'static str, Fragment)> {
    let scaled = |power: i32| {
        let s = libm::ldexp(1.0, power);
        Fragment {
            n: [0.0, 0.0, s],
            dn_dx: [0.1 * s, 0.0, 0.0],
            dn_dy: [0.0, 0.2 * s, 0.0],
            ..PLAIN
        }
    };
    let wide = |length: f64| straight([[length, 0.0], [0.0, 1.0 / 128.0]]);
    let turned = |angle: f64| {
        let (sin, cos) = (libm::sin(angle), libm::cos(angle));
        let (l, m) = (0.5, 0.125);
        straight([[l * cos, -m * sin], [l * sin, m * cos]])
    };
    // Half of the step of 32 entries over 90°.
    let boundary = std::f64::consts::FRAC_PI_2 / 64.0;
    vec![
        ("K = 0", PLAIN),
        ("K isotropic", straight([[0.5, 0.0], [0.0, 0.5]])),
        ("K isotropic, turned", straight([[0.25, -0.25], [0.25, 0.25]])),
        ("a = c, b > 0", straight([[0.5, 0.25], [0.25, 0.5]])),
        ("a = c, b < 0", straight([[0.5, -0.25], [-0.25, 0.5]])),
        ("K of rank 1", straight([[0.375, 0.0], [0.5, 0.0]])),
        ("λ ratio 10⁶", straight([[1.0, 0.0], [0.0, 1e-6]])),
        ("silhouette", Fragment { v: [1.0, 0.0, 1e-10], ..straight([[0.1, 0.0], [0.0, 0.1]]) }),
        (
            "silhouette exactly",
            Fragment { v: [1.0, 0.0, 0.0], ..straight([[0.1, 0.0], [0.0, 0.1]]) },
        ),
        ("n·v < 0", Fragment { n: [0.1, 0.2, -1.0], ..straight([[0.1, 0.0], [0.0, 0.1]]) }),
        ("v_r = 0, v = 0", Fragment { v: [0.0; 3], ..straight([[0.1, 0.0], [0.0, 0.1]]) }),
        ("v_r = 0, n = 0", Fragment { n: [0.0; 3], ..straight([[0.1, 0.0], [0.0, 0.1]]) }),
        ("−0", Fragment { v: [-0.0, -0.0, 1.0], n: [-0.0, -0.0, 1.0], dn_dx: [-0.0; 3], ..PLAIN }),
        ("|n| = 2⁻¹⁰", scaled(-10)),
        ("|n| = 2¹⁰", scaled(10)),
        ("|n| = 2⁻¹⁰⁰⁰", scaled(-1000)),
        ("|n| = 2¹⁰⁰⁰", scaled(1000)),
        ("|∂n| ≫ |n|", straight([[256.0, 0.0], [0.0, 100.0]])),
        ("|∂n| beyond its register", straight([[1e6, 0.0], [0.0, 1e9]])),
        ("|b| = 14", rough([14.0, 0.0], [0.01, 0.0, 0.01])),
        ("|b| = 14, both", rough([9.9, -9.9], [0.01, 0.0, 0.01])),
        (
            "a at the top of its register",
            straight([[256.0 - 1.0 / 1_048_576.0, 0.0], [0.0, 128.0]]),
        ),
        (
            "c at the top of its register",
            straight([[128.0, 0.0], [0.0, 256.0 - 1.0 / 1_048_576.0]]),
        ),
        ("α at a table boundary", turned(boundary)),
        ("α one ulp above a table boundary", turned(up(boundary))),
        ("α one ulp below a table boundary", turned(down(boundary))),
        ("α at −45°", turned(-std::f64::consts::FRAC_PI_4)),
        ("count at a boundary", wide(3.0 / 64.0)),
        ("count one ulp above a boundary", wide(up(3.0 / 64.0))),
        ("count one ulp below a boundary", wide(down(3.0 / 64.0))),
        ("count at 2⁻⁸ beyond a boundary", wide((3.0 + 1.0 / 256.0) / 64.0)),
        ("equal components, all", along([1.0, 1.0, 1.0])),
        ("equal components, x and z", along([1.0, 0.5, 1.0])),
        ("equal components, x and y", along([1.0, 1.0, 0.5])),
        ("one ulp inside an edge", along([down(1.0), 0.5, 1.0])),
        ("one ulp outside an edge", along([up(1.0), 0.5, 1.0])),
        ("one ulp inside a corner", along([down(1.0), down(1.0), 1.0])),
        ("one ulp outside a corner", along([up(1.0), up(1.0), 1.0])),
        (
            "a probe line over an edge",
            Fragment { dn_dx: [1.0, 0.0, 0.0], dn_dy: [0.0, 0.01, 0.0], ..along([0.9, 0.1, 1.0]) },
        ),
        (
            "a probe line over two edges",
            Fragment { dn_dx: [2.0, 2.0, 0.0], dn_dy: [0.01, 0.0, 0.0], ..along([0.9, 0.9, 1.0]) },
        ),
        ("h ∥ n", Fragment { h: Some([0.0, 0.0, 3.0]), ..rough([0.1, 0.1], [0.1, 0.0, 0.1]) }),
        ("h = 0", Fragment { h: Some([0.0; 3]), ..rough([0.1, 0.1], [0.1, 0.0, 0.1]) }),
        (
            "h ∥ n but for an ulp",
            Fragment { h: Some([f64::EPSILON, 0.0, 1.0]), ..rough([0.1, 0.1], [0.1, 0.0, 0.1]) },
        ),
        ("roughness with c = 0", rough([0.0, 0.0], [0.25, 0.0, 0.0])),
        ("roughness of rank 1", rough([0.0, 0.0], [0.0, 0.25, 0.25])),
        ("roughness 0", rough([0.5, 0.5], [0.0; 3])),
        (
            "not finite",
            Fragment { v: [f64::INFINITY, 1.0, f64::NAN], dn_dx: [f64::NAN; 3], ..PLAIN },
        ),
        ("subnormal", Fragment { v: [5e-324, 0.0, 1e-310], n: [0.0, 5e-324, 0.0], ..PLAIN }),
        (
            "largest",
            Fragment {
                v: [f64::MAX; 3],
                n: [f64::MAX, -f64::MAX, f64::MAX],
                dv_dx: [f64::MAX; 3],
                ..PLAIN
            },
        ),
    ]
}

/// Rows of HIT in the room of half edges 3, 2, 4.
#[must_use]
pub fn hit() -> Vec<(&'static str, HitFragment)> {
    let ray = |x: [f64; 3], r: [f64; 3]| HitFragment { x, r, cone: Some([0.01, 0.05]) };
    vec![
        ("x = 0", ray([0.0; 3], [1.0, 0.5, 0.25])),
        ("R along an axis", ray([0.5, 0.25, 1.0], [0.0, 0.0, -1.0])),
        ("R = 0", ray([0.5, 0.25, 1.0], [0.0; 3])),
        ("x at the surface", ray([0.0, 0.0, 4.0], [0.5, 0.25, -1.0])),
        ("p_un = 1 − τ", ray([0.0, 0.0, 4.0 * (1.0 - 1.0 / 1024.0)], [0.5, 0.25, -1.0])),
        ("p_un = 1 + τ", ray([0.0, 0.0, 4.0 * (1.0 + 1.0 / 1024.0)], [0.5, 0.25, -1.0])),
        ("x beyond the surface", ray([0.0, 0.0, 4.5], [0.0, 0.0, 1.0])),
        ("x far outside", ray([40.0, -30.0, 100.0], [1.0, 1.0, 1.0])),
        ("grazing", ray([0.0, 1.999, 0.0], [1.0, 1e-4, 0.5])),
        ("grazing along the wall", ray([0.0, 1.99, 0.0], [1.0, 0.0, 0.0])),
        ("R of length 2⁻³⁰⁰", ray([0.5, 0.25, 1.0], [1e-90, -1e-90, 2e-90])),
        ("R of length 2³⁰⁰", ray([0.5, 0.25, 1.0], [1e90, -1e90, 2e90])),
        ("x subnormal", ray([5e-324, 0.0, -5e-324], [1.0, 2.0, 3.0])),
        ("x = −0", ray([-0.0; 3], [-1.0, -0.0, 0.0])),
        ("not finite", ray([f64::NAN, 0.0, 1.0], [f64::INFINITY, 1.0, 0.0])),
        ("into a corner", ray([0.1, 0.2, 0.3], [3.0, 2.0, 4.0])),
        ("into an edge", ray([0.0; 3], [3.0, 2.0, 0.0])),
        ("no cone", HitFragment { cone: None, ..ray([0.5, 0.25, 1.0], [1.0, 1.0, 1.0]) }),
        (
            "cone of width 0",
            HitFragment { cone: Some([0.0, 0.0]), ..ray([0.5, 0.25, 1.0], [1.0, 0.3, 0.2]) },
        ),
        (
            "cone through its waist",
            HitFragment { cone: Some([-0.125, 0.1]), ..ray([0.5, 0.25, 1.0], [1.0, 0.3, 0.2]) },
        ),
    ]
}

/// Rows of a cone: operation, angle and width, operands.
pub const CONES: [(u64, [f64; 2], [f64; 3]); 24] = [
    (0, [0.0, 0.0], [1.0, 0.0, 0.0]),
    (0, [-0.0, -0.0], [1.0, 0.0, 0.0]),
    (0, [1e-40, 1e-40], [1.0, 0.0, 0.0]),
    (0, [3e38, 3e38], [1.0, 0.0, 0.0]),
    (0, [-0.25, -0.5], [1.0, 0.0, 0.0]),
    (0, [0.25, -0.5], [1.0, 0.0, 0.0]),
    (0, [-0.25, 0.25], [1.0, 0.0, 0.0]),
    (0, [-0.25, 0.25], [2.0, 0.0, 0.0]),
    (0, [0.01, 0.5], [1e9, 0.0, 0.0]),
    (0, [0.01, 0.5], [-1e9, 0.0, 0.0]),
    (0, [0.01, 0.5], [f64::INFINITY, 0.0, 0.0]),
    (1, [0.25, 0.5], [0.0, 0.0, 0.0]),
    (1, [0.249, 0.5], [-1e30, 0.0, 0.0]),
    (1, [0.25, -0.5], [1.0, 0.0, 0.0]),
    (2, [0.1, 0.5], [0.0, 1.0, 1.5]),
    (2, [0.1, 0.5], [0.5, 1.25, 1.25]),
    (2, [0.1, 0.5], [0.5, 3.0, 1.0]),
    (2, [0.1, 0.5], [0.5, 1.0, 3.0]),
    (2, [0.1, 0.5], [0.5, 1.0, 0.0]),
    (2, [0.0, 0.5], [0.0, 1.0, 0.0]),
    (3, [0.1, 0.5], [0.0, 0.0, 0.0]),
    (3, [0.1, 0.5], [std::f64::consts::FRAC_1_PI, 0.0, 0.0]),
    (3, [-0.1, 0.5], [1e-3, 0.0, 0.0]),
    (3, [0.1, 0.5], [-1.0, 0.0, f64::NAN]),
];

/// A request to a 2-D texture before its ports.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Request {
    /// The cone's width.
    pub width: f64,
    /// The ray's direction.
    pub d: [f64; 3],
    /// The normal.
    pub n: [f64; 3],
    /// ∂P/∂s and ∂P/∂t, or a triangle's edges.
    pub tangents: [[f64; 3]; 2],
    /// Differences of s, then of t, along a triangle's edges.
    pub edge: Option<[f64; 4]>,
    /// s and t.
    pub st: [f64; 2],
}

/// A request to a surface that faces the ray.
pub const FACING: Request = Request {
    width: 0.01,
    d: [0.0, 0.0, -1.0],
    n: [0.0, 0.0, 1.0],
    tangents: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
    edge: None,
    st: [0.5, 0.5],
};

/// Rows of TEX.
#[must_use]
pub fn tex() -> Vec<(&'static str, Request)> {
    let f = FACING;
    let slant = [0.6, 0.0, -0.8];
    vec![
        ("D ∥ N", f),
        ("D·N = 0", Request { d: [1.0, 0.0, 0.0], ..f }),
        ("grazing", Request { d: [1.0, 0.25, -1e-3], ..f }),
        ("w = 0", Request { width: 0.0, d: slant, ..f }),
        ("w < 0", Request { width: -0.01, d: slant, ..f }),
        ("w subnormal", Request { width: libm::ldexp(1.0, -130), d: slant, ..f }),
        ("w at its largest", Request { width: f64::MAX, d: slant, ..f }),
        ("∂P/∂s ∥ ∂P/∂t", Request { tangents: [[1.0, 2.0, 0.0], [2.0, 4.0, 0.0]], d: slant, ..f }),
        ("∂P/∂s = 0", Request { tangents: [[0.0; 3], [0.0, 1.0, 0.0]], d: slant, ..f }),
        ("∂P = 0", Request { tangents: [[0.0; 3]; 2], d: slant, ..f }),
        (
            "nearly parallel ∂P",
            Request { tangents: [[1.0, 0.0, 0.0], [1.0, 1e-6, 0.0]], d: slant, ..f },
        ),
        (
            "∂P of 2⁻³⁰⁰ and 2³⁰⁰",
            Request { tangents: [[1e-90, 0.0, 0.0], [0.0, 1e90, 0.0]], d: slant, ..f },
        ),
        ("D = 0", Request { d: [0.0; 3], ..f }),
        ("N = 0", Request { n: [0.0; 3], ..f }),
        ("not finite", Request { d: [f64::NAN, 1.0, f64::INFINITY], ..f }),
        ("triangle", Request { edge: Some([1.0, 0.0, 0.0, 1.0]), d: slant, ..f }),
        ("triangle without texture coordinates", Request { edge: Some([0.0; 4]), d: slant, ..f }),
        ("s and t at the edge", Request { st: [0.0, 1.0], d: slant, ..f }),
        ("s and t far outside", Request { st: [300.7, -411.3], d: slant, ..f }),
        ("s and t beyond their registers", Request { st: [1e6, -1e9], d: slant, ..f }),
    ]
}
