//! Circuits of the stages that reflections use, and of the back end that all operations share.

use rtl_model::TexelFormat;
use rtl_model::policy::{Axis, Dnmod, Minor, Weights};
use rtl_model::regs::Reg;

use super::gates::{Circuit, PORT, log2};

pub(super) fn local_frame(p: &mut Circuit<'_>) {
    let (n, h, cross) = (p.w(Reg::FrameN), p.w(Reg::FrameH), p.w(Reg::FrameCross));
    p.block(Reg::FrameN, 3, 53);
    p.block(Reg::FrameH, 3, 53);
    p.dot(h, n, 2, 3);
    p.block(Reg::FrameCross, 3, h + n + 1);
    p.inverse_length(Reg::FrameInvLength, cross);
    p.length(Reg::FrameLength, n);
    p.block_product(Reg::FrameScale, Reg::FrameLength, Reg::FrameInvLength);
    p.product(Reg::FrameE1, cross, Reg::FrameScale, 3);
    p.cross_in(Reg::FrameNCross, n, cross);
    p.product(Reg::FrameE2, Reg::FrameNCross, Reg::FrameInvLength, 3);
}

pub(super) fn bump(p: &mut Circuit<'_>) {
    p.shifted_register(Reg::BumpB, 2, 53);
    p.multiply(Reg::BumpB, Reg::FrameE1, 3);
    p.multiply(Reg::BumpB, Reg::FrameE2, 3);
    p.add(p.w(Reg::BumpN) + p.config.format(Reg::BumpB).frac, 6);
    p.register(Reg::BumpN, 3);
}

pub(super) fn reflect(p: &mut Circuit<'_>, bumped: bool) {
    let (n, v) = (p.w(Reg::ReflectN), p.w(Reg::ReflectV));
    p.block(Reg::ReflectV, 3, 53);
    p.block(Reg::ReflectN, 3, if bumped { p.w(Reg::BumpN) } else { 53 });
    p.dot_in(Reg::ReflectNdotV, n, v, 1);
    p.dot_in(Reg::ReflectNdotN, n, n, 1);
    let (a, b) = (n + 1 + p.w(Reg::ReflectNdotV), v + p.w(Reg::ReflectNdotN));
    p.multiply(n + 1, Reg::ReflectNdotV, 3);
    p.multiply(v, Reg::ReflectNdotN, 3);
    p.add(a.max(b) + 1, 3);
    p.block(Reg::ReflectVr, 3, a.max(b) + 1);
}

/// `looked_up` is the direction's register.
pub(super) fn cube_face(p: &mut Circuit<'_>, looked_up: Reg) {
    let mut d = p.w(looked_up);
    if p.config.rotation.is_some() {
        p.dot(d, rtl_model::config::ROTATION_FRAC + 2, 3, 3);
        p.block(Reg::FaceRotated, 3, d + rtl_model::config::ROTATION_FRAC + 4);
        d = p.w(Reg::FaceRotated);
    }
    face_choice(p, d);
    p.block_reciprocal(Reg::FaceInvMa, d);
    p.multiply(d, Reg::FaceInvMa, 2);
    for reg in [Reg::FaceU, Reg::FaceV] {
        p.shifted_register(reg, 1, d + p.w(Reg::FaceInvMa));
        p.choose(reg, 3, 1);
    }
}

/// Three comparisons of magnitudes, then sc, tc and ma out of three components with their signs.
pub(super) fn face_choice(p: &mut Circuit<'_>, d: u32) {
    p.add(d, 6);
    p.choose(d, 3, 3);
}

/// ∂n_mod, the first half of `jacobian`.
fn normal(p: &mut Circuit<'_>, bumped: bool) {
    p.shifted_register(Reg::JacDnDx, 3, 53);
    p.shifted_register(Reg::JacDnDy, 3, 53);
    let mut dn = p.w(Reg::JacDnDx);
    if bumped && p.config.policy.jacobian.dnmod != Dnmod::Paper {
        let n = p.w(Reg::FrameN);
        p.dot(n, n, 3, 1);
        p.reciprocal(2 * n + 2);
        p.shifted_register(Reg::JacInvNn, 1, PORT);
        p.dot_in(Reg::JacNIdotDn, n, dn, 2);
        p.multiply(Reg::JacNIdotDn, Reg::JacInvNn, 2);
        p.register(Reg::JacAlong, 2);
        p.multiply(n, Reg::JacAlong, 6);
        p.add(n + p.w(Reg::JacAlong) + 1, 6);
        p.register(Reg::JacDnPerp, 6);
        dn = p.w(Reg::JacDnPerp);
        if p.config.policy.jacobian.dnmod == Dnmod::Frame {
            frame(p);
        }
    }
    p.shifted_register(Reg::JacDnMod, 6, dn);
}

