//! The stage documents' tables and worked examples are the code's own.
//!
//! Three kinds of block in `docs/stages/<stage>.md` are generated, each between its marker and
//! `<!-- end -->`: `<!-- registers -->`, `<!-- example NAME -->` and `<!-- errors -->`. The test compares
//! them; `TAPLINE_BLESS=1` writes them. Measured errors are written only from the JSON file
//! that `TAPLINE_COMPARE_JSON` names, the result of the command that the document gives.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use rtl_model::regs::{Event, Kind, Reg};
use rtl_model::{Config, Unit};
use serde_json::Value;
use support::{golden, house};
use tapline::cube::{CubeLevel, FACE_NAMES};
use tapline::engine::encode;
use tapline::engine::probe::{Code, RtlFragment, RtlProbe, rtl};
use tapline::fragment::Fragment;
use tapline::mips::build_mips;
use tapline::report::table::significant;
use tapline::stage::Stage;
use tapline::unit::UnitSpec;

/// The file that holds measured errors, when they are to be written.
const MEASURED: &str = "TAPLINE_COMPARE_JSON";

/// Stages that take rays and cones instead of ENV's fragments.
const OTHERS: [Stage; 2] = [Stage::Hit, Stage::SurfaceFootprint];

fn registers(stage: &str) -> impl Iterator<Item = Reg> {
    Reg::ALL.iter().copied().filter(move |reg| reg.info().stage.name() == stage)
}

/// `s1.22`: sign, integer bits, fraction bits; `block s1.22` where the exponent is shared.
fn format(config: &Config, reg: Reg) -> String {
    let format = config.format(reg);
    let sign = if format.signed { "s" } else { "u" };
    let kind = if reg.info().kind == Kind::Block { "block " } else { "" };
    format!("{kind}{sign}{}.{}", format.int, format.frac)
}

/// The table of a stage's registers in the default unit.
fn register_table(stage: &str) -> String {
    let config = UnitSpec::default().config;
    let mut out = String::from(
        "| register | components | format | bits each | rounding, overflow | holds |\n\
         |---|--:|---|--:|---|---|\n",
    );
    for reg in registers(stage) {
        let (info, format_of) = (reg.info(), config.format(reg));
        let overflow = if info.kind == Kind::Block {
            String::new()
        } else {
            format!(", {}", format_of.overflow.name())
        };
        writeln!(
            out,
            "| `{}` | {} | {} | {} | {}{overflow} | {} |",
            info.name,
            info.components,
            format(&config, reg),
            format_of.width(),
            format_of.rounding.name(),
            info.meaning.replace('|', "\\|"),
        )
        .unwrap();
    }
    out
}

/// The fragments of docs/stages/README.md, by the name in the fence's info string.
fn example(name: &str) -> Fragment {
    let text = house::read(&house::root("docs/stages/README.md"));
    let fence = format!("```json {name}\n");
    let (_, rest) = text
        .split_once(&fence)
        .unwrap_or_else(|| panic!("docs/stages/README.md has no example {name}"));
    let line: Value = serde_json::from_str(rest.split("```").next().unwrap()).unwrap();
    let numbers = |key: &str| -> Option<Vec<f64>> {
        let items = line.get(key)?.as_array()?;
        Some(items.iter().map(|x| x.as_f64().unwrap()).collect())
    };
    let vector = |key: &str| <[f64; 3]>::try_from(numbers(key).unwrap()).unwrap();
    Fragment {
        v: vector("v"),
        n: vector("n"),
        dv_dx: vector("dv_dx"),
        dv_dy: vector("dv_dy"),
        dn_dx: vector("dn_dx"),
        dn_dy: vector("dn_dy"),
        h: line.get("h").map(|_| vector("h")),
        bump: numbers("bump").map(|b| b.try_into().unwrap()),
        rough: line.get("rough").map(|_| vector("rough")),
    }
}

