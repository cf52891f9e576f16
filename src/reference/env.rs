//! The ENV operation: the stages wired together.

use super::address::{Address, address};
use super::bump::bump;
use super::covariance::covariance;
use super::cube_face::{Facing, cube_face};
use super::eigen::{Axes, eigen};
use super::filter::{Levels, filter};
use super::flags::{Flag, Flags};
use super::footprint::{Chain, Footprint, footprint};
use super::jacobian::{Derivatives, Surface, jacobian};
use super::local_frame::local_frame;
use super::prepared::{Prepared, finite};
use super::real::Real;
use super::reflect::reflect;
use super::roughness::roughness;
use super::tap::{NoTap, Tap};
use super::texture::Texture;
use super::vector::{largest, vector};
use super::wide::Wide;
use crate::fragment::Fragment;
use crate::policy::Minor;

/// The unit's result for a fragment. Every number is finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Env {
    /// Face, 0…5 for +x −x +y −y +z −z.
    pub face: usize,
    /// sc/|ma| of the looked-up direction, −1 … 1.
    pub u: f64,
    /// tc/|ma|, −1 … 1.
    pub v: f64,
    /// [∂u/∂x, ∂u/∂y], [∂v/∂x, ∂v/∂y] per pixel.
    pub d: [[f64; 2]; 2],
    /// K = (a, b; b, c).
    pub k: [f64; 3],
    /// λ1, λ2 in (u, v) per pixel.
    pub lambda: [f64; 2],
    /// Direction of the probe line.
    pub axis: [f64; 2],
    /// Number of probes.
    pub probes: u32,
    /// Level of detail.
    pub lod: f64,
    /// The flags of the fragment.
    pub flags: Flags,
    /// Linear RGB; zero without a texture.
    pub color: [f64; 3],
}

/// The front end's results before the footprint, as doubles, and whether they can be trusted.
pub(super) struct Front {
    pub(super) centre: Address,
    pub(super) d: [[f64; 2]; 2],
    pub(super) k: [f64; 3],
    pub(super) lambda: [f64; 2],
    pub(super) axis: [f64; 2],
    pub(super) flags: Flags,
    pub(super) exact: bool,
}

impl Front {
    #[inline]
    pub(super) fn new<R: Real>(
        facing: &Facing<R>,
        d: &[[R; 2]; 2],
        (k, axes): ([R; 3], &Axes<R>),
        flags: Flags,
        exact: bool,
    ) -> Self {
        Self {
            centre: Address { face: facing.face, u: facing.u.to_f64(), v: facing.v.to_f64() },
            d: d.map(|row| row.map(R::to_f64)),
            k: k.map(R::to_f64),
            lambda: axes.lambda.map(R::to_f64),
            axis: axes.axis.map(Real::to_f64),
            flags,
            exact,
        }
    }
}

/// The ENV operation on one fragment, in float64.
///
/// `face_size` N (at least 1) is the size of the texture's faces; a texture's own size goes before it.
/// Without a texture everything but the colour is computed. `h` absent switches bump and roughness off.
///
/// Accuracy, for every finite input: an entry of D is within 1e-9 of the sum of the magnitudes of its
/// terms (measured against an independent 200-bit evaluation: 1e-15 for inputs of ordinary size; with
/// `dnmod = frame` the terms of ∂e1, ∂e2 count, too). Unless all of D and B' cancel to less than 2⁻⁶⁰ of their terms, K is within
/// 1e-9·(a + c) and λ1 within 1e-9·λ1 of exact arithmetic on the inputs. Beyond `f64::MAX` they saturate
/// and raise a flag. Plain doubles do that unless inputs are extreme or terms cancel; both are
/// detected, and the front end then runs again with twice the precision and unlimited exponents.
pub fn env<T: Tap>(
    prepared: &Prepared,
    fragment: &Fragment,
    face_size: usize,
    texture: Option<&Texture>,
    tap: &mut T,
) -> Env {
    let mut flags = Flags::default();
    let fragment = cleaned(*fragment, &mut flags);
    let mut front = None;
    if ordinary(prepared, &fragment) {
        let quick = run_front::<f64, _>(prepared, &fragment, flags, &mut NoTap);
        if quick.exact {
            front = Some(if T::ACTIVE {
                run_front::<f64, _>(prepared, &fragment, flags, tap)
            } else {
                quick
            });
        }
    }
    let front = match front {
        Some(front) => front,
        None => run_front::<Wide, _>(prepared, &fragment, flags, tap),
    };
    back_end(prepared, front, face_size, texture, tap)
}