/// The frame's own derivatives: two inner products with h, a quotient, the turn, and ∂e1, ∂e2.
fn frame(p: &mut Circuit<'_>) {
    let (n, h, e) = (p.w(Reg::FrameN), p.w(Reg::FrameH), p.w(Reg::FrameE2));
    p.dot(n, h, 3, 1);
    p.dot(e, h, 3, 1);
    p.reciprocal(e + h + 2);
    p.multiply(n + h, PORT, 1);
    p.dot_in(Reg::JacPerpDotE, Reg::JacDnPerp, e, 4);
    p.multiply(Reg::JacPerpDotE, Reg::JacInvNn, 4);
    p.register(Reg::JacTilt, 4);
    p.multiply(Reg::JacTilt, Reg::JacTurn, 2);
    p.shifted_register(Reg::JacTurn, 3, n + h + PORT);
    p.multiply(Reg::JacTilt, n, 12);
    p.multiply(Reg::JacTurn, e, 12);
    p.add(n + p.w(Reg::JacTilt) + 2, 12);
    p.register(Reg::JacDe, 12);
    p.multiply(Reg::BumpB, Reg::JacDe, 12);
    p.add(p.w(Reg::BumpB) + p.w(Reg::JacDe) + 2, 12);
}

/// Rotation of a derivative, and the numerators of its face coordinates' derivatives, of `columns` vectors.
pub(super) fn project(p: &mut Circuit<'_>, [dv, numerator, out]: [Reg; 3], columns: u32) {
    let d = p.w(dv);
    if p.config.rotation.is_some() {
        p.dot(rtl_model::config::ROTATION_FRAC + 2, d, 3, 3 * columns);
        p.register(dv, 3 * columns);
    }
    p.choose(d, 3, 3 * columns);
    p.multiply(Reg::FaceU, d, columns);
    p.multiply(Reg::FaceV, d, columns);
    p.add(p.w(Reg::FaceU) + d + 1, 2 * columns);
    p.register(numerator, 2 * columns);
    p.product(out, p.w(numerator), Reg::FaceInvMa, 2 * columns);
}

pub(super) fn jacobian(p: &mut Circuit<'_>, bumped: bool) {
    p.shifted_register(Reg::JacDvDx, 3, 53);
    p.shifted_register(Reg::JacDvDy, 3, 53);
    normal(p, bumped);
    let (n, v) = (p.w(Reg::ReflectN), p.w(Reg::ReflectV));
    let (dv, dn) = (p.w(Reg::JacDvDx), p.w(Reg::JacDnMod));
    p.dot_in(Reg::JacNdotDv, n, dv, 2);
    p.dot_in(Reg::JacVdotDn, v, dn, 2);
    p.dot_in(Reg::JacNdotDn, n, dn, 2);
    p.multiply(n + 1, Reg::JacNdotDv, 6);
    p.multiply(Reg::ReflectNdotN, dv, 6);
    p.multiply(p.w(Reg::ReflectNdotV) + 1, dn, 6);
    p.multiply(Reg::JacVdotDn, n + 1, 6);
    p.multiply(Reg::JacNdotDn, v + 1, 6);
    p.add(p.w(Reg::JacVdotDn) + n + 3, 24);
    p.register(Reg::JacDvr, 6);
    project(p, [Reg::JacDvr, Reg::JacNumerator, Reg::JacD], 2);
}

pub(super) fn roughness(p: &mut Circuit<'_>) {
    let (n, v, e) = (p.w(Reg::ReflectN), p.w(Reg::ReflectV), p.w(Reg::FrameE1));
    p.shifted_register(Reg::RoughD, 3, 53);
    p.multiply(Reg::RoughD, rtl_model::config::SCALE_FRAC + 4, 3);
    p.register(Reg::RoughScaled, 3);
    p.dot_in(Reg::RoughVdotE, v, e, 2);
    p.dot_in(Reg::RoughNdotE, n, e, 2);
    p.multiply(p.w(Reg::ReflectNdotV) + 1, e, 6);
    p.multiply(n + 1, Reg::RoughVdotE, 6);
    p.multiply(v + 1, Reg::RoughNdotE, 6);
    p.add(n + p.w(Reg::RoughVdotE) + 2, 12);
    p.register(Reg::RoughDvr, 6);
    project(p, [Reg::RoughDvr, Reg::RoughNumerator, Reg::RoughE], 2);
    p.multiply(Reg::RoughE, Reg::RoughScaled, 6);
    p.add(p.w(Reg::RoughE) + p.w(Reg::RoughScaled) + 1, 2);
    p.register(Reg::RoughB, 4);
}

