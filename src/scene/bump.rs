//! Bump maps: periodic textures of offsets (b1, b2), the height's negative slope in the local frame.
//!
//! A map is a picture of the surface seen from outside: columns grow along e1, rows grow along −e2.
//! So b1 = −∂height/∂column and b2 = +∂height/∂row, and a tangent-space normal map whose green channel
//! points up (the OpenGL convention) gives b = (nx/nz, ny/nz) as it stands.

use crate::base::num;
use crate::error::InputError;

/// Longest offset that a map may hold: steeper slopes are shortened to it and counted. Real normal maps
/// reach 14.3; 15 keeps four integer bits.
pub const MAX_OFFSET: f64 = 15.0;

/// Where a bump map comes from, as plain numbers, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub enum BumpSource {
    /// Heights. `scale` turns a height into texels: slope = scale · difference per texel.
    Height {
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
        /// One height a texel.
        values: Vec<f32>,
        /// Texels per unit of height; [`default_height_scale`] where nothing else is known.
        scale: f64,
        /// How slopes are taken.
        difference: Difference,
    },
    /// Tangent-space normals, already mapped to −1…1, green up; they need not be unit length.
    Normals {
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
        /// One normal a texel.
        values: Vec<[f32; 3]>,
    },
    /// The offsets themselves.
    Offsets {
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
        /// b1, b2 of each texel.
        values: Vec<[f32; 2]>,
    },
}

/// Texels per unit of height for an image whose white is 1: a 64th of the map's width. Relief of half the
/// range over a 64th of the map then has slopes around one half.
#[must_use]
pub fn default_height_scale(width: usize) -> f64 {
    width as f64 / 64.0
}

/// How slopes follow from heights; both wrap at the edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Difference {
    /// Half the difference of the two neighbours.
    #[default]
    Central,
    /// An eighth of the 3 × 3 Sobel sum.
    Sobel,
}

/// A periodic map of offsets.
#[derive(Clone, Debug, PartialEq)]
pub struct BumpMap {
    width: usize,
    height: usize,
    offsets: Vec<[f32; 2]>,
    cleaned: u64,
}

impl BumpMap {
    /// The map of a source.
    ///
    /// # Errors
    /// A size of zero, or a number of values that is not width × height.
    pub fn new(source: &BumpSource) -> Result<Self, InputError> {
        match source {
            BumpSource::Height { width, height, values, scale, difference } => {
                Self::from_height_by(*width, *height, values, *scale, *difference)
            }
            BumpSource::Normals { width, height, values } => {
                Self::from_normals(*width, *height, values)
            }
            BumpSource::Offsets { width, height, values } => {
                Self::from_offsets(*width, *height, values)
            }
        }
    }

    /// Offsets from heights by central differences.
    ///
    /// # Errors
    /// As [`BumpMap::new`], and a scale that is not finite.
    pub fn from_height(
        width: usize,
        height: usize,
        values: &[f32],
        scale: f64,
    ) -> Result<Self, InputError> {
        Self::from_height_by(width, height, values, scale, Difference::Central)
    }

    /// Offsets from heights: b1 = −scale·∂/∂column, b2 = scale·∂/∂row.
    ///
    /// # Errors
    /// As [`BumpMap::new`], and a scale that is not finite.
    pub fn from_height_by(
        width: usize,
        height: usize,
        values: &[f32],
        scale: f64,
        difference: Difference,
    ) -> Result<Self, InputError> {
        check_size(width, height, values.len())?;
        if !scale.is_finite() {
            return Err(InputError::new(
                "bump scale",
                "a finite number",
                scale.to_string(),
                "give the height of white in texels",
            ));
        }
        let at = |x: usize, y: usize| f64::from(values[y * width + x]);
        Ok(Self::build(width, height, |x, y| {
            let (left, right) = ((x + width - 1) % width, (x + 1) % width);
            let (above, below) = ((y + height - 1) % height, (y + 1) % height);
            let (dx, dy) = match difference {
                Difference::Central => {
                    ((at(right, y) - at(left, y)) / 2.0, (at(x, below) - at(x, above)) / 2.0)
                }
                Difference::Sobel => {
                    let column = |c| at(c, above) + 2.0 * at(c, y) + at(c, below);
                    let row = |r| at(left, r) + 2.0 * at(x, r) + at(right, r);
                    ((column(right) - column(left)) / 8.0, (row(below) - row(above)) / 8.0)
                }
            };
            [-scale * dx, scale * dy]
        }))
    }

