//! Jobs: scenes with their maps, as every engine renders them.

pub mod env;
pub mod hit;
pub mod lit;
pub mod tex;
pub(crate) mod tex_requests;
pub(super) mod tex_row;

use super::float::{EwaEngine, F64Engine, TruthEngine};
use super::gpu::GpuEngine;
use super::gpu::check::{check_env, check_hit, check_tex};
use super::gpu::sampler::SamplerEngine;
use super::hit::{HitResult, HitRtl};
use super::probe::RtlProbe;
use super::registers::RegisterErrors;
use super::reuse::lines::Line;
use super::rtl::RtlEngine;
use super::stage_checks::StageChecks;
use super::{Engine, EngineKind, Progress, Rendering};
use crate::base::num;
use crate::cube::CubeMap;
use crate::error::InputError;
use crate::fragment::HitFragment;
use crate::gpu::{Gpu, GpuError};
use crate::operation::Operation;
use crate::planar::PlanarMap;
use crate::settings::Settings;
use crate::truth::TruthOptions;
use crate::unit::UnitSpec;
use env::EnvJob;
use hit::HitJob;
use tex::{TexEngine, TexJob};

/// A scene with its maps.
#[derive(Clone, Debug)]
pub enum Job {
    /// Fragments of reflections.
    Env(Box<EnvJob>),
    /// Rays against an impostor.
    Hit(Box<HitJob>),
    /// Paths with ray cones.
    Tex(Box<TexJob>),
}

impl Job {
    /// The job with its scene moved to the right and down by so many pixels. Pixels without a fragment keep
    /// the colours of the view that stands still.
    #[must_use]
    pub fn shifted(&self, pixels: f64) -> Self {
        let mut job = self.clone();
        match &mut job {
            Self::Env(job) => job.scene.shift(pixels),
            Self::Hit(job) => job.scene.shift(pixels),
            Self::Tex(job) => job.scene.camera.shift += pixels,
        }
        job
    }

    /// Columns and rows.
    #[must_use]
    pub fn size(&self) -> [usize; 2] {
        match self {
            Self::Env(job) => [job.scene.width, job.scene.height],
            Self::Hit(job) => [job.scene.width, job.scene.height],
            Self::Tex(job) => [job.scene.width, job.scene.height],
        }
    }

    /// Fragments, rays or requests.
    #[must_use]
    pub fn fragments(&self) -> u64 {
        match self {
            Self::Env(job) => num::u64(job.scene.fragments.len()),
            Self::Hit(job) => num::u64(job.scene.rays.len()),
            Self::Tex(job) => job.requests,
        }
    }

    /// How far an engine's progress counts.
    #[must_use]
    pub fn total(&self, kind: EngineKind) -> u64 {
        match self {
            Self::Hit(job) if kind == EngineKind::Truth => num::u64(job.scene.pixels().len()),
            Self::Env(_) | Self::Hit(_) => self.fragments(),
            Self::Tex(job) => num::u64(job.scene.width * job.scene.height),
        }
    }

    /// The pixel of each fragment or ray; none for textures, where a pixel has many requests.
    #[must_use]
    pub fn pixels(&self) -> Vec<[u32; 2]> {
        match self {
            Self::Env(job) => job.scene.fragments.iter().map(|f| f.pixel).collect(),
            Self::Hit(job) => job.scene.rays.iter().map(|ray| ray.pixel).collect(),
            Self::Tex(_) => Vec::new(),
        }
    }

    /// The operation that the unit must be able to do.
    #[must_use]
    pub fn operation(&self) -> Operation {
        match self {
            Self::Env(job) => Operation::Env(job.needs()),
            Self::Hit(_) => Operation::Hit,
            Self::Tex(_) => Operation::Tex,
        }
    }

    /// The environment that is filtered.
    #[must_use]
    pub fn map(&self) -> &CubeMap {
        match self {
            Self::Env(job) => &job.map,
            Self::Hit(job) => &job.map,
            Self::Tex(job) => &job.sky,
        }
    }

    /// The 2-D textures that are filtered.
    #[must_use]
    pub fn textures(&self) -> &[PlanarMap] {
        match self {
            Self::Env(_) | Self::Hit(_) => &[],
            Self::Tex(job) => &job.scene.textures,
        }
    }

