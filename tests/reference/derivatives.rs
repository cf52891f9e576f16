//! D of the float reference against finite differences, and what D may not depend on.

use support::reference::{
    Draw, Random, apply, cross, dot, frame, mirror, project, scaled, sum, unit,
};
use tapline::fragment::Fragment;
use tapline::policy::Dnmod;
use tapline::reference::{NoTap, Prepared, env};
use tapline::settings::Settings;

/// The modified normal `t` pixels along (x, y) under a policy, by its meaning rather than by formulas
/// for derivatives.
fn modified_normal(f: &Fragment, dn: [f64; 3], t: f64, dnmod: Dnmod) -> [f64; 3] {
    let moved = sum(f.n, scaled(t, dn));
    let (Some([b1, b2]), Some(h)) = (f.bump, f.h) else {
        return moved;
    };
    let offset = |[e1, e2]: [[f64; 3]; 2]| sum(scaled(b1, e1), scaled(b2, e2));
    // n turned, but as long as at the centre: its derivative is ∂n⊥.
    let turned = scaled(dot(f.n, f.n).sqrt(), unit(moved));
    match dnmod {
        Dnmod::Paper => sum(moved, offset(frame(f.n, h))),
        Dnmod::Normal => sum(turned, offset(frame(f.n, h))),
        Dnmod::Frame => sum(turned, offset(frame(turned, h))),
    }
}

/// Central difference of (u, v) on the centre's face, `step` to each side.
fn difference(
    f: &Fragment,
    [dv, dn]: [[f64; 3]; 2],
    settings: &Settings,
    face: usize,
    step: f64,
) -> [f64; 2] {
    let at = |t: f64| {
        let n_mod = modified_normal(f, dn, t, settings.policy.jacobian.dnmod);
        let d = mirror(sum(f.v, scaled(t, dv)), n_mod);
        project(face, apply(&settings.rotation, d))
    };
    let (high, low) = (at(step), at(-step));
    [0, 1].map(|i| (high[i] - low[i]) / (2.0 * step))
}

fn check_against_differences(f: &Fragment, settings: &Settings) -> (usize, f64) {
    let out = env(&Prepared::new(settings), f, 256, None, &mut NoTap);
    let mut largest = 0.0f64;
    for (column, derivatives) in [[f.dv_dx, f.dn_dx], [f.dv_dy, f.dn_dy]].into_iter().enumerate() {
        let step = 1.0 / 65536.0;
        let coarse = difference(f, derivatives, settings, out.face, step);
        let fine = difference(f, derivatives, settings, out.face, step / 2.0);
        for row in 0..2 {
            // The error of a central difference falls as step²: that of `fine` is a third of its distance
            // to `coarse`, up to step⁴. (u, v) are computed to about 100·2⁻⁵³ (some 30 operations, |d|
            // up to √3 times the major component, bumps up to 1.5 times the normal); two of them over
            // the step of 2⁻¹⁷ give 2⁻²⁸.
            let got = out.d[row][column];
            let bound = (coarse[row] - fine[row]).abs() + 1.0 / (1u64 << 28) as f64;
            assert!(
                (got - fine[row]).abs() <= bound,
                "D[{row}][{column}] = {got}, differences give {} ± {bound}: {f:?}",
                fine[row]
            );
            largest = largest.max(got.abs());
        }
    }
    (out.face, largest)
}

#[test]
fn d_is_the_derivative_of_the_reflected_direction_on_all_faces_rotations_and_policies() {
    let mut random = Random::new(1);
    let mut faces = [0; 6];
    let mut large = 0;
    for case in 0..3000 {
        let mut f = random.fragment();
        let mut settings = Settings::default().with(|p| p.jacobian.dnmod = Dnmod::ALL[case % 3]);
        if case % 2 == 0 {
            f.bump = Some([random.signed(), random.signed()]);
            // Keep clear of grazing look-ups, where third derivatives explode.
            let n_mod = modified_normal(&f, [0.0; 3], 0.0, Dnmod::Paper);
            if dot(f.v, n_mod).abs() < 0.1 {
                continue;
            }
        }
        if case % 4 < 2 {
            settings.rotation = random.rotation();
        }
        let (face, largest) = check_against_differences(&f, &settings);
        faces[face] += 1;
        large += usize::from(largest > 0.1);
    }
    assert!(faces.iter().all(|&count| count > 100), "{faces:?}");
    assert!(large > 2000, "the comparison would be vacuous: {large}");
}

