//! The first screen of `compare`: how far, from where, at what cost.

use std::io::Write;

use super::Failure;
use super::compare::Results;
use super::compare_tables::per;
use crate::base::num;
use crate::conformance::attribution::{ANGLE_TABLE, Part, WHOLE, attribute};
use crate::engine::{EngineKind, EnvJob, Job};
use crate::error::InputError;
use crate::operation::Operation;
use crate::policy::Axis;
use crate::report::metrics::{Pair, compare};
use crate::report::table::significant;
use crate::study::cost::CostModel;
use crate::unit::UnitSpec;

/// Most fragments that the attribution renders, some twenty times.
const SAMPLE: usize = 4096;

/// The RMS difference of two pictures in 8-bit steps.
fn steps(pair: &Pair) -> String {
    significant(255.0 * pair.rmse, 3)
}

/// The difference of two engines that ran.
fn pair(
    results: &Results,
    a: EngineKind,
    b: EngineKind,
    exposure: f64,
) -> Result<Option<Pair>, InputError> {
    let (Some(a), Some(b)) = (results.get(a), results.get(b)) else { return Ok(None) };
    compare(&a.picture, &b.picture, exposure).map(Some)
}

/// The answers to three questions; nothing where the integer model did not run.
pub(super) fn print(
    out: &mut impl Write,
    spec: &UnitSpec,
    job: &Job,
    results: &Results,
    exposure: f64,
) -> Result<(), Failure> {
    let Some(rtl) = results.get(EngineKind::Rtl) else { return Ok(()) };
    writeln!(
        out,
        "How far is the unit from exact? (PSNR; differences of fragments in 8-bit steps)"
    )?;
    let far = [
        (EngineKind::F64, "the same algorithm in doubles (f64)"),
        (EngineKind::Truth, "supersampled rays (truth)"),
    ];
    for (kind, name) in far {
        let Some(pair) = pair(results, EngineKind::Rtl, kind, exposure)? else { continue };
        let db = pair.psnr_db.map_or("equal".into(), |db| format!("{db:.2} dB"));
        writeln!(
            out,
            "  from {name}: {db}, RMS {}, worst {}; {} % off by more than a step",
            steps(&pair),
            significant(pair.max_lsb8, 3),
            significant(100.0 * pair.share_over_1_lsb8, 3)
        )?;
    }
    let sampled = matches!(job, Job::Env(_)) && job.fragments() > num::u64(SAMPLE);
    let sampled = if sampled { "; the first two by a sample of the fragments" } else { "" };
    writeln!(out, "Where does it come from? (RMS, and what buys it back{sampled})")?;
    let apart = |a, b| pair(results, a, b, exposure);
    sources(out, spec, job, &apart)?;
    let model = CostModel::default();
    let operation = job.operation();
    let (fragments, sheet) = (job.fragments(), model.sheet(&spec.config, operation));
    let probes = per(rtl.probes, fragments);
    let look_ups = rtl.searches.as_ref().map_or(0.0, |searches| searches.look_ups());
    writeln!(out, "What does it cost?")?;
    writeln!(
        out,
        "  a fragment: {} probes, {} texels, {} cycles; the unit: {} kGE (`tapline cost unit` by stage)",
        significant(probes, 3),
        significant(per(rtl.texels, fragments), 3),
        significant(model.cycles(operation, [probes, look_ups]), 3),
        significant(sheet.total().gates(&model.cells) / 1000.0, 4)
    )?;
    let rates = results.renderings.iter().map(|(kind, r)| {
        let rate = per(fragments, 1) / r.seconds.max(1e-9);
        format!("{} {}", kind.name(), significant(rate / 1000.0, 3))
    });
    writeln!(out, "  thousand fragments/s: {}\n", rates.collect::<Vec<_>>().join(", "))?;
    Ok(())
}

/// Fewer fragments of a job, evenly spread.
fn sample(job: &EnvJob) -> EnvJob {
    let mut job = job.clone();
    let every = job.scene.fragments.len().div_ceil(SAMPLE).max(1);
    job.scene.fragments = job.scene.fragments.iter().step_by(every).copied().collect();
    job
}

/// The parts of the error, from the unit down to the truth.
fn sources(
    out: &mut impl Write,
    spec: &UnitSpec,
    job: &Job,
    pair: &dyn Fn(EngineKind, EngineKind) -> Result<Option<Pair>, InputError>,
) -> Result<(), Failure> {
    if let (Job::Env(job), Some(_)) = (job, pair(EngineKind::Rtl, EngineKind::F64)?) {
        let job = &sample(job);
        let parts = attribute(spec, job)?;
        let steps = |keep: &dyn Fn(&Part) -> bool| {
            let squares: f64 =
                parts.iter().filter(|p| keep(p)).map(|part| part.rmse * part.rmse).sum();
            significant(255.0 * squares.sqrt(), 3)
        };
        let all = |part: &Part| part.name == WHOLE;
        let table = |part: &Part| part.name == ANGLE_TABLE;
        if spec.config.policy.footprint.axis == Axis::EigenTable {
            writeln!(out, "  angle table      {}{}", steps(&table), finer(spec, job)?)?;
        }
        writeln!(
            out,
            "  word lengths     {}: registers.*; `tapline budget --attribution SCENE` has each stage",
            steps(&|part| !all(part) && !table(part))
        )?;
    } else if let Some(pair) = pair(EngineKind::Rtl, EngineKind::F64)? {
        writeln!(
            out,
            "  words and tables {}: registers.* and tables.*, see --registers",
            steps(&pair)
        )?;
    }
    if let Some(pair) = pair(EngineKind::F64, EngineKind::Ewa)? {
        writeln!(
            out,
            "  probes on a line {}: footprint.max_probes, .weights, .policy (f64 against ewa, a Gaussian of the ellipse)",
            steps(&pair)
        )?;
    }
    if let Some(pair) = pair(EngineKind::Ewa, EngineKind::Truth)? {
        writeln!(
            out,
            "  linearisation    {}: no knob (ewa against truth: an ellipse for the true footprint)",
            steps(&pair)
        )?;
    }
    Ok(())
}

/// What an angle table of twice the entries leaves of its own error, and its price.
fn finer(spec: &UnitSpec, job: &EnvJob) -> Result<String, InputError> {
    let entries = spec.config.tables.eigen.entries;
    let Ok(finer) = spec.clone().with(&format!("eigen.entries={}", 2 * entries)) else {
        return Ok(": eigen.entries has its most".into());
    };
    let model = CostModel::default();
    let operation = Operation::Env(job.needs());
    let kilo_gates =
        |spec: &UnitSpec| model.sheet(&spec.config, operation).total().gates(&model.cells) / 1000.0;
    let price = significant(kilo_gates(&finer) - kilo_gates(spec), 3);
    let left = attribute(&finer, job)?.into_iter().find(|part| part.name == ANGLE_TABLE);
    let left = left.map_or("-".into(), |part| significant(255.0 * part.rmse, 3));
    Ok(format!(": eigen.entries={} leaves {left} for {price} kGE", 2 * entries))
}
