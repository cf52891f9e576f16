//! Axes, angle table and probe count of the float reference.
#![expect(clippy::float_cmp, reason = "what is exact by construction is compared exactly")]

use support::reference::{Draw, Random, plain};
use tapline::policy::{Axis, Count, FootprintPolicy, Minor, Placement};
use tapline::reference::angle::Angles;
use tapline::reference::eigen::{Axes, eigen};
use tapline::reference::footprint::{Chain, Footprint, footprint};
use tapline::reference::weights::spreads;
use tapline::reference::{Flags, NoTap, Prepared, env};
use tapline::settings::{AngleTable, Settings};

fn axes(k: [f64; 3], minor: Minor) -> Axes<f64> {
    eigen(k, [None; 2], (Axis::EigenExact, minor), None, &mut NoTap)
}

fn probes(lambda: [f64; 2], count: Count, max_probes: u32) -> Footprint<f64> {
    let chain = Chain { size: 256, levels: 9 };
    let policy = FootprintPolicy { count, max_probes, ..FootprintPolicy::default() };
    footprint(
        lambda,
        [1.0, 0.0],
        chain,
        (&policy, &spreads(&policy)),
        &mut Flags::default(),
        &mut NoTap,
    )
}

#[test]
fn errata_r1_is_the_major_axis_when_c_is_less_than_a() {
    assert_eq!(axes([1.0, 0.0, 4.0], Minor::Paper).axis, [0.0, 1.0]);
    assert_eq!(axes([4.0, 0.0, 1.0], Minor::Paper).axis, [1.0, 0.0]);
}

#[test]
fn extreme_k_isotropic_has_equal_axes_along_u_and_one_probe() {
    for minor in [Minor::Paper, Minor::Det] {
        let got = axes([0.0625, 0.0, 0.0625], minor);
        assert_eq!((got.lambda, got.axis), ([0.25, 0.25], [1.0, 0.0]));
    }
    assert_eq!(probes([0.25, 0.25], Count::Ceil, 16).probes, 1);
}

#[test]
fn extreme_a_equal_to_c_with_b_points_to_a_diagonal_of_its_sign() {
    // λ² = a ± b = 4 and 2 (exact sums); the axis is 1/√2 twice, to one rounding.
    for b in [1.0, -1.0] {
        let got = axes([3.0, b, 3.0], Minor::Paper);
        assert_eq!(got.lambda, [2.0, 2f64.sqrt()]);
        assert!((got.axis[0] - 0.5f64.sqrt()).abs() <= f64::EPSILON);
        assert_eq!(got.axis[1], got.axis[0] * b);
    }
}

#[test]
fn extreme_axis_ratio_of_a_million_has_the_right_length_and_width_after_clamping() {
    // K = R diag(1, 1e-12) Rᵀ at 30°: λ1 = 1 to 1e-9, and M/16 = 8 texels stands in for λ2.
    let (c, s) = (0.75f64.sqrt(), 0.5);
    let (l1, l2) = (1.0, 1e-12);
    let k = [c * c * l1 + s * s * l2, c * s * (l1 - l2), s * s * l1 + c * c * l2];
    for minor in [Minor::Paper, Minor::Det] {
        let got = axes(k, minor);
        assert!((got.lambda[0] - 1.0).abs() <= 1e-9);
        let footprint = probes(got.lambda, Count::Ceil, 16);
        assert_eq!(footprint.probes, 16);
        assert!((footprint.lod - 3.0).abs() <= 1e-9 * 2.0);
    }
}

#[test]
fn extreme_angles_one_ulp_beside_a_table_boundary_take_the_entries_beside_it() {
    for placement in Placement::ALL.iter().copied() {
        let entries = 32;
        let angles = Angles::new(AngleTable { entries, placement, order: 0 });
        let step = std::f64::consts::PI / f64::from(entries);
        for bin in 1..entries / 2 {
            let offset = match placement {
                Placement::Edges => 0.5,
                Placement::Centres => 0.0,
            };
            let boundary = (f64::from(bin) + offset - 1.0) * step;
            if boundary <= 0.0 {
                continue;
            }
            // 1e-14 rad is 2⁶ times the error of sine and cosine below 90°.
            let [below, above] = [boundary - 1e-14, boundary + 1e-14]
                .map(|x| angles.look_up([libm::cos(x), libm::sin(x)]));
            let angle = |[c, s]: [f64; 2]| libm::atan2(s, c);
            let gap = angle(above) - angle(below);
            // Entries are half a step in 2α apart; atan2 and the entries carry a few roundings.
            assert!((gap - step / 2.0).abs() <= 1e-14, "{placement:?} {bin}: {gap}");
        }
    }
}