/// `d` holds D.
pub(super) fn covariance(p: &mut Circuit<'_>, d: Reg, rough: bool) {
    let mut exact = 2 * p.w(d) + 1;
    p.dot(p.w(d), p.w(d), 2, 3);
    if rough {
        p.dot(Reg::RoughB, Reg::RoughB, 2, 3);
        exact = exact.max(2 * p.w(Reg::RoughB) + 1) + 1;
        p.add(exact, 3);
    }
    if p.config.policy.footprint.axis == Axis::LongerDerivative {
        // The squares are there; their sums by columns and the longest one are not.
        let columns = if rough { 4 } else { 2 };
        p.add(exact, 2 * columns);
        p.choose(2 * p.w(d), columns, 1);
        p.choose(exact, columns, 1);
    }
    p.block(Reg::CovK, 3, exact);
}

pub(super) fn eigen(p: &mut Circuit<'_>) {
    let k = p.w(Reg::CovK) + 1;
    p.add(k, 1);
    p.dot(k, k, 2, 1);
    p.root(2 * k + 1);
    p.shifted_register(Reg::EigenRoot, 1, PORT);
    p.add(k.max(p.w(Reg::EigenRoot)) + 1, 3);
    p.register(Reg::EigenSq, 2);
    p.root(Reg::EigenSq);
    if p.config.policy.eigen.minor == Minor::Det
        && p.config.policy.footprint.axis != Axis::LongerDerivative
    {
        p.dot(k, k, 2, 1);
        p.root(2 * k);
        p.reciprocal(Reg::EigenLambda);
        p.multiply(PORT, PORT, 1);
    } else {
        p.root(Reg::EigenSq);
    }
    p.shifted_register(Reg::EigenLambda, 2, PORT);
    let axis = p.w(Reg::EigenAxis);
    match p.config.policy.footprint.axis {
        Axis::EigenTable => angle_table(p, k),
        Axis::EigenExact | Axis::LongerDerivative => {
            p.dot(PORT, PORT, 2, 1);
            p.reciprocal_root(2 * PORT + 1);
            p.multiply(PORT, PORT, 2);
        }
    }
    p.choose(axis, 4, 2);
    p.register(Reg::EigenAxis, 2);
}

/// The angle by a binary search of |2b|·cos θ against |c − a|·sin θ: a pair of multipliers a step.
fn angle_table(p: &mut Circuit<'_>, k: u32) {
    let spec = p.config.tables.eigen;
    // Boundaries of |2α| over 90°, two words of 31 bits each.
    let boundaries = spec.entries / 2;
    let steps = log2(boundaries + 1);
    p.multiply(k, PORT, 2 * steps);
    p.add(k + PORT, steps);
    p.parts.rom_bits += u64::from(boundaries) * 2 * u64::from(PORT);
    p.parts.rom_bits += u64::from(boundaries + 1) * 2 * u64::from(spec.frac + 1);
    if spec.order > 0 {
        // Its place between two entries: a quotient of two rotated components, then two interpolations.
        p.multiply(k, PORT, 4);
        p.reciprocal(k + PORT);
        p.multiply(PORT, PORT, 2);
        p.multiply(PORT, spec.frac + 1, 2);
        p.add(PORT, 6);
        p.parts.rom_bits += u64::from(boundaries) * 2 * u64::from(PORT);
    }
}

