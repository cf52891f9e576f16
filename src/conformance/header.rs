//! Declarations of a subject's fields for C and SystemVerilog, from the same description that the vectors have.

use std::fmt::Write as _;

use rtl_model::policy::{Legal, ROWS, Setting as _};

use super::field::{Field, Meaning, Shape};
use super::subject::Subject;
use crate::unit::UnitSpec;

/// A language.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Language {
    /// A SystemVerilog package: packed structs of one line of a `readmemh` file.
    Sv,
    /// A C header: structs of `int64_t`, as `tapline.h` takes them.
    C,
}

/// The kind of a field's numbers, for a comment.
fn remark(field: &Field) -> String {
    let mut out = field.text.clone();
    if let Some(frac) = field.frac {
        let _ = write!(out, "; value = code / 2^{frac}");
    }
    if field.meaning == Meaning::Word {
        out.push_str("; bits of a binary64 number");
    }
    let bit = if matches!(field.meaning, Meaning::Flags(_)) { "bit " } else { "" };
    for (i, name) in field.meaning.names().iter().enumerate() {
        let lead = if i == 0 { ";" } else { "," };
        let _ = write!(out, "{lead} {bit}{i} {name}");
    }
    out
}

/// The declarations of a subject in a unit, with a line about their origin.
#[must_use]
pub fn declare(language: Language, subject: Subject, shape: &Shape, spec: &UnitSpec) -> String {
    let name = subject.name().replace('-', "_");
    let origin = format!(
        "Fields of `{}` vectors: tapline {}, unit {}. Generated; do not edit.",
        subject.name(),
        env!("CARGO_PKG_VERSION"),
        spec.hash()
    );
    let constants = constants(subject, shape, spec);
    match language {
        Language::Sv => system_verilog(&name, shape, &constants, &origin),
        Language::C => c(&name, shape, &constants, &origin),
    }
}

/// A whole number that a circuit or a test bench needs, by name.
struct Constant {
    name: String,
    value: i64,
    /// What the number stands for, where it is not itself.
    remark: String,
}

/// A name of one word in capitals.
fn constant_name(parts: &[&str]) -> String {
    parts.join("_").replace(|c: char| !c.is_ascii_alphanumeric(), "_").to_uppercase()
}

/// Every constant of a subject: fields with their formats, roundings, choices and flags, then the knobs of its stages.
fn constants(subject: Subject, shape: &Shape, spec: &UnitSpec) -> Vec<Constant> {
    let mut out = Vec::new();
    let mut add = |parts: &[&str], value: i64, remark: &str| {
        out.push(Constant { name: constant_name(parts), value, remark: remark.into() });
    };
    for (side, fields) in [("in", &shape.inputs), ("out", &shape.outputs)] {
        for field in fields {
            let name = &field.identifier();
            add(&[side, name, "bits"], field.bits.into(), "");
            if let Some(frac) = field.frac {
                add(&[side, name, "frac"], frac.into(), "");
            }
            if let Some(reg) = field.meaning.register() {
                let format = spec.config.format(reg);
                let (rounding, overflow) = (format.rounding, format.overflow);
                add(&[side, name, "rounding"], rounding.number().into(), rounding.name());
                add(&[side, name, "overflow"], overflow.number().into(), overflow.name());
            }
            for (number, choice) in (0..).zip(field.meaning.names()) {
                // Faces.
                let choice = choice.replace('+', "pos_").replace('-', "neg_");
                add(&[side, name, &choice], number, "");
            }
        }
    }
    let stages = subject.stages();
    for row in ROWS {
        let reached = stages.iter().any(|stage| stage.name() == row.reach);
        let Some(number) = row.get(&spec.config).filter(|_| reached) else { continue };
        let names = if let Legal::Names(names) = row.legal { names } else { &[] };
        let value = names.get(usize::try_from(number).unwrap_or(usize::MAX)).unwrap_or(&"");
        add(&["knob", row.path], number.into(), value);
    }
    out
}

/// Reserved words of SystemVerilog that a register may have as its name; none is one of C.
const RESERVED: [&str; 12] = [
    "cross", "edge", "table", "weak", "strong", "small", "medium", "large", "time", "wire",
    "event", "bit",
];

