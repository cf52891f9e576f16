//! Bounds of the integer model against exact arithmetic, derived from the formats and tables.
//!
//! Forward error analysis, register by register; nothing is measured or fitted. All of it is done in
//! the nominal scale of `rtl_model::stages`, where the largest component of v, n and h lies in [1, 2),
//! so that |v|, |n| ≥ 1. A rounding to nearest is off by ½ LSB, floor and to-zero by one. A block's
//! mantissa is off by one LSB at most (½, or what the largest code costs), of a largest one ≥ 1.
//!
//! The facts that carry the analysis: v_r = R(n, n, v) is trilinear with |v_r| = |v||n|²; J_v is |n|²
//! times an orthogonal matrix; |J_n x| ≤ 2|n||v||x|; |ma| ≥ |v_r|/√3; |u|, |v| ≤ 1.

pub mod words;

use crate::base::num;
use rtl_model::Config;
use rtl_model::policy::{Axis, Dnmod, Minor, Policy, Weights};
use rtl_model::regs::Reg;

use words::{SQRT_3, TableErrors, Words, power};

/// One bound.
#[derive(Clone, Debug, PartialEq)]
pub struct Bound {
    /// The quantity that it bounds.
    pub name: &'static str,
    /// Largest |error|, in the unit that `holds` names.
    pub bound: f64,
    /// Its unit and where it holds.
    pub holds: &'static str,
}

const SQRT_2: f64 = std::f64::consts::SQRT_2;
/// √6.
const SQRT_6: f64 = 2.449_489_742_783_178;

/// 1/(1 − x) for a relative error x; infinite where x may be the whole of the number.
fn inverse(x: f64) -> f64 {
    if x < 1.0 { 1.0 / (1.0 - x) } else { f64::INFINITY }
}

/// Errors of the inputs of `reflect` and `jacobian`.
struct Inputs {
    /// Length of v's error over |v|.
    v: f64,
    /// Length of the reflecting normal's error over its length.
    n: f64,
    /// ∂n_mod's error: a share of |∂n|, and an absolute part in n_mod's nominal scale.
    dn: [f64; 2],
}

impl Inputs {
    /// Ports alone.
    fn plain(w: &Words<'_>) -> Self {
        Self {
            v: SQRT_3 * w.block(Reg::ReflectV),
            n: SQRT_3 * w.block(Reg::ReflectN),
            dn: [0.0, w.vector(Reg::JacDnDx).max(w.vector(Reg::JacDnDy)) + w.vector(Reg::JacDnMod)],
        }
    }

    /// With the local frame and a bump; `None` for the policy `frame`, whose ∂e has no bound of this kind.
    fn bumped(w: &Words<'_>, t: &TableErrors, frame: &Frame) -> Option<Self> {
        let n = SQRT_3 * w.block(Reg::FrameN);
        // n + b1 e1 + b2 e2 is |n|√(1 + b²) long; (1, b1, b2)·(errors) ≤ √(1 + b²)·|errors|.
        let sum = (n * n + frame.e1 * frame.e1 + frame.e2 * frame.e2).sqrt()
            + w.fixed(Reg::BumpB) * (2.0 + frame.e1 + frame.e2)
            + w.vector(Reg::BumpN);
        let ports = w.vector(Reg::JacDnDx).max(w.vector(Reg::JacDnDy));
        let (share, absolute) = match w.0.policy.jacobian.dnmod {
            Dnmod::Paper => (0.0, ports),
            Dnmod::Normal => {
                // ∂n⊥ is a projection: turning n by an angle of sine n moves it by as much. 1/⟨n,n⟩ is
                // at least 1/12, ⟨n,∂n⟩/⟨n,n⟩·|n| at most |∂n|, |n| at most 2√3.
                let inv = t.recip + 12.0 * w.fixed(Reg::JacInvNn);
                (
                    n + inv,
                    ports
                        + w.fixed(Reg::JacNIdotDn) * (1.0 + inv)
                        + 2.0 * SQRT_3 * w.fixed(Reg::JacAlong)
                        + w.vector(Reg::JacDnPerp),
                )
            }
            Dnmod::Frame => return None,
        };
        Some(Self {
            v: SQRT_3 * w.block(Reg::ReflectV),
            n: (1.0 + sum) * (1.0 + SQRT_3 * w.block(Reg::ReflectN)) - 1.0,
            // The largest component of n_mod is at least |n|/√3: its scale is at least half of n's.
            dn: [share, 2.0 * absolute + w.vector(Reg::JacDnMod)],
        })
    }
}

/// Errors of the tangent vectors, as lengths over |n|, where |h × n| ≥ ½|h||n|.
struct Frame {
    e1: f64,
    e2: f64,
}

