//! The bounds that `unit show` prints hold for fragments and units at random, and none is vacuous.

use std::collections::BTreeMap;

use proptest::prelude::*;
use rtl_model::Unit;
use rtl_model::fx::Rounding;
use rtl_model::policy::{Axis, Minor};
use rtl_model::regs::Reg;
use rtl_model::unit::Needs;
use support::reference::{Draw, Random, cross, dot, scaled, sum};
use support::rtl::Traced;
use tapline::engine::encode::needs;
use tapline::engine::probe::{RtlProbe, rtl};
use tapline::fragment::Fragment;
use tapline::reference::{Env, Prepared, env};
use tapline::settings::Settings;
use tapline::unit::bounds::{Bound, bounds};
use tapline::unit::{ReferenceAxis, UnitSpec};

const FACE: u32 = 256;

/// Length of a vector.
fn norm(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

/// Worst |error| over its bound, by row.
#[derive(Default)]
struct Worst(BTreeMap<&'static str, f64>);

struct Case<'a> {
    rows: &'a [Bound],
    worst: &'a mut Worst,
}

impl Case<'_> {
    fn row(&self, name: &str) -> Option<f64> {
        self.rows.iter().find(|b| b.name == name).map(|b| b.bound)
    }

    /// Notes `error` against `bound`, which belongs to row `name`.
    fn check(&mut self, name: &'static str, error: f64, bound: f64, about: &Fragment) {
        assert!(error <= bound, "{name}: {error:e} > {bound:e} for {about:?}");
        if bound > 0.0 {
            let worst = self.worst.0.entry(name).or_default();
            *worst = worst.max(error / bound);
        }
    }
}

/// A fragment of ordinary magnitude: its derivatives as small as a pixel's or as large as a few.
fn fragment(random: &mut Random, index: usize) -> Fragment {
    let mut f = random.fragment();
    let small = [1.0, 0.125, 1.0 / 64.0][index % 3];
    let by = |a: [f64; 3]| scaled(small, a);
    f.dv_dx = by(f.dv_dx);
    f.dv_dy = by(f.dv_dy);
    f.dn_dx = by(f.dn_dx);
    f.dn_dy = by(f.dn_dy);
    // Rank-one footprints put λ2 to the test.
    if index.is_multiple_of(5) {
        f.dv_dy = scaled(0.5, f.dv_dx);
        f.dn_dy = scaled(0.5, f.dn_dx);
    }
    // Small lengths within one power of two: every fraction bit of the ports counts.
    f.h = f.h.filter(|_| index % 2 == 1);
    if let Some(h) = f.h {
        f.bump = Some([2.0 * random.signed(), 2.0 * random.signed()]);
        f.rough = Some([random.signed(), random.signed(), random.signed()]);
        let c = cross(h, f.n);
        if dot(c, c) < 0.26 * dot(h, h) * dot(f.n, f.n) {
            return fragment(random, index);
        }
    }
    f
}

fn modified_normal(f: &Fragment) -> [f64; 3] {
    let (Some(h), Some([b1, b2])) = (f.h, f.bump) else {
        return f.n;
    };
    let [e1, e2] = support::reference::frame(f.n, h);
    sum(f.n, sum(scaled(b1, e1), scaled(b2, e2)))
}

/// a, b, c of D Dᵀ + B Bᵀ of the integer model's own codes: 60-bit products, exact to 2⁻⁵².
fn own_k(t: &Traced) -> [f64; 3] {
    let mut k = [0.0; 3];
    for reg in [Reg::JacD, Reg::RoughB] {
        let m = t.values(reg);
        if let [ux, uy, vx, vy] = m[..] {
            k[0] += ux * ux + uy * uy;
            k[1] += ux * vx + uy * vy;
            k[2] += vx * vx + vy * vy;
        }
    }
    k
}

