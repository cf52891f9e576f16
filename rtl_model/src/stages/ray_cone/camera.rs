//! Cones at the camera, and the curvature of triangles.
//!
//! U, V, W is the camera's frame: W from the eye to the centre of the view rectangle, |U| and |V| half of
//! its width and height; D is a unit vector along the ray. Dot products are exact; lengths and divisors are
//! cut to 63 bits, so that a result is within half an ulp of its format and 2^−58 of itself.

use super::{Cfg, Store, single};
use crate::cone::exact::{self, Term};
use crate::cone::{Angle, Cone, Dither, Dyadic, Sum, Width};
use crate::fx::Flags;

/// A vector of exact numbers.
pub type Vector = [Dyadic; 3];

/// The camera's frame and the picture's size in pixels.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// Half of the view rectangle's width, to the right.
    pub u: Vector,
    /// Half of its height.
    pub v: Vector,
    /// From the eye to its centre.
    pub w: Vector,
    /// Columns and rows; 0 counts as 1.
    pub size: [u32; 2],
}

fn dot(a: &Vector, b: &Vector) -> Sum {
    exact::sum(&[0, 1, 2].map(|i| Term::product(&[a[i], b[i]])))
}

/// The leading 63 bits, the last one set if more follow.
fn cut(sum: &Sum) -> Dyadic {
    let shift = 128 - i64::from(sum.m.leading_zeros()) - 63;
    let (m, e) = if shift > 0 {
        let kept = sum.m >> shift;
        (kept | u128::from(kept << shift != sum.m), sum.e + shift)
    } else {
        (sum.m, sum.e)
    };
    Dyadic::new(sum.negative, u64::try_from(m).unwrap_or(u64::MAX), e)
}

/// √ of a sum that is not negative, to 63 bits.
fn root(sum: &Sum) -> Dyadic {
    if sum.m == 0 {
        return Dyadic::ZERO;
    }
    let shift = i64::from(sum.m.leading_zeros()) - 1;
    let shift = shift - ((sum.e - shift) & 1);
    let (m, e) =
        if shift >= 0 { (sum.m << shift, sum.e - shift) } else { (sum.m >> -shift, sum.e - shift) };
    Dyadic::new(false, u64::try_from(m.isqrt()).unwrap_or(u64::MAX), e / 2)
}

/// a/b as a number of 63 bits; 0 where b is 0.
fn quotient(a: &Sum, b: Dyadic) -> Dyadic {
    if b.is_zero() {
        return Dyadic::ZERO;
    }
    cut(&a.divided_by(b))
}

/// |U| over columns or |V| over rows, times 2·scale; the smaller of the two values.
fn pixel(frame: &Frame, scale: Dyadic) -> Dyadic {
    let side = |axis: &Vector, pixels: u32| {
        let length = root(&dot(axis, axis));
        let product = exact::sum(&[Term::product(&[length, scale, Dyadic::new(false, 2, 0)])]);
        quotient(&product, Dyadic::new(false, pixels.max(1).into(), 0))
    };
    let (a, b) = (side(&frame.u, frame.size[0]), side(&frame.v, frame.size[1]));
    if super::at_least(b, a) { a } else { b }
}

/// ⟨D, W⟩/⟨W, W⟩; 0 where W is 0.
fn per_distance(frame: &Frame, direction: &Vector) -> Dyadic {
    quotient(&dot(direction, &frame.w), cut(&dot(&frame.w, &frame.w)))
}

/// α = 2 min(|U|⟨D,W⟩/(columns·⟨W,W⟩), |V|⟨D,W⟩/(rows·⟨W,W⟩)), w = 0.
pub fn pinhole(
    cfg: &Cfg,
    frame: &Frame,
    direction: &Vector,
    dither: &mut Dither,
    flags: &mut Flags,
) -> Cone {
    let angle = pixel(frame, per_distance(frame, direction));
    Cone { angle: Store::new(cfg, dither, flags).angle(&single(angle)), width: Width(0) }
}

/// α = −w_lens⟨D,W⟩/⟨W,W⟩, w = w_lens.
pub fn thin_lens(
    cfg: &Cfg,
    frame: &Frame,
    direction: &Vector,
    lens_width: Dyadic,
    dither: &mut Dither,
    flags: &mut Flags,
) -> Cone {
    let angle = exact::sum2(lens_width.neg(), per_distance(frame, direction), Dyadic::ZERO);
    let mut store = Store::new(cfg, dither, flags);
    Cone { angle: store.angle(&angle), width: store.width(&single(lens_width)) }
}

/// α = 0, w = 2 min(|U|/columns, |V|/rows): a pixel's width on the image plane.
pub fn orthographic(cfg: &Cfg, frame: &Frame, dither: &mut Dither, flags: &mut Flags) -> Cone {
    Cone {
        angle: Angle(0),
        width: Store::new(cfg, dither, flags).width(&single(pixel_width(frame))),
    }
}

/// A pixel's width on the image plane: the lens of the second cone of pinhole and orthographic cameras.
#[must_use]
pub fn pixel_width(frame: &Frame) -> Dyadic {
    pixel(frame, Dyadic::ONE)
}

/// Curvature ⟨N_b − N_a, B − A⟩/⟨B − A, B − A⟩ of an edge; 0 for an edge without length.
#[must_use]
pub fn edge_curvature([a, b]: [&Vector; 2], [na, nb]: [&Vector; 2]) -> Dyadic {
    let mut over = [Term::default(); 12];
    let mut under = [Term::default(); 12];
    for i in 0..3 {
        let (a, b) = (a[i], b[i]);
        let pairs = [(nb[i], b), (nb[i], a.neg()), (na[i].neg(), b), (na[i], a)];
        let squares = [(b, b), (b, a.neg()), (a.neg(), b), (a, a)];
        for (j, ((p, q), (r, s))) in pairs.into_iter().zip(squares).enumerate() {
            over[4 * i + j] = Term::product(&[p, q]);
            under[4 * i + j] = Term::product(&[r, s]);
        }
    }
    quotient(&exact::sum(&over), cut(&exact::sum(&under)))
}

/// Curvature of a triangle: that of the edge with the least magnitude, 0 if signs mix.
#[must_use]
pub fn triangle_curvature(points: [&Vector; 3], normals: [&Vector; 3]) -> Dyadic {
    let mut best: Option<Dyadic> = None;
    for (i, j) in [(0, 1), (1, 2), (2, 0)] {
        let k = edge_curvature([points[i], points[j]], [normals[i], normals[j]]);
        match best {
            Some(b) if b.is_zero() || k.is_zero() || b.negative != k.negative => {
                return Dyadic::ZERO;
            }
            Some(b) if super::at_least(k.abs(), b.abs()) => {}
            Some(_) | None => best = Some(k),
        }
    }
    best.unwrap_or(Dyadic::ZERO)
}
