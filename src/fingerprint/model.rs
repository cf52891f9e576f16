//! A texture unit that follows the rules of a fingerprint: it predicts the device, and tests feed it to the analysis.

use super::aniso::{Width, ratio};
use super::levels::lod_on;
use super::rho::{Projection, Rho};
pub use super::shapes::{Corner, Line, Rule, Seam, Spacing};
use super::steps::Steps;
use crate::base::num;
use crate::cube::{across_edge, direction, face_uv};
use crate::error::InputError;
use crate::sampler::{Format, Image, Query, Shape, Source, State, TextureUnit};

/// The claims of a fingerprint.
#[derive(Clone, Debug)]
pub struct Model {
    /// Weights between texels of float textures.
    pub texels: Steps,
    /// Weights between levels where the level of detail is given.
    pub mips: Steps,
    /// One octave of λ over log2 of the length.
    pub octave: Vec<f64>,
    /// The length on planes without anisotropy.
    pub rho: Rho,
    /// The length on cubes.
    pub cube_rho: (Projection, Rho),
    /// What holds where the clamp is above 1; on cubes the derivatives are projected as `cube_rho` says.
    pub rules: Vec<Rule>,
    /// The texels read beyond an edge of a cube.
    pub seam: Seam,
    /// What takes the place of the missing texel.
    pub corner: Corner,
}

/// The filter that a look-up's derivatives lead to.
struct Footprint {
    lod: f64,
    /// Taps by their offsets in texels of level 0.
    offsets: Vec<[f64; 2]>,
    /// Derivatives in texels of level 0, where an ellipse is filtered, and the rule beyond an edge.
    ellipse: Option<(Seam, [[f64; 2]; 2])>,
}

impl Footprint {
    fn single(lod: f64) -> Self {
        Self { lod, offsets: vec![[0.0; 2]], ellipse: None }
    }
}

impl Model {
    fn color(&self, image: &Image, state: State, source: Source, query: &Query) -> [f64; 4] {
        let top = image.levels.len() as f64 - 1.0;
        let footprint = if source == Source::Level {
            let lod = f64::from(query.lod).clamp(0.0, top);
            Footprint::single(lod.floor() + self.mips.weight(lod - lod.floor()))
        } else {
            self.footprint(image, state, source, query)
        };
        let (lod, taps) = (footprint.lod.clamp(0.0, top), footprint.offsets);
        if let Some((seam, pair)) = footprint.ellipse {
            let model = Self { seam, ..self.clone() };
            return model.ellipse(image, num::index(lod), query, pair);
        }
        let lod = if state.linear_mips { lod } else { (lod + 0.5).floor().min(top) };
        let (low, share) = (lod.floor(), lod - lod.floor());
        let mut sum = [0.0; 4];
        for offset in &taps {
            for (level, weight) in [(low, 1.0 - share), (low + 1.0, share)] {
                if weight > 0.0 {
                    let texel = self.tap(image, state, num::index(level), query, *offset);
                    for (sum, texel) in sum.iter_mut().zip(texel) {
                        *sum += weight * texel / taps.len() as f64;
                    }
                }
            }
        }
        sum
    }

