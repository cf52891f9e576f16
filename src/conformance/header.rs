//! Declarations of a subject's fields for C and SystemVerilog, from the same description that the vectors have.

use std::fmt::Write as _;

use super::field::{Field, Meaning, Shape};
use super::subject::Subject;

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
pub fn declare(language: Language, subject: Subject, shape: &Shape, unit: &str) -> String {
    let name = subject.name().replace('-', "_");
    let origin = format!(
        "Fields of `{}` vectors: tapline {}, unit {unit}. Generated; do not edit.",
        subject.name(),
        env!("CARGO_PKG_VERSION")
    );
    match language {
        Language::Sv => system_verilog(&name, shape, &origin),
        Language::C => c(&name, shape, &origin),
    }
}

fn system_verilog(name: &str, shape: &Shape, origin: &str) -> String {
    let mut out = format!("// {origin}\n//\n");
    out.push_str("// One word of $readmemh is one vector; the first field lies in the top bits. Every number is padded to whole\n");
    out.push_str(
        "// hexadecimal digits: take the low *_BITS bits of it, signed where the field is.\n",
    );
    let _ = writeln!(out, "package tapline_{name}_pkg;");
    let parts = [("in", &shape.inputs), ("out", &shape.outputs)];
    for (_, fields) in parts {
        for field in fields {
            let upper = field.identifier().to_uppercase();
            let _ = writeln!(out, "  localparam int {upper}_BITS = {};", field.bits);
            if let Some(frac) = field.frac {
                let _ = writeln!(out, "  localparam int {upper}_FRAC = {frac};");
            }
        }
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
            let _ = writeln!(out, "    logic{sign} {range}[{top}:0] {};", field.identifier());
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
    let _ = writeln!(out, "\n  localparam int INPUT_BITS = {inputs};");
    let _ = writeln!(out, "  localparam int OUTPUT_BITS = {outputs};");
    let _ = writeln!(out, "  localparam int VECTOR_BITS = {};", inputs + outputs);
    let _ = writeln!(out, "endpackage");
    out
}

fn c(name: &str, shape: &Shape, origin: &str) -> String {
    let guard = format!("TAPLINE_{}_H", name.to_uppercase());
    let mut out =
        format!("/* {origin} */\n#ifndef {guard}\n#define {guard}\n\n#include <stdint.h>\n");
    for (kind, fields) in [("in", &shape.inputs), ("out", &shape.outputs)] {
        for field in fields {
            let upper = field.identifier().to_uppercase();
            let _ = writeln!(
                out,
                "#define TAPLINE_{}_{upper}_BITS {}",
                name.to_uppercase(),
                field.bits
            );
        }
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
