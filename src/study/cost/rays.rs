//! Circuits of the stages that rays and their cones use.

use rtl_model::policy::{ConeGradient, HitFootprint, LookUp, Method};
use rtl_model::regs::Reg;

use super::env::{face_choice, project};
use super::gates::{Circuit, PORT};

/// A look-up of a distance: direction to face, texel coordinates, and between four texels.
fn look_up(p: &mut Circuit<'_>) {
    if p.config.rotation.is_some() {
        p.dot(Reg::HitLookUp, rtl_model::config::ROTATION_FRAC + 2, 3, 3);
    }
    let q = p.w(Reg::HitLookUp);
    p.block(Reg::HitLookUp, 3, Reg::HitL);
    face_choice(p, q);
    p.reciprocal(q);
    p.product(Reg::HitUv, q, PORT, 2);
    p.multiply(Reg::HitUv, 16, 2);
    p.register(Reg::HitS, 2);
    p.choose(Reg::HitS, 3, 2);
    if p.config.policy.hit.lookup == LookUp::Bilinear {
        let sub = p.config.format(Reg::HitS).frac;
        p.multiply(sub + 1, sub + 1, 4);
        p.multiply(Reg::HitDistance, 2 * sub + 1, 4);
        p.add(p.w(Reg::HitDistance) + 2 * sub, 3);
    }
    p.store(Reg::HitDistance, 4);
    p.register(Reg::HitRadius, 1);
}

/// The search. Its loop is one circuit: a look-up, a ratio, a step and the next point, used once a look-up.
pub(super) fn hit(p: &mut Circuit<'_>) {
    let (x, r, l, d) = (p.w(Reg::HitX), p.w(Reg::HitR), p.w(Reg::HitL), p.w(Reg::HitD));
    let direction = p.w(Reg::HitDirection);
    p.shifted_register(Reg::HitX, 3, 53);
    p.block(Reg::HitDirection, 3, 53);
    p.inverse_length(Reg::HitInvNorm, direction);
    p.product(Reg::HitR, direction, Reg::HitInvNorm, 3);
    p.choose(l.max(r).max(x), 3, 3);
    look_up(p);
    p.length(Reg::HitLength, l);
    p.block_reciprocal(Reg::HitInvRadius, Reg::HitRadius);
    p.product(Reg::HitRatio, Reg::HitLength, Reg::HitInvRadius, 1);
    let ratio = p.w(Reg::HitRatio);
    // Comparisons with 1 ± τ; the first d, and eq. 2's step, which is the same product.
    p.add(ratio, 2);
    p.multiply(Reg::HitRadius, ratio, 1);
    // Eq. 3: d and ratio of both ends stand in registers.
    p.store(d + ratio, 2);
    if p.config.policy.hit.method == Method::Illinois {
        p.register(Reg::HitHalved, 1);
    }
    p.add(ratio, 2);
    p.block_reciprocal(Reg::HitInvSpan, ratio);
    p.block_product(Reg::HitQuotient, ratio, Reg::HitInvSpan);
    p.add(d, 1);
    p.product(Reg::HitStep, d, Reg::HitQuotient, 1);
    if p.config.policy.hit.method == Method::Secant {
        p.add(Reg::HitStep, 1);
        p.choose(Reg::HitStep, 2, 1);
    }
    p.add(d, 1);
    p.register(Reg::HitD, 1);
    p.multiply(r, d, 3);
    p.add(r + d, 3);
    p.register(Reg::HitL, 3);
    p.block(Reg::HitTo, 3, l.max(r));
}

/// D of the cone at its hit, by the registers of `jacobian`.
pub(super) fn hit_footprint(p: &mut Circuit<'_>) {
    let (r, t) = (p.w(Reg::HitR), p.w(Reg::HitTangent));
    p.add(r, 3);
    p.choose(r, 3, 3);
    p.dot(r, r, 2, 1);
    p.block_reciprocal_root(Reg::HitInvAcross, 2 * r + 1);
    p.multiply(r, Reg::HitInvAcross, 2);
    p.shifted_register(Reg::HitTangent, 3, r + p.w(Reg::HitInvAcross));
    p.cross_in(Reg::HitTangent, r, t);
    if p.config.policy.hit.footprint == HitFootprint::Plane {
        plane(p);
    }
    let width = p.config.policy.cone.format.float().mantissa_bits + 1;
    p.product(Reg::JacDvr, t, width, 6);
    project(p, [Reg::JacDvr, Reg::JacNumerator, Reg::JacD], 2);
}

/// The wall's normal from four distances, and the tangents moved onto its plane.
fn plane(p: &mut Circuit<'_>) {
    let (r, t, n) = (p.w(Reg::HitR), p.w(Reg::HitTangent), p.w(Reg::HitNormal));
    // Four points: 1/|v| of a texel's centre and three products each; two differences, a cross product.
    for _ in 0..4 {
        p.dot(17, 17, 3, 1);
        p.reciprocal_root(34);
        p.multiply(Reg::HitDistance, PORT, 1);
        p.multiply(17, PORT, 3);
    }
    p.add(PORT, 6);
    p.dot(PORT, PORT, 2, 3);
    p.dot(PORT, PORT, 3, 1);
    p.block_reciprocal_root(Reg::HitInvNormal, 62);
    p.product(Reg::HitNormal, PORT, Reg::HitInvNormal, 3);
    p.dot_in(Reg::HitCosine, n, r, 1);
    p.block_reciprocal(Reg::HitInvCosine, Reg::HitCosine);
    p.dot_in(Reg::HitAlong, n, t, 2);
    p.product(Reg::HitSlope, Reg::HitAlong, Reg::HitInvCosine, 2);
    p.multiply(r, Reg::HitSlope, 6);
    p.add(r + p.w(Reg::HitSlope) + 1, 6);
    p.register(Reg::HitTangent, 6);
}

