//! The interface of a texture sampler: textures, sampler states and queries in, colours out. A GPU has one, and a model
//! of a GPU is one.

use crate::base::named::named;
use crate::error::InputError;

named! {
    /// Kind of texture.
    pub enum Shape {
        /// One face.
        Planar = "2-D",
        /// Six faces, +X −X +Y −Y +Z −Z.
        Cube = "cube",
    }
}

impl Shape {
    /// Number of faces.
    #[must_use]
    pub const fn faces(self) -> usize {
        match self {
            Self::Planar => 1,
            Self::Cube => 6,
        }
    }
}

named! {
    /// The stored form of a texel.
    pub enum Format {
        /// 4 × 8 bits, 0…1.
        Unorm8 = "rgba8unorm",
        /// 4 × half float.
        Half = "rgba16float",
        /// 4 × float; not every device filters it.
        Float = "rgba32float",
    }
}

/// A square texture with mip levels: level L has size/2^L texels along an edge, face-major, then row by row.
#[derive(Clone, Debug)]
pub struct Image {
    /// Kind.
    pub shape: Shape,
    /// Storage.
    pub format: Format,
    /// Texels along an edge of level 0, a power of two.
    pub size: usize,
    /// Levels, the largest first.
    pub levels: Vec<Vec<[f32; 4]>>,
}

impl Image {
    /// A texture with `levels` levels whose texels `texel(level, face, x, y)` gives.
    pub fn new(
        shape: Shape,
        format: Format,
        size: usize,
        levels: usize,
        mut texel: impl FnMut(usize, usize, usize, usize) -> [f32; 4],
    ) -> Self {
        let mut made = Vec::new();
        for level in 0..levels {
            let side = (size >> level).max(1);
            let mut texels = Vec::with_capacity(shape.faces() * side * side);
            for face in 0..shape.faces() {
                for y in 0..side {
                    for x in 0..side {
                        texels.push(texel(level, face, x, y));
                    }
                }
            }
            made.push(texels);
        }
        Self { shape, format, size, levels: made }
    }

    /// Texels along an edge of a level.
    #[must_use]
    pub fn side(&self, level: usize) -> usize {
        (self.size >> level).max(1)
    }
}

/// A sampler: linear or nearest between texels and between levels, clamped to the edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct State {
    /// Linear between texels.
    pub linear: bool,
    /// Linear between levels.
    pub linear_mips: bool,
    /// Largest anisotropy, 1 to 16; above 1 both filters must be linear.
    pub anisotropy: u16,
}

impl State {
    /// Linear everywhere.
    #[must_use]
    pub const fn trilinear(anisotropy: u16) -> Self {
        Self { linear: true, linear_mips: true, anisotropy }
    }

    /// Nearest everywhere.
    #[must_use]
    pub const fn nearest() -> Self {
        Self { linear: false, linear_mips: false, anisotropy: 1 }
    }
}

named! {
    /// Where the level of detail comes from.
    pub enum Source {
        /// Given: `textureSampleLevel`.
        Level = "textureSampleLevel",
        /// From given derivatives: `textureSampleGrad`.
        Gradient = "textureSampleGrad",
        /// From the differences of a 2 × 2 quad of pixels that has these derivatives: `textureSample`.
        Quad = "textureSample",
    }
}

/// One look-up. Planar textures have coordinates 0…1, cubes directions; planar ones ignore the third component.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Query {
    /// Coordinates or direction.
    pub at: [f32; 3],
    /// Its derivative per pixel to the right.
    pub dx: [f32; 3],
    /// Its derivative per pixel downwards.
    pub dy: [f32; 3],
    /// Level of detail for [`Source::Level`].
    pub lod: f32,
}

/// Something that samples textures: a device, or a model of one.
pub trait TextureUnit {
    /// The colours of `queries` on one texture through one sampler.
    ///
    /// # Errors
    ///
    /// The device's error.
    fn sample(
        &mut self,
        image: &Image,
        state: State,
        source: Source,
        queries: &[Query],
    ) -> Result<Vec<[f32; 4]>, InputError>;

    /// Whether it filters a format.
    fn filters(&self, format: Format) -> bool;

    /// Whether it takes anisotropy above 1.
    fn is_anisotropic(&self) -> bool;
}

/// The format with the finest results.
#[must_use]
pub fn finest(unit: &dyn TextureUnit) -> Format {
    if unit.filters(Format::Float) { Format::Float } else { Format::Half }
}

/// As [`TextureUnit::sample`], each given gradient in four neighbouring invocations: a device that takes differences between
/// neighbours in its place sees none, and what it returns does not depend on the other queries.
///
/// # Errors
///
/// The device's error.
pub fn alone(
    unit: &mut dyn TextureUnit,
    image: &Image,
    state: State,
    source: Source,
    queries: &[Query],
) -> Result<Vec<[f32; 4]>, InputError> {
    if source != Source::Gradient {
        return unit.sample(image, state, source, queries);
    }
    let four: Vec<Query> = queries.iter().flat_map(|q| [*q; 4]).collect();
    let seen = unit.sample(image, state, source, &four)?;
    Ok(seen.into_iter().step_by(4).collect())
}
