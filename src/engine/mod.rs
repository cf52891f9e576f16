//! Engines side by side: the same fragments through the integer model, the float reference, the
//! elliptical Gaussian and supersampled truth.

pub mod cones;
pub mod dispatch;
pub mod encode;
pub mod float;
pub mod gpu;
pub mod hit;
pub mod hit_subject;
pub mod probe;
pub mod registers;
pub mod reuse;
pub mod rtl;
pub mod sampler;
pub mod tex;
pub(crate) mod tex_requests;
mod tex_row;
pub mod tex_subject;
pub mod tiles;

use std::collections::BTreeMap;

use rtl_model::unit::Needs;

use crate::base::num;
use crate::cube::CubeMap;
use crate::picture::Picture;
use crate::scene::Scene;

/// The accuracy ladder, from the unit down to the truth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, clap::ValueEnum)]
pub enum Rung {
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

impl Rung {
    /// Every rung in the ladder's order.
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

/// A scene with its environment, as every engine renders it.
#[derive(Clone, Debug)]
pub struct Subject {
    /// Geometry and fragments.
    pub scene: Scene,
    /// Environment with its mip chain.
    pub map: CubeMap,
    /// Colours of the pixels without a fragment, and black elsewhere.
    pub background: Vec<[f64; 3]>,
}

impl Subject {
    /// The picture of `colors`, one a fragment, over the background.
    #[must_use]
    pub fn picture(&self, colors: &[[f64; 3]]) -> Picture {
        let mut picture = Picture::new(self.scene.width, self.scene.height);
        picture.rgb.copy_from_slice(&self.background);
        for (fragment, color) in self.scene.fragments.iter().zip(colors) {
            let index = self.index(fragment.pixel);
            picture.rgb[index] = *color;
            picture.covered[index] = true;
        }
        picture
    }

    /// Index of a pixel.
    #[must_use]
    pub fn index(&self, [column, row]: [u32; 2]) -> usize {
        let place = |x: u32| num::usize(x);
        place(row) * self.scene.width + place(column)
    }

    /// The parts of the unit that the fragments need. All of a scene need the same, so the first one tells; a
    /// scene without fragments needs nothing.
    #[must_use]
    pub fn needs(&self) -> Needs {
        self.scene
            .fragments
            .first()
            .map_or(Needs { bump: false, rough: false }, |f| encode::needs(&f.fragment))
    }
}

/// An engine's result for a scene.
#[derive(Clone, Debug)]
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
    /// A picture by real rays: nothing was filtered.
    fn by_rays(picture: Picture, seconds: f64, samples: u64, standard_error: f64) -> Self {
        Self {
            picture,
            seconds,
            probes: samples,
            texels: 0,
            flags: BTreeMap::new(),
            standard_error: Some(standard_error),
            searches: None,
            texture_use: None,
            beyond_f32: None,
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

/// Something that filters fragments.
pub trait Engine: Sync {
    /// Its place in the ladder.
    fn rung(&self) -> Rung;

    /// Renders all fragments.
    fn render(&self, subject: &Subject, progress: Progress<'_>) -> Rendering;
}