impl Frame {
    fn new(w: &Words<'_>, t: &TableErrors) -> Self {
        let n = SQRT_3 * w.block(Reg::FrameN);
        let h = SQRT_3 * w.block(Reg::FrameH);
        let cross = 1.0 + 2.0 * ((1.0 + h) * (1.0 + n) - 1.0);
        let cross = cross * (1.0 + SQRT_3 * w.block(Reg::FrameCross)) - 1.0;
        // Unit vectors of x and x + δ differ by at most |δ|/(|x| − |δ|).
        let turned = 1.0 + cross * inverse(cross);
        let inv = (1.0 + t.rsqrt) * (1.0 + w.block(Reg::FrameInvLength));
        let length = 1.0 + t.sqrt + w.fixed(Reg::FrameLength);
        let e1 = turned * (1.0 + n) * inv * length * (1.0 + w.block(Reg::FrameScale)) - 1.0
            + w.vector(Reg::FrameE1);
        let e2 = turned * (1.0 + n) * inv - 1.0
            + w.vector(Reg::FrameNCross) * inv
            + w.vector(Reg::FrameE2);
        Self { e1, e2 }
    }
}

/// Errors of the projection's inputs: 1/|ma| relative, u and v absolute.
struct Facing {
    inv: f64,
    uv: f64,
}

impl Facing {
    fn new(w: &Words<'_>, t: &TableErrors, i: &Inputs) -> Self {
        let both = (1.0 + i.n) * (1.0 + i.v);
        // v_r over |v||n|²: the inputs' errors through a trilinear form, then 2n·δ⟨n,v⟩ − v·δ⟨n,n⟩.
        let sum = (1.0 + i.n) * both - 1.0
            + 2.0 * w.fixed(Reg::ReflectNdotV) * (1.0 + i.n)
            + w.fixed(Reg::ReflectNdotN) * (1.0 + i.v);
        let block = w.block(Reg::ReflectVr);
        // |v_r| ≤ √3·|ma|. |δsc − u·δma| ≤ √2·|δ|; the block's two components are off by one LSB each.
        let ma = (1.0 + SQRT_3 * sum) * (1.0 + block) - 1.0;
        let before = (SQRT_6 * sum + 2.0 * block * (1.0 + SQRT_3 * sum)) * inverse(ma);
        let recip = (1.0 + t.recip) * (1.0 + w.block(Reg::FaceInvMa)) - 1.0;
        Self {
            inv: (1.0 + recip) * inverse(ma) - 1.0,
            uv: before + recip * (1.0 + before) + w.fixed(Reg::FaceU).max(w.fixed(Reg::FaceV)),
        }
    }
}

/// D: (share of T = |∂v|/|v| + 2|∂n|/|n_mod|, absolute part).
fn derivatives(w: &Words<'_>, i: &Inputs, f: &Facing) -> [f64; 2] {
    let dots = w.fixed(Reg::JacNdotDv) + w.fixed(Reg::JacVdotDn) + w.fixed(Reg::JacNdotDn);
    let grown = (1.0 + i.n) * (1.0 + i.n.max(i.v));
    // ∂v_r over |v||n|²: the forms' inputs; ∂v's and ∂n's errors; the rounded products; the register.
    let grown = grown + w.fixed(Reg::ReflectNdotN).max(w.fixed(Reg::ReflectNdotV));
    let share = grown - 1.0 + i.dn[0] * grown;
    let port = w.vector(Reg::JacDvDx).max(w.vector(Reg::JacDvDy));
    let absolute =
        (port + 2.0 * i.dn[1]) * grown + 2.0 * dots * (1.0 + i.n.max(i.v)) + w.vector(Reg::JacDvr);
    // p = ∂sc − u·∂ma is at most √2·|∂v_r|, then divided by |ma| ≥ |v||n|²/√3.
    let grow = 1.0 + f.inv;
    [
        SQRT_6 * f.inv + grow * (SQRT_6 * share + SQRT_3 * f.uv * (1.0 + share)),
        grow * (SQRT_6 * absolute + SQRT_3 * f.uv * absolute + SQRT_3 * w.fixed(Reg::JacNumerator))
            + w.fixed(Reg::JacD),
    ]
}

