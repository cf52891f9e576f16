//! The bound of the colour that `unit show` prints, against the exact filter at the unit's own addresses.

use rtl_model::fx::Flags;
use rtl_model::regs::Reg;
use rtl_model::stages::{Sink, address};
use rtl_model::texture::Texels;
use rtl_model::unit::{Results, State};
use rtl_model::{Stage, Texture, Unit};
use support::reference::{Draw, Random, scaled};
use tapline::engine::encode::{needs, texture, words};
use tapline::engine::probe::{RtlProbe, rtl, to_f64};
use tapline::fragment::Fragment;
use tapline::unit::UnitSpec;
use tapline::unit::bounds::bounds;

/// The colour of a fragment from its own addresses and LOD, in doubles, with unrounded weights.
fn own_color(spec: &UnitSpec, unit: &Unit, texture: &Texture, f: &Fragment) -> ([f64; 3], f64) {
    let config = &spec.config;
    let frac = |reg: Reg| i32::try_from(config.format(reg).frac).expect("a short register");
    let mut state = State::<1>::default();
    let (mut out, mut tap) = (Results::default(), RtlProbe::default());
    unit.one(&words(f), Some(Stage::Address), None, &mut state, &mut out, &mut tap);
    let request = unit.request(&state, 0);
    let cfg = address::Cfg::new(config).expect("the unit was built");
    let lod = to_f64(request.lod, frac(Reg::FootLod));
    let last = texture.levels.len() - 1;
    let first = (0..=last).rev().find(|l| as_f64(*l) <= lod).unwrap_or(0);
    let part = if first == last { 0.0 } else { lod - as_f64(first) };
    let Texels::Wide(texels) = &texture.texels else {
        panic!("a widened texture");
    };
    let texel_frac = i32::try_from(config.policy.texel.frac).expect("at most 24");
    let (mut color, mut most) = ([0.0; 3], 0.0f64);
    for k in 0..request.line.count {
        let mut probe = RtlProbe::default();
        let mut sink = Sink { lane: 0, flags: &mut Flags::default(), tap: &mut probe };
        let at = address::address(&cfg, &unit.roms, &request.line, k, &mut sink);
        for (l, share) in [(first, 1.0 - part), ((first + 1).min(last), part)] {
            let level = &texture.levels[l];
            let size = level.size.map(|n| i64::try_from(n).expect("a small face"));
            let taps = cfg.taps(&at, size, 0, &mut sink);
            let s = [0, 1].map(|i| sink.tap.get(Reg::AddrS)[i].value());
            let [x, y] = s.map(|s| s - s.floor());
            for (i, j, weight) in [
                (0, 0, (1.0 - x) * (1.0 - y)),
                (1, 0, x * (1.0 - y)),
                (0, 1, (1.0 - x) * y),
                (1, 1, x * y),
            ] {
                let [tx, ty] = taps.corner;
                let texel = texels.get(level.index(at.face, tx + i, ty + j));
                for (c, sum) in color.iter_mut().enumerate() {
                    let value = to_f64(texel.map_or(0, |t| t[c]), texel_frac);
                    most = most.max(value);
                    *sum += share * weight * value / to_f64(request.line.count, 0);
                }
            }
        }
    }
    (color, most)
}

/// The fragment with its derivatives scaled and without its local frame.
fn smaller(f: Fragment, by: f64) -> Fragment {
    Fragment {
        dv_dx: scaled(by, f.dv_dx),
        dv_dy: scaled(by, f.dv_dy),
        dn_dx: scaled(by, f.dn_dx),
        dn_dy: scaled(by, f.dn_dy),
        h: None,
        ..f
    }
}

fn as_f64(n: usize) -> f64 {
    f64::from(u32::try_from(n).unwrap_or(u32::MAX))
}

#[test]
fn colours_are_within_their_bound_of_the_exact_filter_at_their_own_addresses() {
    let mut narrow = UnitSpec::default();
    narrow.config.policy.filter.weight_bits = 5;
    narrow.config.policy.filter.lod_bits = 4;
    narrow.config.formats[Reg::FilterColor.index()].frac = 12;
    let map = support::reference::noise(64, 8);
    for spec in [UnitSpec::default(), narrow] {
        let rows = bounds(&spec.config);
        let row = |name: &str| rows.iter().find(|b| b.name == name).expect("a row").bound;
        let texture = texture(&spec.config, &map).expect("a texture");
        let wide = texture.widened();
        let mut random = Random::new(21);
        let (mut worst, mut count) = (0.0f64, 0);
        for index in 0..600 {
            let f = smaller(random.fragment(), [1.0, 0.125, 1.0 / 64.0][index % 3]);
            let unit = Unit::new(&spec.config, needs(&f), 64).expect("a unit");
            let mut probe = RtlProbe::default();
            rtl(&unit, &spec.config, &f, Some(&texture), &mut probe);
            let (exact, most) = own_color(&spec, &unit, &wide, &f);
            let bound = row("filter.color, factor") * most + row("filter.color, absolute");
            for (code, want) in probe.get(Reg::FilterColor).iter().zip(exact) {
                // 64 sums of four terms in doubles.
                let error = (code.value() - want).abs();
                assert!(error <= bound + 1e-13, "{error:e} > {bound:e}: {f:?}");
                worst = worst.max(error / bound);
                count += 1;
            }
        }
        eprintln!("filter.color: bound is {:.1} times the worst error of {count}", 1.0 / worst);
        assert!(worst > 1.0 / 64.0, "a vacuous bound");
    }
}
