//! Unit files come back as they were written, in any order of keys, and their errors say where.
#![expect(
    clippy::unwrap_used,
    reason = "a test stops at the first thing that is not as it should be"
)]

use proptest::prelude::*;
use rtl_model::fx::Rounding;
use support::reference::{Draw as _, Random};
use tapline::unit::UnitSpec;
use tapline::unit::file::{from_toml, to_toml};
use tapline::unit::knobs::Value;

fn key(path: &str) -> &str {
    path.rsplit_once('.').unwrap().1
}

/// A unit in which about one knob in three has another legal value (legal by itself: the whole may be
/// refused).
fn random_unit(seed: u64) -> UnitSpec {
    let mut random = Random::new(seed);
    let mut spec = UnitSpec::default();
    let below = |random: &mut Random, n: u64| random.word() % n;
    for knob in UnitSpec::default().knobs() {
        if below(&mut random, 3) != 0 {
            continue;
        }
        let value = match &knob.value {
            Value::Integer(_) if key(&knob.path) == "entries" => {
                Value::Integer(1 << (1 + below(&mut random, 8)))
            }
            Value::Integer(_) => Value::Integer(i64::try_from(below(&mut random, 30)).unwrap()),
            Value::Float(_) => Value::Float(4.0 * random.signed().abs()),
            Value::Text(_) => {
                let all: Vec<&str> = knob.legal.split(" | ").collect();
                let pick = below(&mut random, u64::try_from(all.len()).unwrap());
                Value::Text(all[usize::try_from(pick).unwrap()].into())
            }
            Value::Numbers(_) => Value::Numbers(random.rotation().concat()),
        };
        // Some numbers are out of a knob's range; it keeps its default then.
        let _ = spec.set(&knob.path, &value);
    }
    spec
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 200,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn a_unit_file_brings_back_every_bit_of_the_unit(seed in any::<u64>()) {
        let spec = random_unit(seed);
        let text = to_toml(&spec);
        let back = from_toml("file", &text).map_err(|e| TestCaseError::fail(e.to_string()))?;
        prop_assert_eq!(&back, &spec);
        prop_assert_eq!(to_toml(&back), text);
        prop_assert_eq!(back.hash(), spec.hash());
    }
}

#[test]
fn random_units_are_not_all_alike() {
    let default = UnitSpec::default();
    let hashes: Vec<String> = (0..20).map(|seed| random_unit(seed).hash()).collect();
    for (i, hash) in hashes.iter().enumerate() {
        assert!(*hash != default.hash() && !hashes[..i].contains(hash));
    }
}

#[test]
fn a_file_may_exchange_integer_and_fraction_bits_in_any_order() {
    // 50 integer bits do not fit beside the default's fraction bits; the file's own do.
    for text in [
        "[registers.bump.b]\nint = 50\nfrac = 2\n",
        "[registers.bump.b]\nfrac = 2\nint = 50\n",
        "[registers.footprint.length]\nint = 2\nfrac = 50\n",
        "[registers.footprint.length]\nfrac = 50\nint = 2\n",
    ] {
        let spec = from_toml("file", text).map_err(|e| e.to_string());
        assert!(spec.is_ok(), "{text}: {spec:?}");
    }
}

