//! How near the integer model's pictures are to the float reference's.
//!
//! The two bounds are the project's acceptance figures for the default unit: at least 50 dB (PSNR
//! over fragments, after sRGB, peak 1) against the reference with the exact axis, and at least 60 dB
//! where the reference takes its axis from the same angle table, which leaves the words' error alone.

use std::path::{Path, PathBuf};

use tapline::cube::CubeMap;
use tapline::engine::float::F64Engine;
use tapline::engine::{Engine, EnvJob};
use tapline::image::{LoadOptions, load_environment};
use tapline::report::metrics::compare;
use tapline::scene::SCENES;
use tapline::unit::{ReferenceAxis, UnitSpec};

/// Bound with the exact axis: it contains half a bin of a 32-entry angle table.
const EXACT_DB: f64 = 50.0;
/// Bound with the table's axis: words, roundings and the other tables.
const TABLE_DB: f64 = 60.0;

/// PSNR of rtl against f64 with either axis; identical pictures count as infinite.
fn psnr(subject: &EnvJob, spec: &UnitSpec) -> [f64; 2] {
    let ours = support::rtl::engine(spec, subject).render(subject, &|_| {}).unwrap().picture;
    let lit = ours.rgb.iter().zip(&ours.covered);
    let lit = lit.filter(|(rgb, covered)| **covered && rgb.iter().any(|c| *c > 1.0 / 64.0));
    assert!(lit.count() > 100, "{} is black", subject.scene.info.name);
    [ReferenceAxis::Exact, ReferenceAxis::Table].map(|axis| {
        let theirs = F64Engine { settings: spec.settings(axis) };
        let theirs = theirs.render(subject, &|_| {}).unwrap().picture;
        let pair = compare(&ours, &theirs, 0.0).expect("pictures of one size");
        pair.psnr_db.unwrap_or(f64::INFINITY)
    })
}

/// Fails with every case that misses a bound, in one panic.
fn hold(cases: &[(String, [f64; 2])]) {
    let mut missed = Vec::new();
    for (name, [exact, table]) in cases {
        eprintln!("{name}: {exact:.2} dB exact axis, {table:.2} dB table axis");
        if !(*exact >= EXACT_DB && *table >= TABLE_DB) {
            missed.push(format!("{name}: {exact:.2} dB, {table:.2} dB"));
        }
    }
    assert!(!cases.is_empty(), "nothing was compared");
    assert!(missed.is_empty(), "below {EXACT_DB} dB or {TABLE_DB} dB: {missed:#?}");
}

#[test]
fn every_built_in_scene_is_within_50_db_and_60_db_with_the_same_table() {
    let spec = UnitSpec::default();
    let cases: Vec<_> = SCENES
        .iter()
        .map(|info| {
            let subject = support::rtl::subject(info.name, 192, &spec);
            (info.name.to_string(), psnr(&subject, &spec))
        })
        .collect();
    hold(&cases);
}

/// Maps of the shared data; none where the folder is not there.
fn maps() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/env");
    let Ok(entries) = std::fs::read_dir(&folder) else {
        eprintln!("skipped: no shared test data at {}", folder.display());
        return Vec::new();
    };
    let mut files: Vec<PathBuf> = entries.flatten().map(|e| e.path()).collect();
    files.sort();
    files
}

#[test]
fn every_shared_map_on_sphere_and_cylinder_is_within_50_db_and_60_db() {
    let files = maps();
    if files.is_empty() {
        return;
    }
    let spec = UnitSpec::default();
    let settings = spec.settings(ReferenceAxis::Exact);
    let mut cases = Vec::new();
    for file in files {
        let map: CubeMap =
            load_environment(&file, &LoadOptions::default()).expect("a map that loads").map;
        for scene in ["sphere", "cylinder"] {
            let subject = support::rtl::subject_with(scene, 128, &settings, Some(map.clone()));
            let name = file.file_name().unwrap_or_default().to_string_lossy();
            cases.push((format!("{scene} {name}"), psnr(&subject, &spec)));
        }
    }
    hold(&cases);
}
