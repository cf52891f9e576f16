//! The footprint at the hit: D = G(l)·|w|·[t1 t2].

use super::Hit;
use crate::policy::{ConeEnv, HitFootprint, HitStatus};
use crate::reference::cube_face::cube_face;
use crate::reference::distances::{Distances, unit};
use crate::reference::env::{Env, Front, back_end, ellipse, trusted};
use crate::reference::flags::{Flag, Flags};
use crate::reference::prepared::Prepared;
use crate::reference::real::{Real, saturate};
use crate::reference::tap::{NoTap, Tap, put};
use crate::reference::texture::Texture;
use crate::reference::vector::{Vector, beside, transform, vector};
use crate::reference::wide::Wide;
use crate::stage::Stage;

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// t1 = unit(e_k × R), k the smallest |R_k| (ties z, y, x), and t2 = R × t1.
#[must_use]
pub fn basis(r: [f64; 3]) -> [[f64; 3]; 2] {
    let [x, y, z] = r;
    let t1 = unit(beside(r));
    let t2 = [y * t1[2] - z * t1[1], z * t1[0] - x * t1[2], x * t1[1] - y * t1[0]];
    [t1, t2]
}

/// The tangents moved along R onto the wall's plane, |⟨n,R⟩| at least 1/max_probes.
#[must_use]
pub fn onto_plane(r: [f64; 3], t: [[f64; 3]; 2], n: [f64; 3], max_probes: u32) -> [[f64; 3]; 2] {
    let n = unit(n);
    let cosine = dot(n, r);
    let least = 1.0 / f64::from(max_probes.max(1));
    let cosine = if cosine < 0.0 { cosine.min(-least) } else { cosine.max(least) };
    t.map(|t| {
        let slope = dot(n, t) / cosine;
        [t[0] - r[0] * slope, t[1] - r[1] * slope, t[2] - r[2] * slope]
    })
}

/// ENV from the hit on.
pub(super) fn env<T: Tap>(
    prepared: &Prepared,
    distance: &Distances,
    hit: &Hit,
    [angle, width]: [f64; 2],
    face_size: usize,
    texture: Option<&Texture>,
    tap: &mut T,
) -> Env {
    let settings = prepared.settings();
    let escaped = hit.status == HitStatus::Escaped;
    let mut flags = hit.flags;
    let mut t = basis(hit.r);
    if settings.policy.hit.footprint == HitFootprint::Plane && !escaped {
        let turned = match prepared.rotation() {
            None => hit.l,
            Some(a) => a.map(|row| dot(row, unit(hit.l))),
        };
        let back = |n: [f64; 3]| match prepared.rotation() {
            None => n,
            Some(a) => [0, 1, 2].map(|i| a[0][i] * n[0] + a[1][i] * n[1] + a[2][i] * n[2]),
        };
        match distance.normal(turned) {
            Some(n) => t = onto_plane(hit.r, t, back(n), settings.policy.footprint.max_probes),
            None => flags.insert(Flag::HitNoPlane),
        }
    }
    // Where the ray escaped, |w|/|l| tends to |α|.
    let width = if escaped { angle.abs() } else { saturate(width + angle * hit.d).abs() };
    let quick = front::<f64, _>(prepared, hit.l, (width, escaped), t, flags, &mut NoTap);
    let front = if !quick.exact || !ordinary(hit.l, width) {
        front::<Wide, _>(prepared, hit.l, (width, escaped), t, flags, tap)
    } else if T::ACTIVE {
        front::<f64, _>(prepared, hit.l, (width, escaped), t, flags, tap)
    } else {
        quick
    };
    back_end(prepared, front, face_size, texture, tap)
}

/// Whether no product of plain doubles can leave their range.
fn ordinary(l: [f64; 3], width: f64) -> bool {
    let largest = l.iter().fold(0.0f64, |most, x| most.max(x.abs()));
    let good = |x: f64| x == 0.0 || (1e-60..1e60).contains(&x);
    good(largest) && good(width)
}

/// Face, D, K and the axes in the arithmetic `R`.
fn front<R: Real, T: Tap>(
    prepared: &Prepared,
    l: [f64; 3],
    (width, escaped): (f64, bool),
    t: [[f64; 3]; 2],
    mut flags: Flags,
    tap: &mut T,
) -> Front {
    let settings = prepared.settings();
    let matrix = prepared.rotation().map(|rows| rows.map(vector::<R>));
    let facing = cube_face(vector::<R>(l), matrix.as_ref(), &mut flags, tap);
    let width = R::from_f64(width);
    let constant = escaped && settings.policy.cone.env == ConeEnv::Otk;
    let zero = R::from_f64(0.0);
    let mut d = [[zero; 2]; 2];
    let mut terms = zero;
    for (col, t) in t.into_iter().enumerate() {
        let t: Vector<R> = vector(t);
        let t = matrix.as_ref().map_or(t, |a| transform(a, t));
        let rows = facing.numerator(t);
        for (row, value) in rows.into_iter().enumerate() {
            d[row][col] = if !constant {
                value * facing.inv_ma * width
            } else if row == col {
                // OptiX Toolkit's constant 2α/π per [0, 1] of a face.
                R::from_f64(4.0 * std::f64::consts::FRAC_1_PI) * width
            } else {
                zero
            };
        }
        for c in t {
            terms = terms + c.abs() * facing.inv_ma * width;
        }
    }
    put(tap, Stage::Jacobian, "d", d.as_flattened());
    let saturated = Flag::DerivativesSaturated;
    let (k, axes) = ellipse(prepared, (&d, saturated), None, &mut flags, tap);
    let exact = trusted(k, terms, zero, axes.lambda, settings.policy.eigen.minor);
    Front::new(&facing, &d, (k, &axes), flags, exact)
}
