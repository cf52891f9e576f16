//! `surface_footprint`: the reference against identities, the integer model against the reference.

use rtl_model::regs::Reg;
use tapline::engine::tex::TexRtl;
use tapline::fragment::{Tangents, TexFragment};
use tapline::policy::{ConeGradient, ConeRules};
use tapline::unit::UnitSpec;

use super::{Random, by_f64, by_rtl, cross, dot, length, request, unit};

const SIZE: [usize; 2] = [512, 256];

fn spec(gradient: ConeGradient) -> UnitSpec {
    let mut spec = UnitSpec::default();
    spec.config.policy.cone.gradient = gradient;
    spec
}

/// Geometry whose D, N and tangents are neither parallel nor grazing beyond the cap.
fn geometry(numbers: &mut Random) -> TexFragment {
    loop {
        let (d, n) = (numbers.vector(), numbers.vector());
        if length(d) < 0.1 || length(n) < 0.1 {
            continue;
        }
        let n_unit = unit(n);
        // Tangents in the plane of N, at any angle to each other.
        let in_plane = |v: [f64; 3]| {
            let along = dot(v, n_unit);
            [0, 1, 2].map(|i| v[i] - along * n_unit[i])
        };
        let (s, t) = (in_plane(numbers.vector()), in_plane(numbers.vector()));
        if length(s) > 0.1 && length(t) > 0.1 && length(cross(unit(s), unit(t))) > 0.05 {
            let scale = 4.0;
            return request(d, n, s.map(|c| scale * c), t.map(|c| c / scale));
        }
    }
}

#[test]
fn the_footprint_is_the_cut_of_the_cone_with_the_plane() {
    let mut numbers = Random::new(1);
    let spec = spec(ConeGradient::Gram);
    for _ in 0..2000 {
        let fragment = geometry(&mut numbers);
        let width = 2.0 * numbers.signed();
        let found = by_f64(&spec, &fragment, width, SIZE);
        let (d, n) = (unit(fragment.d), unit(fragment.n));
        let cosine = dot(d, n).abs().max(1.0 / 16.0);
        let [x, y] = found.dp;
        let w = width.abs();
        // Lengths, directions and right angles; a dozen roundings each.
        assert!((length(x) * cosine / w - 1.0).abs() < 1e-12);
        assert!((length(y) / w - 1.0).abs() < 1e-12);
        for (a, b) in [(x, n), (y, n), (x, y), (y, d)] {
            assert!(dot(a, b).abs() <= 1e-12 * length(a) * length(b));
        }
        // Gram: S·∂s + T·∂t is dP itself, as dP lies in their plane.
        let Tangents::Surface { dp_ds, dp_dt } = fragment.tangents else {
            unreachable!("geometry makes surfaces");
        };
        for (dp, dd) in found.dp.into_iter().zip(found.dd) {
            let terms = length(dp_ds) * dd[0].abs() + length(dp_dt) * dd[1].abs();
            for c in 0..3 {
                let back = dp_ds[c] * dd[0] + dp_dt[c] * dd[1];
                assert!((back - dp[c]).abs() <= 1e-12 * terms.max(length(dp)));
            }
        }
        // D counts texels.
        assert!((found.d[0][1] - found.dd[1][0] * 512.0).abs() <= 1e-12 * found.d[0][1].abs());
        assert!((found.d[1][0] - found.dd[0][1] * 256.0).abs() <= 1e-12 * found.d[1][0].abs());
    }
}

#[test]
fn the_notes_dot_products_are_exact_for_orthogonal_derivatives_only() {
    let (d, n) = ([0.3, -1.0, 0.2], [0.0, 1.0, 0.0]);
    let both = |dp_dt: [f64; 3]| {
        [ConeGradient::Otk, ConeGradient::Gram]
            .map(|g| by_f64(&spec(g), &request(d, n, [4.0, 0.0, 0.0], dp_dt), 0.1, SIZE).dd)
    };
    let [otk, gram] = both([0.0, 0.0, 2.0]);
    for (a, b) in otk.as_flattened().iter().zip(gram.as_flattened()) {
        assert!((a - b).abs() <= 1e-15);
    }
    let [otk, gram] = both([2.0, 0.0, 2.0]);
    let off = (otk[0][0] - gram[0][0]).abs() / gram[0][0].abs();
    assert!(off > 0.1, "{otk:?} {gram:?}");
}

