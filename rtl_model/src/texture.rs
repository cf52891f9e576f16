//! A texture in the unit's memory: every level of every face with a border of one texel.
//!
//! On a cube, border texels repeat the neighbouring faces' edges; a corner, which has no texel of its own, holds the
//! mean of the three that meet there (D3D11.3 §7.18.12), rounded once to the texel format. A 2-D texture has one
//! face, whose border holds what its addressing shows there.

use alloc::vec;
use alloc::vec::Vec;

use crate::config::{Config, ConfigError};
use crate::policy::Wrap;
use crate::texel;

/// One level: where it starts and how it is laid out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Level {
    /// Columns and rows, without the border.
    pub size: [usize; 2],
    /// Index of the first texel of face 0.
    pub offset: usize,
    /// Texels from row to row: columns + 2.
    pub stride: usize,
    /// Texels from face to face.
    pub face_stride: usize,
}

impl Level {
    /// Index of the texel in column `x`, row `y` of the bordered face.
    #[inline(always)]
    #[must_use]
    pub fn index(&self, face: usize, x: usize, y: usize) -> usize {
        self.offset + face * self.face_stride + y * self.stride + x
    }
}

/// Texel memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Texels {
    /// Three packed binary16 words ([`texel::pack`]), decoded by the filter.
    Half(Vec<u64>),
    /// Decoded texels.
    Wide(Vec<[i64; 4]>),
}

/// A texture as the unit reads it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Texture {
    /// Level 0 first.
    pub levels: Vec<Level>,
    /// All texels; the fourth channel of decoded ones is 0.
    pub texels: Texels,
}

/// One unbordered level as it comes in: `size`, and binary32 RGB words, face-major, then row-major.
#[derive(Clone, Copy, Debug)]
pub struct Source<'a> {
    /// Texels along an edge.
    pub size: usize,
    /// 6·size² texels.
    pub words: &'a [[u32; 3]],
}

/// One level of a 2-D texture as it comes in: binary32 RGB words, row by row.
#[derive(Clone, Copy, Debug)]
pub struct PlanarSource<'a> {
    /// Columns and rows.
    pub size: [usize; 2],
    /// columns · rows texels.
    pub words: &'a [[u32; 3]],
}

impl Wrap {
    /// The texel that stands at column or row `x` of `n`, which may lie outside.
    #[must_use]
    pub fn texel(self, x: i64, n: usize) -> usize {
        let n = i64::try_from(n.max(1)).unwrap_or(i64::MAX);
        let inside = match self {
            Self::Repeat => x.rem_euclid(n),
            Self::Clamp => x.clamp(0, n - 1),
            Self::Mirror => {
                let x = x.rem_euclid(2 * n);
                x.min(2 * n - 1 - x)
            }
        };
        usize::try_from(inside).unwrap_or(0)
    }
}

/// The texel beyond an edge: (face, x, y) with exactly one coordinate −1 or `size`, to the neighbour's.
pub type AcrossEdge<'a> = &'a dyn Fn(usize, usize, i64, i64) -> Option<(usize, usize, usize)>;

