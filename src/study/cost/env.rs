//! Circuits of the stages that reflections use, and of the back end that all operations share.

use rtl_model::Config;
use rtl_model::TexelFormat;
use rtl_model::policy::{Axis, Dnmod, Minor, Weights};
use rtl_model::regs::Reg;

use super::gates::{PORT, Parts, log2};

/// Width of a register with its sign.
pub(super) fn w(c: &Config, reg: Reg) -> u32 {
    c.format(reg).width()
}

pub(super) fn local_frame(c: &Config) -> Parts {
    let mut p = Parts::default();
    let (n, h, cross) = (w(c, Reg::FrameN), w(c, Reg::FrameH), w(c, Reg::FrameCross));
    p.block(c, Reg::FrameN, 3, 53);
    p.block(c, Reg::FrameH, 3, 53);
    p.dot(h, n, 2, 3);
    p.block(c, Reg::FrameCross, 3, h + n + 1);
    p.dot(cross, cross, 3, 1);
    p.reciprocal_root(c, 2 * cross + 2);
    p.block(c, Reg::FrameInvLength, 1, PORT);
    p.dot(n, n, 3, 1);
    p.root(c, 2 * n + 2);
    p.shifted_register(c, Reg::FrameLength, 1, PORT);
    p.multiply(w(c, Reg::FrameLength), w(c, Reg::FrameInvLength), 1);
    p.block(c, Reg::FrameScale, 1, w(c, Reg::FrameLength) + w(c, Reg::FrameInvLength));
    p.multiply(cross, w(c, Reg::FrameScale), 3);
    p.shifted_register(c, Reg::FrameE1, 3, cross + w(c, Reg::FrameScale));
    p.dot(n, cross, 2, 3);
    p.register(c, Reg::FrameNCross, 3);
    p.multiply(w(c, Reg::FrameNCross), w(c, Reg::FrameInvLength), 3);
    p.shifted_register(c, Reg::FrameE2, 3, w(c, Reg::FrameNCross) + w(c, Reg::FrameInvLength));
    p
}

pub(super) fn bump(c: &Config) -> Parts {
    let mut p = Parts::default();
    p.shifted_register(c, Reg::BumpB, 2, 53);
    p.multiply(w(c, Reg::BumpB), w(c, Reg::FrameE1), 3);
    p.multiply(w(c, Reg::BumpB), w(c, Reg::FrameE2), 3);
    p.add(w(c, Reg::BumpN) + c.format(Reg::BumpB).frac, 6);
    p.register(c, Reg::BumpN, 3);
    p
}

pub(super) fn reflect(c: &Config, bumped: bool) -> Parts {
    let mut p = Parts::default();
    let (n, v) = (w(c, Reg::ReflectN), w(c, Reg::ReflectV));
    p.block(c, Reg::ReflectV, 3, 53);
    p.block(c, Reg::ReflectN, 3, if bumped { w(c, Reg::BumpN) } else { 53 });
    p.dot(n, v, 3, 1);
    p.register(c, Reg::ReflectNdotV, 1);
    p.dot(n, n, 3, 1);
    p.register(c, Reg::ReflectNdotN, 1);
    let (a, b) = (n + 1 + w(c, Reg::ReflectNdotV), v + w(c, Reg::ReflectNdotN));
    p.multiply(n + 1, w(c, Reg::ReflectNdotV), 3);
    p.multiply(v, w(c, Reg::ReflectNdotN), 3);
    p.add(a.max(b) + 1, 3);
    p.block(c, Reg::ReflectVr, 3, a.max(b) + 1);
    p
}

