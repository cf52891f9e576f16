//! `trace`: the registers of one pixel, or of every line of a file.

mod f64;
mod line;
mod pixel;
mod record;
mod request;
mod rtl;

use std::io::{BufRead, BufReader, Read, Write};
use std::path::PathBuf;

use self::f64::F64;
use self::line::Line;
use self::pixel::Output;
use self::record::Record;
use self::request::Request;
use self::rtl::Rtl;
use super::args::{RunArgs, SceneArgs, UnitArgs};
use super::job;
use super::{Failure, subject};
use crate::base::num;
use crate::cube::{CubeLevel, CubeMap};
use crate::distance::Distance;
use crate::engine::Job;
use crate::error::InputError;
use crate::mips::build_mips;
use crate::operation::Operation;
use crate::planar::PlanarMap;
use crate::scene::registry::find;
use crate::settings::Settings;
use crate::unit::UnitSpec;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Built-in scene, with --pixel; with --input it is where the texture comes from.
    scene: Option<String>,
    /// Column and row of the picture.
    #[arg(long, value_name = "X,Y", value_parser = column_and_row, requires = "scene", allow_hyphen_values = true)]
    pixel: Option<(u32, u32)>,
    /// Trace lines; `-` is standard input.
    #[arg(long, value_name = "FILE", conflicts_with = "pixel")]
    input: Option<PathBuf>,
    /// Engine of the JSON lines.
    #[arg(long, value_enum, default_value_t = TraceEngine::Rtl)]
    engine: TraceEngine,
    /// Registers as {"raw": int, "frac": bits} instead of decimals (rtl only).
    #[arg(long)]
    raw: bool,
    /// JSON lines even on a terminal.
    #[arg(long)]
    lines: bool,
    #[command(flatten)]
    unit: UnitArgs,
    #[command(flatten)]
    scene_args: SceneArgs,
    #[command(flatten)]
    run: RunArgs,
}

/// Engines that trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum TraceEngine {
    Rtl,
    F64,
}

fn column_and_row(text: &str) -> Result<(u32, u32), String> {
    text.split_once(',')
        .and_then(|(x, y)| Some((x.trim().parse().ok()?, y.trim().parse().ok()?)))
        .ok_or_else(|| "expected COLUMN,ROW such as 250,140".into())
}

/// Face size of trace lines where neither a file nor a scene gives one.
const DEFAULT_FACE: usize = 256;
/// Largest face that the address registers are made for.
const MAX_FACE: usize = 16384;
/// Longest line.
const MAX_LINE: u64 = 1 << 20;

/// The memories that a trace reads.
struct Memories {
    /// The environment.
    map: Option<CubeMap>,
    /// Texels along its faces, with or without texels.
    face_size: usize,
    distance: Option<Distance>,
    /// The 2-D texture of `tex` requests.
    planar: Option<PlanarMap>,
    /// Its columns and rows, with or without texels.
    texture_size: [usize; 2],
}

impl Memories {
    /// An environment alone; `face_size` where there is none.
    fn of_map(map: Option<CubeMap>, face_size: usize) -> Self {
        let face_size = map.as_ref().map_or(face_size, CubeMap::size);
        Self { map, face_size, distance: None, planar: None, texture_size: [face_size; 2] }
    }

    fn distance(&self) -> Result<&Distance, InputError> {
        self.distance.as_ref().ok_or_else(Self::no_distance)
    }

    fn no_distance() -> InputError {
        InputError::new(
            "--distance",
            "a distance map for the operation \"hit\"",
            "none",
            "add --distance, such as --distance box:4,3,2.5",
        )
    }
}

