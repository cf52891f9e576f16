//! Faces, (u, v) and probes of the integer model against the cube map's own definitions.

#![expect(
    clippy::cast_precision_loss,
    reason = "the oracle is in doubles: integers here stay below 2^53"
)]

use rtl_model::fx::{Flags, Rounding};
use rtl_model::regs::Event;
use rtl_model::stages::{Roms, Sink, address, cube_face};
use rtl_model::{Config, NoTap, Reg};
use support::model::{Record, Rng};
use tapline::cube;

#[test]
fn faces_are_chosen_and_undone_like_the_cube_maps() {
    // All directions of small integers: every tie of magnitudes is among them.
    for x in -4i64..=4 {
        for y in -4i64..=4 {
            for z in -4i64..=4 {
                let d = [x, y, z];
                let face = cube_face::select(d);
                assert_eq!(face, cube::major_face(d.map(|c| c as f64)), "{d:?}");
                let components = cube_face::components(face, d);
                assert!(components[2] >= components[0].abs().max(components[1].abs()));
                assert_eq!(cube_face::direction(face, components), d);
                if d != [0; 3] {
                    let (_, u, v) = cube::face_uv(d.map(|c| c as f64));
                    let [sc, tc, ma] = components.map(|c| c as f64);
                    assert!((sc / ma - u).abs() < 1e-15 && (tc / ma - v).abs() < 1e-15, "{d:?}");
                }
            }
        }
    }
}

/// `cube_face` of one direction given as 25-bit mantissas: (face, u, v, zero).
fn stage(config: &Config, roms: &Roms, d: [i64; 3]) -> (usize, [f64; 2], Flags) {
    let cfg = cube_face::Cfg::new(config).expect("the default");
    let mut flags = Flags::default();
    let mut sink = Sink { lane: 0, flags: &mut flags, tap: &mut Record::default() };
    let out = cube_face::cube_face(&cfg, roms, (d, 24, 0), &mut sink);
    let scale = f64::from(1u32 << 24);
    let face = usize::try_from(out.face).expect("a face");
    (face, [out.u as f64 / scale, out.v as f64 / scale], flags)
}

#[test]
fn u_and_v_lie_within_the_errors_of_their_reciprocal_and_register() {
    let config = Config::default();
    let roms = Roms::new(&config).expect("the default tables");
    let mut rng = Rng(41);
    let mut worst = 0.0f64;
    for _ in 0..100_000 {
        let mut d = [0; 3].map(|_: i64| rng.range(-(1 << 25) + 1, (1 << 25) - 1));
        let major = usize::try_from(rng.range(0, 2)).expect("an axis");
        d[major] = if rng.one_in(2) { 1 << 24 } else { (1 << 25) - 1 };
        if rng.one_in(4) {
            d[(major + 1) % 3] = d[major];
        }
        let (face, uv, flags) = stage(&config, &roms, d);
        let (want, u, v) = cube::face_uv(d.map(|c| c as f64));
        assert_eq!(face, want);
        // 1/x of 64 intervals, 16 bits, one Newton step: (2^−15 + 2^−17)²·2 + 2^−29.7 < 2^−28.4, doubled by
        // a mantissa near 2; inv_ma: ½·2^−26; the register: ½·2^−24.
        let bound = 0.5f64.powi(27) + 0.5f64.powi(26) + 0.5f64.powi(25);
        let error = (uv[0] - u).abs().max((uv[1] - v).abs());
        assert!(error <= bound, "{d:?}: {error} > {bound}");
        assert!(uv.iter().all(|c| c.abs() <= 1.0));
        assert_eq!(flags, Flags::default());
        worst = worst.max(error);
    }
    assert!(worst > 0.5f64.powi(26), "{worst}: nothing was measured");
}

#[test]
fn the_zero_direction_is_plus_z_and_flagged() {
    let config = Config::default();
    let roms = Roms::new(&config).expect("the default tables");
    let (face, uv, flags) = stage(&config, &roms, [0; 3]);
    assert_eq!((face, uv.map(f64::to_bits)), (4, [0, 0]));
    assert!(flags.has_event(Event::FaceZero));
}

#[test]
fn probes_outside_of_their_face_are_looked_up_along_their_direction() {
    let mut config = Config::default();
    config.formats[Reg::AddrU.index()].rounding = Rounding::Floor;
    config.formats[Reg::AddrV.index()].rounding = Rounding::Floor;
    let cfg = address::Cfg::new(&config).expect("the default");
    let roms = Roms::new(&config).expect("the default tables");
    let one = 1i64 << 24;
    let scale = one as f64;
    let mut rng = Rng(42);
    let (mut inside, mut outside, mut over_two_edges) = (0, 0, 0);
    for _ in 0..20_000 {
        let face = usize::try_from(rng.range(0, 5)).expect("a face");
        let center = [rng.range(-one, one), rng.range(-one, one)];
        let reach = rng.pick(&[one / 64, one, 8 * one]);
        let step = [rng.range(-reach, reach), rng.range(-reach, reach)];
        let count = rng.range(1, 64);
        let line = address::In { face, center, step, step_frac: 24, count };
        let k = rng.range(0, count - 1);
        let mut flags = Flags::default();
        let mut sink = Sink { lane: 0, flags: &mut flags, tap: &mut NoTap };
        let probe = address::address(&cfg, &roms, &line, k, &mut sink);
        let plane = [0, 1].map(|i: usize| center[i] + (2 * k + 1 - count) * step[i]);
        if plane.iter().any(|p| p.abs() >= 1 << 33) {
            assert!(flags.has(Reg::AddrU) || flags.has(Reg::AddrV));
            continue;
        }
        if plane.iter().all(|p| p.abs() <= one) {
            assert_eq!((probe.face, probe.uv), (face, plane));
            assert!(!flags.has_event(Event::AddressOtherFace));
            inside += 1;
            continue;
        }
        assert!(flags.has_event(Event::AddressOtherFace));
        outside += 1;
        over_two_edges += usize::from(plane.iter().all(|p| p.abs() > one));
        let d = cube::direction(face, plane[0] as f64 / scale, plane[1] as f64 / scale);
        let (want, u, v) = cube::face_uv(d);
        assert_eq!(probe.face, want, "{plane:?} of face {face}");
        // c/ma at 30 bits times a reciprocal off by < 2^−28.4 (of a quotient ≤ 1, doubled by a mantissa
        // near 2), then the register's floor: 2^−24.
        for (got, want) in probe.uv.into_iter().zip([u, v]) {
            let error = (got as f64 / scale - want).abs();
            assert!(error <= 0.5f64.powi(24) + 0.5f64.powi(27), "{error}");
            assert!(got.abs() <= one);
        }
    }
    assert!(inside > 2000 && outside > 2000 && over_two_edges > 500);
}

#[test]
fn probes_are_symmetric_about_the_centre_of_their_line() {
    let config = Config::default();
    let cfg = address::Cfg::new(&config).expect("the default");
    let roms = Roms::new(&config).expect("the default tables");
    for count in 1..=64 {
        let line =
            address::In { face: 2, center: [1000, -2000], step: [777, -333], step_frac: 24, count };
        for k in 0..count {
            let mut flags = Flags::default();
            let mut sink = Sink { lane: 0, flags: &mut flags, tap: &mut NoTap };
            let a = address::address(&cfg, &roms, &line, k, &mut sink).uv;
            let b = address::address(&cfg, &roms, &line, count - 1 - k, &mut sink).uv;
            assert_eq!([a[0] + b[0], a[1] + b[1]], [2000, -4000]);
        }
    }
}
