//! Elliptical Gaussian over level-0 texels: the ideal filter for a footprint of the same K.

pub(super) mod planes;

use std::f64::consts::PI;

use super::address::Address;
use super::env::Env;
use super::planar::PlanarTexture;
use super::real::Real;
use super::tex::Tex;
use super::texture::Texture;
use crate::base::num;
use crate::cube::{direction, face_uv};

/// Most lattice points that a footprint may take before the lattice becomes coarser.
pub const MOST_POINTS: f64 = 65_536.0;

/// Variance of the ellipse's minor axis, in squared texels, from which on the lattice becomes coarser: 16²,
/// so that the coarser one still has σ ≥ 8 and its own h²/6 is at most 1/384 of the variance.
pub const FINE_ENOUGH: f64 = 256.0;

/// Points of a row whose weights follow from one another: the last has 15 products of a ratio with up
/// to 15 roundings of its own, about 2⁷ roundings in all.
const RUN: usize = 16;

/// The filtered colour and the lattice behind it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ewa {
    /// Linear RGB.
    pub color: [f64; 3],
    /// The lattice's level: 0 unless the ellipse holds more than [`MOST_POINTS`] texels. Beyond the
    /// chain the lattice spans several texels of the last level.
    pub level: u32,
    /// Lattice points inside the ellipse.
    pub points: u64,
}

/// The colour of [`ewa_counted`].
#[must_use]
pub fn ewa(env: &Env, texture: &Texture) -> [f64; 3] {
    ewa_counted(env, texture).color
}

/// Mean of the texels around (u, v), weighted by a Gaussian of covariance K/12 + h²/6·I, h = 2/N the
/// side of a texel: K/12 is the variance of a box as wide as the footprint, h²/6 that of a texel's
/// box and of the bilinear tent of a reconstruction's square. Cut where x·Σ⁻¹·x > 9 (3σ), normalised.
///
/// Works in the plane of the fragment's face. Points of the lattice (i + ½)·h − 1 inside the face are
/// texels; outside, the direction (1, u, v) chooses face and coordinates anew and is read bilinearly.
/// Where the ellipse would hold more than [`MOST_POINTS`] points, or spans [`FINE_ENOUGH`] texels even across
/// its minor axis, the first coarser mip level that
/// does not takes the place of level 0 (texels, N and h alike); 3σ of the finest is 1.2 texels, so
/// there is always a point.
#[must_use]
pub fn ewa_counted(env: &Env, texture: &Texture) -> Ewa {
    let (lattice, form) = fitting_lattice(env, texture);
    let centre = [env.u, env.v].map(|x| (x + 1.0) / lattice.spacing - 0.5);
    let (color, points) =
        gaussian(centre, &form, |i, j, weights, sum| lattice.add([i, j], weights, sum));
    Ewa { color, level: lattice.level, points }
}

/// The same filter on a 2-D texture: covariance K/12 + ⅙·I in texels. The lattice is the first level on which the
/// ellipse holds at most [`MOST_POINTS`] texels and its minor axis is below [`FINE_ENOUGH`], the last one at the
/// latest. The colour and the lattice points that it took.
#[must_use]
pub fn ewa_planar(tex: &Tex, texture: &PlanarTexture<'_>) -> ([f64; 3], u64) {
    let size = texture.level_size(0).map(|n| n as f64);
    let last = texture.levels() - 1;
    let mut level = 0;
    loop {
        let here = texture.level_size(level).map(|n| n as f64);
        let [x, y] = [0, 1].map(|i| here[i] / size[i]);
        let [a, b, c] = tex.k;
        let (form, fits) = form([a * x * x / 12.0, b * x * y / 12.0, c * y * y / 12.0]);
        if fits {
            let centre = [0, 1].map(|i| (tex.centre[i] + 1.0) / 2.0 * here[i] - 0.5);
            return gaussian(centre, &form, |first, j, weights, sum| {
                weighted(sum, weights, (first..).map(|i| texture.texel(level, [i, j])));
            });
        }
        if level == last {
            // One texel, or an ellipse over very many copies of a few: their mean.
            return (texture.texel(last, [0, 0]), 1);
        }
        level += 1;
    }
}

