//! Rules of `covariance`, `eigen` and `footprint`.

use rtl_model::fx::Overflow;
use rtl_model::regs::Reg;
use rtl_model::stages::footprint::planar_unit;

use super::Case;
use super::sheet::{Known, Sheet, real, within, zero};
use crate::base::num;
use crate::policy::{Axis, Count, Minor, Placement};
use crate::reference::real::Real;
use crate::reference::wide::Wide;

/// The larger of two.
fn larger(a: Wide, b: Wide) -> Wide {
    if a > b { a } else { b }
}

/// K = D Dᵀ + (sB')(sB')ᵀ, one even exponent for all three.
pub(super) fn covariance(s: &mut Sheet<'_>, planar: bool) {
    let d = if planar { Reg::SurfJac } else { Reg::JacD };
    let mut k = [zero(); 3];
    for reg in [d, Reg::RoughB] {
        let [ux, uy, vx, vy] = [0, 1, 2, 3].map(|i| s.value(reg, i));
        k[0] = k[0] + ux * ux + uy * uy;
        k[1] = k[1] + ux * vx + uy * vy;
        k[2] = k[2] + vx * vx + vy * vy;
    }
    let codes = s.codes(Reg::CovK);
    if codes.len() < 3 {
        return;
    }
    let width = s.config.format(Reg::CovK).magnitude_bits();
    let most = codes[0].raw.unsigned_abs().max(codes[2].raw.unsigned_abs());
    // The leading bit lies on one of the two top bits, as the exponent is even.
    let is_normal = most >> (width - 2) != 0 && most >> width == 0;
    s.mantissas(Reg::CovK, 0, k, is_normal);
}

/// λ1, λ2, the axis.
pub(super) fn eigen(s: &mut Sheet<'_>) {
    let [a, b, c] = s.vector(Reg::CovK, 0);
    let diff = c - a;
    let two_b = real(2.0) * b;
    let root = s.fixed(Reg::EigenRoot, 0, s.sqrt(diff * diff + two_b * two_b));
    let longer = s.config.policy.footprint.axis == Axis::LongerDerivative;
    if !longer {
        let half = real(0.5);
        s.fixed(Reg::EigenSq, 0, half * (a + c + root));
        s.fixed(Reg::EigenSq, 1, larger(half * (a + c - root), zero()));
    }
    for k in 0..2 {
        let exact: Known = if k == 1 && s.config.policy.eigen.minor == Minor::Det && !longer {
            let major = s.value(Reg::EigenLambda, 0);
            if major.is_zero() {
                continue;
            }
            let exact = larger(a * c - b * b, zero()).sqrt() / major;
            let share = (1.0 + s.tables.sqrt) * (1.0 + s.tables.recip) - 1.0;
            within(exact, Sheet::share(exact, share))
        } else {
            s.sqrt(s.value(Reg::EigenSq, k))
        };
        s.fixed(Reg::EigenLambda, k, exact);
    }
    match s.config.policy.footprint.axis {
        Axis::EigenTable if s.config.tables.eigen.order == 0 => table_axis(s, two_b, diff),
        Axis::EigenTable => interpolated_axis(s, two_b, diff),
        Axis::EigenExact => exact_axis(s, two_b, diff, root),
        Axis::LongerDerivative => {}
    }
}

/// The axis at the angle α of r1 = (cos α, −sin α) or r2 = (sin α, cos α), its first component not negative.
fn direction(alpha: f64, is_first: bool) -> [f64; 2] {
    let (sin, cos) = (libm::sin(alpha), libm::cos(alpha));
    let [x, y] = if is_first { [cos, -sin] } else { [sin, cos] };
    if x < 0.0 || (x == 0.0 && y < 0.0) { [-x, -y] } else { [x, y] }
}

/// Notes the axis against the nearest of some directions, each known to `slack`.
fn nearest(s: &mut Sheet<'_>, candidates: &[[f64; 2]], slack: f64) {
    let held = [0, 1].map(|i| s.value(Reg::EigenAxis, i).to_f64());
    let distance = |d: &[f64; 2]| (d[0] - held[0]).abs().max((d[1] - held[1]).abs());
    // At (0, ±1) both signs are right.
    let turned = candidates.iter().filter(|d| d[0].abs() <= slack).map(|d| [-d[0], -d[1]]);
    let best =
        candidates.iter().copied().chain(turned).min_by(|a, b| distance(a).total_cmp(&distance(b)));
    if let Some(best) = best {
        s.fixed_all(Reg::EigenAxis, 0, best.map(|x| within(real(x), real(slack))));
    }
}

