//! `trace`: the registers of one pixel, or of every line of a file.

use std::collections::HashMap;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::PathBuf;

use rtl_model::regs::Reg;
use rtl_model::unit::Needs;
use rtl_model::{Texture, Unit};
use serde_json::{Map, Number, Value, json};

use super::args::{RunArgs, SceneArgs, UnitArgs};
use super::job::Job;
use super::json_lines::Op;
use super::{Failure, json_lines, subject, trace_cone, trace_hit, trace_pixel, trace_tex};
use crate::base::num;
use crate::cube::{CubeLevel, CubeMap, FACE_NAMES};
use crate::distance::Distance;
use crate::engine::encode;
use crate::engine::probe::{Code, RtlProbe, rtl};
use crate::engine::tex::TexRtl;
use crate::error::InputError;
use crate::fragment::Fragment;
use crate::image::build_mips;
use crate::planar::PlanarMap;
use crate::reference::{self, Env, NoTap, Prepared};
use crate::scene::hit::is_hit_scene;
use crate::scene::tex::is_tex_scene;
use crate::settings::Settings;
use crate::unit::{UnitSpec, refused};

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Built-in scene, with --pixel; with --input it is where the texture comes from.
    pub(super) scene: Option<String>,
    /// Column and row of the picture.
    #[arg(long, value_name = "X,Y", value_parser = pixel, requires = "scene", allow_hyphen_values = true)]
    pub(super) pixel: Option<(u32, u32)>,
    /// Trace lines; `-` is standard input.
    #[arg(long, value_name = "FILE", conflicts_with = "pixel")]
    input: Option<PathBuf>,
    /// Engine of the JSON lines.
    #[arg(long, value_enum, default_value_t = TraceEngine::Rtl)]
    pub(super) engine: TraceEngine,
    /// Registers as {"raw": int, "frac": bits} instead of decimals (rtl only).
    #[arg(long)]
    pub(super) raw: bool,
    /// JSON lines even on a terminal.
    #[arg(long)]
    pub(super) lines: bool,
    #[command(flatten)]
    pub(super) unit: UnitArgs,
    #[command(flatten)]
    pub(super) scene_args: SceneArgs,
    #[command(flatten)]
    pub(super) run: RunArgs,
}

/// Engines that trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum TraceEngine {
    Rtl,
    F64,
}