    /// Offsets from tangent-space normals: b = (nx/nz, ny/nz). A normal that points along or below the
    /// surface gets the longest offset in its direction and is counted.
    ///
    /// # Errors
    /// As [`BumpMap::new`].
    pub fn from_normals(
        width: usize,
        height: usize,
        values: &[[f32; 3]],
    ) -> Result<Self, InputError> {
        check_size(width, height, values.len())?;
        Ok(Self::build(width, height, |x, y| {
            let [nx, ny, nz] = values[y * width + x].map(f64::from);
            if nz > 0.0 {
                [nx / nz, ny / nz]
            } else if nx.is_finite() && ny.is_finite() && nz.is_finite() {
                // Twice the longest offset, so that the cleaning counts it.
                let length = (nx * nx + ny * ny).sqrt();
                if length > 0.0 {
                    [nx, ny].map(|c| c / length * (2.0 * MAX_OFFSET))
                } else {
                    [f64::NAN; 2]
                }
            } else {
                [f64::NAN; 2]
            }
        }))
    }

    /// A map of offsets as they are, cleaned like the others.
    ///
    /// # Errors
    /// As [`BumpMap::new`].
    pub fn from_offsets(
        width: usize,
        height: usize,
        values: &[[f32; 2]],
    ) -> Result<Self, InputError> {
        check_size(width, height, values.len())?;
        Ok(Self::build(width, height, |x, y| values[y * width + x].map(f64::from)))
    }

    /// Evaluates, cleans and rounds every texel.
    fn build(width: usize, height: usize, offset: impl Fn(usize, usize) -> [f64; 2]) -> Self {
        let mut cleaned = 0;
        let mut offsets = Vec::with_capacity(width * height);
        for y in 0..height {
            for x in 0..width {
                let [b1, b2] = offset(x, y);
                let length = (b1 * b1 + b2 * b2).sqrt();
                let kept = if length <= MAX_OFFSET {
                    [b1, b2]
                } else {
                    cleaned += 1;
                    let shorter = [b1 / length * MAX_OFFSET, b2 / length * MAX_OFFSET];
                    if shorter.iter().all(|c| c.is_finite()) { shorter } else { [0.0; 2] }
                };
                offsets.push(kept.map(num::f32));
            }
        }
        Self { width, height, offsets, cleaned }
    }

    /// Columns.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// Offsets row by row from the top.
    #[must_use]
    pub fn offsets(&self) -> &[[f32; 2]] {
        &self.offsets
    }

    /// Texels that were shortened to [`MAX_OFFSET`] or, not being finite, set to zero.
    #[must_use]
    pub fn cleaned(&self) -> u64 {
        self.cleaned
    }

    /// The offset of a texel, in doubles.
    #[must_use]
    pub fn texel(&self, x: usize, y: usize) -> [f64; 2] {
        self.offsets[y * self.width + x].map(f64::from)
    }

    /// Bilinear offset of level 0 at (s, t), repeating: what truth calls the unfiltered map.
    #[inline]
    #[must_use]
    pub fn bilinear(&self, s: f64, t: f64) -> [f64; 2] {
        let x = Taps::new(s, self.width);
        let y = Taps::new(t, self.height);
        let row = |y| mix(self.texel(x.first, y), self.texel(x.second, y), x.weight);
        mix(row(y.first), row(y.second), y.weight)
    }
}

/// a + (b − a)·weight.
fn mix(a: [f64; 2], b: [f64; 2], weight: f64) -> [f64; 2] {
    [a[0] + (b[0] - a[0]) * weight, a[1] + (b[1] - a[1]) * weight]
}

/// The two texels of a repeating row that a linear look-up takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Taps {
    /// Texel whose centre is at or before the place.
    pub(super) first: usize,
    /// The next one.
    pub(super) second: usize,
    /// Weight of the second, 0…1.
    pub(super) weight: f64,
}

impl Taps {
    /// Taps of a coordinate whose unit is one repetition; a coordinate that is not finite counts as 0.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the whole part is within 0..=size after the fraction was taken and one texel added"
    )]
    pub(super) fn new(coordinate: f64, size: usize) -> Self {
        let fraction = coordinate - num::floor(coordinate);
        let fraction = if fraction.is_finite() { fraction } else { 0.0 };
        // Half a texel back, one texel on: positive, and the same texel after the wrap.
        let place = fraction * size as f64 + 0.5;
        let whole = place as u32;
        let index = whole as usize + size - 1;
        let first = if index < size { index } else { index - size };
        let second = if first + 1 < size { first + 1 } else { 0 };
        Self { first, second, weight: place - f64::from(whole) }
    }
}