/// Footprint, addresses and filter. A trace sees the addresses with or without a texture.
pub(super) fn back_end<T: Tap>(
    prepared: &Prepared,
    front: Front,
    face_size: usize,
    texture: Option<&Texture>,
    tap: &mut T,
) -> Env {
    let settings = prepared.settings();
    let size = texture.map_or(face_size, Texture::size).max(1);
    let chain = Chain { size, levels: texture.map_or(size.ilog2() as usize + 1, Texture::levels) };
    let mut flags = front.flags;
    let (lambda, axis) = (front.lambda, front.axis);
    let policy = (&settings.policy.footprint, prepared.spreads());
    let Footprint { probes, lod, step } = footprint(lambda, axis, chain, policy, &mut flags, tap);
    let levels = Levels::new(lod, chain.levels);
    let sizes = levels
        .index
        .map(|level| texture.map_or((size >> level).max(1), |texture| texture.level_size(level)));
    let centre = front.centre;
    if T::ACTIVE {
        for i in 0..probes {
            address(centre, step, i, probes, sizes, tap);
        }
    }
    let line = (0..probes).map(|i| {
        let at = address(centre, step, i, probes, sizes, &mut NoTap);
        (at, prepared.weight(i, probes))
    });
    let color = texture.map_or([0.0; 3], |texture| filter(texture, levels, line, tap));
    if T::ACTIVE {
        for name in flags.names() {
            tap.event(name);
        }
    }
    Env {
        face: centre.face,
        u: centre.u,
        v: centre.v,
        d: front.d,
        k: front.k,
        lambda,
        axis,
        probes,
        lod,
        flags,
        color,
    }
}

/// The fragment with finite numbers, and with +0 for −0.
#[inline]
fn cleaned(mut fragment: Fragment, flags: &mut Flags) -> Fragment {
    let mut changed = false;
    fragment.for_each(|x| clean(x, &mut changed));
    if changed {
        flags.insert(Flag::NonFinite);
    }
    fragment
}

/// Makes a number finite.
#[inline]
pub(super) fn clean(value: &mut f64, changed: &mut bool) {
    if value.is_finite() {
        *value += 0.0;
    } else {
        *value = finite(*value).0;
        *changed = true;
    }
}

/// Whether plain doubles can neither overflow nor underflow to any effect.
///
/// Inputs lie in 2⁻¹⁰⁰ … 2⁴⁰ or are zero; v and n have a component of at least 2⁻⁴⁰. Then
/// |n_mod| < 2⁸³, |∂v_r| < 2²¹⁰ and, as |v_r| = |v||n_mod|², 1/|ma| < 2¹²¹: |D| < 2³³² and K < 2⁶⁶⁶.
/// h × n, at least 2⁻²⁰⁰·2⁻¹⁰⁶ where it is not zero, has a reciprocal below 2³⁰⁷ only in the frame's
/// unit vector. What is too small for the squares in `eigen` is caught by `run_front`.
fn ordinary(prepared: &Prepared, fragment: &Fragment) -> bool {
    const LEAST: f64 = 7.888_609_052_210_118e-31; // 2⁻¹⁰⁰
    const MOST: f64 = 1_099_511_627_776.0; // 2⁴⁰
    fn good<const N: usize>(values: [f64; N]) -> bool {
        let mut good = true;
        for x in values {
            let size = x.abs();
            good &= (size == 0.0) | (LEAST..=MOST).contains(&size);
        }
        good
    }
    let strong = |a: [f64; 3]| a[0].abs().max(a[1].abs()).max(a[2].abs()) >= 1.0 / MOST;
    let f = fragment;
    strong(f.v)
        && strong(f.n)
        && good(f.v)
        && good(f.n)
        && good(f.dv_dx)
        && good(f.dv_dy)
        && good(f.dn_dx)
        && good(f.dn_dy)
        && f.h.is_none_or(good)
        && f.bump.is_none_or(good)
        && f.rough.is_none_or(good)
        && good([prepared.settings().roughness_scale])
        && prepared.rotation().is_none_or(|rotation| rotation.iter().copied().all(good))
}