/// λ1, λ2 with λ2 from the determinant where that is the better one.
fn own_lambda(t: &Traced, [a, b, c]: [f64; 3]) -> [f64; 2] {
    let root = ((c - a) * (c - a) + 4.0 * b * b).sqrt();
    let major = f64::midpoint(a + c, root).sqrt();
    // det(D Dᵀ) is (det D)², without cancellation; with roughness the plain form is good enough.
    let minor = match t.values(Reg::JacD)[..] {
        [p, q, r, s] if t.probe.get(Reg::RoughB).is_empty() => (p * s - q * r).abs() / major,
        _ => (0.5 * (a + c - root)).max(0.0).sqrt(),
    };
    [major, minor]
}

fn direction_rows(case: &mut Case<'_>, f: &Fragment, t: &Traced, exact: &Env) {
    let bumped = f.h.is_some();
    let names = if bumped {
        ["cube_face.u, v, bumped", "jacobian.d, bumped, factor", "jacobian.d, bumped, absolute"]
    } else {
        ["cube_face.u, v", "jacobian.d, factor", "jacobian.d, absolute"]
    };
    let (Some(uv), Some(factor), Some(absolute)) =
        (case.row(names[0]), case.row(names[1]), case.row(names[2]))
    else {
        return;
    };
    for (reg, want) in [(Reg::FaceU, exact.u), (Reg::FaceV, exact.v)] {
        case.check(names[0], (t.value(reg, 0) - want).abs(), uv, f);
    }
    let n = norm(modified_normal(f));
    for col in 0..2 {
        let (dv, dn) = [(f.dv_dx, f.dn_dx), (f.dv_dy, f.dn_dy)][col];
        let terms = norm(dv) / norm(f.v) + 2.0 * norm(dn) / n;
        for row in 0..2 {
            let error = (t.value(Reg::JacD, 2 * row + col) - exact.d[row][col]).abs();
            case.check(names[1], error, factor * terms + absolute, f);
        }
    }
}

/// B' of the reference: what K holds beyond D Dᵀ, entry by entry, in doubles.
fn factor_rows(case: &mut Case<'_>, f: &Fragment, t: &Traced, theirs: &[f64]) {
    let (Some(factor), Some(absolute), Some(d)) =
        (case.row("roughness.b, factor"), case.row("roughness.b, absolute"), f.rough)
    else {
        return;
    };
    for (i, want) in theirs.iter().enumerate() {
        let size = if i % 2 == 0 { d[0].abs() } else { d[1].abs() + d[2].abs() };
        let error = (t.value(Reg::RoughB, i) - want).abs();
        case.check("roughness.b, factor", error, factor * size + absolute, f);
    }
}

fn ellipse_rows(case: &mut Case<'_>, f: &Fragment, t: &Traced, spec: &UnitSpec) {
    let k = own_k(t);
    let trace = k[0] + k[2];
    if let Some(share) = case.row("covariance.k") {
        for (i, want) in k.iter().enumerate() {
            // The doubles' own error on top: 8 roundings.
            let slack = 8.0 * f64::EPSILON * trace;
            case.check(
                "covariance.k",
                (t.value(Reg::CovK, i) - want).abs(),
                share * trace + slack,
                f,
            );
        }
    }
    let lambda = own_lambda(t, k);
    for (i, name) in ["eigen.lambda 1", "eigen.lambda 2"].into_iter().enumerate() {
        if let Some(share) = case.row(name) {
            // √(8·2⁻⁵²) where the plain form cancels.
            let slack = if i == 1 && f.rough.is_some() { 5e-8 } else { 1e-14 };
            let error = (t.value(Reg::EigenLambda, i) - lambda[i]).abs();
            case.check(name, error, (share + slack) * lambda[0], f);
        }
    }
    if let Some(bound) = case.row("footprint.lod") {
        let cap = 1.0 / f64::from(spec.config.policy.footprint.max_probes);
        let half = f64::from(FACE) / 2.0;
        let m = (lambda[1] * half).max(1.0).max(lambda[0] * half * cap);
        let lod = libm::log2(m).clamp(0.0, 8.0);
        case.check("footprint.lod", (t.value(Reg::FootLod, 0) - lod).abs(), bound + 1e-6, f);
    }
    if let Some(bound) = case.row("eigen.axis") {
        let [a, b, c] = [0, 1, 2].map(|i| t.value(Reg::CovK, i));
        let isotropic = ((c - a) * (c - a) + 4.0 * b * b).sqrt() < (a + c) / 256.0;
        if isotropic {
            return;
        }
        let angle = 0.5 * libm::atan2(2.0 * b, a - c);
        let ours = libm::atan2(t.value(Reg::EigenAxis, 1), t.value(Reg::EigenAxis, 0));
        let turn = (ours - angle).rem_euclid(std::f64::consts::PI);
        let error = turn.min(std::f64::consts::PI - turn);
        case.check("eigen.axis", error, bound + 1e-12, f);
    }
}