/// `looked_up` is the direction's register.
pub(super) fn cube_face(c: &Config, looked_up: Reg) -> Parts {
    let mut p = Parts::default();
    let mut d = w(c, looked_up);
    if c.rotation.is_some() {
        p.dot(d, rtl_model::config::ROTATION_FRAC + 2, 3, 3);
        p.block(c, Reg::FaceRotated, 3, d + rtl_model::config::ROTATION_FRAC + 4);
        d = w(c, Reg::FaceRotated);
    }
    face_choice(&mut p, d);
    p.reciprocal(c, d);
    p.block(c, Reg::FaceInvMa, 1, PORT);
    p.multiply(d, w(c, Reg::FaceInvMa), 2);
    for reg in [Reg::FaceU, Reg::FaceV] {
        p.shifted_register(c, reg, 1, d + w(c, Reg::FaceInvMa));
        p.choose(w(c, reg), 3, 1);
    }
    p
}

/// Three comparisons of magnitudes, then sc, tc and ma out of three components with their signs.
pub(super) fn face_choice(p: &mut Parts, d: u32) {
    p.add(d, 6);
    p.choose(d, 3, 3);
}

/// ∂n_mod, the first half of `jacobian`.
fn normal(p: &mut Parts, c: &Config, bumped: bool) {
    p.shifted_register(c, Reg::JacDnDx, 3, 53);
    p.shifted_register(c, Reg::JacDnDy, 3, 53);
    let mut dn = w(c, Reg::JacDnDx);
    if bumped && c.policy.jacobian.dnmod != Dnmod::Paper {
        let n = w(c, Reg::FrameN);
        p.dot(n, n, 3, 1);
        p.reciprocal(c, 2 * n + 2);
        p.shifted_register(c, Reg::JacInvNn, 1, PORT);
        p.dot(n, dn, 3, 2);
        p.register(c, Reg::JacNIdotDn, 2);
        p.multiply(w(c, Reg::JacNIdotDn), w(c, Reg::JacInvNn), 2);
        p.register(c, Reg::JacAlong, 2);
        p.multiply(n, w(c, Reg::JacAlong), 6);
        p.add(n + w(c, Reg::JacAlong) + 1, 6);
        p.register(c, Reg::JacDnPerp, 6);
        dn = w(c, Reg::JacDnPerp);
        if c.policy.jacobian.dnmod == Dnmod::Frame {
            frame(p, c);
        }
    }
    p.shifted_register(c, Reg::JacDnMod, 6, dn);
}

/// The frame's own derivatives: two inner products with h, a quotient, the turn, and ∂e1, ∂e2.
fn frame(p: &mut Parts, c: &Config) {
    let (n, h, e) = (w(c, Reg::FrameN), w(c, Reg::FrameH), w(c, Reg::FrameE2));
    p.dot(n, h, 3, 1);
    p.dot(e, h, 3, 1);
    p.reciprocal(c, e + h + 2);
    p.multiply(n + h, PORT, 1);
    p.dot(w(c, Reg::JacDnPerp), e, 3, 4);
    p.register(c, Reg::JacPerpDotE, 4);
    p.multiply(w(c, Reg::JacPerpDotE), w(c, Reg::JacInvNn), 4);
    p.register(c, Reg::JacTilt, 4);
    p.multiply(w(c, Reg::JacTilt), w(c, Reg::JacTurn), 2);
    p.shifted_register(c, Reg::JacTurn, 3, n + h + PORT);
    p.multiply(w(c, Reg::JacTilt), n, 12);
    p.multiply(w(c, Reg::JacTurn), e, 12);
    p.add(n + w(c, Reg::JacTilt) + 2, 12);
    p.register(c, Reg::JacDe, 12);
    p.multiply(w(c, Reg::BumpB), w(c, Reg::JacDe), 12);
    p.add(w(c, Reg::BumpB) + w(c, Reg::JacDe) + 2, 12);
}

