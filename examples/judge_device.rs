//! A device against the integer model, bit by bit.
//!
//! The device here is the model of another unit: its angle table has 30 entries instead of 32, as if a ROM had been
//! filled with the wrong one. Put your simulator in its place: a closure from the numbers of a case to its outputs.
//!
//!     cargo run --release --example judge_device

use tapline::conformance::Device as _;
use tapline::conformance::subject::Subject;
use tapline::conformance::{Build, harness};
use tapline::error::InputError;
use tapline::{Unit, vectors};

fn main() -> Result<(), InputError> {
    let unit = Unit::default();
    for entries in [32, 30] {
        let other = Unit::default().with(&format!("eigen.entries={entries}"))?;
        let mut device = harness(&other, Subject::parse("eigen")?, Build::default())?;
        let outputs = device.shape().output_len();
        let judged = vectors(&unit, "eigen", 1)?.judge(&mut |input| {
            let mut output = vec![0; outputs];
            device.run(input, &mut output);
            output
        });
        println!("{entries} entries: {} of {} cases wrong", judged.wrong, judged.cases);
        if let Some(first) = judged.first {
            println!("    first: {}", first.text());
        }
    }
    Ok(())
}
