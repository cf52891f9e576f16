//! Mutation test of the judges: a copy of the unit with one rounding, one sign or one table entry changed, as data.

use tapline::conformance::cases::{Class, Place, fill};
use tapline::conformance::check::{Checker, Difference};
use tapline::conformance::field::registers;
use tapline::conformance::subject::Subject;
use tapline::conformance::{Build, Device, Harness, harness};
use tapline::stage::Stage;
use tapline::unit::{UnitSpec, file};

const CASES: u64 = 60;

/// Ordinary inputs of a subject.
fn inputs(subject: Subject) -> Vec<Vec<i64>> {
    let mut own = harness(&UnitSpec::default(), subject, Build::default()).unwrap();
    (0..CASES)
        .map(|index| {
            let place = Place { class: Class::Ordinary, level: 1, seed: 5, index };
            let mut input = vec![0; own.shape().input_len()];
            fill(&mut own, subject, place, &mut input);
            input
        })
        .collect()
}

/// The first difference that a judge of the default unit finds in a device.
fn caught(subject: Subject, device: &mut dyn Device, exact: bool) -> Option<Difference> {
    caught_by(&UnitSpec::default(), subject, device, exact)
}

/// The first difference that a judge of a unit finds in a device.
fn caught_by(
    spec: &UnitSpec,
    subject: Subject,
    device: &mut dyn Device,
    exact: bool,
) -> Option<Difference> {
    let own = harness(spec, subject, Build::default()).unwrap();
    let mut judge = Checker::new(own, subject, Build::default(), exact);
    let mut output = vec![0; device.shape().output_len()];
    inputs(subject).iter().find_map(|input| {
        device.run(input, &mut output);
        judge.case(input, &output)
    })
}

/// The operation that a stage belongs to.
fn operation(stage: Stage) -> Subject {
    match stage {
        Stage::Hit => Subject::Hit,
        Stage::SurfaceFootprint => Subject::Tex,
        Stage::RayCone => Subject::Stage(stage),
        Stage::LocalFrame
        | Stage::Bump
        | Stage::Reflect
        | Stage::CubeFace
        | Stage::Jacobian
        | Stage::Roughness
        | Stage::Covariance
        | Stage::Eigen
        | Stage::Footprint
        | Stage::Address
        | Stage::Filter => Subject::Env,
    }
}

/// The default unit with some paths set.
fn unit(sets: &[String]) -> UnitSpec {
    file::load(None, sets).unwrap().0
}