#[test]
fn a_triangles_gradients_are_those_of_its_derivatives() {
    let mut numbers = Random::new(5);
    for _ in 0..500 {
        let corners = [0, 1, 2].map(|_| numbers.vector());
        let st = [0, 1, 2].map(|_| [numbers.signed(), numbers.signed()]);
        let edge = |i: usize| [0, 1, 2].map(|c| corners[i][c] - corners[0][c]);
        let edges = [edge(1), edge(2)];
        let n = cross(edges[0], edges[1]);
        let change = [1, 2].map(|i: usize| [st[i][0] - st[0][0], st[i][1] - st[0][1]]);
        let area = change[0][0] * change[1][1] - change[1][0] * change[0][1];
        if length(n) < 0.05 || area.abs() < 0.05 {
            continue;
        }
        let tangents = Tangents::Triangle { edges, st: change };
        let triangle = TexFragment { d: numbers.vector(), n, tangents, st: [0.0; 2] };
        let (dp_ds, dp_dt) = tangents.derivatives();
        let surface = request(triangle.d, n, dp_ds, dp_dt);
        let spec = UnitSpec::default();
        let (a, b) = (by_f64(&spec, &triangle, 0.3, SIZE), by_f64(&spec, &surface, 0.3, SIZE));
        for (x, y) in a.dd.as_flattened().iter().zip(b.dd.as_flattened()) {
            let size = a.dd.as_flattened().iter().fold(0.0f64, |m, v| m.max(v.abs()));
            assert!((x - y).abs() <= 1e-11 * size, "{a:?} {b:?}");
        }
        // The integer model has a circuit of its own for triangles.
        let engine = TexRtl::sized(&spec, [512, 256]).unwrap();
        compare(&engine, &triangle, 0.3125, ConeGradient::Gram);
    }
}

/// ddx and ddy of the integer model against the reference with the same width.
///
/// Every unit vector has 24 fraction bits: mantissas of D and N are off by ½ LSB of 25 bits and their reciprocal length by
/// one, so that a component of the unit vector is off by at most 2 LSB and D × N by 2·2·2 = 8 in length √3·…, under 14.
/// Divided by |D × N| = sin θ that is the error of both directions, with 2 LSB more for their own roundings. The cosine is
/// off by 2·2·√3 + ½ < 8 LSB, which counts by its reciprocal. ∇ is a quotient of products of mantissas of 25 bits: each
/// cross product loses up to 2 LSB of its factors' product, which is 1/sin φ of the result, φ between the tangents;
/// three such products and their roundings come to 16/sin φ. A triangle forms them for its edges and adds its products
/// of differences of s and t: the sum of their magnitudes counts.
fn compare(engine: &TexRtl, fragment: &TexFragment, width: f64, gradient: ConeGradient) -> f64 {
    let mut spec = UnitSpec::default();
    spec.config.policy.cone.gradient = gradient;
    let (probe, _, _) = by_rtl(engine, fragment, width);
    let there = by_f64(&spec, fragment, width, SIZE);
    let (d, n) = (unit(fragment.d), unit(fragment.n));
    let sine = length(cross(d, n));
    let cosine = dot(d, n).abs().max(1.0 / 16.0);
    let (tangents, growth) = match fragment.tangents {
        Tangents::Surface { dp_ds, dp_dt } => ([dp_ds, dp_dt], 1.0),
        Tangents::Triangle { edges, .. } => {
            let most = there.dd.as_flattened().iter().fold(0.0f64, |m, v| m.max(v.abs()));
            let sum = terms(fragment, &there.dp);
            (edges, sum / most)
        }
    };
    let between = length(cross(unit(tangents[0]), unit(tangents[1])));
    let lsb = 1.0 / f64::from(1u32 << 24);
    let relative = lsb * (14.0 / sine + 8.0 / cosine + 16.0 / between + 8.0) * growth;
    let mut worst = 0.0f64;
    let regs = [Reg::SurfDdx, Reg::SurfDdy];
    for (j, (reg, dd)) in regs.into_iter().zip(there.dd).enumerate() {
        // A gradient's length times dP's: what an error of a direction turns into.
        let (dp_ds, dp_dt) = fragment.tangents.derivatives();
        let plane = cross(dp_ds, dp_dt);
        let square = dot(plane, plane);
        let grads = [length(cross(dp_dt, plane)) / square, length(cross(plane, dp_ds)) / square];
        for i in 0..2 {
            let got = probe.get(reg)[i].value();
            // ddx and ddy share an exponent: half of its LSB, too.
            let shared = there.dd.as_flattened().iter().fold(0.0f64, |m, v| m.max(v.abs()));
            let scale = match gradient {
                ConeGradient::Gram => length(there.dp[j]) * grads[i],
                ConeGradient::Otk => {
                    length(there.dp[j]) / [length(tangents[0]), length(tangents[1])][i]
                }
            };
            let bound = relative * scale + 2.0 * lsb * shared;
            let error = (got - dd[i]).abs();
            assert!(error <= bound, "{reg:?} {i}: {got} {} {error} {bound}", dd[i]);
            worst = worst.max(error / bound);
        }
    }
    worst
}

