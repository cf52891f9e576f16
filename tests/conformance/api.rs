//! The facade judges and traces as the commands do.

use tapline::{Scene, Unit, trace, vectors};

#[test]
fn a_device_with_missing_outputs_is_wrong_in_every_case() {
    let unit = Unit::default();
    // All outputs that are there are right.
    let mut right = vectors(&unit, "eigen", 1).unwrap().map(|case| case.output);
    let judged = vectors(&unit, "eigen", 1).unwrap().judge(&mut |_| {
        let mut output = right.next().unwrap();
        output.pop();
        output
    });
    assert!(judged.cases > 1000 && judged.wrong == judged.cases, "{judged:?}");
    assert_eq!(judged.lengths, Some(vectors(&unit, "eigen", 1).unwrap().shape().output_len() - 1));
}

#[test]
fn vectors_that_are_cut_short_after_a_start_end() {
    let mut cases = vectors(&Unit::default(), "eigen", 1).unwrap();
    cases.nth(9);
    let mut cases = cases.with_cases(5);
    assert_eq!((cases.remaining(), cases.next()), (0, None));
}

#[test]
fn a_trace_has_the_flags_of_its_pixel() {
    // At the rim of the sphere probes leave their face; beyond it there is no request.
    let scene = Scene::built_in("sphere", [64, 64]).unwrap();
    let unit = Unit::default();
    let flags = (0..64).filter_map(|x| trace(&unit, &scene, [x, 32]).unwrap());
    assert!(flags.flat_map(|trace| trace.flags).any(|flag| flag == "address.other_face"));
    assert!(trace(&unit, &scene, [0, 0]).unwrap().is_none());
}