/// Rotation of a derivative, and the numerators of its face coordinates' derivatives, of `columns` vectors.
pub(super) fn project(p: &mut Parts, c: &Config, [dv, numerator, out]: [Reg; 3], columns: u32) {
    let d = w(c, dv);
    if c.rotation.is_some() {
        p.dot(rtl_model::config::ROTATION_FRAC + 2, d, 3, 3 * columns);
        p.register(c, dv, 3 * columns);
    }
    p.choose(d, 3, 3 * columns);
    p.multiply(w(c, Reg::FaceU), d, columns);
    p.multiply(w(c, Reg::FaceV), d, columns);
    p.add(w(c, Reg::FaceU) + d + 1, 2 * columns);
    p.register(c, numerator, 2 * columns);
    p.multiply(w(c, numerator), w(c, Reg::FaceInvMa), 2 * columns);
    p.shifted_register(c, out, 2 * columns, w(c, numerator) + w(c, Reg::FaceInvMa));
}

pub(super) fn jacobian(c: &Config, bumped: bool) -> Parts {
    let mut p = Parts::default();
    p.shifted_register(c, Reg::JacDvDx, 3, 53);
    p.shifted_register(c, Reg::JacDvDy, 3, 53);
    normal(&mut p, c, bumped);
    let (n, v) = (w(c, Reg::ReflectN), w(c, Reg::ReflectV));
    let (dv, dn) = (w(c, Reg::JacDvDx), w(c, Reg::JacDnMod));
    p.dot(n, dv, 3, 2);
    p.register(c, Reg::JacNdotDv, 2);
    p.dot(v, dn, 3, 2);
    p.register(c, Reg::JacVdotDn, 2);
    p.dot(n, dn, 3, 2);
    p.register(c, Reg::JacNdotDn, 2);
    p.multiply(n + 1, w(c, Reg::JacNdotDv), 6);
    p.multiply(w(c, Reg::ReflectNdotN), dv, 6);
    p.multiply(w(c, Reg::ReflectNdotV) + 1, dn, 6);
    p.multiply(w(c, Reg::JacVdotDn), n + 1, 6);
    p.multiply(w(c, Reg::JacNdotDn), v + 1, 6);
    p.add(w(c, Reg::JacVdotDn) + n + 3, 24);
    p.register(c, Reg::JacDvr, 6);
    project(&mut p, c, [Reg::JacDvr, Reg::JacNumerator, Reg::JacD], 2);
    p
}

pub(super) fn roughness(c: &Config) -> Parts {
    let mut p = Parts::default();
    let (n, v, e) = (w(c, Reg::ReflectN), w(c, Reg::ReflectV), w(c, Reg::FrameE1));
    p.shifted_register(c, Reg::RoughD, 3, 53);
    p.multiply(w(c, Reg::RoughD), rtl_model::config::SCALE_FRAC + 4, 3);
    p.register(c, Reg::RoughScaled, 3);
    p.dot(v, e, 3, 2);
    p.register(c, Reg::RoughVdotE, 2);
    p.dot(n, e, 3, 2);
    p.register(c, Reg::RoughNdotE, 2);
    p.multiply(w(c, Reg::ReflectNdotV) + 1, e, 6);
    p.multiply(n + 1, w(c, Reg::RoughVdotE), 6);
    p.multiply(v + 1, w(c, Reg::RoughNdotE), 6);
    p.add(n + w(c, Reg::RoughVdotE) + 2, 12);
    p.register(c, Reg::RoughDvr, 6);
    project(&mut p, c, [Reg::RoughDvr, Reg::RoughNumerator, Reg::RoughE], 2);
    p.multiply(w(c, Reg::RoughE), w(c, Reg::RoughScaled), 6);
    p.add(w(c, Reg::RoughE) + w(c, Reg::RoughScaled) + 1, 2);
    p.register(c, Reg::RoughB, 4);
    p
}

/// `d` holds D.
pub(super) fn covariance(c: &Config, d: Reg, rough: bool) -> Parts {
    let mut p = Parts::default();
    let mut exact = 2 * w(c, d) + 1;
    p.dot(w(c, d), w(c, d), 2, 3);
    if rough {
        p.dot(w(c, Reg::RoughB), w(c, Reg::RoughB), 2, 3);
        exact = exact.max(2 * w(c, Reg::RoughB) + 1) + 1;
        p.add(exact, 3);
    }
    if c.policy.footprint.axis == Axis::LongerDerivative {
        // The squares are there; their sums by columns and the longest one are not.
        let columns = if rough { 4 } else { 2 };
        p.add(exact, 2 * columns);
        p.choose(2 * w(c, d), columns, 1);
        p.choose(exact, columns, 1);
    }
    p.block(c, Reg::CovK, 3, exact);
    p
}