    /// Where the colours come from if no file was named.
    #[must_use]
    pub fn origin(&self) -> &'static str {
        match self {
            Self::Env(_) => "procedural environment",
            Self::Hit(_) => "the world's impostor",
            Self::Tex(_) => "procedural textures, procedural environment",
        }
    }

    /// Renders by an engine.
    ///
    /// # Errors
    /// The unit is refused, or the driver's error.
    pub fn render(
        &self,
        kind: EngineKind,
        setup: &Setup<'_>,
        progress: Progress<'_>,
    ) -> Result<Rendering, InputError> {
        Ok(match self {
            Self::Env(job) => setup.engine(kind, &**job)?.render(job, progress),
            Self::Hit(job) => setup.engine(kind, &**job)?.render(job, progress),
            Self::Tex(job) => setup.engine(kind, &**job)?.render(job, progress),
        }?)
    }

    /// Renders by the float reference, with the probe line of each request.
    #[must_use]
    pub fn lines(&self, settings: &Settings) -> (Rendering, Vec<Line>) {
        match self {
            Self::Env(job) => job.f64(settings, &|_| {}),
            Self::Hit(job) => job.lines(settings),
            Self::Tex(job) => job.lines(settings),
        }
    }

    /// Compiles the integer model.
    ///
    /// # Errors
    /// The unit is refused.
    pub fn compile(&self, spec: &UnitSpec) -> Result<Box<dyn Model + '_>, InputError> {
        Ok(match self {
            Self::Env(job) => Box::new((&**job, job.rtl(spec)?)),
            Self::Hit(job) => Box::new((&**job, job.rtl(spec)?)),
            Self::Tex(job) => Box::new((&**job, job.rtl(spec)?)),
        })
    }

    /// Every register of every stage of a GPU's kernels against the float reference.
    ///
    /// # Errors
    /// The driver's error.
    pub fn check_stages(
        &self,
        gpu: &Gpu,
        settings: &Settings,
        progress: Progress<'_>,
    ) -> Result<StageChecks, GpuError> {
        match self {
            Self::Env(job) => check_env(gpu, settings, &job.map, &job.scene.fragments, progress),
            Self::Hit(job) => {
                let rays: Vec<_> = job.scene.rays.iter().map(|r| (r.pixel, r.fragment)).collect();
                check_hit(gpu, settings, (&job.map, &job.distance), &rays, progress)
            }
            Self::Tex(job) => check_tex(gpu, settings, job, progress),
        }
    }
}

/// The inputs of engines besides the job.
#[derive(Clone, Copy)]
pub struct Setup<'a> {
    /// The unit of `rtl`.
    pub spec: &'a UnitSpec,
    /// The other engines' policies.
    pub settings: &'a Settings,
    /// Samples and seed of `truth`.
    pub truth: TruthOptions,
    /// The device of `gpu` and `sampler`.
    pub gpu: Option<&'a Gpu>,
}

impl<'a> Setup<'a> {
    /// An engine for a job.
    fn engine<J: Compile>(
        &self,
        kind: EngineKind,
        job: &J,
    ) -> Result<Box<dyn Engine<J> + 'a>, InputError>
    where
        GpuEngine<'a>: Engine<J>,
        SamplerEngine<'a>: Engine<J>,
        F64Engine: Engine<J>,
        EwaEngine: Engine<J>,
        TruthEngine: Engine<J>,
    {
        let settings = self.settings.clone();
        let gpu = || self.gpu.ok_or(GpuError::NoAdapter);
        Ok(match kind {
            EngineKind::Rtl => Box::new(job.rtl(self.spec)?),
            EngineKind::Gpu => Box::new(GpuEngine { gpu: gpu()?, settings }),
            EngineKind::Sampler => Box::new(SamplerEngine { gpu: gpu()?, settings }),
            EngineKind::F64 => Box::new(F64Engine { settings }),
            EngineKind::Ewa => Box::new(EwaEngine { settings }),
            EngineKind::Truth => Box::new(TruthEngine { settings, options: self.truth }),
        })
    }
}

/// A job that the integer model is compiled for.
pub trait Compile: Sized {
    /// The integer model.
    type Rtl: Engine<Self> + 'static;

    /// Compiles the unit and encodes the maps.
    ///
    /// # Errors
    /// The unit is refused.
    fn rtl(&self, spec: &UnitSpec) -> Result<Self::Rtl, InputError>;
}

impl Compile for EnvJob {
    type Rtl = RtlEngine;

    fn rtl(&self, spec: &UnitSpec) -> Result<RtlEngine, InputError> {
        RtlEngine::new(spec, self.needs(), &self.map)
    }
}

impl Compile for HitJob {
    type Rtl = HitRtl;

    fn rtl(&self, spec: &UnitSpec) -> Result<HitRtl, InputError> {
        HitRtl::new(spec, &self.distance, Some(&self.map), self.map.size())
    }
}

impl Compile for TexJob {
    type Rtl = TexEngine;

    fn rtl(&self, spec: &UnitSpec) -> Result<TexEngine, InputError> {
        TexEngine::new(spec, self)
    }
}

/// The integer model, compiled for a job.
pub trait Model {
    /// Renders the job.
    ///
    /// # Errors
    /// None: those of [`Engine`].
    fn render(&self, progress: Progress<'_>) -> Result<Rendering, GpuError>;

    /// Every register against the float reference.
    fn registers(&self, settings: &Settings, progress: Progress<'_>) -> RegisterErrors;

    /// Writes the registers of a pixel's first request into `probe`; the names of its flags, or nothing where the pixel
    /// has no request.
    fn trace(&self, pixel: [u32; 2], probe: &mut RtlProbe) -> Option<Vec<String>>;

    /// Results of other rays with the job's distances; nothing where the operation searches for none.
    fn search(&self, _: &[HitFragment]) -> Option<Vec<HitResult>> {
        None
    }
}