/// What the default unit makes of an example on faces of 256 texels: red (column + ½)/256, green
/// (row + ½)/256, blue ¼, the same on every face.
fn run(name: &str) -> (RtlFragment, RtlProbe) {
    let config = UnitSpec::default().config;
    let fragment = example(name);
    let size = 256u16;
    let place = |i: u16| (f32::from(i) + 0.5) / f32::from(size);
    let texels = (0..6 * size)
        .flat_map(|row| (0..size).map(move |x| [place(x), place(row % size), 0.25]))
        .collect();
    let map = build_mips(CubeLevel { size: size.into(), texels });
    let unit = Unit::new(&config, encode::needs(&fragment), size.into()).unwrap();
    let texture = encode::texture(&config, &map).unwrap();
    let mut probe = RtlProbe::default();
    let result = rtl(&unit, &config, &fragment, Some(&texture), &mut probe);
    (result, probe)
}

/// Sign and magnitude of a raw code in hex.
fn hex(raw: i64) -> String {
    let sign = if raw < 0 { "-" } else { "" };
    format!("{sign}0x{:x}", raw.unsigned_abs())
}

fn row(name: &str, codes: &[Code]) -> String {
    let join = |f: &dyn Fn(&Code) -> String| codes.iter().map(f).collect::<Vec<_>>().join(" ");
    let frac = codes[0].frac;
    // The second level of a LOD without a fraction is never addressed.
    let unwritten = |c: &Code| !c.is_written();
    assert!(codes.iter().all(|c| c.frac == frac || unwritten(c)), "{name}");
    let values = join(&|c| {
        if unwritten(c) {
            return "-".into();
        }
        let all = c.decimal();
        if all.len() <= 12 { all } else { format!("{}…", significant(c.value(), 8)) }
    });
    let shown = join(&|c| {
        if unwritten(c) { "-".into() } else { hex(c.raw) }
    });
    format!("{name:<24} {shown} ·2^{} = {values}\n", -frac)
}

/// Every register that a stage writes for an example, per probe where it works on probes.
fn worked(stage: &str, name: &str) -> String {
    let (result, probe) = run(name);
    let mut out = String::from("```text\n");
    if stage == "cube_face" {
        writeln!(out, "{:<24} {}", "face", FACE_NAMES[result.face]).unwrap();
    }
    for reg in registers(stage) {
        let (info, codes) = (reg.info(), probe.get(reg));
        let per_probe = codes.len() > info.components;
        for (i, part) in codes.chunks(info.components).enumerate() {
            let title = if per_probe { format!("{reg} {i}") } else { reg.to_string() };
            out.push_str(&row(&title, part));
        }
    }
    if stage == "footprint" {
        writeln!(out, "{:<24} {}", "probes", result.probes).unwrap();
    }
    let own = |flag: &&String| flag.starts_with(&format!("{stage}."));
    let flags: Vec<&str> = result.flags.iter().filter(own).map(String::as_str).collect();
    if !flags.is_empty() {
        writeln!(out, "{:<24} {}", "flags", flags.join(" ")).unwrap();
    }
    out + "```\n"
}

/// The table of measured errors, from the result of `compare --json`.
fn error_table(stage: &str, json: &Value) -> String {
    let mut out = String::from("| register | worst (LSB) | mean (LSB) |\n|---|--:|--:|\n");
    let mut rows = 0;
    for entry in json["registers"].as_array().unwrap() {
        if entry["stage"] == stage {
            let number = |key: &str| significant(entry[key].as_f64().unwrap(), 3);
            let name = entry["register"].as_str().unwrap();
            let (worst, mean) = (number("worst_lsb"), number("mean_lsb"));
            writeln!(out, "| `{name}` | {worst} | {mean} |").unwrap();
            rows += 1;
        }
    }
    assert!(rows > 0, "nothing measured in {stage}");
    out
}