/// K, λ against the float reference: what the error of D brings, and the stages' own on top.
fn compounded(case: &Case<'_>, f: &Fragment, t: &Traced, exact: &Env) {
    let (Some(factor), Some(absolute)) =
        (case.row("jacobian.d, factor"), case.row("jacobian.d, absolute"))
    else {
        return;
    };
    let size = exact.k[0] + exact.k[2];
    if f.h.is_some() || size == 0.0 || t.out.face != exact.face {
        return;
    }
    let mut square = 0.0;
    for (dv, dn) in [(f.dv_dx, f.dn_dx), (f.dv_dy, f.dn_dy)] {
        let terms = norm(dv) / norm(f.v) + 2.0 * norm(dn) / norm(f.n);
        let entry = factor * terms + absolute;
        square += 2.0 * entry * entry;
    }
    let eta = square.sqrt() / size.sqrt();
    let brought = 2.0 * eta + eta * eta;
    if let Some(k) = case.row("covariance.k") {
        for i in 0..3 {
            let error = (t.value(Reg::CovK, i) - exact.k[i]).abs();
            assert!(error <= (brought + k * (1.0 + brought) + 1e-9) * size, "K of {f:?}");
        }
    }
    for (i, name) in ["eigen.lambda 1", "eigen.lambda 2"].into_iter().enumerate() {
        if let Some(share) = case.row(name) {
            let turned = std::f64::consts::SQRT_2 * eta;
            let error = (t.value(Reg::EigenLambda, i) - exact.lambda[i]).abs();
            let most = turned + share * (1.0 + turned) + 1e-7;
            assert!(error <= most * exact.lambda[0], "{name} of {f:?}");
        }
    }
}

/// Runs `count` fragments through a unit and checks every row; fragments with flags are left out.
fn hold(spec: &UnitSpec, seed: u64, count: usize, worst: &mut Worst) -> usize {
    let rows = bounds(&spec.config);
    let settings: Settings = spec.settings(ReferenceAxis::Exact);
    let prepared = Prepared::new(&settings);
    let mut units: Vec<(Needs, Unit)> = Vec::new();
    let mut random = Random::new(seed);
    let mut checked = 0;
    for index in 0..count {
        let f = fragment(&mut random, index);
        let needs = needs(&f);
        if !units.iter().any(|(n, _)| *n == needs) {
            let Ok(unit) = Unit::new(&spec.config, needs, FACE) else {
                return 0;
            };
            units.push((needs, unit));
        }
        let Some((_, unit)) = units.iter().find(|(n, _)| *n == needs) else {
            return 0;
        };
        let mut probe = RtlProbe::default();
        let out = rtl(unit, &spec.config, &f, None, &mut probe);
        let t = Traced { out, probe };
        let mut theirs = tapline::engine::probe::FloatProbe::default();
        let exact = env(&prepared, &f, 256, None, &mut theirs);
        if !t.out.flags.is_empty() {
            continue;
        }
        checked += 1;
        let mut case = Case { rows: &rows, worst: &mut *worst };
        if t.out.face == exact.face {
            direction_rows(&mut case, &f, &t, &exact);
            compounded(&case, &f, &t, &exact);
            factor_rows(&mut case, &f, &t, theirs.get(Reg::RoughB));
        }
        ellipse_rows(&mut case, &f, &t, spec);
    }
    checked
}

