//! Circuits of the stages that rays and their cones use.

use rtl_model::Config;
use rtl_model::policy::{ConeGradient, HitFootprint, LookUp, Method};
use rtl_model::regs::Reg;

use super::env::{face_choice, project, w};
use super::gates::{PORT, Parts};

/// A look-up of a distance: direction to face, texel coordinates, and between four texels.
fn look_up(p: &mut Parts, c: &Config) {
    if c.rotation.is_some() {
        p.dot(w(c, Reg::HitLookUp), rtl_model::config::ROTATION_FRAC + 2, 3, 3);
    }
    let q = w(c, Reg::HitLookUp);
    p.block(c, Reg::HitLookUp, 3, w(c, Reg::HitL));
    face_choice(p, q);
    p.reciprocal(c, q);
    p.multiply(q, PORT, 2);
    p.shifted_register(c, Reg::HitUv, 2, q + PORT);
    p.multiply(w(c, Reg::HitUv), 16, 2);
    p.register(c, Reg::HitS, 2);
    p.choose(w(c, Reg::HitS), 3, 2);
    if c.policy.hit.lookup == LookUp::Bilinear {
        let sub = c.format(Reg::HitS).frac;
        p.multiply(sub + 1, sub + 1, 4);
        p.multiply(w(c, Reg::HitDistance), 2 * sub + 1, 4);
        p.add(w(c, Reg::HitDistance) + 2 * sub, 3);
    }
    p.register_bits += u64::from(w(c, Reg::HitDistance)) * 4;
    p.register(c, Reg::HitRadius, 1);
}

/// The search. Its loop is one circuit: a look-up, a ratio, a step and the next point, used once a look-up.
pub(super) fn hit(c: &Config) -> Parts {
    let mut p = Parts::default();
    let (x, r, l, d) = (w(c, Reg::HitX), w(c, Reg::HitR), w(c, Reg::HitL), w(c, Reg::HitD));
    let direction = w(c, Reg::HitDirection);
    p.shifted_register(c, Reg::HitX, 3, 53);
    p.block(c, Reg::HitDirection, 3, 53);
    p.dot(direction, direction, 3, 1);
    p.reciprocal_root(c, 2 * direction + 2);
    p.block(c, Reg::HitInvNorm, 1, PORT);
    p.multiply(direction, w(c, Reg::HitInvNorm), 3);
    p.shifted_register(c, Reg::HitR, 3, direction + w(c, Reg::HitInvNorm));
    p.choose(l.max(r).max(x), 3, 3);
    look_up(&mut p, c);
    p.dot(l, l, 3, 1);
    p.root(c, 2 * l + 2);
    p.shifted_register(c, Reg::HitLength, 1, PORT);
    p.reciprocal(c, w(c, Reg::HitRadius));
    p.block(c, Reg::HitInvRadius, 1, PORT);
    p.multiply(w(c, Reg::HitLength), w(c, Reg::HitInvRadius), 1);
    let ratio = w(c, Reg::HitRatio);
    p.shifted_register(c, Reg::HitRatio, 1, w(c, Reg::HitLength) + w(c, Reg::HitInvRadius));
    // Comparisons with 1 ± τ; the first d, and eq. 2's step, which is the same product.
    p.add(ratio, 2);
    p.multiply(w(c, Reg::HitRadius), ratio, 1);
    // Eq. 3: d and ratio of both ends stand in registers.
    p.register_bits += 2 * u64::from(d + ratio);
    if c.policy.hit.method == Method::Illinois {
        p.register(c, Reg::HitHalved, 1);
    }
    p.add(ratio, 2);
    p.reciprocal(c, ratio);
    p.block(c, Reg::HitInvSpan, 1, PORT);
    p.multiply(ratio, w(c, Reg::HitInvSpan), 1);
    p.block(c, Reg::HitQuotient, 1, ratio + w(c, Reg::HitInvSpan));
    p.add(d, 1);
    p.multiply(d, w(c, Reg::HitQuotient), 1);
    p.shifted_register(c, Reg::HitStep, 1, d + w(c, Reg::HitQuotient));
    if c.policy.hit.method == Method::Secant {
        p.add(w(c, Reg::HitStep), 1);
        p.choose(w(c, Reg::HitStep), 2, 1);
    }
    p.add(d, 1);
    p.register(c, Reg::HitD, 1);
    p.multiply(r, d, 3);
    p.add(r + d, 3);
    p.register(c, Reg::HitL, 3);
    p.block(c, Reg::HitTo, 3, l.max(r));
    p
}