pub(super) fn eigen(c: &Config) -> Parts {
    let mut p = Parts::default();
    let k = w(c, Reg::CovK) + 1;
    p.add(k, 1);
    p.dot(k, k, 2, 1);
    p.root(c, 2 * k + 1);
    p.shifted_register(c, Reg::EigenRoot, 1, PORT);
    p.add(k.max(w(c, Reg::EigenRoot)) + 1, 3);
    p.register(c, Reg::EigenSq, 2);
    p.root(c, w(c, Reg::EigenSq));
    if c.policy.eigen.minor == Minor::Det && c.policy.footprint.axis != Axis::LongerDerivative {
        p.dot(k, k, 2, 1);
        p.root(c, 2 * k);
        p.reciprocal(c, w(c, Reg::EigenLambda));
        p.multiply(PORT, PORT, 1);
    } else {
        p.root(c, w(c, Reg::EigenSq));
    }
    p.shifted_register(c, Reg::EigenLambda, 2, PORT);
    let axis = w(c, Reg::EigenAxis);
    match c.policy.footprint.axis {
        Axis::EigenTable => angle_table(&mut p, c, k),
        Axis::EigenExact | Axis::LongerDerivative => {
            p.dot(PORT, PORT, 2, 1);
            p.reciprocal_root(c, 2 * PORT + 1);
            p.multiply(PORT, PORT, 2);
        }
    }
    p.choose(axis, 4, 2);
    p.register(c, Reg::EigenAxis, 2);
    p
}

/// The angle by a binary search of |2b|·cos θ against |c − a|·sin θ: a pair of multipliers a step.
fn angle_table(p: &mut Parts, c: &Config, k: u32) {
    let spec = c.tables.eigen;
    // Boundaries of |2α| over 90°, two words of 31 bits each.
    let boundaries = spec.entries / 2;
    let steps = log2(boundaries + 1);
    p.multiply(k, PORT, 2 * steps);
    p.add(k + PORT, steps);
    p.rom_bits += u64::from(boundaries) * 2 * u64::from(PORT);
    p.rom_bits += u64::from(boundaries + 1) * 2 * u64::from(spec.frac + 1);
    if spec.order > 0 {
        // Its place between two entries: a quotient of two rotated components, then two interpolations.
        p.multiply(k, PORT, 4);
        p.reciprocal(c, k + PORT);
        p.multiply(PORT, PORT, 2);
        p.multiply(PORT, spec.frac + 1, 2);
        p.add(PORT, 6);
        p.rom_bits += u64::from(boundaries) * 2 * u64::from(PORT);
    }
}

/// `sizes`: for a texture whose sides are no powers of two they are multiplied with.
pub(super) fn footprint(c: &Config) -> Parts {
    let mut p = Parts::default();
    let lambda = w(c, Reg::EigenLambda);
    p.multiply(lambda, 16, 2);
    p.shifted_register(c, Reg::FootLength, 1, lambda + 16);
    p.shifted_register(c, Reg::FootWidth, 1, lambda + 16);
    if c.policy.footprint.max_probes.count_ones() != 1 || c.policy.footprint.count.has_end_points()
    {
        // M over a constant that is no power of two: a multiplication with its reciprocal.
        p.multiply(w(c, Reg::FootLength), 16, 1);
    }
    p.add(w(c, Reg::FootWidth), 2);
    p.choose(w(c, Reg::FootWidth), 3, 1);
    // Six steps of a comparison with a multiple of m, and that multiple.
    let wide = w(c, Reg::FootLength).max(w(c, Reg::FootWidth)) + 14;
    let steps = log2(c.policy.footprint.max_probes + 1);
    p.add(wide, 2 * steps);
    p.choose(wide, 2, steps);
    p.normalise(w(c, Reg::FootWidth));
    p.table(c.tables.log2, false);
    p.register(c, Reg::FootLod, 1);
    p.choose(w(c, Reg::FootLod), 3, 1);
    p.multiply(lambda, w(c, Reg::EigenAxis), 2);
    if c.policy.footprint.count.has_end_points() {
        p.multiply(w(c, Reg::FootWidth), 28, 1);
        p.add(38, 1);
    }
    p.shifted_register(c, Reg::FootLine, 2, lambda + w(c, Reg::EigenAxis));
    p.rom_bits += u64::from(c.policy.footprint.max_probes) * 29;
    p.multiply(w(c, Reg::FootLine), 29, 2);
    p.register(c, Reg::FootStep, 2);
    p
}

