//! `vectors gen|check|header`: test vectors of a stage or of the unit.

use std::io::{BufRead as _, BufWriter, Read as _, Write as _};

use clap::{Subcommand, ValueEnum};

use super::Failure;
use super::args::UnitArgs;
use crate::base::num;
use crate::conformance::cases::{self, Schedule};
use crate::conformance::check::{Checker, Verdict};
use crate::conformance::header::{self, Language};
use crate::conformance::subject::Subject;
use crate::conformance::text::{self, Format, Header};
use crate::conformance::{Build, Device as _, Harness, harness};
use crate::error::InputError;
use crate::unit::UnitSpec;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// Write vectors to stdout: inputs and every register, as the integer model has them.
    Gen {
        #[command(flatten)]
        what: What,
        /// 1: a pattern at one number of a case; 2: more patterns, at two numbers, extremes in every symmetry.
        #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=2))]
        level: u32,
        /// Seed of what is random.
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// Cases; what covers the level if not given.
        #[arg(long, value_name = "N")]
        count: Option<u64>,
        /// Instead of vectors, the fields' declarations.
        #[arg(long, value_enum, value_name = "LANGUAGE")]
        header: Option<Language>,
    },
    /// Read vectors with a device's outputs from stdin; status 1 if any is wrong.
    Check {
        #[command(flatten)]
        what: What,
        /// What outputs are held against: the integer model's bits, or what the unit's formats allow around exact
        /// arithmetic.
        #[arg(long, value_enum, default_value_t = Against::Rtl)]
        against: Against,
        /// Mismatches to print; the rest is counted.
        #[arg(long, value_name = "N", default_value_t = 100)]
        show: u64,
    },
    /// The fields' declarations for SystemVerilog or C.
    Header {
        #[command(flatten)]
        what: What,
        /// Language.
        #[arg(long, value_enum, default_value_t = Language::Sv)]
        language: Language,
    },
}

/// What judges a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Against {
    /// The integer model, bit by bit.
    Rtl,
    /// Exact arithmetic on the registers that came before, and the formats' and tables' own errors.
    F64,
}

/// A subject in a unit.
#[derive(Clone, Debug, clap::Args)]
struct What {
    /// A stage, `unit` (ENV), `unit-hit` or `unit-tex`.
    stage: String,
    /// How a case is written.
    #[arg(long, value_enum, default_value_t = Format::Hex)]
    format: Format,
    /// A unit built without bump and roughness.
    #[arg(long)]
    plain: bool,
    /// Texels along a face; columns of a 2-D texture.
    #[arg(long, value_name = "N", default_value_t = Build::default().size, value_parser = clap::value_parser!(u32).range(1..=1024))]
    face_size: u32,
    #[command(flatten)]
    unit: UnitArgs,
}

impl What {
    fn load(&self) -> Result<(Harness, Subject, Build, UnitSpec), InputError> {
        let subject = Subject::parse(&self.stage)?;
        let spec = self.unit.load()?;
        let build = Build { bump: !self.plain, rough: !self.plain, size: self.face_size };
        let model = harness(&spec, subject, build)?;
        Ok((model, subject, build, spec))
    }
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    match &args.action {
        Action::Gen { what, header: Some(language), .. } | Action::Header { what, language } => {
            let (model, subject, _, spec) = what.load()?;
            let text = header::declare(*language, subject, model.shape(), &spec.hash());
            std::io::stdout().lock().write_all(text.as_bytes())?;
            Ok(())
        }
        Action::Gen { what, level, seed, count, header: None } => {
            generate(what, *level, *seed, *count)
        }
        Action::Check { what, against, show } => check(what, *against, *show),
    }
}

fn generate(what: &What, level: u32, seed: u64, count: Option<u64>) -> Result<(), Failure> {
    let (mut model, subject, build, spec) = what.load()?;
    let schedule = Schedule::new(&model, subject, level, seed);
    let count = count.unwrap_or_else(|| schedule.cases());
    let header = Header { subject, unit: spec.hash(), build, level, seed, count };
    let shape = model.shape().clone();
    let mut out = BufWriter::new(std::io::stdout().lock());
    out.write_all(header.text(&shape, what.format).as_bytes())?;
    let mut input = vec![0; shape.input_len()];
    let mut output = vec![0; shape.output_len()];
    for index in 0..count {
        cases::fill(&mut model, subject, schedule.place(index), &mut input);
        model.run(&input, &mut output);
        let line = text::line(&shape, what.format, &input, &output);
        writeln!(out, "{line}")?;
    }
    out.flush()?;
    Ok(())
}