/// `sizes`: for a texture whose sides are no powers of two they are multiplied with.
pub(super) fn footprint(p: &mut Circuit<'_>) {
    let lambda = p.w(Reg::EigenLambda);
    p.multiply(lambda, 16, 2);
    p.shifted_register(Reg::FootLength, 1, lambda + 16);
    p.shifted_register(Reg::FootWidth, 1, lambda + 16);
    if p.config.policy.footprint.max_probes.count_ones() != 1
        || p.config.policy.footprint.count.has_end_points()
    {
        // M over a constant that is no power of two: a multiplication with its reciprocal.
        p.multiply(Reg::FootLength, 16, 1);
    }
    p.add(Reg::FootWidth, 2);
    p.choose(Reg::FootWidth, 3, 1);
    // Six steps of a comparison with a multiple of m, and that multiple.
    let wide = p.w(Reg::FootLength).max(p.w(Reg::FootWidth)) + 14;
    let steps = log2(p.config.policy.footprint.max_probes + 1);
    p.add(wide, 2 * steps);
    p.choose(wide, 2, steps);
    p.normalise(Reg::FootWidth);
    p.table(p.config.tables.log2, false);
    p.register(Reg::FootLod, 1);
    p.choose(Reg::FootLod, 3, 1);
    p.multiply(lambda, Reg::EigenAxis, 2);
    if p.config.policy.footprint.count.has_end_points() {
        p.multiply(Reg::FootWidth, 28, 1);
        p.add(38, 1);
    }
    p.shifted_register(Reg::FootLine, 2, lambda + p.w(Reg::EigenAxis));
    p.parts.rom_bits += u64::from(p.config.policy.footprint.max_probes) * 29;
    p.multiply(Reg::FootLine, 29, 2);
    p.register(Reg::FootStep, 2);
}

/// One probe a cycle.
pub(super) fn address(p: &mut Circuit<'_>, planar: bool) {
    let (u, s) = (p.w(Reg::AddrU), p.w(Reg::AddrS));
    p.multiply(Reg::FootStep, log2(p.config.policy.footprint.max_probes) + 2, 2);
    p.add(u + 8, 2);
    p.register(Reg::AddrU, 1);
    p.register(Reg::AddrV, 1);
    if planar {
        // Repeat, clamp and mirror of a coordinate.
        p.add(u, 2);
        p.choose(u, 3, 2);
    } else {
        face_choice(p, u);
        p.reciprocal(u);
        p.multiply(u, PORT, 2);
        p.choose(u, 2, 2);
    }
    // Two levels: (u + 1)·N/2 − ½ of both coordinates, clamped.
    p.multiply(u, 16, 4);
    p.add(s, 8);
    p.register(Reg::AddrS, 4);
    p.choose(s, 3, 4);
}

/// One trilinear probe a cycle: eight texels decoded, weighed and added up.
pub(super) fn filter(p: &mut Circuit<'_>) {
    let (weight, texel) = (
        p.config.policy.filter.weight_bits,
        p.config.policy.texel.int + p.config.policy.texel.frac,
    );
    match p.config.policy.texel.format {
        TexelFormat::Half => p.shift(texel, 32, 24),
        TexelFormat::Rgb9e5 => p.shift(texel, 32, 24),
        TexelFormat::Unorm8 => p.multiply(8, texel, 24),
        TexelFormat::Q => {}
    }
    p.multiply(weight + 1, weight + 1, 8);
    p.add(weight + 1, 8);
    p.multiply(texel, 2 * weight + 1, 24);
    let sum = texel + 2 * weight;
    p.add(sum + 2, 18);
    let bilinear = p.config.format(Reg::FilterBilinear);
    let narrowed = bilinear.frac < p.config.policy.texel.frac + 2 * weight
        || bilinear.int < p.config.policy.texel.int;
    let kept = if narrowed {
        p.register(Reg::FilterBilinear, 6);
        bilinear.width()
    } else {
        sum
    };
    let mut total = kept + log2(p.config.policy.footprint.max_probes);
    if p.config.policy.footprint.weights != Weights::Box {
        p.multiply(kept, p.config.policy.footprint.weight_bits + 1, 6);
        total = kept + p.config.policy.footprint.weight_bits + 1;
        // One row a count, one weight a probe of half of the line.
        let half = (1..=p.config.policy.footprint.max_probes)
            .map(|n| u64::from(n.div_ceil(2)))
            .sum::<u64>();
        p.parts.rom_bits += half * u64::from(p.config.policy.footprint.weight_bits + 1);
    }
    p.add(total, 6);
    p.store(total, 6);
    // Once a fragment: between two levels, over the count, the output.
    p.multiply(total, p.config.policy.filter.lod_bits + 1, 6);
    p.add(total + p.config.policy.filter.lod_bits, 3);
    if p.config.policy.footprint.weights == Weights::Box && p.config.policy.footprint.max_probes > 1
    {
        // An exact quotient: a product with the rounded-up reciprocal, as wide as the dividend, and the rest.
        let dividend = total + p.config.policy.filter.lod_bits;
        p.parts.rom_bits += u64::from(p.config.policy.footprint.max_probes) * u64::from(dividend);
        p.multiply(dividend, dividend, 3);
        p.multiply(dividend, log2(p.config.policy.footprint.max_probes) + 1, 3);
        p.add(dividend, 3);
    }
    p.register(Reg::FilterColor, 3);
}