/// The sum of the magnitudes of a triangle's products.
fn terms(fragment: &TexFragment, dp: &[[f64; 3]; 2]) -> f64 {
    let Tangents::Triangle { edges, st } = fragment.tangents else {
        return 0.0;
    };
    let plane = cross(edges[0], edges[1]);
    let square = dot(plane, plane);
    let grads = [length(cross(edges[1], plane)) / square, length(cross(plane, edges[0])) / square];
    let largest = length(dp[0]).max(length(dp[1]));
    let change = st.as_flattened().iter().fold(0.0f64, |m, v| m.max(v.abs()));
    largest * (grads[0] + grads[1]) * change
}

#[test]
fn the_integer_model_matches_the_reference_within_derived_bounds() {
    let mut numbers = Random::new(9);
    for gradient in [ConeGradient::Gram, ConeGradient::Otk] {
        let engine = TexRtl::sized(&spec(gradient), [512, 256]).unwrap();
        let mut worst = 0.0f64;
        for i in 0..3000 {
            let fragment = geometry(&mut numbers);
            // Widths that bf16 holds, of any power of two.
            let width = f64::from(128 + i % 128) * libm::exp2(f64::from(i % 41) - 27.0);
            worst = worst.max(compare(&engine, &fragment, width, gradient));
        }
        // The bound counts every worst case at once; the worst seen is not a hundredth of it only if it is no bound.
        assert!(worst > 0.01, "{worst}");
    }
}

#[test]
fn otk_rules_keep_the_sign_of_w_and_flatten_near_the_normal() {
    let mut spec = UnitSpec::default();
    spec.config.policy.cone.rules = ConeRules::Otk;
    let tilted = |angle: f64| {
        let d = [libm::sin(angle), -libm::cos(angle), 0.0];
        request(d, [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0])
    };
    let engine = TexRtl::sized(&spec, [64, 64]).unwrap();
    // cos 0.04 = 0.99920, cos 0.05 = 0.99875.
    let flat = by_f64(&spec, &tilted(0.04), -0.5, SIZE);
    assert!((length(flat.dp[0]) - 0.5).abs() < 1e-12 && (length(flat.dp[1]) - 0.5).abs() < 1e-12);
    let seen = by_f64(&spec, &tilted(0.05), 0.5, SIZE);
    assert!(length(seen.dp[0]) > 0.5005);
    let opposite = by_f64(&spec, &tilted(0.05), -0.5, SIZE);
    for c in 0..3 {
        assert!((seen.dp[0][c] + opposite.dp[0][c]).abs() < 1e-15);
    }
    for (angle, width) in [(0.04, -0.5), (0.05, -0.5), (0.05, 0.5), (0.7, -0.25)] {
        let (probe, _, _) = by_rtl(&engine, &tilted(angle), width);
        let there = by_f64(&spec, &tilted(angle), width, [64, 64]);
        for c in 0..3 {
            let got = probe.get(Reg::SurfDpDx)[c].value();
            // sin 0.04 magnifies the directions' errors 25 times: 14·25 + 10 LSB of 2^-24.
            assert!((got - there.dp[0][c]).abs() < 360.0 / 16_777_216.0, "{angle} {width}");
        }
    }
}

#[test]
fn any_anisotropy_cap_holds() {
    let grazing = request([1.0, -1e-6, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    for cap in [1, 2, 8, 16, 64] {
        let mut spec = UnitSpec::default();
        spec.config.policy.surface_footprint.max_anisotropy = cap;
        let engine = TexRtl::sized(&spec, [64, 64]).unwrap();
        let there = by_f64(&spec, &grazing, 0.25, [64, 64]);
        assert!((length(there.dp[0]) - 0.25 * f64::from(cap)).abs() < 1e-12);
        let (probe, _, _) = by_rtl(&engine, &grazing, 0.25);
        let got = probe.get(Reg::SurfDpDx)[0].value().abs();
        assert!((got / (0.25 * f64::from(cap)) - 1.0).abs() < 1e-6, "{cap}: {got}");
    }
}