#[test]
fn no_bound_of_the_default_unit_is_vacuous() {
    let spec = UnitSpec::default();
    let mut worst = Worst::default();
    let checked = hold(&spec, 1, 6000, &mut worst);
    assert!(checked > 5000, "{checked} fragments");
    assert!(worst.0.len() >= 10, "{:?}", worst.0.keys());
    let mut loose = Vec::new();
    for (name, share) in &worst.0 {
        eprintln!("{name}: bound is {:.1} times the worst error", 1.0 / share);
        if *share < 1.0 / 64.0 {
            loose.push(name);
        }
    }
    assert!(loose.is_empty(), "bounds above 64 times the worst error: {loose:?}");
}

/// A unit whose words, roundings, tables and λ2 rule are drawn at random around the default's.
fn random_unit(seed: u64) -> UnitSpec {
    let mut random = Random::new(seed);
    let mut spec = UnitSpec::default();
    let mut below = |n: u32| u32::try_from(random.word() % u64::from(n)).unwrap_or(0);
    for format in &mut spec.config.formats {
        let cut = below(9);
        format.frac = format.frac.saturating_sub(cut).max(4);
        let mode = Rounding::ALL.get(usize::try_from(below(8)).unwrap_or(0));
        format.rounding = mode.copied().unwrap_or(Rounding::Floor);
    }
    for table in [
        &mut spec.config.tables.recip,
        &mut spec.config.tables.rsqrt,
        &mut spec.config.tables.sqrt,
        &mut spec.config.tables.log2,
    ] {
        table.entries = 4 << below(6);
        table.order = below(3);
        table.frac = 8 + below(16);
    }
    spec.config.tables.recip.newton = below(3);
    spec.config.tables.rsqrt.newton = below(3);
    spec.config.tables.sqrt.newton = below(3);
    spec.config.tables.eigen.entries = 2 + 2 * below(40);
    spec.config.tables.eigen.order = below(2);
    spec.config.policy.footprint.max_probes = 1 + below(32);
    if below(2) == 1 {
        spec.config.policy.eigen.minor = Minor::Det;
    }
    if below(3) == 0 {
        spec.config.policy.footprint.axis = Axis::EigenExact;
    }
    spec
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 40,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn the_bounds_hold_for_units_and_fragments_at_random(seed in any::<u64>()) {
        let spec = random_unit(seed);
        let checked = hold(&spec, seed ^ 0xabcd, 400, &mut Worst::default());
        prop_assert!(checked > 200, "only {checked} of 400 fragments without a flag");
    }
}

#[test]
fn shorter_words_widen_the_bounds_they_enter() {
    let before = bounds(&UnitSpec::default().config);
    let mut spec = UnitSpec::default();
    for format in &mut spec.config.formats {
        format.frac -= 4;
    }
    let after = bounds(&spec.config);
    assert_eq!(before.len(), after.len());
    for (a, b) in before.iter().zip(&after) {
        assert!(b.bound >= a.bound, "{}: {} then {}", a.name, a.bound, b.bound);
        assert!(a.bound.is_finite() && !a.holds.is_empty());
    }
    // Policies that a row does not fit leave it out.
    spec.config.policy.footprint.axis = Axis::LongerDerivative;
    let names: Vec<&str> = bounds(&spec.config).iter().map(|b| b.name).collect();
    assert!(!names.contains(&"eigen.axis") && !names.contains(&"eigen.lambda 2"));
}

#[test]
fn tables_too_coarse_for_any_bound_have_no_row() {
    // Mantissas of two bits: each may be off by half of the number.
    let mut spec = UnitSpec::default();
    for reg in [Reg::ReflectV, Reg::ReflectN, Reg::ReflectVr] {
        spec.config.formats[reg.index()].frac = 1;
    }
    let rows = bounds(&spec.config);
    assert!(rows.iter().all(|b| b.name != "cube_face.u, v"));
    assert!(rows.iter().all(|b| b.bound.is_finite() && b.bound >= 0.0));
}