/// The weighted mean of the lattice points whose offset x from `centre` has x·Σ⁻¹·x ≤ 9, and their number. `add` adds
/// the values from a column on in a row, each by its weight, and the weights to a sum.
fn gaussian(
    centre: [f64; 2],
    form: &Form,
    add: impl Fn(i64, i64, &[f64], &mut [f64; 4]),
) -> ([f64; 3], u64) {
    let [_, b, c] = form.covariance;
    let variance = form.determinant / c;
    let fall = libm::exp(-1.0 / variance);
    let mut sum = [0.0; 4];
    let mut points = 0;
    let mut weights = Vec::new();
    let reach = 3.0 * c.sqrt();
    for j in whole_numbers(centre[1] - reach, centre[1] + reach) {
        let dy = j as f64 - centre[1];
        let left = 9.0 - dy * dy / c;
        if left < 0.0 {
            continue;
        }
        let middle = centre[0] + b / c * dy;
        let half = (left * variance).sqrt();
        let row_weight = libm::exp(-0.5 * dy * dy / c);
        let columns = whole_numbers(middle - half, middle + half);
        weights.clear();
        weights.resize(
            num::usize(columns.end().saturating_sub(*columns.start()).saturating_add(1)),
            0.0,
        );
        for (start, run) in columns.clone().step_by(RUN).zip(weights.chunks_mut(RUN)) {
            // e^(−x²/2σ²) by multiplication: the ratio of neighbours falls by the same factor each time.
            let dx = start as f64 - middle;
            let mut weight = libm::exp(-0.5 * dx * dx / variance);
            let mut ratio = libm::exp(-(dx + 0.5) / variance);
            for slot in run {
                *slot = weight;
                weight *= ratio;
                ratio *= fall;
            }
        }
        let mut row = [0.0; 4];
        add(*columns.start(), j, &weights, &mut row);
        for (sum, row) in sum.iter_mut().zip(row) {
            *sum += row_weight * row;
        }
        points += num::u64(weights.len());
    }
    let [.., total] = sum;
    (std::array::from_fn(|c| if total > 0.0 { sum[c] / total } else { 0.0 }), points)
}

/// Adds values by their weights, and the weights, as long as there are both; their number.
#[inline]
fn weighted(sum: &mut [f64; 4], weights: &[f64], values: impl Iterator<Item = [f64; 3]>) -> usize {
    let mut taken = 0;
    let [mut r, mut g, mut b, mut total] = *sum;
    for (weight, value) in weights.iter().zip(values) {
        r += weight * value[0];
        g += weight * value[1];
        b += weight * value[2];
        total += weight;
        taken += 1;
    }
    *sum = [r, g, b, total];
    taken
}

/// The whole numbers from `low` to `high`.
fn whole_numbers(low: f64, high: f64) -> std::ops::RangeInclusive<i64> {
    #[expect(
        clippy::cast_possible_truncation,
        reason = "bounded by the lattice: below 2^17 from a centre below 2^32; the cast saturates"
    )]
    let (low, high) = (low.ceil() as i64, high.floor() as i64);
    low..=high
}

/// Σ in lattice units.
struct Form {
    covariance: [f64; 3],
    determinant: f64,
}

/// A lattice of sample points in the plane of a face.
struct Lattice<'a> {
    texture: &'a Texture<'a>,
    face: usize,
    level: u32,
    /// Level of the chain whose texels are read.
    mip: usize,
    /// Texels along an edge where lattice points are texels, else 0.
    size: usize,
    /// From point to point, in u, v.
    spacing: f64,
}