#[test]
fn every_error_of_a_unit_file_has_file_line_and_column() {
    for (text, place, words) in [
        ("[footprint]\nmax_probes = = 3\n", "line 2, column 14", "TOML"),
        (
            "[footprint]\n\n  max_probes = 65\n",
            "line 3, column 16, footprint.max_probes",
            "1 to 64",
        ),
        (
            "[footprint]\nmax_probes = \"8\"\n",
            "line 2, column 14, footprint.max_probes",
            "whole number",
        ),
        ("[footprint]\nmax_prob = 8\n", "line 2, column 1, footprint.max_prob", "unit show"),
        ("[footprint]\naxis = \"eigen\"\n", "line 2, column 8, footprint.axis", "eigen-table"),
        ("[footprint]\naxis = true\n", "line 2, column 8, footprint.axis", "found true"),
        ("eigen.entries = 33\n", "line 1, column 17, eigen.entries", "even"),
        ("[tables.eigen]\nentries = 33\n", "line 2, column 11, tables.eigen.entries", "even"),
        ("[tables.log2]\nnewton = 1\n", "line 2, column 10, tables.log2.newton", "no Newton"),
        ("[tables]\nrecip.order = 3\n", "line 2, column 15, tables.recip.order", "0, 1 or 2"),
        ("[registers.bump.b]\nfrac = 59\n", "line 2, column 8, registers.bump.b.frac", "0 to 58"),
        (
            "[registers.bump.b]\nint = 40\nfrac = 30\n",
            "line 3, column 8, registers.bump.b.frac",
            "at most 58",
        ),
        (
            "[registers.bump.b]\nrounding = \"even\"\n",
            "line 2, column 12, registers.bump.b.rounding",
            "half-even",
        ),
        (
            "[registers.covariance.k]\noverflow = \"wrap\"\n",
            "line 2, column 12, registers.covariance.k.overflow",
            "never overflows",
        ),
        ("[registers.bump.c]\nint = 1\n", "line 2, column 1, registers.bump.c.int", "unit show"),
        (
            "[surface_footprint]\nmax_anisotropy = 0\n",
            "line 2, column 18, surface_footprint.max_anisotropy",
            "1 to 64",
        ),
        (
            "[transform]\nrotation = [1, 0, 0]\n",
            "line 2, column 12, transform.rotation",
            "nine numbers",
        ),
        ("# é\n[roughness]\nscale = \"é\" # nine\n", "line 3, column 9, roughness.scale", "0 to 8"),
        ("[roughness]\nscale = nan\n", "line 2, column 9, roughness.scale", "0 to 8"),
        ("x = 1\n", "line 1, column 1, x", "unit show"),
    ] {
        let error = from_toml("unit.toml", text).expect_err(text);
        assert_eq!(error.subject, "unit.toml", "{text}");
        assert_eq!(error.place.as_deref(), Some(place), "{text}");
        assert!(error.to_string().contains(words), "{text}: {error}");
    }
}

#[test]
fn a_knob_that_is_refused_leaves_the_unit_as_it_was() {
    let mut spec = UnitSpec::default();
    for (path, value) in [
        ("registers.footprint.length.frac", Value::Integer(50)),
        ("registers.footprint.length.int", Value::Integer(59)),
        ("footprint.max_probes", Value::Integer(0)),
        ("eigen.entries", Value::Integer(3)),
    ] {
        assert!(spec.set(path, &value).is_err(), "{path}");
        assert_eq!(spec, UnitSpec::default(), "{path}");
    }
}

#[test]
fn the_alias_of_the_angle_tables_entries_is_the_same_knob() {
    let mut spec = UnitSpec::default();
    spec.set("tables.eigen.entries", &Value::Integer(10)).unwrap();
    assert_eq!(spec.config.tables.eigen.entries, 10);
    assert_eq!(spec.get("eigen.entries"), Some(Value::Integer(10)));
    assert_eq!(spec.get("tables.eigen.entries"), Some(Value::Integer(10)));
    let file = from_toml("file", "[tables.eigen]\nentries = 10\n").unwrap();
    assert_eq!(file, from_toml("file", "[eigen]\nentries = 10\n").unwrap());
    assert_eq!(file, spec);
    // One name only in the list, so that a file never has both.
    let paths: Vec<String> = spec.knobs().into_iter().map(|k| k.path).collect();
    assert_eq!(paths.iter().filter(|p| p.contains("entries")).count(), 5);
    assert!(!paths.contains(&"tables.eigen.entries".to_string()));
}

#[test]
fn every_rounding_is_a_literal_of_every_register() {
    for knob in UnitSpec::default().knobs() {
        if knob.path.starts_with("registers.") && key(&knob.path) == "rounding" {
            for mode in Rounding::ALL {
                let mut spec = UnitSpec::default();
                spec.set(&knob.path, &Value::Text(mode.name().into())).unwrap();
                assert_eq!(spec.get(&knob.path), Some(Value::Text(mode.name().into())));
            }
        }
    }
}