/// 2^−bits.
fn power(bits: u32) -> f64 {
    libm::ldexp(1.0, -num::i32(bits))
}

/// The entry of the bin that 2α lies in; next to a boundary, whose constants have 28 bits, either of the two.
fn table_axis(s: &mut Sheet<'_>, two_b: Wide, diff: Wide) {
    if two_b.is_zero() && diff.is_zero() {
        nearest(s, &[[1.0, 0.0]], 0.0);
        return;
    }
    let spec = s.config.tables.eigen;
    let n = f64::from(spec.entries);
    let step = std::f64::consts::PI / n;
    let ratio = (two_b.abs() / larger(diff.abs(), Wide::code(1, 4000))).to_f64();
    let angle = if diff.is_zero() { std::f64::consts::FRAC_PI_2 } else { libm::atan(ratio) };
    let centred = s.config.policy.eigen.placement == Placement::Centres;
    // 2α in steps: the entry's number, from a boundary that is one or half a step above 0.
    let place = angle / step + if centred { 0.0 } else { 0.5 };
    // Boundary constants are off by 2^−29 each, doubles by less.
    let fuzz = 4.0 * power(28) / step;
    let entry = |bin: f64| if centred { bin + 0.5 } else { bin };
    let last = if centred { (n / 2.0).ceil() - 1.0 } else { (n / 2.0).floor() };
    let negative = (two_b < zero()) != (diff < zero());
    let sign = if two_b.is_zero() || !negative { 1.0 } else { -1.0 };
    let mut candidates = Vec::new();
    for bin in [(place - fuzz).floor(), (place + fuzz).floor()] {
        let alpha = sign * entry(bin.clamp(0.0, last)) * step / 2.0;
        candidates.push(direction(alpha, diff < zero()));
        if two_b.is_zero() {
            candidates.push(direction(-alpha, diff < zero()));
        }
    }
    // A finished entry has its own rounding.
    nearest(s, &candidates, power(spec.frac + 1) + 4.0 * f64::EPSILON);
}

/// The exact axis, off by the chord of a step and by the entries' roundings.
fn interpolated_axis(s: &mut Sheet<'_>, two_b: Wide, diff: Wide) {
    if two_b.is_zero() && diff.is_zero() {
        nearest(s, &[[1.0, 0.0]], 0.0);
        return;
    }
    // K may lie far outside of the doubles.
    let size = two_b.abs() + diff.abs();
    let alpha = libm::atan2((two_b / size).to_f64(), (diff / size).to_f64());
    let alpha = if diff < zero() { alpha - std::f64::consts::PI } else { alpha } / 2.0;
    let step = std::f64::consts::FRAC_PI_2 / f64::from(s.config.tables.eigen.entries);
    // Chord against arc: h²/8. Linear in tan 2α over a step of 2h instead of in α: (2h)³/(9√3)·sec² of the step, at
    // most h³ for h ≤ 45°, of a component's slope of 1. The fraction of the way: the reciprocal's error and 30 bits.
    let curve = step * step / 8.0 + step * step * step;
    let fraction = step * (s.tables.recip + 4.0 * power(28));
    let slack = curve + fraction + 2.0 * power(s.config.tables.eigen.frac + 1) + 8.0 * power(30);
    nearest(s, &[direction(alpha, diff < zero())], slack);
}

/// (|c − a| + root, 2b) normalised: components cut to 30 bits, 1/√x from its table.
fn exact_axis(s: &mut Sheet<'_>, two_b: Wide, diff: Wide, root: Wide) {
    if two_b.is_zero() && diff.is_zero() {
        nearest(s, &[[1.0, 0.0]], 0.0);
        return;
    }
    let p = diff.abs() + root;
    let [x, y] = if diff < zero() { [p, two_b] } else { [two_b, p] };
    let length = (x * x + y * y).sqrt();
    let unit = [(x / length).to_f64(), (y / length).to_f64()];
    let unit = if unit[0] < 0.0 || (unit[0] == 0.0 && unit[1] < 0.0) {
        [-unit[0], -unit[1]]
    } else {
        unit
    };
    let slack = s.tables.rsqrt + 4.0 * power(29);
    nearest(s, &[unit], slack);
}

