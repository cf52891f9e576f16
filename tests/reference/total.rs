//! Any finite input gives finite numbers, with or without a trace.

use proptest::prelude::*;
use support::reference::{Strict, assert_finite, map};
use tapline::fragment::Fragment;
use tapline::policy::{Axis, Count, Dnmod, Minor, Placement, Weights};
use tapline::reference::{Flag, NoTap, Prepared, Texture, env};
use tapline::settings::{AngleTable, Settings};

fn finite() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => any::<u64>().prop_map(f64::from_bits).prop_filter("finite", |x| x.is_finite()),
        1 => Just(0.0),
        1 => Just(-0.0),
        1 => Just(1.0),
        1 => Just(f64::MAX),
        1 => Just(f64::from_bits(1)),
        2 => -2.0..2.0,
    ]
}

fn vector() -> impl Strategy<Value = [f64; 3]> {
    [finite(), finite(), finite()]
}

prop_compose! {
    fn fragment()(
        v in vector(), n in vector(),
        d in [vector(), vector(), vector(), vector()],
        h in proptest::option::of(vector()),
        bump in proptest::option::of([finite(), finite()]),
        rough in proptest::option::of(vector()),
    ) -> Fragment {
        Fragment { v, n, dv_dx: d[0], dv_dy: d[1], dn_dx: d[2], dn_dy: d[3], h, bump, rough }
    }
}

prop_compose! {
    fn settings()(
        max_probes in 0u32..40,
        policy in (0usize..4, 0usize..3, 0usize..2, 0usize..2, 0usize..3),
        scale in finite(), rotate in any::<bool>(), rotation in [vector(), vector(), vector()],
        table in proptest::option::of((0u32..70, 0usize..2, 0u32..2)),
        probe_weight_bits in 0u32..20,
    ) -> Settings {
        let plain = Settings::default();
        Settings { roughness_scale: scale, rotation: if rotate { rotation } else { plain.rotation }, reference_table: table.map(|(entries, placement, order)| AngleTable {
                entries, placement: Placement::ALL[placement], order,
            }), ..plain }.with(|p| { p.footprint.max_probes = max_probes; p.footprint.count = Count::ALL[policy.0]; p.footprint.axis = Axis::ALL[policy.1]; p.footprint.weights = Weights::ALL[policy.2]; p.eigen.minor = Minor::ALL[policy.3]; p.jacobian.dnmod = Dnmod::ALL[policy.4]; p.footprint.weight_bits = probe_weight_bits; })
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1500))]

    #[test]
    fn every_finite_fragment_gives_finite_numbers_and_the_trace_changes_nothing(
        f in fragment(), settings in settings(), size in 1usize..20_000,
    ) {
        let prepared = Prepared::new(&settings);
        let out = env(&prepared, &f, size, None, &mut NoTap);
        assert_finite(&out);
        prop_assert!(!out.flags.contains(Flag::NonFinite));
        let traced = env(&prepared, &f, size, None, &mut Strict);
        prop_assert_eq!(out, traced);
        let cube = map(5, |face, x, y| [face, x, y].map(|t| u8::try_from(t).map_or(0.0, f32::from)));
        let texture = Texture::new(&cube);
        let seen = env(&prepared, &f, size, Some(&texture), &mut NoTap);
        assert_finite(&seen);
        for channel in tapline::reference::ewa(&seen, &texture) {
            prop_assert!(channel.is_finite());
        }
    }

    #[test]
    fn numbers_that_are_not_finite_are_replaced_and_flagged(
        mut f in fragment(), at in 0usize..3, which in 0usize..3,
    ) {
        f.v[at] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY][which];
        let out = env(&Prepared::new(&Settings::default()), &f, 64, None, &mut Strict);
        assert_finite(&out);
        prop_assert!(out.flags.contains(Flag::NonFinite));
    }
}