/// Refuses an empty map and one whose values do not fill it.
fn check_size(width: usize, height: usize, values: usize) -> Result<(), InputError> {
    if width == 0 || height == 0 || width.checked_mul(height) != Some(values) {
        return Err(InputError::new(
            "bump map",
            "at least one texel, and width x height values",
            format!("{width} x {height} with {values} values"),
            "give a complete image",
        ));
    }
    Ok(())
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "where bits must be equal, that is what is tested")]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_of_heights_gives_the_negative_slope_in_the_local_frame() {
        // Height grows by 0.25 a column and 0.5 a row; b1 is against the columns, b2 with the rows,
        // because e2 points against the rows. Powers of two: exact.
        let (width, height) = (8, 6);
        let values: Vec<f32> =
            (0..48u8).map(|i| 0.25 * f32::from(i % 8) + 0.5 * f32::from(i / 8)).collect();
        for difference in [Difference::Central, Difference::Sobel] {
            let map = BumpMap::from_height_by(width, height, &values, 2.0, difference).unwrap();
            for (x, y) in [(2, 2), (5, 3), (3, 4)] {
                assert_eq!(map.texel(x, y), [-0.5, 1.0], "{difference:?} at {x}, {y}");
            }
        }
    }

    #[test]
    fn a_normal_map_gives_back_its_normals() {
        // n + b1 e1 + b2 e2 with n = (0,0,1) is (b1, b2, 1), which must be parallel to the normal.
        // b is rounded to single (2^-24 relative), the cross product has two such products.
        let normals = [[0.3f32, -0.2, 0.9], [-0.6, 0.1, 0.5], [0.0, 0.0, 1.0]];
        let map = BumpMap::from_normals(3, 1, &normals).unwrap();
        for (x, n) in normals.iter().enumerate() {
            let [nx, ny, nz] = n.map(f64::from);
            let [b1, b2] = map.texel(x, 0);
            let bound = 2.0 * (nx.abs() + ny.abs()) * f64::from(f32::EPSILON);
            assert!((b1 * nz - nx).abs() <= bound && (b2 * nz - ny).abs() <= bound);
        }
        assert_eq!(map.cleaned(), 0);
    }

    #[test]
    fn steep_missing_and_broken_texels_are_shortened_and_counted() {
        let normals = [
            [1.0f32, 0.0, 0.001],
            [0.0, 1.0, 0.0],
            [-1.0, 0.0, -0.5],
            [0.0, 0.0, -1.0],
            [f32::NAN, 0.0, 1.0],
            [0.0, f32::INFINITY, 1.0],
            [0.1, 0.0, 1.0],
        ];
        let map = BumpMap::from_normals(7, 1, &normals).unwrap();
        let expected = [[15.0, 0.0], [0.0, 15.0], [-15.0, 0.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]];
        for (x, b) in expected.into_iter().enumerate() {
            assert_eq!(map.texel(x, 0), b, "texel {x}");
        }
        assert_eq!(map.cleaned(), 6);
    }

    #[test]
    fn the_bilinear_map_meets_texel_centres_and_repeats() {
        let values: Vec<[f32; 2]> =
            (0..15u8).map(|i| [f32::from(i), -f32::from(i * i) / 16.0]).collect();
        let map = BumpMap::from_offsets(5, 3, &values).unwrap();
        for y in 0..3u8 {
            for x in 0..5u8 {
                let (s, t) = ((f64::from(x) + 0.5) / 5.0, (f64::from(y) + 0.5) / 3.0);
                let want = map.texel(usize::from(x), usize::from(y));
                for (ds, dt) in [(0.0, 0.0), (3.0, -2.0)] {
                    let got = map.bilinear(s + ds, t + dt);
                    // The coordinate carries at most 2^-50 (values below 4), times 5 texels, times the
                    // largest step between neighbours (15).
                    for i in 0..2 {
                        assert!((got[i] - want[i]).abs() <= 75.0 / f64::powi(2.0, 50));
                    }
                }
            }
        }
        assert_eq!(map.bilinear(f64::NAN, f64::INFINITY), map.bilinear(0.0, 0.0));
    }

    #[test]
    fn fails_when_the_values_do_not_fill_the_map() {
        assert!(BumpMap::from_height(4, 4, &[0.0; 15], 1.0).is_err());
        assert!(BumpMap::from_normals(0, 4, &[]).is_err());
        assert!(BumpMap::from_offsets(usize::MAX, 2, &[]).is_err());
        assert!(BumpMap::from_height(1, 1, &[0.0], f64::NAN).is_err());
    }
}
