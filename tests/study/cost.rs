//! The cost model counts every register of the stages that are built, and its file reads back.

use rtl_model::regs::Reg;
use rtl_model::unit::Needs;
use tapline::operation::Operation;
use tapline::stage::Stage;
use tapline::study::cost::CostModel;
use tapline::unit::UnitSpec;
use tapline::unit::knobs::Value;

const ALL: Needs = Needs { bump: true, rough: true };

/// Units in which a register is used that is not there by default.
fn unit_with(reg: Reg) -> UnitSpec {
    let mut spec = UnitSpec::default();
    let mut set = |path: &str, value: Value| spec.set(path, &value).unwrap();
    let text = |t: &str| Value::Text(t.into());
    let is = |regs: &[Reg]| regs.contains(&reg);
    if reg == Reg::FaceRotated {
        let turn = vec![0.6, -0.8, 0.0, 0.8, 0.6, 0.0, 0.0, 0.0, 1.0];
        set("transform.rotation", Value::Numbers(turn));
    }
    if is(&[Reg::JacPerpDotE, Reg::JacTilt, Reg::JacTurn, Reg::JacDe]) {
        set("jacobian.dnmod", text("frame"));
    }
    if reg == Reg::HitHalved {
        set("hit.method", text("illinois"));
    }
    let plane = [Reg::HitNormal, Reg::HitInvNormal, Reg::HitCosine, Reg::HitInvCosine];
    if is(&plane) || is(&[Reg::HitAlong, Reg::HitSlope]) {
        set("hit.footprint", text("plane"));
    }
    if reg == Reg::FilterBilinear {
        // Exact by default.
        set("registers.filter.bilinear.frac", Value::Integer(20));
    }
    spec
}

#[test]
fn a_longer_word_of_any_register_that_is_built_costs_more() {
    let model = CostModel::default();
    for operation in [Operation::Env(ALL), Operation::Hit, Operation::Tex] {
        let mut counted = 0;
        for reg in Reg::ALL {
            let spec = unit_with(*reg);
            let sheet = model.sheet(&spec.config, operation);
            let built = sheet.stages.iter().any(|(stage, _)| *stage == reg.info().stage);
            // `jacobian` and `cube_face` of a ray have some registers of a reflection's only.
            let reflects_only = [Stage::Jacobian, Stage::CubeFace].contains(&reg.info().stage)
                && operation != Operation::Env(ALL)
                && ![
                    Reg::FaceRotated,
                    Reg::FaceInvMa,
                    Reg::FaceU,
                    Reg::FaceV,
                    Reg::JacDvr,
                    Reg::JacNumerator,
                    Reg::JacD,
                ]
                .contains(reg);
            if !built || reflects_only {
                continue;
            }
            let mut wider = spec.clone();
            wider.config.formats[reg.index()].frac += 1;
            let gates =
                |s: &UnitSpec| model.sheet(&s.config, operation).total().gates(&model.cells);
            assert!(gates(&wider) > gates(&spec), "{operation:?}: {reg:?} costs nothing");
            counted += 1;
        }
        assert!(counted > 30, "{operation:?}: only {counted} registers");
    }
}

#[test]
fn tables_probes_and_policies_that_need_more_cost_more() {
    let model = CostModel::default();
    let gates = |path: &str, value: Value, operation| {
        let mut spec = UnitSpec::default();
        spec.set(path, &value).unwrap();
        model.sheet(&spec.config, operation).total().gates(&model.cells)
    };
    let env = Operation::Env(ALL);
    let whole = |n| Value::Integer(n);
    let text = |t: &str| Value::Text(t.into());
    for (path, less, more, operation) in [
        ("eigen.entries", whole(8), whole(128), env),
        ("tables.recip.entries", whole(32), whole(64), env),
        ("tables.recip.newton", whole(1), whole(2), env),
        ("tables.sqrt.order", whole(1), whole(2), env),
        ("footprint.max_probes", whole(4), whole(16), env),
        ("eigen.minor", text("paper"), text("det"), env),
        ("jacobian.dnmod", text("paper"), text("normal"), env),
        ("filter.weight_bits", whole(4), whole(8), env),
        ("filter.lod_bits", whole(4), whole(8), env),
        ("texel.frac", whole(16), whole(24), env),
        ("hit.method", text("false-position"), text("illinois"), Operation::Hit),
        ("hit.footprint", text("disc"), text("plane"), Operation::Hit),
        ("cone.format", text("bf16"), text("f32"), Operation::Tex),
        ("cone.count", whole(1), whole(2), Operation::Tex),
        ("cone.gradient", text("otk"), text("gram"), Operation::Tex),
    ] {
        let (less, more) = (gates(path, less, operation), gates(path, more, operation));
        assert!(less < more, "{path}: {less} and {more}");
    }
    // Gaussian weights save the division and take multipliers for it.
    let weights = |name: &str| gates("footprint.weights", text(name), env);
    assert!((weights("box") - weights("gaussian")).abs() > 1000.0);
}

#[test]
fn cycles_are_those_of_the_slowest_part() {
    let model = CostModel { look_up_interval: 3.0, ..CostModel::default() };
    let env = Operation::Env(ALL);
    let cycles = |operation, loops| model.cycles(operation, loops);
    assert!((cycles(env, [0.5, 0.0]) - 1.0).abs() < 1e-12, "the front");
    assert!((cycles(env, [4.25, 9.0]) - 4.25).abs() < 1e-12, "the probes");
    // dist(R) and dist(x) come before the loop.
    assert!((cycles(Operation::Hit, [4.25, 2.0]) - 12.0).abs() < 1e-12, "the search");
}

#[test]
fn the_knobs_file_reads_back_and_says_what_is_wrong() {
    let mut model = CostModel { front_interval: 2.0, ..CostModel::default() };
    model.cells.rom_bit = 0.5;
    model.cache.ways = 8;
    assert_eq!(CostModel::parse("c.toml", &model.to_toml()).unwrap(), model);
    for (text, parts) in [
        ("[cells]\nnand = 1.0", &["line 2, column 1, nand", "unknown key"][..]),
        ("[cells]\nmux2 = -1.0", &["line 2, column 8, mux2"]),
        ("[cache]\nways = 3", &["line 1", "power of two"]),
    ] {
        let error = CostModel::parse("c.toml", text).unwrap_err().to_string();
        for part in parts {
            assert!(error.contains(part), "no `{part}` in `{error}`");
        }
    }
}
