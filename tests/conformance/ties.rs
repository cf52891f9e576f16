//! Vectors tell the ways to round a tie from each other.

use tapline::conformance::subject::Subject;
use tapline::conformance::{Build, Device as _, harness};
use tapline::operation::{Needs, Operation};
use tapline::unit::UnitSpec;
use tapline::vectors;

/// Registers of ENV for which the level-1 vectors do not tell another rounding of ties from half-even.
const NOT_TOLD: [&str; 7] = [
    // The table's entries have the register's own format: nothing is rounded.
    "eigen.axis",
    // Exact by default: 24 fraction bits of a texel and 16 of its weights are the register's 40.
    "filter.bilinear",
    // No case comes to a tie that tells; none was searched for.
    "footprint.lod",
    "address.u",
    "address.v",
    "roughness.b",
    "reflect.n_dot_n",
];

#[test]
fn vectors_of_every_stage_tell_the_roundings_of_ties_apart() {
    let unit = UnitSpec::default();
    let mut missed = Vec::new();
    let mut told = 0;
    for stage in Operation::Env(Needs { bump: true, rough: true }).stages() {
        let model = harness(&unit, Subject::Stage(stage), Build::default()).unwrap();
        for reg in model.shape().outputs.iter().filter_map(|field| field.meaning.register()) {
            for rounding in ["half-up", "half-down", "half-odd"] {
                let set = format!("registers.{reg}.rounding={rounding}");
                let other = unit.clone().with(&set).unwrap();
                let mut device = harness(&other, Subject::Stage(stage), Build::default()).unwrap();
                let outputs = device.shape().output_len();
                let judged = vectors(&unit, stage.name(), 1).unwrap().judge(&mut |input| {
                    let mut output = vec![0; outputs];
                    device.run(input, &mut output);
                    output
                });
                if judged.wrong > 0 {
                    told += 1;
                } else {
                    missed.push(reg.to_string());
                }
            }
        }
    }
    let unknown: Vec<_> = missed.iter().filter(|reg| !NOT_TOLD.contains(&reg.as_str())).collect();
    assert!(unknown.is_empty(), "{unknown:?}");
    assert!(told > 100, "{told}");
}
