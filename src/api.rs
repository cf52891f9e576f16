//! The door for programs: a unit, a scene, and what can be asked of them.
//!
//! [`Unit`] has every knob, [`Scene`] a workload with its maps. [`compare`] renders it by several engines,
//! [`trace`] and [`filter`] show every register of one request, [`vectors`] makes test vectors and judges a device.
//! The other modules of this crate are internal: they are public for the tests and the benches, and change without
//! notice.

use fixed::types::I64F64;
use rtl_model::regs::Reg;

use crate::base::num;
use crate::conformance::cases::{self, Schedule};
use crate::conformance::check::{Difference, difference};
use crate::conformance::field::Shape;
use crate::conformance::subject::Subject;
use crate::conformance::{Build, Device, Harness, harness};
use crate::cube::CubeMap;
use crate::engine::probe::{Code, RtlProbe, rtl};
use crate::engine::{EngineKind, EnvJob, HitJob, Job, Rendering, Setup, TexJob, encode};
use crate::error::InputError;
use crate::fragment::Fragment;
use crate::mips::build_mips;
use crate::operation::Operation;
use crate::picture::Picture;
use crate::report::metrics::{self, Pair};
use crate::scene::{DEFAULT_FACE_SIZE, SceneOptions, environment, hit, registry, tex};
use crate::truth::TruthOptions;
use crate::unit::{ReferenceAxis, UnitSpec as Unit, refused};

/// A scene with its maps: the requests of a picture.
#[derive(Clone, Debug)]
pub struct Scene {
    job: Job,
}

impl Scene {
    /// A built-in scene of [`registry::all`] with its own maps, as a picture of `size` columns and rows.
    ///
    /// # Errors
    /// There is no scene of that name, or the size is 0 or above the limit.
    pub fn built_in(name: &str, size: [usize; 2]) -> Result<Self, InputError> {
        let [width, height] = size;
        Self::build(name, &SceneOptions { width, height, ..SceneOptions::default() })
    }

    /// The same with a bump map, a mesh or another size of the procedural environment.
    ///
    /// # Errors
    /// As [`Scene::built_in`]; a file that cannot be read.
    pub fn build(name: &str, options: &SceneOptions) -> Result<Self, InputError> {
        let job = match registry::find(name)?.operation() {
            Operation::Env(_) => {
                let settings = Unit::default().settings(ReferenceAxis::Exact);
                let scene = crate::scene::build(name, options, &settings)?;
                let map = build_mips(scene.environment());
                Job::Env(Box::new(EnvJob::new(scene, map, &settings)))
            }
            Operation::Hit => Job::Hit(Box::new(HitJob::built_in(hit::build(name, options)?))),
            Operation::Tex => {
                let sky = build_mips(environment::procedural(DEFAULT_FACE_SIZE));
                Job::Tex(Box::new(TexJob::new(tex::build(name, options, None)?, sky)))
            }
        };
        Ok(Self { job })
    }

    /// Columns and rows of its picture.
    #[must_use]
    pub fn size(&self) -> [usize; 2] {
        self.job.size()
    }

    /// Fragments, rays or texture requests.
    #[must_use]
    pub fn requests(&self) -> u64 {
        self.job.fragments()
    }

    /// The operation that the unit must have.
    #[must_use]
    pub fn operation(&self) -> Operation {
        self.job.operation()
    }

    /// The environment, level by level.
    #[must_use]
    pub fn map(&self) -> &CubeMap {
        self.job.map()
    }
}

/// Pictures of one scene by several engines.
#[derive(Clone, Debug)]
pub struct Comparison {
    renderings: Vec<(EngineKind, Rendering)>,
}

impl Comparison {
    /// An engine's result: its picture, probes, texels, flags and seconds.
    #[must_use]
    pub fn rendering(&self, engine: EngineKind) -> Option<&Rendering> {
        self.renderings.iter().find(|(kind, _)| *kind == engine).map(|(_, rendering)| rendering)
    }

    /// An engine's picture in linear RGB.
    #[must_use]
    pub fn picture(&self, engine: EngineKind) -> Option<&Picture> {
        self.rendering(engine).map(|rendering| &rendering.picture)
    }

    /// How far `a` is from `b`, as `tapline compare` prints it: sRGB-encoded values with peak 1, fragments alone.
    ///
    /// # Errors
    /// One of the engines did not run; a picture without a fragment or with a value that is not finite.
    pub fn pair(&self, a: EngineKind, b: EngineKind) -> Result<Pair, InputError> {
        let picture = |kind: EngineKind| {
            self.picture(kind).ok_or_else(|| {
                let ran: Vec<_> = self.renderings.iter().map(|(kind, _)| kind.name()).collect();
                InputError::new("engine", ran.join(", "), kind.name(), "compare with that engine")
            })
        };
        metrics::compare(picture(a)?, picture(b)?, 0.0)
    }
}