/// D of the cone at its hit, by the registers of `jacobian`.
pub(super) fn hit_footprint(c: &Config) -> Parts {
    let mut p = Parts::default();
    let (r, t) = (w(c, Reg::HitR), w(c, Reg::HitTangent));
    p.add(r, 3);
    p.choose(r, 3, 3);
    p.dot(r, r, 2, 1);
    p.reciprocal_root(c, 2 * r + 1);
    p.block(c, Reg::HitInvAcross, 1, PORT);
    p.multiply(r, w(c, Reg::HitInvAcross), 2);
    p.shifted_register(c, Reg::HitTangent, 3, r + w(c, Reg::HitInvAcross));
    p.dot(r, t, 2, 3);
    p.register(c, Reg::HitTangent, 3);
    if c.policy.hit.footprint == HitFootprint::Plane {
        plane(&mut p, c);
    }
    let width = c.policy.cone.format.float().mantissa_bits + 1;
    p.multiply(t, width, 6);
    p.shifted_register(c, Reg::JacDvr, 6, t + width);
    project(&mut p, c, [Reg::JacDvr, Reg::JacNumerator, Reg::JacD], 2);
    p
}

/// The wall's normal from four distances, and the tangents moved onto its plane.
fn plane(p: &mut Parts, c: &Config) {
    let (r, t, n) = (w(c, Reg::HitR), w(c, Reg::HitTangent), w(c, Reg::HitNormal));
    // Four points: 1/|v| of a texel's centre and three products each; two differences, a cross product.
    for _ in 0..4 {
        p.dot(17, 17, 3, 1);
        p.reciprocal_root(c, 34);
        p.multiply(w(c, Reg::HitDistance), PORT, 1);
        p.multiply(17, PORT, 3);
    }
    p.add(PORT, 6);
    p.dot(PORT, PORT, 2, 3);
    p.dot(PORT, PORT, 3, 1);
    p.reciprocal_root(c, 62);
    p.block(c, Reg::HitInvNormal, 1, PORT);
    p.multiply(PORT, w(c, Reg::HitInvNormal), 3);
    p.shifted_register(c, Reg::HitNormal, 3, PORT + w(c, Reg::HitInvNormal));
    p.dot(n, r, 3, 1);
    p.register(c, Reg::HitCosine, 1);
    p.reciprocal(c, w(c, Reg::HitCosine));
    p.block(c, Reg::HitInvCosine, 1, PORT);
    p.dot(n, t, 3, 2);
    p.register(c, Reg::HitAlong, 2);
    p.multiply(w(c, Reg::HitAlong), w(c, Reg::HitInvCosine), 2);
    p.shifted_register(c, Reg::HitSlope, 2, w(c, Reg::HitAlong) + w(c, Reg::HitInvCosine));
    p.multiply(r, w(c, Reg::HitSlope), 6);
    p.add(r + w(c, Reg::HitSlope) + 1, 6);
    p.register(c, Reg::HitTangent, 6);
}

/// Cones: one multiply-add for `propagate` and `reflect`; where a scene bends and scatters rays, the sums of products
/// of `refract` and `scatter` and one divider. Cones live in `cones` pairs of registers.
pub(super) fn ray_cone(c: &Config, bends: bool, cones: u32) -> Parts {
    let mut p = Parts::default();
    let format = c.policy.cone.format.float();
    let significand = format.mantissa_bits + 1;
    let stored = format.exponent_bits + format.mantissa_bits + 1;
    // An operand comes as binary32: 24 bits.
    multiply_add(&mut p, significand, 24);
    if bends {
        for _ in 0..3 {
            multiply_add(&mut p, significand + 24, 24);
        }
        // A divider of one row of subtractors a quotient bit, two more to round.
        let width = significand + 24;
        p.add(width, significand + 2);
        p.choose(width, 2, significand + 2);
    }
    // Two stores, and the cones.
    p.rounding_bits += 2 * u64::from(stored);
    p.choose(stored, 2, 2);
    p.register_bits += 2 * u64::from(stored) * u64::from(cones);
    p
}

/// A product of floating-point numbers and a third one added to it: alignment, sum, normalisation.
fn multiply_add(p: &mut Parts, a: u32, b: u32) {
    let exact = a + b;
    p.multiply(a, b, 1);
    p.add(10, 2);
    p.shift(exact, exact, 1);
    p.add(exact + 1, 1);
    p.count_zeros(exact, 1);
    p.shift(exact, exact, 1);
}