    fn footprint(&self, image: &Image, state: State, source: Source, query: &Query) -> Footprint {
        let size = image.size as f64;
        let [at, dx, dy] = [query.at, query.dx, query.dy].map(|v| v.map(f64::from));
        let (pair, major) = match image.shape {
            Shape::Planar => {
                let pair = [dx, dy].map(|d| [d[0] * size, d[1] * size]);
                (pair, self.rho.length(pair[0], pair[1]))
            }
            Shape::Cube => {
                let (projection, rho) = self.cube_rho;
                let pair = [dx, dy].map(|d| projection.on_face(at, d, size));
                (pair, projection.length(rho, at, [dx, dy], size))
            }
        };
        let fits =
            |r: &&Rule| (r.shape, r.source, r.clamp) == (image.shape, source, state.anisotropy);
        let Some(rule) = self.rules.iter().find(fits) else {
            return Footprint::single(lod_on(&self.octave, libm::log2(major)));
        };
        let mut footprint = Footprint::single(rule.lod.lod(&self.octave, rule.clamp, major, pair));
        match rule.line {
            Line::Single => {}
            Line::Ellipse(seam) => {
                let seen = rule.lod.width != Width::Zero;
                footprint.ellipse = Some((seam, if seen { pair } else { [[0.0; 2]; 2] }));
            }
            Line::Taps(count, spacing) => {
                let (long, short, axis) = rule.lod.lengths.of(pair[0], pair[1]);
                let taps = count.of(ratio(long, short), rule.clamp);
                let gap = long * spacing.share(taps);
                footprint.offsets = (0..num::index(taps))
                    .map(|i| (i as f64 - (taps - 1.0) / 2.0) * gap)
                    .map(|along| axis.map(|a| a * along))
                    .collect();
            }
        }
        footprint
    }

    /// Where a look-up with an offset in texels of level 0 lies: face and coordinates 0…1.
    fn place(image: &Image, query: &Query, offset: [f64; 2]) -> (usize, [f64; 2]) {
        let at = query.at.map(f64::from);
        let share = offset.map(|o| o / image.size as f64);
        if image.shape == Shape::Planar {
            return (0, [at[0] + share[0], at[1] + share[1]]);
        }
        let (face, u, v) = face_uv(at);
        let (face, u, v) = if offset.iter().all(|o| o.abs() < 1e-12) {
            (face, u, v)
        } else {
            face_uv(direction(face, u + 2.0 * share[0], v + 2.0 * share[1]))
        };
        (face, [u, v].map(|c| f64::midpoint(c, 1.0)))
    }

    /// The mean over Heckbert's ellipse in one level.
    fn ellipse(&self, image: &Image, level: usize, query: &Query, pair: [[f64; 2]; 2]) -> [f64; 4] {
        let n = image.side(level) as f64;
        let (face, at) = Self::place(image, query, [0.0; 2]);
        let [x, y] = at.map(|c| c * n - 0.5);
        let shrink = libm::exp2(-(level as f64));
        let [[sx, tx], [sy, ty]] = pair.map(|d| d.map(|c| c * shrink));
        let (a, b, c) =
            (tx * tx + ty * ty + 1.0, -2.0 * (sx * tx + sy * ty), sx * sx + sy * sy + 1.0);
        let f = a * c - b * b / 4.0;
        // Half the box around A s² + B s t + C t² = F.
        let [reach_x, reach_y] = [c, a].map(libm::sqrt);
        let (mut sum, mut weights) = ([0.0; 4], 0.0);
        let range =
            |middle: f64, reach: f64| to_texel(middle - reach)..=to_texel(middle + reach) + 1;
        for row in range(y, reach_y) {
            for column in range(x, reach_x) {
                let (s, t) = (column as f64 - x, row as f64 - y);
                let q = (a * s * s + b * s * t + c * t * t) / f;
                // 1024 entries of a table: the last one's index is 1023.
                if q * 1023.0 < 1024.0 {
                    let weight = libm::exp(-2.0 * (q * 1023.0).floor() / 1023.0);
                    let texel = self.texel(image, level, face, column, row).unwrap_or([0.0; 4]);
                    for (sum, texel) in sum.iter_mut().zip(texel) {
                        *sum += weight * texel;
                    }
                    weights += weight;
                }
            }
        }
        sum.map(|c| c / weights)
    }