/// Renders a scene by each of `engines`; those on a GPU are refused here, as they need a device.
///
/// ```
/// use tapline::engine::EngineKind::{F64, Rtl};
/// use tapline::{Scene, Unit, compare};
///
/// let scene = Scene::built_in("sphere", [64, 64])?;
/// let coarse = Unit::default().with("eigen.entries=4")?;
/// let psnr_db = |unit: &Unit| compare(unit, &scene, &[Rtl, F64])?.pair(Rtl, F64).map(|p| p.psnr_db);
/// assert!(psnr_db(&Unit::default())? > psnr_db(&coarse)?);
/// # Ok::<(), tapline::error::InputError>(())
/// ```
///
/// # Errors
/// The unit is refused, with the path of the knob; an engine that needs a GPU.
pub fn compare(
    unit: &Unit,
    scene: &Scene,
    engines: &[EngineKind],
) -> Result<Comparison, InputError> {
    let settings = &unit.settings(ReferenceAxis::Exact);
    let setup = Setup { spec: unit, settings, truth: TruthOptions::default(), gpu: None };
    let render = |kind: &EngineKind| Ok((*kind, scene.job.render(*kind, &setup, &|_| {})?));
    let renderings = engines.iter().map(render).collect::<Result<_, InputError>>()?;
    Ok(Comparison { renderings })
}

/// A register of a request, component by component.
#[derive(Clone, Debug)]
pub struct Register {
    reg: Reg,
    /// The integers with their fraction bits.
    pub codes: Vec<Code>,
}

impl Register {
    /// `stage.register`, as in `docs/stages`.
    #[must_use]
    pub fn name(&self) -> String {
        self.reg.to_string()
    }

    /// The values to the nearest double.
    #[must_use]
    pub fn values(&self) -> Vec<f64> {
        self.codes.iter().map(|code| code.value()).collect()
    }

    /// The values as fixed-point numbers; nothing where one does not fit into 64 bits on either side of the point.
    #[must_use]
    pub fn exact(&self) -> Option<Vec<I64F64>> {
        self.codes.iter().map(|code| exact(*code)).collect()
    }
}

/// raw · 2^−frac, if it is a multiple of 2^−64 within 64 bits before the point.
fn exact(code: Code) -> Option<I64F64> {
    let bits = i128::from(code.raw);
    let left = 64_i64.saturating_sub(code.frac);
    let by = u32::try_from(left.unsigned_abs()).ok()?;
    let shifted = if left < 0 { bits.checked_shr(by) } else { bits.checked_shl(by) }?;
    let back = if left < 0 { shifted.checked_shl(by) } else { shifted.checked_shr(by) };
    (back == Some(bits)).then_some(I64F64::from_bits(shifted))
}

/// The registers of one request.
#[derive(Clone, Debug)]
pub struct Trace {
    probe: RtlProbe,
    /// Names of the flags that the request set.
    pub flags: Vec<String>,
}

impl Trace {
    /// A register by its name, such as `footprint.probes`; nothing where the request does not reach its stage.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<Register> {
        self.registers().find(|register| register.name() == name)
    }

    /// Every register that was written, in pipeline order.
    pub fn registers(&self) -> impl Iterator<Item = Register> {
        Reg::ALL.iter().filter_map(|&reg| {
            let codes = self.probe.get(reg).iter().copied();
            let codes: Vec<Code> = codes.filter(|code| code.is_written()).collect();
            (!codes.is_empty()).then_some(Register { reg, codes })
        })
    }

    /// The filtered colour, linear RGB: exact, as `filter.color` has at most 48 bits.
    #[must_use]
    pub fn color(&self) -> Option<[I64F64; 3]> {
        let codes = self.probe.get(Reg::FilterColor);
        codes.iter().map(|code| exact(*code)).collect::<Option<Vec<_>>>()?.try_into().ok()
    }
}

/// The registers of a pixel's first request; nothing where the pixel has none.
///
/// ```
/// use tapline::{Scene, Unit, trace};
///
/// let scene = Scene::built_in("room", [32, 32])?;
/// let ray = trace(&Unit::default(), &scene, [16, 16])?.expect("the reflector is in the middle");
/// let d = ray.get("hit.d").expect("every ray has a parameter");
/// assert!(d.values().iter().all(|d| *d > 0.0));
/// # Ok::<(), tapline::error::InputError>(())
/// ```
///
/// # Errors
/// The unit is refused.
pub fn trace(unit: &Unit, scene: &Scene, pixel: [u32; 2]) -> Result<Option<Trace>, InputError> {
    let mut probe = RtlProbe::default();
    let flags = scene.job.compile(unit)?.trace(pixel, &mut probe);
    Ok(flags.map(|flags| Trace { probe, flags }))
}

