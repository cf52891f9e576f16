//! `vectors gen|check|header`: test vectors of a stage or of the unit.

use std::io::{BufRead as _, BufWriter, Read as _, Write as _};

use clap::{Subcommand, ValueEnum};

use super::Failure;
use super::args::UnitArgs;
use crate::api::{Vector, Vectors};
use crate::base::num;
use crate::conformance::check::{Checker, Verdict};
use crate::conformance::header::{self, Language};
use crate::conformance::read::{self, Comments};
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
    /// How a case is written; hex if not given, and for `check` what the first line looks like.
    #[arg(long, value_enum)]
    format: Option<Format>,
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
    fn parts(&self) -> Result<(Subject, Build, UnitSpec), InputError> {
        let subject = Subject::parse(&self.stage)?;
        let build = Build { bump: !self.plain, rough: !self.plain, size: self.face_size };
        Ok((subject, build, self.unit.load()?))
    }

    fn load(&self) -> Result<(Harness, Subject, Build, UnitSpec), InputError> {
        let (subject, build, spec) = self.parts()?;
        let model = harness(&spec, subject, build)?;
        Ok((model, subject, build, spec))
    }
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    match &args.action {
        Action::Gen { what, header: Some(language), .. } | Action::Header { what, language } => {
            let (model, subject, _, spec) = what.load()?;
            let text = header::declare(*language, subject, model.shape(), &spec);
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
    let (subject, build, spec) = what.parts()?;
    let vectors = Vectors::new(&spec, subject, build, (level, seed))?;
    let vectors = match count {
        Some(count) => vectors.with_cases(count),
        None => vectors,
    };
    let header =
        Header { subject, unit: spec.hash(), build, level, seed, count: vectors.remaining() };
    let shape = vectors.shape().clone();
    let format = what.format.unwrap_or(Format::Hex);
    let mut out = BufWriter::new(std::io::stdout().lock());
    out.write_all(header.text(&shape, format).as_bytes())?;
    for Vector { input, output } in vectors {
        writeln!(out, "{}", text::line(&shape, format, &input, &output))?;
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
    let Judged { cases, wrong, declared, skipped } = judged?;
    for warning in checker.warnings() {
        super::note(&warning);
    }
    if declared.is_none() {
        super::note("no header says how many cases there are: whether some are missing is unknown");
    }
    let judged = checker.summary();
    let hash = &header.unit;
    super::note(&format!("{cases} cases, {wrong} wrong; unit {hash}{judged}"));
    let name = subject.name();
    if wrong > 0 {
        return Err(Failure::Disagrees(format!("{wrong} of {cases} cases of {name} differ")));
    }
    if let Some(declared) = declared.filter(|declared| *declared != cases) {
        return Err(Failure::Disagrees(format!(
            "the header says {declared} cases of {name}, found {cases}"
        )));
    }
    if skipped > 0 {
        return Err(Failure::Disagrees(format!("addresses leave {skipped} cases of {name} out")));
    }
    Ok(())
}

/// What a file for a subject in a unit must say.
fn header_of(spec: &UnitSpec, subject: Subject, build: Build) -> Header {
    Header { subject, unit: spec.hash(), build, level: 0, seed: 0, count: 0 }
}

/// Bytes as `check eigen` would read them.
pub(super) fn answer(bytes: &[u8]) -> Result<(), InputError> {
    let spec = UnitSpec::default();
    // `eigen` reads no memory.
    let build = Build { size: 1, ..Build::default() };
    let subject = Subject::parse("eigen")?;
    for exact in [false, true] {
        let model = harness(&spec, subject, build)?;
        let mut checker = Checker::new(model, subject, build, exact);
        let header = header_of(&spec, subject, build);
        let mut reader = bytes;
        match judge(&mut checker, &header, None, &mut reader, &mut std::io::sink(), 10) {
            Ok(_) | Err(Failure::Closed | Failure::Disagrees(_)) => {}
            Err(Failure::Input(error)) => return Err(error),
        }
    }
    Ok(())
}

/// What a stream of vectors held.
#[derive(Clone, Copy, Debug, Default)]
struct Judged {
    cases: u64,
    wrong: u64,
    /// Cases that its headers announce.
    declared: Option<u64>,
    /// Words between its addresses that are not there.
    skipped: u64,
}

/// Judges every case of a stream.
fn judge(
    checker: &mut Checker,
    header: &Header,
    mut format: Option<Format>,
    reader: &mut dyn std::io::BufRead,
    out: &mut dyn std::io::Write,
    show: u64,
) -> Result<Judged, Failure> {
    let mut bytes = Vec::new();
    let mut number = 0u64;
    let mut seen = Judged::default();
    let mut comments = Comments::default();
    // The address of the next word, once there is one.
    let mut address: Option<u64> = None;
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
        let line = line.trim_end();
        format = format.or_else(|| read::format_of(line));
        let Some(format) = format else { continue };
        if let Some((key, want, found)) = header.contradiction(line) {
            return Err(bad(number, 1, format!("{key} {want}"), found).into());
        }
        if text::declared(line, "vectors").is_some() {
            let count = text::declared(line, "count").and_then(|count| count.parse().ok());
            seen.declared = count.map(|n: u64| n.saturating_add(seen.declared.unwrap_or(0)));
            continue;
        }
        let line = if format == Format::Jsonl { line.into() } else { comments.strip(line) };
        let whole = [(1, line.trim_end())];
        let each: Vec<(usize, &str)> = match format {
            Format::Readmemh => read::words(&line).collect(),
            Format::Hex | Format::Jsonl if line.trim().is_empty() => continue,
            Format::Hex | Format::Jsonl => whole.into(),
        };
        for (column, case) in each {
            if let Some(digits) = case.strip_prefix('@').filter(|_| format == Format::Readmemh) {
                let to = u64::from_str_radix(digits, 16).ok();
                let next = address.unwrap_or(0);
                let Some(to) = to.filter(|to| *to >= next) else {
                    let expected = format!("an address of at least @{next:x}");
                    return Err(bad(number, column, expected, format!("`{case}`")).into());
                };
                seen.skipped += address.map_or(0, |next| to - next);
                address = Some(to);
                continue;
            }
            seen.cases += 1;
            address = Some(address.unwrap_or(0).saturating_add(1));
            match checker.line(format, case) {
                Ok(Verdict::Agrees) => {}
                Ok(Verdict::Differs(text)) => {
                    seen.wrong += 1;
                    if seen.wrong <= show {
                        writeln!(out, "line {number}, {text}")?;
                    }
                }
                Err(e) => {
                    let column = column + e.column - 1;
                    return Err(bad(number, column, e.expected, e.found).into());
                }
            }
        }
    }
    if seen.cases == 0 {
        return Err(InputError::new(
            "standard input",
            "at least one case",
            "none",
            "pipe a device's vectors into the command",
        )
        .into());
    }
    if comments.open {
        return Err(bad(number, 1, "`*/`".into(), "the end of the file".into()).into());
    }
    Ok(seen)
}