impl Texture {
    /// Encodes a mip chain. `across` maps coordinates beyond an edge to the neighbouring texel.
    pub fn new(
        config: &Config,
        sources: &[Source<'_>],
        across: AcrossEdge<'_>,
    ) -> Result<Self, ConfigError> {
        check_levels(sources, "6·size²", |source| {
            let texels = source.size.checked_mul(source.size)?.checked_mul(6)?;
            (texels > 0 && source.words.len() == texels).then_some(())
        })?;
        let sizes: Vec<[usize; 2]> = sources.iter().map(|s| [s.size; 2]).collect();
        Self::encode(config, &sizes, 6, |level, face, [x, y]| {
            let Some(source) = sources.get(level) else {
                return [[0; 3]; 3];
            };
            let size = source.size;
            let n = i64::try_from(size).unwrap_or(i64::MAX);
            let word = |(face, x, y): (usize, usize, usize)| {
                let at = (face * size + y) * size + x;
                source.words.get(at).copied().unwrap_or([0; 3])
            };
            let corner = (x < 0 || x == n) && (y < 0 || y == n);
            if corner {
                corner_texels(size, face, x, y, across).map(word)
            } else {
                [word(across(size, face, x, y).unwrap_or((face, 0, 0))); 3]
            }
        })
    }

    /// Encodes the mip chain of a 2-D texture with the borders that `wrap` asks for, column- and row-wise.
    pub fn planar(
        config: &Config,
        sources: &[PlanarSource<'_>],
        wrap: [Wrap; 2],
    ) -> Result<Self, ConfigError> {
        check_levels(sources, "columns·rows", |source| {
            let texels = source.size[0].checked_mul(source.size[1])?;
            (texels > 0 && source.words.len() == texels).then_some(())
        })?;
        let sizes: Vec<[usize; 2]> = sources.iter().map(|s| s.size).collect();
        Self::encode(config, &sizes, 1, |level, _, at| {
            let Some(source) = sources.get(level) else {
                return [[0; 3]; 3];
            };
            let [x, y] = [0, 1].map(|i| wrap[i].texel(at[i], source.size[i]));
            let texel = source.words.get(y * source.size[0] + x).copied();
            [texel.unwrap_or([0; 3]); 3]
        })
    }

    /// Lays levels out and fills them: `texel` gives, for a level, a face, a column and a row from −1 on, the three
    /// texels whose mean is stored there.
    fn encode(
        config: &Config,
        sizes: &[[usize; 2]],
        faces: usize,
        texel: impl Fn(usize, usize, [i64; 2]) -> [[u32; 3]; 3],
    ) -> Result<Self, ConfigError> {
        config.check()?;
        let mut levels = Vec::new();
        let mut total = 0;
        for size in sizes {
            let stride = size[0] + 2;
            let face_stride = stride * (size[1] + 2);
            levels.push(Level { size: *size, offset: total, stride, face_stride });
            total += faces * face_stride;
        }
        let mut wide = vec![[0i64; 4]; total];
        let mut half = Vec::new();
        let keep = texel::keeps_half(config);
        if keep {
            wide = Vec::new();
            half = vec![0u64; total];
        }
        for (index, level) in levels.iter().enumerate() {
            let [columns, rows] = level.size.map(|n| i64::try_from(n).unwrap_or(i64::MAX));
            for face in 0..faces {
                for y in -1..=rows {
                    for x in -1..=columns {
                        let at = level.index(face, place(x), place(y));
                        let texels = texel(index, face, [x, y]);
                        if keep {
                            let halves = texels.map(|t| t.map(texel::to_half));
                            if let Some(slot) = half.get_mut(at) {
                                *slot = texel::pack(mean_half(halves));
                            }
                        } else if let Some(slot) = wide.get_mut(at) {
                            *slot = mean_wide(texels.map(|t| texel::decode(config, t)));
                        }
                    }
                }
            }
        }
        Ok(Self { levels, texels: if keep { Texels::Half(half) } else { Texels::Wide(wide) } })
    }

    /// The same texture with every texel decoded: slower or faster, never other bits.
    #[must_use]
    pub fn widened(&self) -> Self {
        let texels = match &self.texels {
            Texels::Half(half) => half
                .iter()
                .map(|t| {
                    let [r, g, b] = texel::unpack_q24(*t);
                    [r, g, b, 0]
                })
                .collect(),
            Texels::Wide(wide) => wide.clone(),
        };
        Self { levels: self.levels.clone(), texels: Texels::Wide(texels) }
    }

    /// Bytes of texel memory.
    #[must_use]
    pub fn bytes(&self) -> usize {
        match &self.texels {
            Texels::Half(t) => t.len() * 8,
            Texels::Wide(t) => t.len() * 32,
        }
    }
}

fn place(x: i64) -> usize {
    usize::try_from(x + 1).unwrap_or(0)
}

/// The three texels that meet at a corner: the face's own and its two neighbours'.
pub(crate) fn corner_texels(
    size: usize,
    face: usize,
    x: i64,
    y: i64,
    across: AcrossEdge<'_>,
) -> [(usize, usize, usize); 3] {
    let last = i64::try_from(size).unwrap_or(i64::MAX) - 1;
    let (ix, iy) = (x.clamp(0, last), y.clamp(0, last));
    [(ix, iy), (x, iy), (ix, y)].map(|(x, y)| across(size, face, x, y).unwrap_or((face, 0, 0)))
}

/// Mean of three decoded texels, to nearest (no ties: thirds).
fn mean_wide(t: [[i64; 3]; 3]) -> [i64; 4] {
    let mean = |c: usize| (2 * (t[0][c] + t[1][c] + t[2][c]) + 3) / 6;
    [mean(0), mean(1), mean(2), 0]
}

/// Mean of three halves, rounded to a half (ties to even).
fn mean_half(t: [[u16; 3]; 3]) -> [u16; 3] {
    let mean = |c: usize| {
        let sum = t.map(|t| texel::half_to_q24(t[c])).into_iter().sum::<i64>();
        if t.iter().all(|h| h[c] == t[0][c]) { t[0][c] } else { third_to_half(sum.cast_unsigned()) }
    };
    [mean(0), mean(1), mean(2)]
}

/// sum/3 · 2^−24 as a half.
fn third_to_half(sum: u64) -> u16 {
    let top = 63 - i64::from((sum / 3).max(1).leading_zeros());
    // Spacing 2^(top − 10) LSBs of 2^−24, at least one.
    let shift = (top - 10).max(0);
    let parts = 3u64 << shift;
    let (floor, rest) = (sum / parts, sum % parts);
    let up = 2 * rest > parts || (2 * rest == parts && floor & 1 == 1);
    let code = floor + u64::from(up);
    let bits = (shift.cast_unsigned() << 10) + code;
    u16::try_from(bits.min(0x7bff)).unwrap_or(0x7bff)
}

/// Refuses a chain without a level, or one whose level `whole` denies.
fn check_levels<S>(
    sources: &[S],
    texels: &str,
    whole: impl Fn(&S) -> Option<()>,
) -> Result<(), ConfigError> {
    let broken = sources.iter().position(|source| whole(source).is_none());
    let found = match (sources.len(), broken) {
        (0, _) => "no level".into(),
        (_, Some(level)) => alloc::format!("level {level} without them"),
        (_, None) => return Ok(()),
    };
    Err(ConfigError {
        path: "texture.levels".into(),
        expected: alloc::format!("at least one level, each of {texels} texels"),
        found,
    })
}