/// s·B': (share of the sum of |d| that enter an entry, absolute part).
fn factors(w: &Words<'_>, i: &Inputs, frame: &Frame, f: &Facing) -> [f64; 2] {
    let scale = libm::ldexp(w.0.roughness_scale.max(0) as f64, -20);
    let e = frame.e1.max(frame.e2);
    // J_n e over |v||n_mod||n|.
    let t = 2.0 * ((1.0 + i.n) * (1.0 + i.v) * (1.0 + e) - 1.0)
        + 2.0
            * (1.0 + e)
            * (1.0 + i.n.max(i.v))
            * (w.fixed(Reg::ReflectNdotV) + w.fixed(Reg::RoughVdotE) + w.fixed(Reg::RoughNdotE))
        + w.vector(Reg::RoughDvr);
    let grow = 1.0 + f.inv;
    let most = 2.0 * SQRT_6;
    let entry = most * f.inv
        + grow * SQRT_3 * (SQRT_2 * t + f.uv * (2.0 + t) + 2.0 * w.fixed(Reg::RoughNumerator))
        + w.fixed(Reg::RoughE);
    [
        entry * scale + (most + entry) * power(21),
        2.0 * (most + entry) * (scale * w.fixed(Reg::RoughD) + w.fixed(Reg::RoughScaled))
            + w.fixed(Reg::RoughB),
    ]
}

/// λ1 and λ2 as shares of λ1, and K as a share of a + c, from given D and s·B'.
struct Ellipse {
    k: f64,
    lambda: [f64; 2],
}

impl Ellipse {
    fn new(w: &Words<'_>, t: &TableErrors) -> Self {
        let format = w.0.format(Reg::CovK);
        // The larger of a, c has its leading bit on one of the two top bits.
        let k = libm::ldexp(4.0, -num::i32(format.magnitude_bits()));
        let least = libm::ldexp(0.25, num::i32(format.int));
        // λ²: eigenvalues move by |δK| ≤ 2k(a + c) ≤ 4kλ1²; half of the root's error; its own register,
        // where λ1² ≥ (a + c)/2 ≥ least/2. The root is at most a + c ≤ 2λ1².
        let square = 4.0 * k
            + t.sqrt * (1.0 + 4.0 * k)
            + (w.fixed(Reg::EigenRoot) + 2.0 * w.fixed(Reg::EigenSq)) / least;
        let word = w.fixed(Reg::EigenLambda) / (least / 2.0).sqrt();
        let root = 1.0 - (1.0 - square.min(1.0)).sqrt();
        let major = root + t.sqrt * (1.0 + square) + word;
        let minor = match w.0.policy.eigen.minor {
            Minor::Paper => square.sqrt() + t.sqrt * (1.0 + square) + word,
            // √det K moves by √(2k(a + c)²(1 + k)) ≤ √(8k(1 + k))·λ1², then /λ1.
            Minor::Det => {
                let det = (8.0 * k * (1.0 + k)).sqrt();
                let quotient = (1.0 + t.sqrt) * (1.0 + t.recip) * inverse(major) - 1.0;
                det * (1.0 + quotient) + quotient + word
            }
        };
        Self { k, lambda: [major, minor] }
    }
}

/// Angle of the axis against the eigenvector of K's own codes; `None` where it is another axis.
fn axis(w: &Words<'_>, t: &TableErrors) -> Option<(f64, &'static str)> {
    let word = SQRT_2 * w.fixed(Reg::EigenAxis);
    let angle = |chord: f64| libm::asin(chord.min(1.0));
    let spec = w.0.tables.eigen;
    match w.0.policy.footprint.axis {
        Axis::EigenTable => {
            let step = std::f64::consts::FRAC_PI_2 / f64::from(spec.entries);
            // Interpolation stays between the two entries.
            let bin = if spec.order == 0 { step / 2.0 } else { step };
            let entry = SQRT_2 * power(spec.frac + 1);
            // Boundary constants have 28 bits.
            Some((
                bin + angle(entry + word) + power(28),
                "radians, from the eigenvector of K's own codes; K not isotropic",
            ))
        }
        Axis::EigenExact => {
            let least = libm::ldexp(0.25, num::i32(w.0.format(Reg::CovK).int));
            // (|c − a| + root, 2b) is at least the root long; 30-bit components and 1/√x.
            let root = t.sqrt + 256.0 * w.fixed(Reg::EigenRoot) / least;
            Some((
                angle(root + 4.0 * power(29) + SQRT_2 * t.rsqrt + word),
                "radians, from the eigenvector of K's own codes, where λ1² − λ2² ≥ (a + c)/256",
            ))
        }
        Axis::LongerDerivative => None,
    }
}

