//! A cube map prepared for bilinear look-ups across edges and corners.

use super::address::{Address, texel_coordinate};
use super::ewa::planes::Planes;
use crate::base::num;
use crate::cube::{CubeLevel, CubeMap, across_edge};

/// The surroundings of the faces of one level: a ring of neighbours, and the corners' means.
#[derive(Clone, Debug)]
struct Border {
    /// Index (face·4 + side)·size + t; sides: left, right, top, bottom.
    edges: Vec<[f32; 3]>,
    /// Index face·4 + (right) + 2·(bottom): the mean of the other three taps.
    corners: Vec<[f64; 3]>,
}

/// A borrowed cube map, its borders, and what the elliptical Gaussian has kept of the planes of its faces.
#[derive(Debug)]
pub struct Texture<'a> {
    map: &'a CubeMap,
    borders: Vec<Border>,
    pub(super) planes: Planes,
}

impl Border {
    fn new(level: &CubeLevel) -> Self {
        let size = level.size;
        let last = size.saturating_sub(1);
        let tap = |face: usize, x: i64, y: i64| {
            across_edge(size, face, x, y).map_or([0.0; 3], |(f, x, y)| level.texel(f, x, y))
        };
        let signed = |t: usize| num::i64(t);
        let outside = [-1, signed(size)];
        let mut edges = Vec::with_capacity(24 * size);
        let mut corners = Vec::with_capacity(24);
        for face in 0..6 {
            for x in outside {
                edges.extend((0..size).map(|y| tap(face, x, signed(y))));
            }
            for y in outside {
                edges.extend((0..size).map(|x| tap(face, signed(x), y)));
            }
            for (y, inner_y) in outside.into_iter().zip([0, last]) {
                for (x, inner_x) in outside.into_iter().zip([0, last]) {
                    let three = [
                        tap(face, x, signed(inner_y)),
                        tap(face, signed(inner_x), y),
                        level.texel(face, inner_x, inner_y),
                    ];
                    corners.push(std::array::from_fn(|c| {
                        three.iter().map(|t| f64::from(t[c])).sum::<f64>() / 3.0
                    }));
                }
            }
        }
        Self { edges, corners }
    }
}

impl<'a> Texture<'a> {
    /// Prepares a cube map whose levels are not empty.
    #[must_use]
    pub fn new(map: &'a CubeMap) -> Self {
        let borders = map.levels.iter().map(Border::new).collect();
        Self { map, borders, planes: Planes::new(map.levels.len()) }
    }

    /// Texels along an edge of level 0.
    #[must_use]
    pub fn size(&self) -> usize {
        self.map.size()
    }

    /// Number of levels.
    #[must_use]
    pub fn levels(&self) -> usize {
        self.map.levels.len()
    }

    /// Texels along an edge of a level; beyond the chain, of the last one.
    #[must_use]
    pub fn level_size(&self, level: usize) -> usize {
        self.map.levels[level.min(self.levels() - 1)].size
    }

    /// The texel of a face, inside.
    #[inline]
    #[must_use]
    pub fn texel(&self, level: usize, face: usize, x: usize, y: usize) -> [f64; 3] {
        self.map.levels[level].texel(face, x, y).map(f64::from)
    }

    /// A row of a face.
    pub(super) fn row(&self, level: usize, face: usize, y: usize) -> &[[f32; 3]] {
        let CubeLevel { size, texels } = &self.map.levels[level];
        &texels[(face * size + y) * size..][..*size]
    }

    /// The bilinear value at a point of the cube, with the neighbour's texels across an edge and, at a
    /// corner, the mean of the other three. |u|, |v| ≤ 1; a level beyond the chain counts as the last.
    #[inline]
    #[must_use]
    pub fn bilinear(&self, level: usize, at: Address) -> [f64; 3] {
        let level = level.min(self.levels() - 1);
        let size = self.map.levels[level].size;
        let (x, fx) = cell(at.u, size);
        let (y, fy) = cell(at.v, size);
        let taps = if x > 0 && y > 0 && x < size && y < size {
            let texels = &self.map.levels[level].texels;
            let row = (at.face * size + y - 1) * size + x - 1;
            let wide = |[r, g, b]: [f32; 3]| [f64::from(r), f64::from(g), f64::from(b)];
            [
                wide(texels[row]),
                wide(texels[row + 1]),
                wide(texels[row + size]),
                wide(texels[row + size + 1]),
            ]
        } else {
            [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)]
                .map(|(x, y)| self.tap(level, at.face, x, y))
        };
        let [lt, rt, lb, rb] = taps;
        let value = |c: usize| mix(mix(lt[c], rt[c], fx), mix(lb[c], rb[c], fx), fy);
        [value(0), value(1), value(2)]
    }

    /// The tap at column x − 1 and row y − 1 of a face, which may lie one texel outside.
    #[must_use]
    pub fn tap(&self, level: usize, face: usize, x: usize, y: usize) -> [f64; 3] {
        let size = self.map.levels[level].size;
        let border = &self.borders[level];
        let inside = |t: usize| t >= 1 && t <= size;
        let far = |t: usize| usize::from(t > size);
        match (inside(x), inside(y)) {
            (true, true) => self.texel(level, face, x - 1, y - 1),
            (false, true) => border.edges[(face * 4 + far(x)) * size + y - 1].map(f64::from),
            (true, false) => border.edges[(face * 4 + 2 + far(y)) * size + x - 1].map(f64::from),
            (false, false) => border.corners[face * 4 + far(x) + 2 * far(y)],
        }
    }
}

/// a + (b − a)·f: a constant stays what it is.
#[inline]
pub(super) fn mix(a: f64, b: f64, f: f64) -> f64 {
    a + (b - a) * f
}

/// The left tap of a coordinate, plus one, and the weight of the right one.
#[inline]
fn cell(u: f64, size: usize) -> (usize, f64) {
    // Never negative, so that the cast is a floor.
    let above_left = (texel_coordinate(u, size) + 1.0).clamp(0.5, size as f64 + 0.5);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "from ½ to size + ½"
    )]
    let index = above_left as u32;
    (index as usize, above_left - f64::from(index))
}