/// M, m, LOD, count, the line and its step.
pub(super) fn footprint(s: &mut Sheet<'_>, case: &Case<'_>, size: u32, planar: bool) {
    let sizes = if planar { [size, (size / 2).max(1)] } else { [size; 2] };
    let unit = if planar { planar_unit(sizes) } else { size };
    // λ is in u, v of a cube and in texels of a texture.
    let half = if planar { 1.0 } else { f64::from(size) / 2.0 };
    let config = s.config;
    let [major, minor] = [0, 1].map(|k| s.value(Reg::EigenLambda, k));
    let length = s.fixed(Reg::FootLength, 0, major * real(half));
    let policy = &config.policy.footprint;
    let [most, of] = policy.count.most(policy.max_probes).map(f64::from);
    let cap = of / most;
    // Dividing in doubles costs 2^−52 of the quotient.
    let capped = length * real(cap);
    let exact = larger(larger(minor * real(half), capped), real(1.0));
    // The largest of three that were limited one by one: beyond the range a register that does not saturate gives any of
    // them, and that is for the bits to say.
    let saturates = matches!(
        config.format(Reg::FootWidth).overflow,
        Overflow::Saturate | Overflow::SaturateSymmetric
    );
    let inside = |x: Wide| s.is_inside(Reg::FootWidth, 0, x);
    if saturates || (inside(minor * real(half)) && inside(capped)) {
        let slack = Sheet::share(capped, 2.0 * f64::EPSILON);
        s.fixed(Reg::FootWidth, 0, within(exact, slack));
    }
    let width = s.value(Reg::FootWidth, 0);
    if width.to_f64() > 0.0 {
        let last = f64::from(sizes[0].max(sizes[1]).max(1).ilog2());
        let lod = libm::log2(width.to_f64()).clamp(0.0, last);
        let slack = s.tables.log2 + 16.0 * f64::EPSILON;
        s.fixed(Reg::FootLod, 0, within(real(lod), real(slack)));
    }
    let Some(count) = case.count() else { return };
    if case.input("count", 0).is_none() && length.to_f64() >= 0.0 && width.to_f64() > 0.0 {
        s.choice("count", count, counted(policy.count, policy.max_probes, length, width));
    }
    let axis = [0, 1].map(|k| s.value(Reg::EigenAxis, k));
    let feline = policy.count.has_end_points();
    // What a texture's λ counts in, in texels; a cube's is in u and v.
    let in_units = if planar { f64::from(unit) / 2.0 } else { 1.0 };
    for (k, axis) in axis.into_iter().enumerate() {
        let (body, slack) = if feline {
            let body = larger(major - width / real(half), zero()) * real(2.0);
            // λ1 is cut to 28 bits, at most 2^9; 2/N has 28 bits, its product is cut; all in the stage's own units.
            let own = real(2.0 * power(28) * in_units);
            (body, (real(3.0) + width) * own)
        } else {
            (major, zero())
        };
        if feline && major.to_f64() >= 512.0 {
            continue;
        }
        let line = s.fixed(Reg::FootLine, k, within(body * axis, slack * axis.abs()));
        let nominal = line / real(in_units);
        let parts = if feline { 2 * (count - 1) } else { 2 * count };
        let ratio = f64::from(unit) / f64::from(sizes[k].max(1));
        let over = (f64::from(unit - 1) / f64::from(sizes[k].max(1))).floor();
        let bits = 28.0 - if over >= 1.0 { libm::log2(over).floor() + 1.0 } else { 0.0 };
        #[expect(clippy::cast_precision_loss, reason = "at most 128 parts")]
        let exact = if parts > 0 { nominal * real(ratio) / real(parts as f64) } else { zero() };
        // The quotient's table has `bits` fraction bits.
        let slack = nominal.abs() * real(libm::exp2(-bits - 1.0));
        s.fixed(Reg::FootStep, k, within(exact, slack));
    }
}

/// The count that the rule gives for M and m as their registers hold them.
fn counted(rule: Count, max: u32, length: Wide, width: Wide) -> i64 {
    let max = i64::from(max);
    let beyond = |n: i64| {
        #[expect(clippy::cast_precision_loss, reason = "at most 64 probes")]
        let n = n as f64;
        match rule {
            Count::Ceil | Count::Pow2 => length > width * real(n + 1.0 / 256.0),
            Count::Round => length >= width * real(n + 0.5),
            Count::Feline => length >= width * real((n + 1.5) / 2.0),
        }
    };
    let plain = (1..max).find(|n| !beyond(*n)).unwrap_or(max);
    if rule == Count::Pow2 {
        let most = 1i64 << max.max(1).ilog2();
        plain.unsigned_abs().next_power_of_two().cast_signed().min(most)
    } else {
        plain
    }
}