/// An engine that answers requests.
enum Tracer<'a> {
    Rtl(Box<Rtl<'a>>),
    F64(Box<F64<'a>>),
}

impl<'a> Tracer<'a> {
    fn new(
        engine: TraceEngine,
        spec: &'a UnitSpec,
        settings: &Settings,
        memories: &'a Memories,
    ) -> Result<Self, InputError> {
        Ok(match engine {
            TraceEngine::Rtl => Self::Rtl(Box::new(Rtl::new(spec, memories)?)),
            TraceEngine::F64 => Self::F64(Box::new(F64::new(spec, settings, memories))),
        })
    }

    fn answer(&mut self, request: &Request) -> Result<Record<'_>, InputError> {
        match self {
            Self::Rtl(engine) => engine.answer(request),
            Self::F64(engine) => engine.answer(request),
        }
    }
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    args.run.prepare()?;
    args.run.adapter.refuse()?;
    if args.raw && args.engine == TraceEngine::F64 {
        return Err(InputError::new(
            "--raw",
            "--engine rtl beside it",
            "--engine f64",
            "doubles have no raw code; leave --raw out",
        )
        .into());
    }
    let spec = args.unit.load()?;
    match (&args.input, &args.scene, args.pixel) {
        (Some(input), _, _) => {
            let built = ["--bump", "--mesh", "--bounces"];
            args.scene_args.refuse_idle(&built, "a scene with --pixel, not trace lines")?;
            lines(args, &spec, input)
        }
        (None, Some(scene), Some(xy)) => {
            let settings = args.run.settings(&spec);
            let (job, _) = job::load(scene, &args.scene_args, &settings)?;
            let output = Output { engine: args.engine, raw: args.raw, line: args.lines };
            pixel::run(job, (&spec, &settings), scene, xy, &output)
        }
        (None, Some(_), None) => Err(InputError::new(
            "trace",
            "--pixel X,Y beside a scene",
            "no pixel",
            "name one, such as --pixel 250,140",
        )
        .into()),
        (None, None, _) => Err(InputError::new(
            "trace",
            "a scene with --pixel X,Y, or --input FILE",
            "neither",
            "see `tapline trace --help`",
        )
        .into()),
    }
}

fn lines(args: &Args, spec: &UnitSpec, input: &std::path::Path) -> Result<(), Failure> {
    let subject = if input.as_os_str() == "-" {
        "standard input".into()
    } else {
        input.display().to_string()
    };
    let reader: Box<dyn Read> = if input.as_os_str() == "-" {
        Box::new(std::io::stdin().lock())
    } else {
        let unreadable = |found: String| {
            InputError::new(&subject, "a readable file of trace lines", found, "check the path")
        };
        if input.is_dir() {
            return Err(unreadable("a folder".into()).into());
        }
        Box::new(std::fs::File::open(input).map_err(|e| unreadable(e.to_string()))?)
    };
    let face_size = args.scene_args.face_size.unwrap_or(DEFAULT_FACE);
    if !(1..=MAX_FACE).contains(&face_size) {
        return Err(InputError::new(
            "--face-size",
            format!("1 to {MAX_FACE} texels"),
            face_size.to_string(),
            "choose another size",
        )
        .into());
    }
    // A scene of the HIT operation brings its distances; those of a flag go before them.
    let inputs = &mut Vec::new();
    let mut texture_size = subject::load_texture(&args.scene_args, inputs)?.map(|t| t.size());
    let settings = args.run.settings(spec);
    let (map, distance) = match &args.scene {
        Some(scene) if !matches!(find(scene)?.operation(), Operation::Env(_)) => {
            match job::load(scene, &args.scene_args, &settings)?.0 {
                Job::Env(subject) => (Some(subject.map), None),
                Job::Hit(subject) => (Some(subject.map), Some(subject.distance)),
                Job::Tex(subject) => {
                    texture_size = subject.scene.textures.first().map(PlanarMap::size);
                    (Some(subject.sky), None)
                }
            }
        }
        Some(scene) => {
            let (subject, _) = subject::load(scene, &args.scene_args, &settings)?;
            (Some(subject.map), args.scene_args.distance()?.map(|(distance, _)| distance))
        }
        None => {
            let distance = args.scene_args.distance()?.map(|(distance, _)| distance);
            (subject::load_map(&args.scene_args, inputs)?, distance)
        }
    };
    super::note(&format!("version {}, unit {}, seed 0", env!("CARGO_PKG_VERSION"), spec.hash()));
    let mut memories = Memories { distance, ..Memories::of_map(map, face_size) };
    memories.texture_size = texture_size.unwrap_or(memories.texture_size);
    if let (TraceEngine::Rtl, Some(distance)) = (args.engine, &memories.distance) {
        for loss in crate::engine::ranges::distances(distance, spec)? {
            super::note(&format!("{}: {}", loss.event.name(), loss.note));
        }
    }
    let mut tracer = Tracer::new(args.engine, spec, &settings, &memories)?;
    let out = std::io::BufWriter::new(std::io::stdout().lock());
    stream(&mut tracer, args.raw, &subject, BufReader::new(reader), out)
}