#[test]
fn one_rounding_changed_is_caught_and_located_in_every_stage_by_both_judges() {
    let mut failures = Vec::new();
    for stage in Stage::ALL {
        let subject = operation(stage);
        let changes: Vec<(String, &str)> = if stage == Stage::RayCone {
            vec![("cone.rounding=\"truncate\"".into(), "angle")]
        } else {
            registers(stage)
                .map(|reg| {
                    let info = reg.info();
                    let path = format!("registers.{reg}.rounding=\"floor\"");
                    (path, info.name)
                })
                .collect()
        };
        let mut located = [0; 2];
        for (change, name) in changes {
            let mut device =
                harness(&unit(std::slice::from_ref(&change)), subject, Build::default()).unwrap();
            for (k, exact) in [false, true].into_iter().enumerate() {
                // A register that rounds nothing in this unit has no wrong rounding.
                let Some(found) = caught(subject, &mut device, exact) else {
                    continue;
                };
                let field = found.field.rsplit('.').next().unwrap();
                // Distances are rounded in memory: what is read of them shows it.
                let name = if name == "distance" { "radius" } else { name };
                if found.stage != stage || (exact && field != name) {
                    failures.push(format!("{change}: {} {:?}", exact, found));
                }
                located[k] += 1;
            }
        }
        if located.contains(&0) {
            failures.push(format!("{}: nothing caught: {located:?}", stage.name()));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// A device that turns the sign of one number of its outputs.
struct Turned {
    own: Harness,
    at: usize,
}

impl Device for Turned {
    fn shape(&self) -> &tapline::conformance::field::Shape {
        self.own.shape()
    }

    fn run(&mut self, input: &[i64], output: &mut [i64]) {
        self.own.run(input, output);
        output[self.at] = -output[self.at];
    }
}

#[test]
fn one_sign_changed_is_caught_and_located_at_every_signed_number() {
    use tapline::conformance::field::Meaning;
    let mut failures = Vec::new();
    for subject in [Subject::Env, Subject::Hit, Subject::Tex] {
        let shape =
            harness(&UnitSpec::default(), subject, Build::default()).unwrap().shape().clone();
        let mut at = 0;
        for field in &shape.outputs {
            let code = matches!(field.meaning, Meaning::Code(_) | Meaning::Mantissa(_));
            let mut device = Turned {
                own: harness(&UnitSpec::default(), subject, Build::default()).unwrap(),
                at,
            };
            at += field.components;
            if !(code && field.signed) {
                continue;
            }
            let alive = inputs(subject).iter().any(|input| {
                let mut output = vec![0; shape.output_len()];
                device.run(input, &mut output);
                output[device.at] != 0
            });
            let found = caught(subject, &mut device, false);
            let right = |f: &Difference| f.stage == field.stage && f.field == field.name;
            if alive != found.as_ref().is_some_and(right) {
                failures.push(format!("{}: {alive} {found:?}", field.name));
            }
            let exact = caught(subject, &mut device, true);
            // What a trace shows of the last step alone has no formula of its own.
            let unjudged =
                ["hit.inv_radius", "hit.inv_span", "hit.quotient", "hit.inv_normal", "hit.cosine"];
            let located = exact.as_ref().is_some_and(|f| f.stage == field.stage);
            if alive && !located && !unjudged.contains(&field.name.as_str()) {
                failures.push(format!("{} by exact arithmetic: {exact:?}", field.name));
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn one_table_entry_off_by_an_lsb_is_caught_where_the_table_is_read_first() {
    let build = Build::default();
    // Without the Newton steps, which square an entry's error out of sight.
    let mut paths = ["recip", "rsqrt", "sqrt"].map(|t| format!("tables.{t}.newton=0")).to_vec();
    // An entry of log2 has more bits than the LOD.
    paths.push("registers.footprint.lod.frac=16".into());
    let spec = unit(&paths);
    for (table, stages) in [
        ("recip", [Stage::CubeFace, Stage::Jacobian]),
        ("rsqrt", [Stage::LocalFrame, Stage::LocalFrame]),
        ("sqrt", [Stage::LocalFrame, Stage::Eigen]),
        ("log2", [Stage::Footprint, Stage::Footprint]),
        ("angle", [Stage::Eigen, Stage::Eigen]),
    ] {
        let mut found = 0;
        // Some entries of each: a Newton step may hide an LSB of one.
        for entry in 0..12 {
            let mut device = harness(&spec, Subject::Env, build).unwrap();
            let roms = device.roms().unwrap();
            let values = match table {
                "recip" => &mut roms.recip.values,
                "rsqrt" => &mut roms.rsqrt.values,
                "sqrt" => &mut roms.sqrt.values,
                "log2" => &mut roms.log2.values,
                _ => {
                    roms.angle.angles[entry][1] += 1;
                    &mut roms.log2.values
                }
            };
            if table != "angle" {
                values[5 * entry] += 1;
            }
            if let Some(difference) = caught_by(&spec, Subject::Env, &mut device, false) {
                assert!(stages.contains(&difference.stage), "{table}: {difference:?}");
                found += 1;
            }
        }
        assert!(found > 0, "{table}: no entry was caught");
    }
}

#[test]
fn the_unit_itself_is_right_by_both_judges() {
    for subject in Subject::all() {
        let mut device = harness(&UnitSpec::default(), subject, Build::default()).unwrap();
        for exact in [false, true] {
            let found = caught(subject, &mut device, exact);
            assert_eq!(found, None, "{}", subject.name());
        }
    }
}