/// LOD from given D and s·B'.
fn lod(w: &Words<'_>, t: &TableErrors, e: &Ellipse) -> f64 {
    let c = w.0;
    let policy = &c.policy.footprint;
    let [most, of] = policy.count.most(policy.max_probes).map(f64::from);
    let most = most / of;
    // m ≥ 1 is λ2·N/2, where M ≤ most·m; or 1; or M/most.
    let word = w.fixed(Reg::FootWidth)
        + w.fixed(Reg::FootLength)
        + power(8 + c.format(Reg::FootLength).frac);
    let m = e.lambda[0].max(most * e.lambda[1]) + word;
    libm::log2(inverse(m)) + t.log2 + w.fixed(Reg::FootLod)
}

/// Colour from given addresses, LOD and decoded texels: (share of the largest texel, absolute part).
fn color(w: &Words<'_>) -> [f64; 2] {
    let c = w.0;
    let weight = |bits: u32, reg: Reg| {
        if bits >= c.format(reg).frac { 0.0 } else { power(bits + 1) }
    };
    let Policy { filter, texel, .. } = &c.policy;
    let exact = texel.frac + 2 * filter.weight_bits;
    let bilinear = c.format(Reg::FilterBilinear);
    let narrowed = bilinear.frac < exact || bilinear.int < texel.int;
    [
        2.0 * weight(filter.weight_bits, Reg::AddrS) + weight(filter.lod_bits, Reg::FootLod),
        w.fixed(Reg::FilterColor) + if narrowed { w.fixed(Reg::FilterBilinear) } else { 0.0 },
    ]
}

/// The bounds of a unit, where no flag is raised and without `transform.rotation` before D.
///
/// Rows that do not apply to the unit's policies are left out, and those of words or tables so coarse
/// that a number may be off by all of itself: there is no bound then.
#[must_use]
pub fn bounds(config: &Config) -> Vec<Bound> {
    let w = Words(config);
    let t = TableErrors::new(config);
    let mut out = Vec::new();
    let mut add = |name, bound: f64, holds| {
        if bound.is_finite() {
            out.push(Bound { name, bound, holds });
        }
    };
    if config.rotation.is_none() {
        let i = Inputs::plain(&w);
        let f = Facing::new(&w, &t, &i);
        let d = derivatives(&w, &i, &f);
        add(
            "cube_face.u, v",
            f.uv,
            "absolute; v, n, h as given; on the face that both choose; no bump, no roughness",
        );
        add(
            "jacobian.d, factor",
            d[0],
            "times T = |∂v|/|v| + 2|∂n|/|n| of the column, plus the next row; no bump, no roughness",
        );
        add("jacobian.d, absolute", d[1], "beside the row before");
        let frame = Frame::new(&w, &t);
        if let Some(i) = Inputs::bumped(&w, &t, &frame) {
            let f = Facing::new(&w, &t, &i);
            let d = derivatives(&w, &i, &f);
            let b = factors(&w, &i, &frame, &f);
            add(
                "cube_face.u, v, bumped",
                f.uv,
                "absolute; with bump or roughness, |h × n| ≥ ½|h||n|; on the face that both choose",
            );
            add(
                "jacobian.d, bumped, factor",
                d[0],
                "times T = |∂v|/|v| + 2|∂n|/|n_mod|, plus the next row; as the row before",
            );
            add("jacobian.d, bumped, absolute", d[1], "beside the row before");
            add(
                "roughness.b, factor",
                b[0],
                "times |d1| (first column) or |d2| + |d3| (second), plus the next row; as for u, v, bumped",
            );
            add("roughness.b, absolute", b[1], "beside the row before");
        }
    }
    let e = Ellipse::new(&w, &t);
    add(
        "covariance.k",
        e.k,
        "times (a + c), from D's and B's own codes; an error of η·√(a + c) in [D B] adds 2η + η²",
    );
    if config.policy.footprint.axis != Axis::LongerDerivative {
        add(
            "eigen.lambda 1",
            e.lambda[0],
            "times λ1, from D's and B's own codes; an error of η·√(a + c) in [D B] adds √2·η",
        );
        add(
            "eigen.lambda 2",
            e.lambda[1],
            "times λ1, from D's and B's own codes; an error of η·√(a + c) in [D B] adds √2·η",
        );
        add("footprint.lod", lod(&w, &t, &e), "levels, from D's and B's own codes");
    }
    if let Some((angle, holds)) = axis(&w, &t) {
        add("eigen.axis", angle, holds);
    }
    let c = color(&w);
    add(
        "filter.color, factor",
        c[0],
        "times the largest texel read, plus the next row; from the codes of address and LOD, texels as decoded",
    );
    let weights = match config.policy.footprint.weights {
        Weights::Box => "beside the row before",
        Weights::Gaussian | Weights::Bell => {
            "beside the row before; probe weights as the integers they are"
        }
    };
    add("filter.color, absolute", c[1], weights);
    out
}