/// Answers each line of `reader` on `out`, in order, up to the first that is wrong.
fn stream<R: Read>(
    tracer: &mut Tracer<'_>,
    raw: bool,
    subject: &str,
    mut reader: BufReader<R>,
    mut out: impl Write,
) -> Result<(), Failure> {
    let mut bytes = Vec::new();
    let mut number = 0;
    let mut blank = None;
    let result: Result<(), Failure> = loop {
        bytes.clear();
        number += 1;
        let read = match (&mut reader).take(MAX_LINE + 1).read_until(b'\n', &mut bytes) {
            Ok(n) => n,
            Err(e) => {
                break Err(InputError::new(
                    subject,
                    "a readable stream",
                    e.to_string(),
                    "check the file",
                )
                .at(format!("line {number}"))
                .into());
            }
        };
        if read == 0 {
            break Ok(());
        }
        match one(tracer, raw, subject, number, &bytes) {
            // Empty lines may end a file; between two objects one would shift what follows.
            Ok(Some(_)) | Err(_) if blank.is_some() => {
                let place = format!("line {}", blank.unwrap_or(number));
                break Err(InputError::new(
                    subject,
                    "one JSON object",
                    "an empty line before others",
                    "remove it",
                )
                .at(place)
                .into());
            }
            Ok(Some(line)) => {
                if let Err(e) = writeln!(out, "{line}") {
                    break Err(e.into());
                }
            }
            Ok(None) => blank = blank.or(Some(number)),
            Err(e) => break Err(e.into()),
        }
        // A device on the other end of a pipe waits for its answer before it asks again.
        if reader.buffer().is_empty() {
            out.flush()?;
        }
    };
    let flushed = out.flush();
    result?;
    flushed?;
    Ok(())
}

/// Answers trace lines in memory with the default unit, by both engines, over faces of 8×8 texels of one colour
/// and the distances of a box.
///
/// # Errors
/// What is wrong in the first line that cannot be answered.
pub(super) fn answer(bytes: &[u8]) -> Result<(), InputError> {
    let spec = UnitSpec::default();
    let settings = spec.settings(crate::unit::ReferenceAxis::Exact);
    let map = build_mips(CubeLevel { size: 8, texels: vec![[0.5, 0.25, 1.0]; 6 * 8 * 8] });
    let distance = Distance::analytic("box:3,2,4").transpose()?;
    let memories = Memories { distance, ..Memories::of_map(Some(map), 8) };
    for engine in [TraceEngine::Rtl, TraceEngine::F64] {
        let mut tracer = Tracer::new(engine, &spec, &settings, &memories)?;
        match stream(&mut tracer, false, "trace lines", BufReader::new(bytes), std::io::sink()) {
            Ok(()) | Err(Failure::Closed | Failure::Disagrees(_)) => {}
            Err(Failure::Input(error)) => return Err(error),
        }
    }
    Ok(())
}

fn one(
    tracer: &mut Tracer<'_>,
    raw: bool,
    subject: &str,
    number: usize,
    bytes: &[u8],
) -> Result<Option<String>, InputError> {
    let fail = |expected: &str, found: &str| {
        Err(InputError::new(
            subject,
            expected,
            found,
            "split the file into lines, one JSON object each",
        )
        .at(format!("line {number}")))
    };
    if num::u64(bytes.len()) > MAX_LINE {
        return fail("a line of at most 1 MiB", "a longer one");
    }
    let Ok(text) = std::str::from_utf8(bytes) else {
        return fail("UTF-8", "other bytes");
    };
    if text.trim().is_empty() {
        return Ok(None);
    }
    let line = Line::parse(subject, number, text)?;
    let request = Request::read(&line)?;
    let record = tracer.answer(&request).map_err(|e| e.at(format!("line {number}")))?;
    Ok(Some(line.with_out(record.out(raw))))
}