/// The stages up to `eigen` in the arithmetic `R`.
#[inline]
fn run_front<R: Real, T: Tap>(
    prepared: &Prepared,
    fragment: &Fragment,
    mut flags: Flags,
    tap: &mut T,
) -> Front {
    let settings = prepared.settings();
    let matrix = prepared.rotation().map(|rows| rows.map(vector::<R>));
    let rotation = matrix.as_ref();
    let v = vector::<R>(fragment.v);
    let n = vector::<R>(fragment.n);
    let used = fragment.bump.is_some() || fragment.rough.is_some();
    let frame = fragment.h.filter(|_| used).map(|h| local_frame(n, vector(h), &mut flags, tap));
    let bumped = frame.zip(fragment.bump.map(|b| b.map(R::from_f64)));
    let n_mod = bumped.as_ref().map_or(n, |(frame, b)| bump(n, frame, *b, tap));
    let reflection = reflect(v, n_mod, tap);
    let facing = cube_face(reflection.v_r, rotation, &mut flags, tap);
    let surface = Surface { v, n, n_mod, bump: bumped, reflection, facing };
    let derivatives = Derivatives {
        dv: [fragment.dv_dx, fragment.dv_dy].map(vector),
        dn: [fragment.dn_dx, fragment.dn_dy].map(vector),
    };
    let jacobian = jacobian(&surface, &derivatives, settings.policy.jacobian.dnmod, rotation, tap);
    let rough = frame.zip(fragment.rough).map(|(frame, d)| {
        let scale = R::from_f64(settings.roughness_scale);
        roughness(&surface, &frame, vector(d), scale, rotation, tap)
    });
    let b = rough.as_ref().map(|rough| &rough.b);
    let d = (&jacobian.d, Flag::DerivativesSaturated);
    let (k, axes) = ellipse(prepared, d, b, &mut flags, tap);

    let exact = trusted(
        k,
        jacobian.terms,
        rough.map_or(R::from_f64(0.0), |rough| rough.terms),
        axes.lambda,
        settings.policy.eigen.minor,
    ) && rotation.is_none_or(|_| {
        // A matrix that is no rotation may cancel what it is applied to.
        largest(reflection.v_r) * facing.inv_ma < R::from_f64(4096.0)
    });
    Front::new(&facing, &jacobian.d, (k, &axes), flags, exact)
}

/// K of D and of B', where there is one, and its axes; `saturated` says that D left the doubles.
#[inline]
pub(super) fn ellipse<R: Real, T: Tap>(
    prepared: &Prepared,
    (d, saturated): (&[[R; 2]; 2], Flag),
    rough: Option<&[[R; 2]; 2]>,
    flags: &mut Flags,
    tap: &mut T,
) -> ([R; 3], Axes<R>) {
    let policy = &prepared.settings().policy;
    let k = covariance(d, rough, tap);
    let choices = (policy.footprint.axis, policy.eigen.minor);
    let axes = eigen(k, [Some(d), rough], choices, prepared.angles(), tap);
    for (values, flag) in [
        (d.as_flattened(), saturated),
        (&k, Flag::CovarianceSaturated),
        (&axes.lambda, Flag::LambdaSaturated),
    ] {
        if values.iter().any(|x| x.is_beyond_range()) {
            flags.insert(flag);
        }
    }
    (k, axes)
}

/// Whether K is as exact as promised in plain doubles.
///
/// A sum's error is below about 64·2⁻⁵³ of its terms. Where a + c is at least 2⁻²⁴ of their square, K
/// is off by at most 2·64·2⁻⁵³·2¹² = 2⁻³⁴ of a + c, below 1e-9. `det` also needs det K not to cancel.
/// Outside 2⁻⁴⁰⁰ … 2⁴⁰⁰ the squares in `eigen` would leave the doubles.
pub(super) fn trusted<R: Real>(
    k: [R; 3],
    terms: R,
    rough_terms: R,
    lambda: [R; 2],
    minor: Minor,
) -> bool {
    let trace = (k[0] + k[2]).to_f64();
    let terms = terms.to_f64();
    let rough_terms = rough_terms.to_f64();
    if trace == 0.0 {
        return terms == 0.0 && rough_terms == 0.0;
    }
    let thin = minor == Minor::Det && lambda[1].to_f64() < lambda[0].to_f64() / 256.0;
    let two_to_400 = 2.582_249_878_086_908_6e120;
    let sums = terms.max(rough_terms);
    (1.0 / two_to_400..two_to_400).contains(&trace) && sums <= 4096.0 * trace.sqrt() && !thin
}