    fn tap(
        &self,
        image: &Image,
        state: State,
        level: usize,
        query: &Query,
        offset: [f64; 2],
    ) -> [f64; 4] {
        let n = image.side(level) as f64;
        let (face, [s, t]) = Self::place(image, query, offset);
        let texel = |x: i64, y: i64| self.texel(image, level, face, x, y);
        if !state.linear {
            let [x, y] = [s, t].map(|c| to_texel((c * n).clamp(0.0, n - 1.0)));
            return texel(x, y).unwrap_or([0.0; 4]);
        }
        let [x, y] = [s, t].map(|c| (c * n - 0.5).clamp(-0.5, n - 0.5));
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = (self.texels.weight(x - x0), self.texels.weight(y - y0));
        let (x0, y0) = (to_texel(x0), to_texel(y0));
        let corners = [
            (x0, y0, (1.0 - fx) * (1.0 - fy)),
            (x0 + 1, y0, fx * (1.0 - fy)),
            (x0, y0 + 1, (1.0 - fx) * fy),
            (x0 + 1, y0 + 1, fx * fy),
        ];
        self.blend(image, level, face, corners)
    }

    /// The weighted sum of four texels, one of which may lie beyond a cube's corner.
    fn blend(
        &self,
        image: &Image,
        level: usize,
        face: usize,
        corners: [(i64, i64, f64); 4],
    ) -> [f64; 4] {
        let (mut sum, mut missing, mut three) = ([0.0; 4], None, [0.0; 4]);
        for (x, y, weight) in corners {
            match self.texel(image, level, face, x, y) {
                None => missing = Some((x, y, weight)),
                Some(texel) => {
                    for i in 0..4 {
                        sum[i] += weight * texel[i];
                        three[i] += texel[i];
                    }
                }
            }
        }
        let Some((x, y, weight)) = missing else {
            return sum;
        };
        let last = last(image, level);
        let (inside_x, inside_y) = (x.clamp(0, last), y.clamp(0, last));
        let stand_in = |x, y| self.texel(image, level, face, x, y).unwrap_or([0.0; 4]);
        let instead = match self.corner {
            Corner::Mean => three.map(|c| c / 3.0),
            Corner::Rescaled => return sum.map(|c| c / (1.0 - weight).max(f64::MIN_POSITIVE)),
            Corner::Own => stand_in(inside_x, inside_y),
            Corner::Beside => stand_in(x, inside_y),
            Corner::Below => stand_in(inside_x, y),
        };
        [0, 1, 2, 3].map(|i| sum[i] + weight * instead[i])
    }

    /// A texel, or the one that stands for it beyond an edge; nothing beyond a cube's corner.
    fn texel(&self, image: &Image, level: usize, face: usize, x: i64, y: i64) -> Option<[f64; 4]> {
        let side = image.side(level);
        let last = last(image, level);
        let clamped = || {
            let place = |c: i64| num::usize(c.clamp(0, last));
            (face, place(x), place(y))
        };
        let (face, x, y) = if image.shape == Shape::Planar || self.seam == Seam::Clamped {
            clamped()
        } else {
            across_edge(side, face, x, y)?
        };
        Some(stored(image.format, image.levels[level][(face * side + y) * side + x]))
    }
}

/// The texel that a coordinate lies in.
#[expect(
    clippy::cast_possible_truncation,
    reason = "coordinates are a texture's, a few texels beyond at most; the cast saturates"
)]
fn to_texel(coordinate: f64) -> i64 {
    coordinate.floor() as i64
}

/// The last column or row of a level.
fn last(image: &Image, level: usize) -> i64 {
    i64::try_from(image.side(level)).map_or(i64::MAX, |n| n - 1)
}

/// The value of a texel after storage in a format.
fn stored(format: Format, texel: [f32; 4]) -> [f64; 4] {
    texel.map(|c| match format {
        Format::Unorm8 => (f64::from(c.clamp(0.0, 1.0)) * 255.0).round() / 255.0,
        Format::Half => half::f16::from_f32(c).to_f64(),
        Format::Float => c.into(),
    })
}

impl TextureUnit for Model {
    fn sample(
        &mut self,
        image: &Image,
        state: State,
        source: Source,
        queries: &[Query],
    ) -> Result<Vec<[f32; 4]>, InputError> {
        Ok(queries
            .iter()
            .map(|query| self.color(image, state, source, query).map(num::f32))
            .collect())
    }

    fn filters(&self, _: Format) -> bool {
        true
    }

    fn is_anisotropic(&self) -> bool {
        true
    }
}
