//! Every number of a stage at an end of its range at once: products and sums as large as they get.

use tapline::conformance::cases::{Class, Place, fill};
use tapline::conformance::check::Checker;
use tapline::conformance::subject::Subject;
use tapline::conformance::{Build, Device as _, harness};
use tapline::unit::UnitSpec;

#[test]
fn corners_of_every_stage_stay_within_the_formats() {
    let spec = UnitSpec::default();
    let mut wrong = Vec::new();
    for subject in Subject::all() {
        let make = || harness(&spec, subject, Build::default()).unwrap();
        let (mut own, mut checker) =
            (make(), Checker::new(make(), subject, Build::default(), true));
        let mut input = vec![0; own.shape().input_len()];
        let mut output = vec![0; own.shape().output_len()];
        for index in 0..2048 {
            let place = Place { class: Class::Corners, level: 1, seed: 1, index };
            fill(&mut own, subject, place, &mut input);
            own.run(&input, &mut output);
            if let Some(difference) = checker.case(&input, &output) {
                wrong.push(format!("case {index}: {input:x?} => {}", difference.text()));
            }
        }
    }
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong[..4.min(wrong.len())].join("\n"));
}

#[test]
fn the_largest_sum_of_covariance_is_no_zero() {
    let spec = UnitSpec::default();
    let subject = Subject::parse("covariance").unwrap();
    let mut own = harness(&spec, subject, Build::default()).unwrap();
    let mut output = vec![0; own.shape().output_len()];
    own.run(&[-(1 << 30); 8], &mut output);
    // a = b = c = 4·2^60, which is 2^28 at the even shift of 34.
    assert_eq!(output[..3], [1 << 28; 3]);
}