#[test]
fn table_axis_is_within_half_a_bin_of_the_exact_one_and_exact_along_u_and_v() {
    let mut random = Random::new(13);
    for entries in [2u32, 10, 32, 64] {
        for placement in Placement::ALL.iter().copied() {
            for order in [0, 1] {
                let angles = Angles::new(AngleTable { entries, placement, order });
                for _ in 0..300 {
                    let d = [random.signed(), random.signed(), random.signed(), random.signed()];
                    let k = [
                        d[0] * d[0] + d[1] * d[1],
                        d[0] * d[2] + d[1] * d[3],
                        d[2] * d[2] + d[3] * d[3],
                    ];
                    let policy = (Axis::EigenTable, Minor::Paper);
                    let table = eigen(k, [None; 2], policy, Some(&angles), &mut NoTap).axis;
                    let exact = axes(k, Minor::Paper).axis;
                    let sine = (table[0] * exact[1] - table[1] * exact[0]).abs();
                    // Nearest: half a step of 90°/n. Between entries: never farther than a whole one.
                    let half = std::f64::consts::FRAC_PI_2 / f64::from(entries) / 2.0;
                    let reach = if order == 0 { half } else { 2.0 * half };
                    assert!(
                        sine <= libm::sin(reach) + 1e-12,
                        "{entries} {placement:?} {order}: {sine}"
                    );
                    assert!(table[0] > 0.0 || table == [0.0, 1.0]);
                }
                if placement == Placement::Edges {
                    for (k, want) in [([4.0, 0.0, 1.0], [1.0, 0.0]), ([1.0, 0.0, 4.0], [0.0, 1.0])]
                    {
                        let policy = (Axis::EigenTable, Minor::Paper);
                        let got = eigen::<f64, _>(k, [None; 2], policy, Some(&angles), &mut NoTap);
                        assert_eq!(got.axis, want);
                    }
                }
            }
        }
    }
}

#[test]
fn extreme_counts_beside_a_boundary_follow_the_rule_to_the_ulp() {
    // m = 1 texel (λ2 = 0), N/2 = 128: M = 128·λ1 exactly, M/m = M.
    let count = |m: f64, rule: Count, max: u32| probes([m / 128.0, 0.0], rule, max).probes;
    let ulp = 4.0 * f64::EPSILON;
    let edge = 3.0 + 1.0 / 256.0;
    assert_eq!(count(edge, Count::Ceil, 16), 3);
    assert_eq!(count(edge + ulp, Count::Ceil, 16), 4);
    assert_eq!(count(edge - ulp, Count::Ceil, 16), 3);
    assert_eq!(count(2.5, Count::Round, 16), 3);
    assert_eq!(count(2.5 - ulp, Count::Round, 16), 2);
    assert_eq!(count(4.0 + 1.0 / 256.0, Count::Pow2, 16), 4);
    assert_eq!(count(4.0 + 2.0 / 256.0, Count::Pow2, 16), 8);
    assert_eq!(count(1.75, Count::Feline, 16), 3);
    assert_eq!(count(1.75 - ulp, Count::Feline, 16), 2);
}

#[test]
fn extreme_max_probes_of_one_takes_one_probe_as_wide_as_the_line() {
    for rule in Count::ALL.iter().copied() {
        let got = probes([0.5, 0.0], rule, 1);
        assert_eq!((got.probes, got.lod), (1, 6.0), "{rule:?}");
    }
}

#[test]
fn every_count_fits_and_every_width_covers_the_line() {
    let mut random = Random::new(14);
    for max in 1..=64 {
        for rule in Count::ALL.iter().copied() {
            for _ in 0..50 {
                let lambda = [libm::exp(8.0 * random.signed()), libm::exp(8.0 * random.signed())];
                let got = probes(lambda, rule, max);
                assert!((1..=max).contains(&got.probes));
                if rule == Count::Pow2 {
                    assert!(got.probes.is_power_of_two());
                }
            }
        }
    }
}

