//! Engines side by side: the same fragments through the integer model, the float reference, the
//! elliptical Gaussian and supersampled truth.

pub mod cones;
#[cfg(feature = "files")]
pub mod decimal;
pub mod dispatch;
pub mod encode;
pub mod float;
#[cfg(feature = "gpu")]
pub mod gpu;
#[cfg(not(feature = "gpu"))]
#[path = "gpu/absent.rs"]
pub mod gpu;
pub mod hit;
pub mod job;
pub mod probe;
pub mod ranges;
pub mod registers;
pub mod reuse;
pub mod rtl;
pub mod stage_checks;
pub mod tex;
pub mod tiles;

use std::collections::BTreeMap;
use std::time::Instant;

pub use job::env::EnvJob;
pub use job::hit::HitJob;
pub use job::tex::TexJob;
pub use job::{Job, Model, Setup};

use crate::gpu::GpuError;
use crate::picture::Picture;
use crate::truth::TruthPicture;

/// The accuracy ladder, from the unit down to the truth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum EngineKind {
    /// Bit-accurate integer model.
    Rtl,
    /// WGSL through wgpu.
    Gpu,
    /// A GPU's own sampler; never unless it is named, for what it computes is no form of the unit's algorithm.
    Sampler,
    /// Float reference of the same algorithm.
    F64,
    /// Elliptical Gaussian of the same covariance.
    Ewa,
    /// Supersampled rays.
    Truth,
}

impl EngineKind {
    /// Every kind in the ladder's order.
    pub const ALL: [Self; 6] =
        [Self::Rtl, Self::Gpu, Self::Sampler, Self::F64, Self::Ewa, Self::Truth];

    /// Whether it runs where no engine is named.
    #[must_use]
    pub const fn is_default(self) -> bool {
        !matches!(self, Self::Sampler)
    }

    /// Whether it needs a GPU.
    #[must_use]
    pub const fn needs_gpu(self) -> bool {
        matches!(self, Self::Gpu | Self::Sampler)
    }

    /// The name on the command line and in results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Rtl => "rtl",
            Self::Gpu => "gpu",
            Self::Sampler => "sampler",
            Self::F64 => "f64",
            Self::Ewa => "ewa",
            Self::Truth => "truth",
        }
    }
}

/// An engine's result for a job.
#[derive(Clone, Debug, Default)]
pub struct Rendering {
    /// The picture.
    pub picture: Picture,
    /// Wall-clock seconds for the fragments, textures already made.
    pub seconds: f64,
    /// Probes taken.
    pub probes: u64,
    /// Texels read.
    pub texels: u64,
    /// Fragments that raised each flag.
    pub flags: BTreeMap<String, u64>,
    /// RMS standard error of the picture, where the engine estimates it (linear units).
    pub standard_error: Option<f64>,
    /// How the searches of the HIT operation ended, where the engine searches.
    pub searches: Option<Searches>,
    /// The requests to 2-D textures, where the scene has some and the engine filters.
    pub texture_use: Option<TextureUse>,
    /// How many fragments left the range of f32 on the way, and the pixel of the first, where the engine has that range.
    pub beyond_f32: Option<(u64, [u32; 2])>,
}

impl Rendering {
    /// A picture by real rays that began at `start`, over a background: nothing was filtered.
    fn by_rays(start: Instant, result: TruthPicture, background: &[[f64; 3]]) -> Self {
        let mut picture = result.picture;
        for (i, color) in background.iter().enumerate() {
            if !picture.covered[i] {
                picture.rgb[i] = *color;
            }
        }
        Self {
            picture,
            seconds: start.elapsed().as_secs_f64(),
            probes: result.samples,
            standard_error: Some(result.rms_standard_error),
            ..Self::default()
        }
    }
}

/// Levels and tiles that the requests to a scene's 2-D textures took.
#[derive(Clone, Debug)]
pub struct TextureUse {
    /// Levels of detail in colours, each pixel's requests by their weight.
    pub levels: Picture,
    /// Touched tiles of each texture; empty for engines that do not address texels.
    pub tiles: Vec<tiles::Tiles>,
}

/// How the searches of many rays ended.
#[derive(Clone, Debug, Default)]
pub struct Searches {
    /// Rays by status.
    pub status: BTreeMap<&'static str, u64>,
    /// Look-ups in the loop of each ray, in the rays' order.
    pub iterations: Vec<u32>,
    /// Rays with a step beyond the reference surface.
    pub overshot: u64,
}

impl Searches {
    /// The counts of results.
    #[must_use]
    pub fn of(results: &[hit::HitResult]) -> Self {
        let mut out = Self::default();
        for result in results {
            *out.status.entry(result.status.name()).or_default() += 1;
            out.iterations.push(result.iterations);
            out.overshot += u64::from(result.overshot);
        }
        out
    }

    /// Look-ups in the loop of a ray, on average.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "counts become a mean")]
    pub fn look_ups(&self) -> f64 {
        let sum: u64 = self.iterations.iter().map(|n| u64::from(*n)).sum();
        sum as f64 / self.iterations.len().max(1) as f64
    }
}

/// Counts finished fragments; called from any thread.
pub type Progress<'a> = &'a (dyn Fn(u64) + Sync);

/// Texels that `probes` trilinear probes read: a whole level of detail takes one level, any other takes two.
#[must_use]
pub fn texels_read(lod: f64, probes: u32) -> u64 {
    let levels = if lod.fract() == 0.0 { 1 } else { 2 };
    4 * levels * u64::from(probes)
}

/// Something that renders jobs of an operation.
pub trait Engine<J> {
    /// Renders a whole job.
    ///
    /// # Errors
    /// The driver's error, of engines on a GPU.
    fn render(&self, job: &J, progress: Progress<'_>) -> Result<Rendering, GpuError>;
}
