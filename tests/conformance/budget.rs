//! Budgets: no bound is exceeded, on the default unit none is vacuous, and random units keep theirs.

use rtl_model::fx::Rounding;
use tapline::base::random::Random;
use tapline::conformance::budget::{Row, Verdict, registers};
use tapline::unit::UnitSpec;

fn named(rows: &[Row], verdict: Verdict) -> Vec<String> {
    rows.iter()
        .filter(|r| r.verdict() == verdict)
        .map(|r| format!("{}.{}: {} of {}", r.stage.name(), r.name, r.worst, r.bound))
        .collect()
}

#[test]
fn every_register_of_the_default_unit_has_a_bound_that_holds_and_is_not_vacuous() {
    let rows = registers(&UnitSpec::default(), 60, 1, &|_| ()).unwrap();
    assert!(rows.len() > 90, "{} registers", rows.len());
    assert_eq!(named(&rows, Verdict::Exceeded), Vec::<String>::new());
    assert_eq!(named(&rows, Verdict::Vacuous), Vec::<String>::new());
    // Addresses and bilinear sums of the default unit round nothing.
    assert_eq!(named(&rows, Verdict::Exact).len(), 3);
}

/// Words, roundings and tables at random around the default's; `None` where the model refuses them.
fn random_unit(seed: u64) -> UnitSpec {
    let mut random = Random::of_case(seed, 0, 0);
    let mut spec = UnitSpec::default();
    let mut below = |n: u64| u32::try_from(random.below(n)).unwrap();
    for format in &mut spec.config.formats {
        let cut = below(7);
        format.frac = format.frac.saturating_sub(cut).max(6);
        format.rounding = Rounding::ALL[usize::try_from(below(8)).unwrap()];
    }
    let tables = &mut spec.config.tables;
    for table in [&mut tables.recip, &mut tables.rsqrt, &mut tables.sqrt, &mut tables.log2] {
        (table.entries, table.order, table.frac) = (8 << below(6), below(3), 10 + below(16));
    }
    for table in [&mut tables.recip, &mut tables.rsqrt, &mut tables.sqrt] {
        table.newton = below(3);
    }
    tables.eigen.entries = 2 + 2 * below(40);
    spec.config.policy.footprint.max_probes = 1 + below(20);
    spec
}

#[test]
fn the_budgets_hold_on_twenty_units_at_random() {
    let mut failures = Vec::new();
    let mut units = 0;
    for seed in 0.. {
        let spec = random_unit(seed);
        // Some combinations of words leave the model's integers.
        let Ok(rows) = registers(&spec, 6, seed, &|_| ()) else {
            continue;
        };
        assert!(rows.len() > 90);
        for row in named(&rows, Verdict::Exceeded) {
            failures.push(format!("unit {seed}: {row}"));
        }
        units += 1;
        if units == 20 {
            break;
        }
        assert!(seed < 100, "too few units are legal");
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