/// A cone's footprint on a textured surface: a triangle's, or by derivatives.
pub(super) fn surface_footprint(c: &Config) -> Parts {
    let mut p = Parts::default();
    let port = 53;
    for reg in [Reg::SurfDirection, Reg::SurfNormal, Reg::SurfDpDs, Reg::SurfDpDt] {
        p.block(c, reg, 3, port);
    }
    p.block(c, Reg::SurfEdge, 4, port);
    for reg in [Reg::SurfS, Reg::SurfT] {
        p.shifted_register(c, reg, 1, port);
    }
    let (d, n, cross) = (w(c, Reg::SurfD), w(c, Reg::SurfN), w(c, Reg::SurfCross));
    for (input, out) in [(Reg::SurfDirection, Reg::SurfD), (Reg::SurfNormal, Reg::SurfN)] {
        let v = w(c, input);
        p.dot(v, v, 3, 1);
        p.reciprocal_root(c, 2 * v + 2);
        p.block(c, Reg::SurfInvLength, 1, PORT);
        p.multiply(v, w(c, Reg::SurfInvLength), 3);
        p.shifted_register(c, out, 3, v + w(c, Reg::SurfInvLength));
    }
    p.dot(d, n, 3, 1);
    p.register(c, Reg::SurfCosine, 1);
    p.dot(d, n, 2, 3);
    p.choose(d + n, 2, 3);
    p.block(c, Reg::SurfCross, 3, d + n + 1);
    p.dot(cross, cross, 3, 1);
    p.reciprocal_root(c, 2 * cross + 2);
    p.block(c, Reg::SurfInvCross, 1, PORT);
    p.multiply(cross, w(c, Reg::SurfInvCross), 3);
    p.shifted_register(c, Reg::SurfAcross, 3, cross + w(c, Reg::SurfInvCross));
    p.dot(n, w(c, Reg::SurfAcross), 2, 3);
    p.register(c, Reg::SurfAlong, 3);
    p.add(w(c, Reg::SurfCosine), 1);
    p.reciprocal(c, w(c, Reg::SurfCosine));
    p.block(c, Reg::SurfInvCosine, 1, PORT);
    let width = c.policy.cone.format.float().mantissa_bits + 1;
    p.multiply(width, w(c, Reg::SurfInvCosine), 1);
    p.block(c, Reg::SurfStretch, 1, width + w(c, Reg::SurfInvCosine));
    p.multiply(w(c, Reg::SurfAlong), w(c, Reg::SurfStretch), 3);
    p.shifted_register(c, Reg::SurfDpDx, 3, w(c, Reg::SurfAlong) + w(c, Reg::SurfStretch));
    p.multiply(w(c, Reg::SurfAcross), width, 3);
    p.shifted_register(c, Reg::SurfDpDy, 3, w(c, Reg::SurfAcross) + width);
    gradients(&mut p, c);
    p.dot(w(c, Reg::SurfDpDx), w(c, Reg::SurfGradS), 3, 2);
    p.dot(w(c, Reg::SurfDpDy), w(c, Reg::SurfGradT), 3, 2);
    p.block(c, Reg::SurfBarycentric, 4, w(c, Reg::SurfDpDx) + w(c, Reg::SurfGradS) + 2);
    p.dot(w(c, Reg::SurfBarycentric), w(c, Reg::SurfEdge), 2, 4);
    let exact = w(c, Reg::SurfBarycentric) + w(c, Reg::SurfEdge) + 1;
    p.block(c, Reg::SurfDdx, 2, exact);
    p.block(c, Reg::SurfDdy, 2, exact);
    p.multiply(w(c, Reg::SurfDdx), 16, 4);
    p.block(c, Reg::SurfJac, 4, w(c, Reg::SurfDdx) + 16);
    p
}

/// ∇s and ∇t on the surface.
fn gradients(p: &mut Parts, c: &Config) {
    let t = w(c, Reg::SurfDpDs);
    let inverse = |p: &mut Parts, width: u32| {
        p.reciprocal(c, width);
        p.block(c, Reg::SurfInvSquare, 1, PORT);
    };
    // The quotients of dot products, which also stand in where the plane is degenerate.
    p.dot(t, t, 3, 2);
    inverse(p, 2 * t + 2);
    let mut v = t;
    if c.policy.cone.gradient == ConeGradient::Gram {
        let plane = w(c, Reg::SurfPlane);
        p.dot(t, t, 2, 3);
        p.block(c, Reg::SurfPlane, 3, 2 * t + 1);
        p.dot(plane, plane, 3, 1);
        p.dot(t, plane, 2, 6);
        p.block(c, Reg::SurfTurned, 6, t + plane + 1);
        v = w(c, Reg::SurfTurned);
    } else {
        inverse(p, 2 * t + 2);
    }
    p.multiply(v, w(c, Reg::SurfInvSquare), 6);
    p.block(c, Reg::SurfGradS, 3, v + w(c, Reg::SurfInvSquare));
    p.block(c, Reg::SurfGradT, 3, v + w(c, Reg::SurfInvSquare));
}