#[test]
fn without_a_bump_the_three_policies_of_dnmod_agree_to_the_bit() {
    let mut random = Random::new(2);
    for _ in 0..200 {
        let f = random.fragment();
        let [a, b, c] = [Dnmod::Paper, Dnmod::Normal, Dnmod::Frame].map(|dnmod| {
            let settings = Settings::default().with(|p| p.jacobian.dnmod = dnmod);
            env(&Prepared::new(&settings), &f, 256, None, &mut NoTap)
        });
        assert_eq!((a, a), (b, c));
    }
}

/// The fragment whose normal is multiplied by a field with value 1 and gradient (gx, gy) here.
fn with_scaled_normal(f: &Fragment, value: f64, gradient: [f64; 2]) -> Fragment {
    Fragment {
        n: scaled(value, f.n),
        dn_dx: sum(scaled(value, f.dn_dx), scaled(gradient[0], f.n)),
        dn_dy: sum(scaled(value, f.dn_dy), scaled(gradient[1], f.n)),
        ..*f
    }
}

#[test]
fn errata_dn_for_dn_mod_needs_the_part_across_n_with_a_bump() {
    let mut random = Random::new(3);
    let mut worst_paper = 0.0f64;
    for case in 0..600 {
        let mut f = random.fragment();
        let dnmod = Dnmod::ALL[case % 3];
        let bump = case % 6 < 3;
        f.bump = bump.then(|| [random.signed(), random.signed()]);
        let settings = Settings::default().with(|p| p.jacobian.dnmod = dnmod);
        let prepared = Prepared::new(&settings);
        let value = 1.0 + 0.5 * random.signed();
        let g = with_scaled_normal(&f, value, [random.signed(), random.signed()]);
        let (plain, other) =
            (env(&prepared, &f, 256, None, &mut NoTap), env(&prepared, &g, 256, None, &mut NoTap));
        if plain.face != other.face {
            continue;
        }
        for (p, o) in plain.d.as_flattened().iter().zip(other.d.as_flattened()) {
            let change = (p - o).abs();
            if bump && dnmod == Dnmod::Paper {
                worst_paper = worst_paper.max(change);
            } else {
                // Inputs are rounded to 2⁻⁵³; the terms of D are below 2·(|n|²|∂v| + 2|n||v||∂n|)/|ma|,
                // with |ma| ≥ |v||n_mod|²/√3, |v|, |n| ≥ ½, |∂| ≤ √3·2.5, 1/|h × n| ≤ 5: below 2¹⁰. About
                // 2⁶ roundings of such terms on the way.
                assert!(change <= 1.0 / (1u64 << 37) as f64, "{change}: {f:?}");
            }
        }
    }
    assert!(worst_paper > 0.1, "the paper's ∂n must show: {worst_paper}");
}

#[test]
fn errata_derivative_of_v_is_minus_one_because_a_parabola_from_its_focus_has_no_d() {
    let prepared = Prepared::new(&Settings::default());
    let z0 = 256.0;
    for (x, y) in [(0.0, 0.0), (10.0, 0.0), (-100.0, 60.0), (31.0, -77.0)] {
        // The eye is the focus; all rays leave towards `out`, so that n halves the angle of v and out.
        let v = [-x, -y, -z0];
        let out = [0.0, 0.0, -1.0];
        let length = dot(v, v).sqrt();
        let n = sum(scaled(1.0 / length, v), out);
        let derivative = |dv: [f64; 3]| {
            let along = dot(v, dv) / (length * length * length);
            sum(scaled(1.0 / length, dv), scaled(-along, v))
        };
        let fragment = |sign: f64| {
            let (dv_dx, dv_dy) = ([sign, 0.0, 0.0], [0.0, sign, 0.0]);
            Fragment {
                v,
                n,
                dv_dx,
                dv_dy,
                // The surface does not change with the sign that is put in for ∂v.
                dn_dx: derivative([-1.0, 0.0, 0.0]),
                dn_dy: derivative([0.0, -1.0, 0.0]),
                h: None,
                bump: None,
                rough: None,
            }
        };
        let right = env(&prepared, &fragment(-1.0), 256, None, &mut NoTap);
        let wrong = env(&prepared, &fragment(1.0), 256, None, &mut NoTap);
        // n and ∂n above carry a few roundings of 2⁻⁵³ each (3 and 6 operations); D's terms are at most
        // 8·(|∂v|/|v| + |∂n|/|n|) ≤ 8·2/256 = 2⁻⁴ here, so D is below 2⁻⁴·16·2⁻⁵³.
        for d in right.d.as_flattened() {
            assert!(d.abs() <= 1.0 / (1u64 << 53) as f64, "{d}");
        }
        assert!(wrong.d[0][0].abs() > 1.0 / 512.0, "{:?}", wrong.d);
    }
}

