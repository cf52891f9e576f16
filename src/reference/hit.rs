//! Stage `hit`: where a ray meets the surface of a distance map.

mod footprint;
pub mod step;

use super::distances::{Distances, is_zero, length, unit};
use super::env::{Env, clean};
use super::flags::{Flag, Flags};
use super::prepared::Prepared;
use super::real::saturate;
use super::tap::{Tap, put};
use super::texture::Texture;
use crate::fragment::HitFragment;
use crate::policy::{HitStatus, Outside};
use crate::stage::Stage;
pub use footprint::{basis, onto_plane};

/// Where a ray ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Ray parameter along the unit direction; ∞ where the ray escaped.
    pub d: f64,
    /// The hit; the unit direction where the ray escaped.
    pub l: [f64; 3],
    /// Look-ups in the loop.
    pub iterations: u32,
    /// How the search ended.
    pub status: HitStatus,
    /// The last |l|/dist(l) of the loop; `None` where it made no look-up.
    pub ratio: Option<f64>,
    /// Whether a step went beyond the surface, and what else the ray reported.
    pub flags: Flags,
    /// The unit direction.
    pub r: [f64; 3],
}

/// A hit and, where the ray has a cone, the environment filtered there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HitEnv {
    /// The hit.
    pub hit: Hit,
    /// The footprint and its colour.
    pub env: Option<Env>,
}

/// f = |l|/dist(l): 0 where the distance is infinite, the largest double where it is 0.
fn ratio(length: f64, distance: f64) -> f64 {
    if distance == 0.0 {
        f64::MAX
    } else if distance.is_infinite() {
        0.0
    } else {
        saturate(length / distance)
    }
}

/// The search of Szirmay-Kalos et al. 2005 (eq. 1–3 corrected) in doubles.
///
/// Distances up to 10¹⁵⁰ and directions of any length keep d within 1e-9 of the same steps in exact arithmetic, while no
/// denominator f − p cancels to less than 1e-6; beyond the largest double numbers saturate and raise a flag.
pub fn hit<T: Tap>(
    prepared: &Prepared,
    distance: &Distances,
    fragment: &HitFragment,
    tap: &mut T,
) -> Hit {
    let policy = &prepared.settings().policy.hit;
    let mut flags = Flags::default();
    let mut changed = false;
    let HitFragment { mut x, r: mut direction, .. } = *fragment;
    x.iter_mut().chain(&mut direction).for_each(|x| clean(x, &mut changed));
    if fragment.cone.is_some_and(|cone| cone.iter().any(|c| !c.is_finite())) {
        changed = true;
    }
    if changed {
        flags.insert(Flag::HitNotFinite);
    }
    if is_zero(direction) {
        flags.insert(Flag::HitNoDirection);
    }
    let r = unit(direction);
    let turn = |q: [f64; 3]| match prepared.rotation() {
        None => q,
        Some(a) => a.map(|row| row[0] * q[0] + row[1] * q[1] + row[2] * q[2]),
    };
    let read = |q: [f64; 3]| distance.read(turn(q), policy.lookup);
    put(tap, Stage::Hit, "x", &x);
    put(tap, Stage::Hit, "r", &r);
    let tau = policy.tolerance_bits.map_or(0.0, |bits| 1.0 / f64::from(1u32 << bits.min(31)));
    let side = |f: f64| i8::from(f > 1.0 + tau) - i8::from(f < 1.0 - tau);
    let far = read(r);
    let start = length(x);
    let near = if start == 0.0 { 0.0 } else { read(x) };
    let p_un = if start == 0.0 { 0.0 } else { ratio(start, near) };
    if T::ACTIVE {
        tap.put(Stage::Hit, "radius", 0, saturate(far));
        tap.put(Stage::Hit, "radius", 1, saturate(near));
        tap.put(Stage::Hit, "length", 0, saturate(start));
        tap.put(Stage::Hit, "ratio", 0, p_un);
    }
    let mut out = Hit {
        d: 0.0,
        l: x,
        iterations: 0,
        status: HitStatus::MaxIterations,
        ratio: None,
        flags,
        r,
    };
    let begins = side(p_un);
    if begins == 0 || (begins > 0 && policy.outside == Outside::Stop) {
        out.status = if begins == 0 { HitStatus::AtSurface } else { HitStatus::Outside };
        return out;
    }
    if far.is_infinite() {
        out.status = HitStatus::Escaped;
        out.d = f64::INFINITY;
        out.l = r;
        return out;
    }
    let point = |d: f64| {
        let mut l = [0.0; 3];
        for (l, (x, r)) in l.iter_mut().zip(x.iter().zip(r)) {
            *l = x + r * d;
        }
        l
    };
    let mut ray = step::Ray { far, d: far * (1.0 - p_un), under: (0.0, p_un), over: None, side: 0 };
    for k in 0..=policy.iterations as usize {
        let l = point(ray.d);
        if !ray.d.is_finite() || l.iter().any(|c| !c.is_finite()) {
            out.flags.insert(Flag::HitSaturated);
        }
        ray.d = saturate(ray.d);
        out.d = ray.d;
        out.l = l.map(saturate);
        if T::ACTIVE {
            tap.put(Stage::Hit, "d", k, out.d);
            for (c, value) in out.l.into_iter().enumerate() {
                tap.put(Stage::Hit, "l", 3 * k + c, value);
            }
        }
        if k == policy.iterations as usize {
            break;
        }
        let (size, distance) = (length(out.l), read(out.l));
        let f = ratio(size, distance);
        if T::ACTIVE {
            tap.put(Stage::Hit, "radius", k + 2, saturate(distance));
            tap.put(Stage::Hit, "length", k + 1, saturate(size));
            tap.put(Stage::Hit, "ratio", k + 1, f);
        }
        out.iterations += 1;
        out.ratio = Some(f);
        let side = side(f);
        if side == 0 {
            out.status = HitStatus::Converged;
            break;
        }
        if side > 0 {
            out.flags.insert(Flag::HitOvershoot);
        }
        let step = step::step(policy.method, &mut ray, f, side);
        if T::ACTIVE && step.is_finite() {
            tap.put(Stage::Hit, "step", k, step);
        }
        let next = ray.d + step;
        #[expect(clippy::float_cmp, reason = "a step that leaves d as it is")]
        if next.is_nan() || next == ray.d {
            out.status = HitStatus::Stalled;
            break;
        }
        ray.d = next;
    }
    out
}

/// The HIT operation: the search and, where the ray has a cone, ENV's own stages at its end.
///
/// `face_size` is the size of the environment's faces where there is no texture.
pub fn hit_env<T: Tap>(
    prepared: &Prepared,
    distance: &Distances,
    fragment: &HitFragment,
    face_size: usize,
    texture: Option<&Texture>,
    tap: &mut T,
) -> HitEnv {
    let hit = hit(prepared, distance, fragment, tap);
    let env = fragment.cone.map(|mut cone| {
        cone.iter_mut().for_each(|x| clean(x, &mut false));
        footprint::env(prepared, distance, &hit, cone, face_size, texture, tap)
    });
    HitEnv { hit, env }
}