fn pixel(text: &str) -> Result<(u32, u32), String> {
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

/// Everything that turns a fragment into an `out` object.
pub(super) struct Tracer {
    pub(super) spec: UnitSpec,
    pub(super) engine: TraceEngine,
    raw: bool,
    pub(super) settings: Settings,
    pub(super) distance: Option<Distance>,
    pub(super) hit: Option<trace_hit::Rtl>,
    pub(super) tex: Option<TexRtl>,
    /// Columns and rows of the texture that `tex` lines ask.
    pub(super) texture_size: [usize; 2],
    pub(super) prepared: Prepared,
    pub(super) face_size: usize,
    texture: Option<Texture>,
    pub(super) map: Option<CubeMap>,
    units: HashMap<Needs, Unit>,
    pub(super) probe: RtlProbe,
}

/// How a tracer answers.
pub(super) struct Mode {
    engine: TraceEngine,
    raw: bool,
    settings: Settings,
}

impl Args {
    pub(super) fn mode(&self, spec: &UnitSpec) -> Mode {
        Mode { engine: self.engine, raw: self.raw, settings: self.run.settings(spec) }
    }
}

impl Tracer {
    pub(super) fn new(
        mode: Mode,
        spec: UnitSpec,
        map: Option<CubeMap>,
        face_size: usize,
    ) -> Result<Self, InputError> {
        let texture = match &map {
            Some(map) => Some(encode::texture(&spec.config, map).map_err(refused)?),
            None => None,
        };
        Ok(Self {
            prepared: Prepared::new(&mode.settings),
            settings: mode.settings,
            distance: None,
            hit: None,
            tex: None,
            texture_size: [map.as_ref().map_or(face_size, CubeMap::size); 2],
            engine: mode.engine,
            raw: mode.raw,
            face_size: map.as_ref().map_or(face_size, CubeMap::size),
            texture,
            map,
            units: HashMap::new(),
            probe: RtlProbe::default(),
            spec,
        })
    }

    fn cone_output(&self) -> trace_cone::Output {
        trace_cone::Output { engine: self.engine, raw: self.raw }
    }

    pub(super) fn code(&self, code: Code) -> Value {
        if self.raw {
            return json!({"raw": code.raw, "frac": code.frac});
        }
        Value::Number(Number::from_string_unchecked(code.decimal()))
    }

    pub(super) fn codes(&self, reg: Reg) -> Vec<Value> {
        self.probe.get(reg).iter().map(|c| self.code(*c)).collect()
    }

    /// The `out` object of a fragment.
    pub(super) fn out(&mut self, fragment: &Fragment) -> Result<Map<String, Value>, InputError> {
        match self.engine {
            TraceEngine::Rtl => self.out_rtl(fragment),
            TraceEngine::F64 => Ok(self.out_f64(fragment)),
        }
    }

    fn out_rtl(&mut self, fragment: &Fragment) -> Result<Map<String, Value>, InputError> {
        let needs = encode::needs(fragment);
        if !self.units.contains_key(&needs) {
            let size = num::u32(self.face_size);
            self.units.insert(needs, Unit::new(&self.spec.config, needs, size).map_err(refused)?);
        }
        let Some(unit) = self.units.get(&needs) else {
            return Ok(Map::new());
        };
        let result = rtl(unit, &self.spec.config, fragment, self.texture.as_ref(), &mut self.probe);
        let mut out = Map::new();
        let textured = self.texture.is_some();
        self.env_codes(&mut out, FACE_NAMES[result.face], result.probes, textured);
        out.insert("flags".into(), json!(result.flags));
        Ok(out)
    }

    /// The fields of ENV from the registers of the last run.
    pub(super) fn env_codes(
        &self,
        out: &mut Map<String, Value>,
        face: &str,
        probes: i64,
        textured: bool,
    ) {
        let first = |values: Vec<Value>| values.into_iter().next().unwrap_or(Value::Null);
        out.insert("face".into(), json!(face));
        out.insert("u".into(), first(self.codes(Reg::FaceU)));
        out.insert("v".into(), first(self.codes(Reg::FaceV)));
        let d = self.codes(Reg::JacD);
        let rows: Vec<Value> = d.chunks(2).map(|row| Value::Array(row.to_vec())).collect();
        out.insert("D".into(), Value::Array(rows));
        out.insert("K".into(), Value::Array(self.codes(Reg::CovK)));
        out.insert("lambda".into(), Value::Array(self.codes(Reg::EigenLambda)));
        out.insert("axis".into(), Value::Array(self.codes(Reg::EigenAxis)));
        out.insert("probes".into(), json!(probes));
        out.insert("lod".into(), first(self.codes(Reg::FootLod)));
        if textured {
            out.insert("color".into(), Value::Array(self.codes(Reg::FilterColor)));
        }
    }

    fn out_f64(&self, fragment: &Fragment) -> Map<String, Value> {
        let texture = self.map.as_ref().map(reference::Texture::new);
        let env =
            reference::env(&self.prepared, fragment, self.face_size, texture.as_ref(), &mut NoTap);
        let mut out = Map::new();
        Self::env_values(&mut out, &env, texture.is_some());
        let flags: Vec<&str> = env.flags.names().collect();
        out.insert("flags".into(), json!(flags));
        out
    }

    /// The fields of ENV as the float reference has them.
    pub(super) fn env_values(out: &mut Map<String, Value>, env: &Env, textured: bool) {
        out.insert("face".into(), json!(FACE_NAMES[env.face]));
        out.insert("u".into(), json!(env.u));
        out.insert("v".into(), json!(env.v));
        out.insert("D".into(), json!(env.d));
        out.insert("K".into(), json!(env.k));
        out.insert("lambda".into(), json!(env.lambda));
        out.insert("axis".into(), json!(env.axis));
        out.insert("probes".into(), json!(env.probes));
        out.insert("lod".into(), json!(env.lod));
        if textured {
            out.insert("color".into(), json!(env.color));
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
        (Some(input), _, _) => lines(args, spec, input),
        (None, Some(scene), Some(pixel)) => trace_pixel::run(args, spec, scene, pixel),
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

fn lines(args: &Args, spec: UnitSpec, input: &std::path::Path) -> Result<(), Failure> {
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
    let mut texture_size = subject::load_texture(&args.scene_args)?.map(|t| t.size());
    let (map, distance) = match &args.scene {
        Some(scene) if is_hit_scene(scene) || is_tex_scene(scene) => {
            match Job::load(scene, &args.scene_args, &args.run.settings(&spec))? {
                Job::Env(subject) => (Some(subject.map), None),
                Job::Hit(subject) => (Some(subject.map), Some(subject.distance)),
                Job::Tex(subject) => {
                    texture_size = subject.scene.textures.first().map(PlanarMap::size);
                    (Some(subject.sky), None)
                }
            }
        }
        Some(scene) => {
            let settings = args.run.settings(&spec);
            let subject = subject::load(scene, &args.scene_args, &settings)?;
            (Some(subject.map), args.scene_args.distance()?)
        }
        None => (subject::load_map(&args.scene_args)?, args.scene_args.distance()?),
    };
    super::note(&format!("version {}, unit {}, seed 0", env!("CARGO_PKG_VERSION"), spec.hash()));
    let mut tracer = Tracer::new(args.mode(&spec), spec, map, face_size)?;
    tracer.distance = distance;
    if let Some(size) = texture_size {
        tracer.texture_size = size;
    }
    let out = std::io::BufWriter::new(std::io::stdout().lock());
    stream(&mut tracer, &subject, BufReader::new(reader), out)
}

/// Answers each line of `reader` on `out`, in order, up to the first that is wrong.
fn stream<R: Read>(
    tracer: &mut Tracer,
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
        match one(tracer, subject, number, &bytes) {
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
    for engine in [TraceEngine::Rtl, TraceEngine::F64] {
        let spec = UnitSpec::default();
        let mode =
            Mode { engine, raw: false, settings: spec.settings(crate::unit::ReferenceAxis::Exact) };
        let map = build_mips(CubeLevel { size: 8, texels: vec![[0.5, 0.25, 1.0]; 6 * 8 * 8] });
        let mut tracer = Tracer::new(mode, spec, Some(map), 8)?;
        tracer.distance = Distance::analytic("box:3,2,4").transpose()?;
        match stream(&mut tracer, "trace lines", BufReader::new(bytes), std::io::sink()) {
            Ok(()) | Err(Failure::Closed | Failure::Disagrees(_)) => {}
            Err(Failure::Input(error)) => return Err(error),
        }
    }
    Ok(())
}

fn one(
    tracer: &mut Tracer,
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
    if let Some(answer) =
        trace_cone::answer(&tracer.spec, tracer.cone_output(), subject, number, text)?
    {
        return Ok(Some(answer));
    }
    if let Some(answer) = trace_tex::answer(tracer, subject, number, text)? {
        return Ok(Some(answer));
    }
    let (line, op) = json_lines::parse(subject, number, text)?;
    let out = match op {
        Op::Env(fragment) => tracer.out(&fragment)?,
        Op::Hit(ray) => trace_hit::out(tracer, &ray).map_err(|e| e.at(format!("line {number}")))?,
        Op::Tex(fragment, cone) => trace_tex::out(tracer, &fragment, cone)?,
    };
    Ok(Some(line.with_out(&out)))
}
