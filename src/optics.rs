//! A surface's effect on light: reflectance and the refracted direction.
//!
//! Exact: Fresnel's equations for a medium of index n + i·k against vacuum, unpolarised. Approximate: the
//! formula of Lazányi and Szirmay-Kalos (WSCG 2005) that the distance-impostor paper uses,
//! F = ((n−1)² + k² + 4n(1 − c)⁵)/((n+1)² + k²), which is Schlick's for k = 0.

use glam::DVec3;

/// Share of unpolarised light that a surface reflects, exactly.
///
/// `cosine` is that of the angle between the normal and either ray outside the medium, 0…1 (a magnitude
/// beyond 1 counts as 1); `n` and `k` are the medium's index and extinction relative to the outside.
/// For k = 0 and n < 1 (leaving a dense medium) a total reflection is 1.
///
/// Source: Fresnel's equations with Snell's complex angle, with a² + b² = |n̂² − sin²|. With doubles below 1e-14 of
/// the exact value for n and k between 0.1 and 10: a dozen roundings, none of which cancels but at
/// Brewster's angle, where the p share is 0.
#[must_use]
pub fn fresnel(cosine: f64, n: f64, k: f64) -> f64 {
    let c = cosine.abs().min(1.0);
    let sine2 = 1.0 - c * c;
    // (a + i·b)² = (n + i·k)² − sin².
    let real = n * n - k * k - sine2;
    let imaginary = 2.0 * n * k;
    let size = (real * real + imaginary * imaginary).sqrt();
    // Of the two roots the one whose sum does not cancel; the other follows from the product.
    let (a, b) = if real >= 0.0 {
        let a = ((size + real) / 2.0).sqrt();
        (a, if a > 0.0 { imaginary / (2.0 * a) } else { 0.0 })
    } else {
        let b = ((size - real) / 2.0).sqrt();
        (imaginary / (2.0 * b), b)
    };
    let ratio = |x: f64, y: f64| {
        let (minus, plus) = (x - a, x + a);
        let below = plus * plus + y;
        if below > 0.0 { (minus * minus + y) / below } else { 1.0 }
    };
    let s = ratio(c, b * b);
    // p = s · |a + ib − sin·tan|²/|a + ib + sin·tan|², times cos² above and below.
    let p = {
        let up = a * c - sine2;
        let down = a * c + sine2;
        let square = b * c * (b * c);
        let below = down * down + square;
        if below > 0.0 { s * (up * up + square) / below } else { s }
    };
    (s + p) / 2.0
}

/// The paper's approximation of [`fresnel`], for light that comes from outside.
#[must_use]
pub fn fresnel_lazanyi(cosine: f64, n: f64, k: f64) -> f64 {
    let open = 1.0 - cosine.abs().min(1.0);
    let square = open * open;
    ((n - 1.0) * (n - 1.0) + k * k + 4.0 * n * square * square * open)
        / ((n + 1.0) * (n + 1.0) + k * k)
}

/// Direction of a refracted ray, unit; `None` for a total reflection.
///
/// `direction` (towards the surface) and `normal` (against it) are unit; `ratio` is the index before the
/// surface over the index behind it.
#[must_use]
pub fn refract(direction: DVec3, normal: DVec3, ratio: f64) -> Option<DVec3> {
    let through = direction.refract(normal, ratio);
    (through != DVec3::ZERO).then_some(through)
}