#[test]
fn errata_signs_of_u_and_v_flip_on_negative_faces() {
    // Eq. 6 with u = v_y/v_x as printed gives these on ±x; the GPU's convention is another.
    let mut random = Random::new(5);
    let mut differs = [false; 2];
    let mut done = [0; 6];
    while done.iter().any(|&count| count < 50) {
        let f = random.fragment();
        let (face, _) = check_against_differences(&f, &Settings::default());
        done[face] += 1;
        if face < 2 {
            let out = env(&Prepared::new(&Settings::default()), &f, 256, None, &mut NoTap);
            let d = mirror(f.v, f.n);
            let printed = d[1] / d[0];
            differs[face] |= (out.v - printed).abs() > 0.1;
        }
    }
    assert_eq!(differs, [true, false], "v = −y/|x|: as printed only on −x");
}

#[test]
fn errata_the_matrix_of_equation_10_is_2_by_3_and_applies_to_b() {
    let mut random = Random::new(6);
    for _ in 0..100 {
        let mut f = random.fragment();
        let rough = [random.signed().abs(), random.signed(), random.signed().abs()];
        f.rough = Some(rough);
        for x in [&mut f.dv_dx, &mut f.dv_dy, &mut f.dn_dx, &mut f.dn_dy] {
            *x = [0.0; 3];
        }
        let out = env(&Prepared::new(&Settings::default()), &f, 256, None, &mut NoTap);
        let [e1, e2] = frame(f.n, f.h.unwrap());
        // M is G J_n, two rows of three; its columns by differences of unit steps of n, exactly linear
        // in the limit: take D of a fragment whose ∂n is the unit vector.
        let column = |k: usize| {
            let mut g = f;
            g.rough = None;
            g.dn_dx = [0.0; 3];
            g.dn_dx[k] = 1.0;
            let d = env(&Prepared::new(&Settings::default()), &g, 256, None, &mut NoTap).d;
            [d[0][0], d[1][0]]
        };
        let m = [column(0), column(1), column(2)];
        let times = |e: [f64; 3]| [0, 1].map(|i| (0..3).map(|k| m[k][i] * e[k]).sum::<f64>());
        let (by_e1, by_e2) = (times(e1), times(e2));
        let b: [[f64; 2]; 2] = std::array::from_fn(|i| {
            [by_e1[i] * rough[0], by_e1[i] * rough[1] + by_e2[i] * rough[2]]
        });
        let k = [
            b[0][0] * b[0][0] + b[0][1] * b[0][1],
            b[0][0] * b[1][0] + b[0][1] * b[1][1],
            b[1][0] * b[1][0] + b[1][1] * b[1][1],
        ];
        // Entries of M are below 2·3·|n||v|/|ma| ≤ 6·√3·√3·… ≤ 2⁶, |e| ≤ √3, |d| ≤ 1: the terms of K are
        // below (2⁶·2³)² = 2¹⁸, about 2⁵ roundings.
        for (got, want) in out.k.into_iter().zip(k) {
            assert!((got - want).abs() <= 2f64.powi(18 + 5 - 53), "{got} {want}");
        }
        assert!(out.k[0] + out.k[2] > 0.0);
    }
}