/// Longest line: a case of the largest unit has some 30 KiB.
const MAX_LINE: u64 = 1 << 20;

fn check(what: &What, against: Against, show: u64) -> Result<(), Failure> {
    let (model, subject, build, spec) = what.load()?;
    let header = header_of(&spec, subject, build);
    let mut checker = Checker::new(model, subject, build, against == Against::F64);
    let mut out = BufWriter::new(std::io::stdout().lock());
    let mut reader = std::io::stdin().lock();
    let judged = judge(&mut checker, &header, what.format, &mut reader, &mut out, show);
    out.flush()?;
    drop(out);
    let (cases, wrong) = judged?;
    for warning in checker.warnings() {
        super::note(&warning);
    }
    let judged = checker.summary();
    let hash = &header.unit;
    super::note(&format!("{cases} cases, {wrong} wrong; unit {hash}{judged}"));
    if wrong > 0 {
        return Err(Failure::Disagrees(format!(
            "{wrong} of {cases} cases of {} differ",
            subject.name()
        )));
    }
    Ok(())
}

/// What a file for a subject in a unit must say.
fn header_of(spec: &UnitSpec, subject: Subject, build: Build) -> Header {
    Header { subject, unit: spec.hash(), build, level: 0, seed: 0, count: 0 }
}

/// Bytes as `check eigen` would read them, in the format that their first one looks like.
pub(super) fn answer(bytes: &[u8]) -> Result<(), InputError> {
    let format = match bytes.first() {
        Some(b'{') => Format::Jsonl,
        Some(b'/') => Format::Readmemh,
        _ => Format::Hex,
    };
    let spec = UnitSpec::default();
    // `eigen` reads no memory.
    let build = Build { size: 1, ..Build::default() };
    let subject = Subject::parse("eigen")?;
    for exact in [false, true] {
        let model = harness(&spec, subject, build)?;
        let mut checker = Checker::new(model, subject, build, exact);
        let header = header_of(&spec, subject, build);
        let mut reader = bytes;
        match judge(&mut checker, &header, format, &mut reader, &mut std::io::sink(), 10) {
            Ok(_) | Err(Failure::Closed | Failure::Disagrees(_)) => {}
            Err(Failure::Input(error)) => return Err(error),
        }
    }
    Ok(())
}

/// Judges every line of a stream; cases, and how many are wrong.
fn judge(
    checker: &mut Checker,
    header: &Header,
    format: Format,
    reader: &mut dyn std::io::BufRead,
    out: &mut dyn std::io::Write,
    show: u64,
) -> Result<(u64, u64), Failure> {
    let mut bytes = Vec::new();
    let (mut number, mut cases, mut wrong) = (0u64, 0u64, 0u64);
    let bad = |number: u64, column: usize, expected: String, found: String| {
        InputError::new(
            "standard input",
            expected,
            found,
            "`tapline vectors gen` with the same stage, unit and format shows what a line looks like",
        )
        .at(format!("line {number}, column {column}"))
    };
    loop {
        bytes.clear();
        number += 1;
        if (&mut *reader).take(MAX_LINE + 1).read_until(b'\n', &mut bytes)? == 0 {
            break;
        }
        let long = num::u64(bytes.len()) > MAX_LINE;
        if long {
            return Err(
                bad(number, 1, "a line of at most 1 MiB".into(), "a longer one".into()).into()
            );
        }
        let Ok(line) = std::str::from_utf8(&bytes) else {
            return Err(bad(number, 1, "ASCII".into(), "other bytes".into()).into());
        };
        let line = line.trim_end_matches(['\n', '\r', ' ']);
        if text::is_comment(line, format) {
            if let Some((key, want, found)) = header.contradiction(line, format) {
                return Err(bad(number, 1, format!("{key} {want}"), found).into());
            }
            continue;
        }
        cases += 1;
        match checker.line(format, line) {
            Ok(Verdict::Agrees) => {}
            Ok(Verdict::Differs(text)) => {
                wrong += 1;
                if wrong <= show {
                    writeln!(out, "line {number}, {text}")?;
                }
            }
            Err(e) => {
                return Err(bad(number, e.column, e.expected, e.found).into());
            }
        }
    }
    if cases == 0 {
        return Err(InputError::new(
            "standard input",
            "at least one case",
            "none",
            "pipe a device's vectors into the command",
        )
        .into());
    }
    Ok((cases, wrong))
}