/// A 2×2 symmetric eigenproblem by one Jacobi rotation, whose tangent solves t² + 2θt − 1 = 0.
fn jacobi([a, b, c]: [f64; 3]) -> ([f64; 2], [f64; 2]) {
    let (t, cos) = if b == 0.0 {
        (0.0, 1.0)
    } else {
        let theta = (c - a) / (2.0 * b);
        let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
        (t, 1.0 / (t * t + 1.0).sqrt())
    };
    let sin = t * cos;
    // Columns (cos, −sin) and (sin, cos) belong to a − tb and c + tb.
    let (first, second) = (a - t * b, c + t * b);
    if first > second { ([first, second], [cos, -sin]) } else { ([second, first], [sin, cos]) }
}

#[test]
fn eigen_agrees_with_a_jacobi_rotation() {
    let mut random = Random::new(30);
    for case in 0..2000 {
        let [a, c] = [random.signed().abs(), random.signed().abs()];
        let k = [a, random.signed() * (a * c).sqrt(), c];
        let ([major, minor], [x, y]) = jacobi(k);
        let policy = (Axis::EigenExact, tapline::policy::Minor::ALL[case % 2]);
        let got =
            tapline::reference::eigen::eigen::<f64, _>(k, [None; 2], policy, None, &mut NoTap);
        // Eight roundings of terms below a + c on both sides; λ2² under either formula likewise.
        let bound = 32.0 * f64::EPSILON * (a + c);
        assert!((got.lambda[0] * got.lambda[0] - major).abs() <= bound);
        assert!((got.lambda[1] * got.lambda[1] - minor.max(0.0)).abs() <= bound);
        // The axis moves by the error over the gap of the eigenvalues.
        let sine = got.axis[0] * y - got.axis[1] * x;
        assert!(sine.abs() <= bound / (major - minor) + 8.0 * f64::EPSILON, "{k:?}");
        assert!((got.axis[0].hypot(got.axis[1]) - 1.0).abs() <= 4.0 * f64::EPSILON);
        assert!(got.axis[0] > 0.0);
    }
}

#[test]
fn longer_derivative_takes_the_longest_column() {
    let settings = Settings::default().with(|p| p.footprint.axis = Axis::LongerDerivative);
    let mut f = plain([0.0, 0.0, 1.0]);
    // n = v: ∂v_r = ∂v·(2nnᵀ − I): D = −(∂v).
    f.dv_dx = [-0.25, 0.0, 0.0];
    f.dv_dy = [0.375, -0.5, 0.0];
    let out = env(&Prepared::new(&settings), &f, 256, None, &mut NoTap);
    let [[_, x], [_, y]] = out.d;
    assert_eq!((x.abs(), y.abs()), (0.375, 0.5));
    assert_eq!(out.lambda, [0.625, 0.25]);
    assert!((out.axis[1] / out.axis[0] - y / x).abs() <= 4.0 * f64::EPSILON && out.axis[0] > 0.0);
}

#[test]
fn errata_k_is_d_times_its_transpose() {
    let mut random = Random::new(29);
    let mut transposed_differs = 0;
    for _ in 0..200 {
        let f = random.fragment();
        let out = env(&Prepared::new(&Settings::default()), &f, 256, None, &mut NoTap);
        let [[p, q], [r, s]] = out.d;
        let det = (p * s - q * r) * (p * s - q * r);
        let condition = (out.k[0] + out.k[2]) * (out.k[0] + out.k[2]) / det;
        if condition > 1e6 {
            continue;
        }
        for step in 0..12 {
            let angle = f64::from(step) * 0.5;
            let (c, sn) = (libm::cos(angle), libm::sin(angle));
            let x = [p * c + q * sn, r * c + s * sn];
            let form = |[a, b, c]: [f64; 3]| {
                (c * x[0] * x[0] - 2.0 * b * x[0] * x[1] + a * x[1] * x[1]) / det
            };
            // Terms of the form are below `condition`, with some 32 roundings.
            let bound = 32.0 * f64::EPSILON * condition;
            assert!((form(out.k) - 1.0).abs() <= bound);
            let printed = [p * p + r * r, p * q + r * s, q * q + s * s];
            transposed_differs += usize::from((form(printed) - 1.0).abs() > 0.1);
        }
    }
    assert!(transposed_differs > 500, "{transposed_differs}");
}