/// Cones: one multiply-add for `propagate` and `reflect`; where a scene bends and scatters rays, the sums of products
/// of `refract` and `scatter` and one divider. Cones live in `cones` pairs of registers.
pub(super) fn ray_cone(p: &mut Circuit<'_>, bends: bool, cones: u32) {
    let format = p.config.policy.cone.format.float();
    let significand = format.mantissa_bits + 1;
    let stored = format.exponent_bits + format.mantissa_bits + 1;
    // An operand comes as binary32: 24 bits.
    multiply_add(p, significand, 24);
    if bends {
        for _ in 0..3 {
            multiply_add(p, significand + 24, 24);
        }
        // A divider of one row of subtractors a quotient bit, two more to round.
        let width = significand + 24;
        p.add(width, significand + 2);
        p.choose(width, 2, significand + 2);
    }
    // Two stores, and the cones.
    p.parts.rounding_bits += 2 * u64::from(stored);
    p.choose(stored, 2, 2);
    p.store(stored, 2 * cones);
}

/// A product of floating-point numbers and a third one added to it: alignment, sum, normalisation.
fn multiply_add(p: &mut Circuit<'_>, a: u32, b: u32) {
    let exact = a + b;
    p.multiply(a, b, 1);
    p.add(10, 2);
    p.shift(exact, exact, 1);
    p.add(exact + 1, 1);
    p.count_zeros(exact, 1);
    p.shift(exact, exact, 1);
}

/// A cone's footprint on a textured surface: a triangle's, or by derivatives.
pub(super) fn surface_footprint(p: &mut Circuit<'_>) {
    let port = 53;
    for reg in [Reg::SurfDirection, Reg::SurfNormal, Reg::SurfDpDs, Reg::SurfDpDt] {
        p.block(reg, 3, port);
    }
    p.block(Reg::SurfEdge, 4, port);
    for reg in [Reg::SurfS, Reg::SurfT] {
        p.shifted_register(reg, 1, port);
    }
    let (d, n, cross) = (p.w(Reg::SurfD), p.w(Reg::SurfN), p.w(Reg::SurfCross));
    for (input, out) in [(Reg::SurfDirection, Reg::SurfD), (Reg::SurfNormal, Reg::SurfN)] {
        let v = p.w(input);
        p.inverse_length(Reg::SurfInvLength, v);
        p.product(out, v, Reg::SurfInvLength, 3);
    }
    p.dot_in(Reg::SurfCosine, d, n, 1);
    p.dot(d, n, 2, 3);
    p.choose(d + n, 2, 3);
    p.block(Reg::SurfCross, 3, d + n + 1);
    p.inverse_length(Reg::SurfInvCross, cross);
    p.product(Reg::SurfAcross, cross, Reg::SurfInvCross, 3);
    p.cross_in(Reg::SurfAlong, n, Reg::SurfAcross);
    p.add(Reg::SurfCosine, 1);
    p.block_reciprocal(Reg::SurfInvCosine, Reg::SurfCosine);
    let width = p.config.policy.cone.format.float().mantissa_bits + 1;
    p.block_product(Reg::SurfStretch, width, Reg::SurfInvCosine);
    p.product(Reg::SurfDpDx, Reg::SurfAlong, Reg::SurfStretch, 3);
    p.product(Reg::SurfDpDy, Reg::SurfAcross, width, 3);
    gradients(p);
    p.dot(Reg::SurfDpDx, Reg::SurfGradS, 3, 2);
    p.dot(Reg::SurfDpDy, Reg::SurfGradT, 3, 2);
    p.block(Reg::SurfBarycentric, 4, p.w(Reg::SurfDpDx) + p.w(Reg::SurfGradS) + 2);
    p.dot(Reg::SurfBarycentric, Reg::SurfEdge, 2, 4);
    let exact = p.w(Reg::SurfBarycentric) + p.w(Reg::SurfEdge) + 1;
    p.block(Reg::SurfDdx, 2, exact);
    p.block(Reg::SurfDdy, 2, exact);
    p.multiply(Reg::SurfDdx, 16, 4);
    p.block(Reg::SurfJac, 4, p.w(Reg::SurfDdx) + 16);
}

/// ∇s and ∇t on the surface.
fn gradients(p: &mut Circuit<'_>) {
    let t = p.w(Reg::SurfDpDs);
    let inverse = |p: &mut Circuit<'_>, width: u32| {
        p.block_reciprocal(Reg::SurfInvSquare, width);
    };
    // The quotients of dot products, which also stand in where the plane is degenerate.
    p.dot(t, t, 3, 2);
    inverse(p, 2 * t + 2);
    let mut v = t;
    if p.config.policy.cone.gradient == ConeGradient::Gram {
        let plane = p.w(Reg::SurfPlane);
        p.dot(t, t, 2, 3);
        p.block(Reg::SurfPlane, 3, 2 * t + 1);
        p.dot(plane, plane, 3, 1);
        p.dot(t, plane, 2, 6);
        p.block(Reg::SurfTurned, 6, t + plane + 1);
        v = p.w(Reg::SurfTurned);
    } else {
        inverse(p, 2 * t + 2);
    }
    p.multiply(v, Reg::SurfInvSquare, 6);
    p.block(Reg::SurfGradS, 3, v + p.w(Reg::SurfInvSquare));
    p.block(Reg::SurfGradT, 3, v + p.w(Reg::SurfInvSquare));
}