#[test]
fn errata_e1_is_across_the_plane_of_n_and_h_and_the_second_line_of_figure_6_is_e2() {
    use tapline::reference::{Flags, local_frame::local_frame};
    let mut random = Random::new(7);
    for _ in 0..200 {
        let f = random.fragment();
        let (n, h) = (f.n, f.h.unwrap());
        let mut flags = Flags::default();
        let got = local_frame::<f64, _>(n, h, &mut flags, &mut NoTap);
        assert!(flags.is_empty());
        let n_length = dot(n, n).sqrt();
        // Each product sums three terms below 3, over 1/|h × n| ≤ 5: 2⁵·2⁴ roundings' worth.
        let eps = 2f64.powi(9 - 53);
        assert!(dot(got.e1, n).abs() <= eps && dot(got.e1, h).abs() <= eps);
        assert!(dot(got.e2, n).abs() <= eps && dot(got.e2, got.e1).abs() <= eps);
        // e2 lies in the plane of n and h: across their cross product.
        assert!(dot(got.e2, cross(h, n)).abs() <= eps);
        // "e1·|n_I| = n_I × e1" in the paper is e2·|n_I|.
        let second = cross(n, got.e1);
        for (second, e2) in second.into_iter().zip(got.e2) {
            assert!((second - e2 * n_length).abs() <= eps);
        }
        for e in [got.e1, got.e2] {
            assert!((dot(e, e).sqrt() - n_length).abs() <= eps);
        }
    }
}

#[test]
fn wide_arithmetic_agrees_with_plain_doubles_under_powers_of_two_beyond_their_range() {
    // v, n and their derivatives scaled by powers of two change nothing but the roundings of the two
    // arithmetics. D's terms are below 2¹³ (2¹⁰ as above, ∂n_mod up to 2³·∂n under `frame`), with about
    // 2⁶ roundings on the way: 2⁻³⁴.
    let mut random = Random::new(8);
    for case in 0..300i32 {
        let mut f = random.fragment();
        f.bump = (case % 2 == 0).then(|| [random.signed(), random.signed()]);
        f.rough = (case % 3 == 0).then(|| random.vector());
        if case % 5 == 0 {
            // ∂n almost along n, down to 2⁻³⁰ of it: D all but vanishes, and K must be right all the same.
            f.bump = None;
            f.rough = None;
            f.dv_dx = [0.0; 3];
            f.dv_dy = [0.0; 3];
            let across = 2f64.powi(-(case % 31));
            f.dn_dx = sum(scaled(0.75, f.n), scaled(across, f.dn_dx));
            f.dn_dy = sum(scaled(-0.5, f.n), scaled(across, f.dn_dy));
        }
        let settings = Settings { rotation: random.rotation(), ..Settings::default() }
            .with(|p| p.jacobian.dnmod = Dnmod::ALL[usize::try_from(case).unwrap() % 3]);
        let prepared = Prepared::new(&settings);
        let plain = env(&prepared, &f, 256, None, &mut NoTap);
        for (by_v, by_n, by_h) in [(900, -900, 800), (-1000, 1000, -900), (0, -1000, 1000)] {
            let power =
                |p: i32, a: [f64; 3]| a.map(|x| x * 2f64.powi(p / 2) * 2f64.powi(p - p / 2));
            let g = Fragment {
                v: power(by_v, f.v),
                dv_dx: power(by_v, f.dv_dx),
                dv_dy: power(by_v, f.dv_dy),
                n: power(by_n, f.n),
                dn_dx: power(by_n, f.dn_dx),
                dn_dy: power(by_n, f.dn_dy),
                h: f.h.map(|h| power(by_h, h)),
                ..f
            };
            let wide = env(&prepared, &g, 256, None, &mut NoTap);
            assert_eq!(plain.face, wide.face);
            assert!(wide.flags.is_empty(), "{:?}", wide.flags);
            for (a, b) in plain.d.as_flattened().iter().zip(wide.d.as_flattened()) {
                assert!((a - b).abs() <= 2f64.powi(-34), "{a} {b}");
            }
            let trace = plain.k[0] + plain.k[2];
            assert!((plain.k[1] - wide.k[1]).abs() <= 1e-9 * trace);
            assert!((plain.lambda[0] - wide.lambda[0]).abs() <= 1e-9 * plain.lambda[0]);
            assert!(plain.probes.abs_diff(wide.probes) <= 1);
        }
    }
}