/// Filters one fragment of your own over an environment.
///
/// ```
/// use tapline::fragment::Fragment;
/// use tapline::{Scene, Unit, filter};
///
/// let fragment = Fragment {
///     v: [0.0, 0.0, 1.0],
///     n: [0.0, 0.6, 0.8],
///     dv_dx: [0.002, 0.0, 0.0],
///     dv_dy: [0.0, 0.002, 0.0],
///     dn_dx: [0.01, 0.0, 0.0],
///     dn_dy: [0.0, 0.008, -0.006],
///     h: None,
///     bump: None,
///     rough: None,
/// };
/// let scene = Scene::built_in("sphere", [1, 1])?;
/// let out = filter(&Unit::default(), &fragment, scene.map())?;
/// assert!(out.flags.is_empty());
/// assert!(out.color().expect("filtered").iter().all(|channel| *channel >= 0));
/// # Ok::<(), tapline::error::InputError>(())
/// ```
///
/// # Errors
/// The unit is refused.
pub fn filter(unit: &Unit, fragment: &Fragment, map: &CubeMap) -> Result<Trace, InputError> {
    let (config, needs) = (&unit.config, encode::needs(fragment));
    let model = rtl_model::Unit::new(config, needs, num::u32(map.size())).map_err(refused)?;
    let texture = encode::texture(config, map).map_err(refused)?;
    let mut probe = RtlProbe::default();
    let flags = rtl(&model, config, fragment, Some(&texture), &mut probe).flags;
    Ok(Trace { probe, flags })
}

/// A case of a stage: the numbers of its fields, inputs and the model's outputs, in [`Vectors::shape`]'s order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Vector {
    /// Numbers that go in.
    pub input: Vec<i64>,
    /// Registers and flags that come out.
    pub output: Vec<i64>,
}

/// The test vectors of a stage or an operation, one after the other.
pub struct Vectors {
    model: Harness,
    subject: Subject,
    schedule: Schedule,
    next: u64,
    end: u64,
}

/// What a device's outputs were.
#[derive(Clone, Debug, Default)]
pub struct Judgement {
    /// Cases that ran.
    pub cases: u64,
    /// Cases with a wrong field.
    pub wrong: u64,
    /// The first wrong field of the first such case.
    pub first: Option<Difference>,
    /// Outputs of the first case that had more or fewer than the shape.
    pub lengths: Option<usize>,
}

/// The vectors that cover a stage at `level` 1 or 2, or an operation (`unit`, `unit-hit`, `unit-tex`):
/// those of `tapline vectors gen`.
///
/// ```
/// use tapline::{Unit, vectors};
///
/// let mut eigen = vectors(&Unit::default(), "eigen", 1)?;
/// let case = eigen.next().expect("there are hundreds");
/// assert_eq!(case.output.len(), eigen.shape().output_len());
/// # Ok::<(), tapline::error::InputError>(())
/// ```
///
/// # Errors
/// There is no such stage; the unit is refused.
pub fn vectors(unit: &Unit, stage: &str, level: u32) -> Result<Vectors, InputError> {
    Vectors::new(unit, Subject::parse(stage)?, Build::default(), (level, 1))
}

impl Vectors {
    /// The vectors of a subject in a unit that was built with some parts, by level and seed.
    pub(crate) fn new(
        unit: &Unit,
        subject: Subject,
        build: Build,
        (level, seed): (u32, u64),
    ) -> Result<Self, InputError> {
        let model = harness(unit, subject, build)?;
        let schedule = Schedule::new(&model, subject, level, seed);
        Ok(Self { model, subject, schedule, next: 0, end: schedule.cases() })
    }

    /// As many cases in all as `cases`, whether the level needs more or fewer.
    #[must_use]
    pub fn with_cases(mut self, cases: u64) -> Self {
        self.end = cases;
        self
    }

    /// Cases still to come.
    #[must_use]
    pub fn remaining(&self) -> u64 {
        self.end.saturating_sub(self.next)
    }

    /// The fields: stage, register, range and width of every number.
    #[must_use]
    pub fn shape(&self) -> &Shape {
        self.model.shape()
    }

    /// Runs every case through a device and compares bit by bit. More or fewer outputs than the shape has are wrong.
    pub fn judge(self, device: &mut dyn FnMut(&[i64]) -> Vec<i64>) -> Judgement {
        let fields = self.shape().outputs.clone();
        let mut judgement = Judgement::default();
        for Vector { input, output } in self {
            let observed = device(&input);
            judgement.cases += 1;
            if observed.len() != output.len() {
                judgement.wrong += 1;
                judgement.lengths.get_or_insert(observed.len());
            } else if let Some(wrong) = difference(&fields, &observed, &output) {
                judgement.wrong += 1;
                judgement.first.get_or_insert(wrong);
            }
        }
        judgement
    }
}

impl Iterator for Vectors {
    type Item = Vector;

    fn next(&mut self) -> Option<Vector> {
        let place = (self.next < self.end).then(|| self.schedule.place(self.next))?;
        self.next += 1;
        let shape = self.model.shape();
        let (mut input, mut output) = (vec![0; shape.input_len()], vec![0; shape.output_len()]);
        cases::fill(&mut self.model, self.subject, place, &mut input);
        self.model.run(&input, &mut output);
        Some(Vector { input, output })
    }
}