impl<'a> Lattice<'a> {
    fn new(level: u32, texture: &'a Texture, face: usize) -> Self {
        let last = texture.levels() - 1;
        let mip = (level as usize).min(last);
        let size = texture.level_size(mip);
        let beyond = num::i32(level as usize - mip);
        Self {
            texture,
            face,
            level,
            mip,
            size: if beyond == 0 { size } else { 0 },
            spacing: libm::scalbn(2.0 / size as f64, beyond),
        }
    }

    /// Adds the points of row j from column i on by their weights, run by run: texels of the face, kept points of
    /// its plane, or a single one.
    fn add(&self, [mut i, j]: [i64; 2], mut weights: &[f64], sum: &mut [f64; 4]) {
        while !weights.is_empty() {
            let taken = if let Some(texels) = self.texels([i, j]) {
                weighted(sum, weights, texels.iter().map(|t| t.map(f64::from)))
            } else if let Some(points) =
                self.texture
                    .planes
                    .row([self.mip, self.face, self.size], [i, j], |i, j| self.value([i, j]))
            {
                weighted(sum, weights, points.iter().copied())
            } else {
                weighted(sum, weights, std::iter::once(self.value([i, j])))
            };
            weights = &weights[taken..];
            i += num::i64(taken);
        }
    }

    /// The texels from column i of the face on to the end of row j.
    fn texels(&self, [i, j]: [i64; 2]) -> Option<&[[f32; 3]]> {
        let [x, y] = [usize::try_from(i).ok()?, usize::try_from(j).ok()?];
        (x < self.size && y < self.size)
            .then(|| self.texture.row(self.mip, self.face, y).get(x..))?
    }

    /// What stands at a point: the texel, or the bilinear value in the direction of the point.
    fn value(&self, at: [i64; 2]) -> [f64; 3] {
        if let Some([texel, ..]) = self.texels(at) {
            return texel.map(f64::from);
        }
        let [u, v] = at.map(|t| (t as f64 + 0.5) * self.spacing - 1.0);
        let at = if u.abs() > 1.0 || v.abs() > 1.0 {
            let (face, u, v) = face_uv(direction(self.face, u, v));
            Address { face, u, v }
        } else {
            Address { face: self.face, u, v }
        };
        self.texture.bilinear(self.mip, at)
    }
}

/// The first lattice with at most [`MOST_POINTS`] points in the ellipse and a minor axis below
/// [`FINE_ENOUGH`], and Σ in its units.
fn fitting_lattice<'a>(env: &Env, texture: &'a Texture) -> (Lattice<'a>, Form) {
    // The largest K is 2^1024: its λ of 2^512 fits at the latest 512 levels beyond the chain.
    let mut level = 0;
    loop {
        let lattice = Lattice::new(level, texture, env.face);
        let (form, fits) = form(env.k.map(|x| x / lattice.spacing / lattice.spacing / 12.0));
        if fits || level >= 2000 {
            return (lattice, form);
        }
        level += 1;
    }
}

/// Σ = K/12 + ⅙·I from K/12, and whether its ellipse has at most [`MOST_POINTS`] points and a minor axis below
/// [`FINE_ENOUGH`].
fn form([a, b, c]: [f64; 3]) -> (Form, bool) {
    let texel = 1.0 / 6.0;
    // det(K' + t·I) = det K' + t·tr K' + t², with det K' ≥ 0 whatever rounding did to it.
    let own = f64::product_difference(a, c, b, b).max(0.0);
    let determinant = own + texel * (a + c) + texel * texel;
    let points = 9.0 * PI * determinant.sqrt();
    let trace = a + c + 2.0 * texel;
    let spread = (trace * trace - 4.0 * determinant).max(0.0).sqrt();
    let minor = 2.0 * determinant / (trace + spread);
    let form = Form { covariance: [a + texel, b, c + texel], determinant };
    (form, points <= MOST_POINTS && minor < FINE_ENOUGH)
}
