//! Stage `ray_cone`: the changes of a ray cone along a path (Cline 2023), in doubles.
//!
//! Results are within 1e-15 of the exact value, relatively, whatever cancels down to 2⁻⁹⁰ of its terms: they
//! are computed in [`Wide`]. Beyond the largest double they saturate; NaN reads as 0, ±∞ as the
//! largest double.

pub mod camera;

use super::prepared::finite;
use super::real::Real;
use super::wide::Wide;
use crate::policy::{ConeRules, SetDiffuse};

/// Full angle in radians.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Angle(pub f64);

/// Full width in world units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Width(pub f64);

/// A ray cone.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cone {
    /// Full angle; positive where the cone diverges.
    pub angle: Angle,
    /// Full width.
    pub width: Width,
}

/// One operation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// Along the ray by a distance.
    Propagate(f64),
    /// At a mirror of a curvature.
    Reflect(f64),
    /// Through a surface of a curvature, from the index `outside` to `inside`.
    Refract {
        /// Curvature.
        curvature: f64,
        /// Index of the incident side.
        outside: f64,
        /// Index of the other side.
        inside: f64,
    },
    /// At a BSDF or phase function of a value.
    Scatter(f64),
}

/// Greatest spread of one scatter, and OptiX Toolkit's limit of an angle.
const S_MAX: f64 = 0.25;

/// 1/π in two doubles.
fn inverse_pi<R: Real>() -> R {
    R::from_f64(std::f64::consts::FRAC_1_PI) + R::from_f64(-1.967_867_667_518_248_6e-17)
}

/// The cone after one operation.
#[must_use]
pub fn ray_cone(cone: Cone, step: Step, rules: ConeRules, set_diffuse: SetDiffuse) -> Cone {
    let [angle, width] = [cone.angle.0, cone.width.0].map(|x| Wide::from_f64(finite(x).0));
    let [angle, width] = after(angle, width, step, rules, set_diffuse);
    Cone { angle: Angle(angle.to_f64()), width: Width(width.to_f64()) }
}

/// Angle and width after one operation, in the arithmetic `R`.
#[must_use]
pub fn after<R: Real>(
    angle: R,
    width: R,
    step: Step,
    rules: ConeRules,
    set_diffuse: SetDiffuse,
) -> [R; 2] {
    let wide = |x: f64| R::from_f64(finite(x).0);
    let zero = R::from_f64(0.0);
    let limit = R::from_f64(S_MAX);
    let otk = rules == ConeRules::Otk;
    let of = |angle: R, width: R| [angle, width];
    if otk && !matches!(step, Step::Propagate(_)) && angle >= limit {
        return of(angle, width);
    }
    match step {
        Step::Propagate(distance) => {
            let width = width + angle * wide(distance);
            if angle < zero && width < zero { of(-angle, -width) } else { of(angle, width) }
        }
        Step::Reflect(curvature) => {
            of(angle + R::from_f64(2.0) * wide(curvature) * width.abs(), width)
        }
        Step::Refract { curvature, outside, inside } => {
            let bend = wide(curvature) * width.abs();
            let (outside, inside) = (wide(outside), wide(inside));
            let through = outside * (angle + bend);
            if inside.is_zero() {
                // No quotient: ± the largest double, or what is left where 0/0 counts as 0.
                let most = wide(f64::INFINITY);
                let angle = if through.is_zero() {
                    -bend
                } else if through > zero {
                    most
                } else {
                    -most
                };
                return of(angle, width);
            }
            let turned = if outside == inside { angle } else { through / inside - bend };
            of(turned, width)
        }
        Step::Scatter(bsdf) => {
            let bsdf = wide(bsdf);
            let spread =
                if bsdf <= inverse_pi::<R>() { limit } else { limit * inverse_pi::<R>() / bsdf };
            let away = otk && angle < zero;
            let turned = angle + if away { -spread } else { spread };
            if otk && turned.abs() >= limit {
                return match set_diffuse {
                    SetDiffuse::Angle => of(limit, width.abs()),
                    SetDiffuse::Exchanged => of(width.abs(), limit),
                };
            }
            of(turned, width)
        }
    }
}
