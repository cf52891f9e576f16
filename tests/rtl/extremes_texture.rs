//! Extremes behind the footprint on the integer model: addresses, texels, faces of any size.
#![expect(
    clippy::float_cmp,
    clippy::unwrap_used,
    reason = "registers are exact; a test stops at the first thing that is not as it should be"
)]

use rtl_model::regs::Reg;
use rtl_model::stages::{Roms, Sink, address};
use rtl_model::unit::{Results, State};
use rtl_model::{NoTap, Unit};
use support::reference::{Draw, PLAIN, Random, map};
use support::rtl::{bound, lod, near, trace};
use tapline::conformance::extremes::straight;
use tapline::engine::encode;
use tapline::engine::probe::FloatProbe;
use tapline::fragment::Fragment;
use tapline::reference::{Prepared, env};
use tapline::unit::{ReferenceAxis, UnitSpec};

#[test]
fn extreme_a_probe_line_over_two_edges_wraps_and_keeps_a_constant() {
    let spec = UnitSpec::default();
    // λ1 = 4 about (u, v) = (0.9, −0.9) of +z along the diagonal: probes leave over +u and over −v.
    let v = [0.9, 0.9, 1.0];
    let f = Fragment { v, n: v, dv_dx: [2.0, 0.125, 0.0], dv_dy: [0.125, 2.0, 0.0], ..PLAIN };
    let constant = map(16, |_, _, _| [0.75, 0.5, 3.0]);
    let texture = encode::texture(&spec.config, &constant).unwrap();
    let long = Fragment { dv_dx: [3.0, -3.0, 0.0], dv_dy: [0.0; 3], ..f };
    for (f, edges) in [(f, 0), (long, 2)] {
        let t = trace(&spec, &f, 16, Some(&texture));
        assert_eq!(t.values(Reg::FilterColor), [0.75, 0.5, 3.0]);
        if edges == 2 {
            assert!(t.flagged("address.other_face"), "{:?}", t.out.flags);
            let (u, w) = (t.values(Reg::AddrU), t.values(Reg::AddrV));
            let over = |x: &[f64]| x.iter().any(|x| *x > 1.0) || x.iter().any(|x| *x < -1.0);
            assert!(over(&u) && over(&w), "u {u:?}, v {w:?}");
            assert!(t.out.probes > 8);
            // The same plane positions as the float reference's.
            let mut theirs = FloatProbe::default();
            let settings = spec.settings(ReferenceAxis::Table);
            env(&Prepared::new(&settings), &f, 16, None, &mut theirs);
            let (tu, tv) = (theirs.get(Reg::AddrU), theirs.get(Reg::AddrV));
            assert_eq!((tu.len(), tv.len()), (u.len(), w.len()));
            // |λ1| < 8: u, v, the line's and the axis' words, λ1's relative error.
            let slack = bound("cube_face.u, v") + 8.0 * (bound("eigen.lambda 1") + 1e-4);
            for (a, b) in u.iter().zip(tu).chain(w.iter().zip(tv)) {
                near(*a, *b, slack);
            }
        }
    }
}

#[test]
fn extreme_faces_of_one_texel_and_of_sizes_that_are_no_power_of_two() {
    let spec = UnitSpec::default();
    let mut random = Random::new(5);
    for size in [1u32, 3, 5, 6, 100] {
        let n = usize::try_from(size).unwrap();
        let constant = map(n, |_, _, _| [0.25, 1.5, 65504.0]);
        let texture = encode::texture(&spec.config, &constant).unwrap();
        let last = f64::from(size.ilog2());
        assert_eq!(constant.levels.len(), usize::try_from(size.ilog2()).unwrap() + 1);
        let mut widest = 0.0f64;
        for _ in 0..100 {
            let f = random.fragment();
            let t = trace(&spec, &f, size, Some(&texture));
            assert_eq!(t.values(Reg::FilterColor), [0.25, 1.5, 65504.0]);
            assert!(lod(&t) <= last);
            widest = widest.max(lod(&t));
        }
        assert_eq!(widest, last, "the chain's end is reached");
    }
}

#[test]
fn extreme_faces_of_16384_texels_have_15_levels_and_exact_addresses() {
    let spec = UnitSpec::default();
    let t = trace(&spec, &straight([[2.0, 0.0], [0.0, 0.0]]), 16384, None);
    assert_eq!((t.out.probes, lod(&t)), (16, 10.0));
    let t = trace(&spec, &straight([[60.0, 0.0], [0.0, 60.0]]), 16384, None);
    assert_eq!((t.out.probes, lod(&t)), (1, 14.0));
    assert!(t.out.flags.is_empty(), "{:?}", t.out.flags);
    // Addresses without texels: u = k·2⁻¹² lies on a whole number of 16.8 codes.
    let config = &spec.config;
    let f = straight([[2.0, 0.0], [0.0, 0.0]]);
    let unit = Unit::new(config, encode::needs(&f), 16384).unwrap();
    let mut out = Results::<1>::default();
    let mut state = State::<1>::default();
    unit.one(&encode::words(&f), None, None, &mut state, &mut out, &mut NoTap);
    let line = unit.request(&state, 0).line;
    let cfg = address::Cfg::new(config).unwrap();
    let roms = Roms::new(config).unwrap();
    for k in 0..16 {
        let mut sink = Sink { lane: 0, flags: &mut out.flags[0], tap: &mut NoTap };
        let probe = address::address(&cfg, &roms, &line, k, &mut sink);
        let taps = cfg.taps(&probe, [16384; 2], 0, &mut sink);
        // (u + 1)/2·N − ½ with u = ((k + ½)/16 − ½)·2: 1024k + 511.5, give or take λ1's last bits.
        let column = f64::from(u32::try_from(taps.corner[0]).unwrap()) - 1.0;
        let s = column + f64::from(u32::try_from(taps.weight[0]).unwrap()) / 256.0;
        let slack =
            16384.0 * bound("eigen.lambda 1") + 2.0 / 256.0 + 16384.0 * libm::ldexp(1.0, -22);
        near(s, 1024.0 * f64::from(u32::try_from(k).unwrap()) + 511.5, slack);
        assert_eq!(probe.face, 4);
    }
    assert!(out.flags[0].is_empty());
}

#[cfg(feature = "files")]
#[test]
fn extreme_texels_are_cleaned_counted_and_kept_to_the_bit() {
    use support::reference::plain;
    use tapline::cube::{CubeLevel, CubeMap};
    use tapline::image::Cleaned;

    let spec = UnitSpec::default();
    let tiny = libm::ldexpf(1.0, -24);
    let mut samples = [65504.0, tiny, -1.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -0.0];
    let raw = samples;
    let mut cleaned = Cleaned::default();
    cleaned.clean(&mut samples);
    assert_eq!(samples, [65504.0, tiny, 0.0, 0.0, 65504.0, 0.0, 0.0]);
    assert_eq!((cleaned.nan, cleaned.inf, cleaned.negative), (1, 2, 1));
    // Cleaned or not, the unit's memory holds the same, and the colour is the texel.
    for (raw, clean) in raw.into_iter().zip(samples) {
        for texel in [raw, clean] {
            let level = CubeLevel { size: 1, texels: vec![[texel; 3]; 6] };
            let map = CubeMap { levels: vec![level] };
            let texture = encode::texture(&spec.config, &map).unwrap();
            let t = trace(&spec, &plain([0.3, -0.2, 1.0]), 1, Some(&texture));
            assert_eq!(t.values(Reg::FilterColor), [f64::from(clean); 3]);
            assert!(!t.out.flags.iter().any(|f| f.contains("filter")));
        }
    }
}