/// A document with its blocks written anew.
fn regenerated(stage: &str, text: &str, measured: Option<&Value>) -> String {
    let mut out = String::new();
    let mut rest = text;
    let mut kinds = BTreeSet::new();
    while let Some((before, after)) = rest.split_once("<!-- ") {
        let (marker, body) = after.split_once(" -->\n").expect("a marker ends its line");
        let (old, behind) = body
            .split_once("<!-- end -->\n")
            .unwrap_or_else(|| panic!("{stage}: no end of {marker}"));
        let new = match marker.split_once(' ') {
            None if marker == "registers" => register_table(stage),
            None if marker == "errors" => {
                measured.map_or_else(|| old.to_owned(), |json| error_table(stage, json))
            }
            Some(("example", name)) => worked(stage, name),
            _ => panic!("{stage}: unknown block {marker}"),
        };
        kinds.insert(marker.split(' ').next().unwrap_or(marker));
        write!(out, "{before}<!-- {marker} -->\n{new}<!-- end -->\n").unwrap();
        rest = behind;
    }
    out.push_str(rest);
    // The fragments of the examples and the scene that errors are measured on reach only ENV's stages.
    let wanted: &[&str] = if OTHERS.iter().any(|other| stage == other.name()) {
        &["registers"]
    } else {
        &["errors", "example", "registers"]
    };
    assert!(
        wanted.iter().all(|kind| kinds.contains(kind)),
        "{stage} lacks one of the blocks {wanted:?}: {kinds:?}"
    );
    out
}

#[test]
fn every_stage_document_has_the_default_units_registers_and_the_examples_codes() {
    let measured = std::env::var_os(MEASURED)
        .map(|path| -> Value { serde_json::from_str(&house::read(path.as_ref())).unwrap() });
    let bless = std::env::var_os(golden::BLESS).is_some();
    let mut problems = Vec::new();
    for stage in Stage::ALL.into_iter().filter(|s| has_fixed_registers(*s)) {
        let path = house::root(&format!("docs/stages/{}.md", stage.name()));
        let text = house::read(&path).replace("\r\n", "\n");
        let new = regenerated(stage.name(), &text, measured.as_ref());
        if new == text {
            continue;
        }
        problems.extend(golden::compare(&path, &new, bless).err());
    }
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

/// All but `ray_cone`, whose registers are small floats: tests/ray_cone holds them to half an ulp.
fn has_fixed_registers(stage: Stage) -> bool {
    let any = registers(stage.name()).next().is_some();
    assert_eq!(any, stage != Stage::RayCone);
    any
}

#[test]
fn every_measured_error_belongs_to_a_register_of_its_stage() {
    for stage in Stage::ALL.into_iter().filter(|s| !OTHERS.contains(s)) {
        let path = house::root(&format!("docs/stages/{}.md", stage.name()));
        let text = house::read(&path);
        if !has_fixed_registers(stage) {
            continue;
        }
        let (_, rest) = text.split_once("<!-- errors -->\n").expect("a block of errors");
        let block = rest.split("<!-- end -->").next().unwrap();
        let names: BTreeSet<&str> = registers(stage.name()).map(|reg| reg.info().name).collect();
        let mut rows = 0;
        for line in block.lines().filter(|line| line.starts_with("| `")) {
            let name = line.split('`').nth(1).unwrap();
            assert!(names.contains(name), "{stage:?} has no register {name}");
            rows += 1;
        }
        assert!(rows > 0, "{stage:?}: nothing measured");
    }
}

#[test]
fn every_event_is_explained_where_it_happens() {
    for event in Event::ALL {
        let (stage, _) = event.name().split_once('.').unwrap();
        let text = house::read(&house::root(&format!("docs/stages/{stage}.md")));
        let quoted = format!("`{}`", event.name());
        assert!(text.contains(&quoted), "{stage}.md does not explain {quoted}");
    }
}

#[test]
fn the_examples_reach_every_stage_and_raise_no_overflow() {
    let (plain, plain_codes) = run("plain");
    let (bumpy, bumpy_codes) = run("bumpy");
    assert!(plain.flags.is_empty() && bumpy.flags.is_empty());
    assert!(plain.probes > 1);
    for stage in Stage::ALL.into_iter().filter(|s| !OTHERS.contains(s) && has_fixed_registers(*s)) {
        let written = registers(stage.name()).any(|reg| {
            let codes = plain_codes.get(reg).iter().chain(bumpy_codes.get(reg));
            codes.into_iter().any(|code| code.raw != 0)
        });
        assert!(written, "no example shows {stage:?}");
    }
}