/// One probe a cycle.
pub(super) fn address(c: &Config, planar: bool) -> Parts {
    let mut p = Parts::default();
    let (u, s) = (w(c, Reg::AddrU), w(c, Reg::AddrS));
    p.multiply(w(c, Reg::FootStep), log2(c.policy.footprint.max_probes) + 2, 2);
    p.add(u + 8, 2);
    p.register(c, Reg::AddrU, 1);
    p.register(c, Reg::AddrV, 1);
    if planar {
        // Repeat, clamp and mirror of a coordinate.
        p.add(u, 2);
        p.choose(u, 3, 2);
    } else {
        face_choice(&mut p, u);
        p.reciprocal(c, u);
        p.multiply(u, PORT, 2);
        p.choose(u, 2, 2);
    }
    // Two levels: (u + 1)·N/2 − ½ of both coordinates, clamped.
    p.multiply(u, 16, 4);
    p.add(s, 8);
    p.register(c, Reg::AddrS, 4);
    p.choose(s, 3, 4);
    p
}

/// One trilinear probe a cycle: eight texels decoded, weighed and added up.
pub(super) fn filter(c: &Config) -> Parts {
    let mut p = Parts::default();
    let (weight, texel) = (c.policy.filter.weight_bits, c.policy.texel.int + c.policy.texel.frac);
    match c.policy.texel.format {
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
    let bilinear = c.format(Reg::FilterBilinear);
    let narrowed =
        bilinear.frac < c.policy.texel.frac + 2 * weight || bilinear.int < c.policy.texel.int;
    let kept = if narrowed {
        p.register(c, Reg::FilterBilinear, 6);
        bilinear.width()
    } else {
        sum
    };
    let mut total = kept + log2(c.policy.footprint.max_probes);
    if c.policy.footprint.weights == Weights::Gaussian {
        p.multiply(kept, c.policy.footprint.weight_bits + 1, 6);
        total = kept + c.policy.footprint.weight_bits + 1;
        // One row a count, one weight a probe of half of the line.
        let half =
            (1..=c.policy.footprint.max_probes).map(|n| u64::from(n.div_ceil(2))).sum::<u64>();
        p.rom_bits += half * u64::from(c.policy.footprint.weight_bits + 1);
    }
    p.add(total, 6);
    p.register_bits += u64::from(total) * 6;
    // Once a fragment: between two levels, over the count, the output.
    p.multiply(total, c.policy.filter.lod_bits + 1, 6);
    p.add(total + c.policy.filter.lod_bits, 3);
    if c.policy.footprint.weights == Weights::Box && c.policy.footprint.max_probes > 1 {
        // An exact quotient: a product with the rounded-up reciprocal, as wide as the dividend, and the rest.
        let dividend = total + c.policy.filter.lod_bits;
        p.rom_bits += u64::from(c.policy.footprint.max_probes) * u64::from(dividend);
        p.multiply(dividend, dividend, 3);
        p.multiply(dividend, log2(c.policy.footprint.max_probes) + 1, 3);
        p.add(dividend, 3);
    }
    p.register(c, Reg::FilterColor, 3);
    p
}