/// A field's name as a member of a SystemVerilog struct.
fn member(field: &Field) -> String {
    let name = field.identifier();
    if RESERVED.contains(&name.as_str()) { name + "_" } else { name }
}

fn system_verilog(name: &str, shape: &Shape, constants: &[Constant], origin: &str) -> String {
    let mut out = format!("// {origin}\n//\n");
    out.push_str("// One word of $readmemh is one vector; the first field lies in the top bits. Every number is padded to whole\n");
    out.push_str("// hexadecimal digits: take the low *_BITS bits of it, signed where the field is. Save it as\n");
    let _ = writeln!(
        out,
        "// tapline_{name}_pkg.sv. Constants that a test bench leaves aside are no fault, and the first"
    );
    out.push_str("// component of a field lies in the higher bits, as in the file:\n");
    out.push_str("/* verilator lint_off UNUSEDPARAM */\n/* verilator lint_off LITENDIAN */\n");
    let _ = writeln!(out, "package tapline_{name}_pkg;");
    let upper = constant_name(&[name]);
    let parts = [("in", &shape.inputs), ("out", &shape.outputs)];
    for Constant { name, value, remark } in constants {
        let remark = if remark.is_empty() { String::new() } else { format!(" // {remark}") };
        let _ = writeln!(out, "  localparam int {upper}_{name} = {value};{remark}");
    }
    for (kind, fields) in parts {
        out.push_str("\n  typedef struct packed {\n");
        for field in fields {
            let _ = writeln!(out, "    // {}", remark(field));
            let sign = if field.signed { " signed" } else { "" };
            let range = match field.components {
                1 => String::new(),
                // The first component lies in the higher bits, as in the file.
                n => format!("[0:{}]", n - 1),
            };
            let top = field.padded_bits() - 1;
            let _ = writeln!(out, "    logic{sign} {range}[{top}:0] {};", member(field));
        }
        let _ = writeln!(out, "  }} {name}_{kind}_t;");
    }
    let _ = writeln!(
        out,
        "\n  typedef struct packed {{\n    {name}_in_t  inputs;\n    {name}_out_t outputs;\n  }} {name}_vector_t;"
    );
    let bits =
        |fields: &[Field]| fields.iter().map(|f| f.components * f.padded_bits()).sum::<usize>();
    let (inputs, outputs) = (bits(&shape.inputs), bits(&shape.outputs));
    let _ = writeln!(out, "\n  localparam int {upper}_INPUT_BITS = {inputs};");
    let _ = writeln!(out, "  localparam int {upper}_OUTPUT_BITS = {outputs};");
    let _ = writeln!(out, "  localparam int {upper}_VECTOR_BITS = {};", inputs + outputs);
    out.push_str(
        "endpackage\n/* verilator lint_on LITENDIAN */\n/* verilator lint_on UNUSEDPARAM */\n",
    );
    out
}

fn c(name: &str, shape: &Shape, constants: &[Constant], origin: &str) -> String {
    let guard = format!("TAPLINE_{}_H", name.to_uppercase());
    let mut out =
        format!("/* {origin} */\n#ifndef {guard}\n#define {guard}\n\n#include <stdint.h>\n");
    for Constant { name: constant, value, remark } in constants {
        let remark = if remark.is_empty() { String::new() } else { format!(" /* {remark} */") };
        let prefix = constant_name(&["tapline", name]);
        let _ = writeln!(out, "#define {prefix}_{constant} {value}{remark}");
    }
    for (kind, fields) in [("in", &shape.inputs), ("out", &shape.outputs)] {
        out.push_str("\ntypedef struct {\n");
        for field in fields {
            let _ = writeln!(out, "    /* {} */", remark(field));
            let range = match field.components {
                1 => String::new(),
                n => format!("[{n}]"),
            };
            let _ = writeln!(out, "    int64_t {}{range};", field.identifier());
        }
        let _ = writeln!(out, "}} tapline_{name}_{kind};\n");
    }
    let _ = writeln!(out, "#endif");
    out
}
