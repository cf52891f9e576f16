//! Light maps: the light that falls onto a world's walls, in addition to their own glow.

use std::f64::consts::PI;

use glam::DVec3;

/// A point light that shines the same in all directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lamp {
    /// Where it hangs, relative to the reference point.
    pub position: DVec3,
    /// Its power, linear RGB.
    pub power: [f64; 3],
}

/// Largest share of the light that a wall sends back: paint brighter than white is a lamp.
const WHITE: f64 = 1.0;

/// Irradiance of one wall.
#[derive(Clone, Debug, PartialEq)]
pub struct WallMap {
    /// Texels along u.
    pub columns: usize,
    /// Texels along v.
    pub rows: usize,
    /// Power per area, linear RGB, row by row.
    pub texels: Vec<[f64; 3]>,
    /// Area of a texel, in world units squared.
    pub area: f64,
    /// Width and height of the wall, in world units.
    pub extent: [f64; 2],
}

/// Irradiance of every wall of a world.
#[derive(Clone, Debug, PartialEq)]
pub struct LightMap {
    /// In the order of the world's walls.
    pub walls: Vec<WallMap>,
}

impl LightMap {
    /// Dark walls of the given width and height, with about `per_unit` texels a world unit.
    #[must_use]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped to 1…4096"
    )]
    pub fn new(walls: &[[f64; 2]], per_unit: f64) -> Self {
        let texels = |length: f64| (length * per_unit).ceil().clamp(1.0, 4096.0) as usize;
        let walls = walls
            .iter()
            .map(|extent| {
                let [columns, rows] = extent.map(texels);
                WallMap {
                    columns,
                    rows,
                    texels: vec![[0.0; 3]; columns * rows],
                    area: extent[0] * extent[1] / (columns * rows) as f64,
                    extent: *extent,
                }
            })
            .collect();
        Self { walls }
    }

    /// Adds a photon: its power, spread by a Gaussian of standard deviation `sigma` (world units) around its place
    /// (0…1 each way), cut at 3 σ and at the wall's edges. The weights of the texels that it reaches are
    /// normalised, so that all of the power arrives; the nearest texel is always one of them.
    ///
    /// The splat is centred: the filter's coordinate runs from −1 to 1 over the square around the photon, and its
    /// middle, not its corner, lies on the photon's texel.
    pub fn splat(&mut self, wall: usize, uv: [f64; 2], power: [f64; 3], sigma: f64) {
        let Some(map) = self.walls.get_mut(wall) else {
            return;
        };
        let across = weights(uv[0] * map.extent[0], map.extent[0], map.columns, sigma);
        let down = weights(uv[1] * map.extent[1], map.extent[1], map.rows, sigma);
        let total: f64 =
            across.iter().map(|(_, w)| w).sum::<f64>() * down.iter().map(|(_, w)| w).sum::<f64>();
        for (row, v) in &down {
            for (column, u) in &across {
                let share = u * v / total / map.area;
                let texel = &mut map.texels[row * map.columns + column];
                for (sum, power) in texel.iter_mut().zip(power) {
                    *sum += share * power;
                }
            }
        }
    }

    /// Irradiance at a place of a wall, bilinear between texel centres.
    #[must_use]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped to the wall's texels"
    )]
    pub fn irradiance(&self, wall: usize, uv: [f64; 2]) -> [f64; 3] {
        let Some(map) = self.walls.get(wall) else {
            return [0.0; 3];
        };
        let cell = |t: f64, n: usize| {
            let at = (t * n as f64 - 0.5).clamp(0.0, (n - 1) as f64);
            let low = at as usize;
            (low, (low + 1).min(n - 1), at - low as f64)
        };
        let (x0, x1, fx) = cell(uv[0], map.columns);
        let (y0, y1, fy) = cell(uv[1], map.rows);
        let at = |x: usize, y: usize| map.texels[y * map.columns + x];
        let (a, b, c, d) = (at(x0, y0), at(x1, y0), at(x0, y1), at(x1, y1));
        [0, 1, 2].map(|i| {
            let above = a[i] + (b[i] - a[i]) * fx;
            let below = c[i] + (d[i] - c[i]) * fx;
            above + (below - above) * fy
        })
    }

    /// Radiance that a diffuse wall of the colour `paint` sends out for what falls onto a place.
    #[must_use]
    pub fn radiance(&self, wall: usize, uv: [f64; 2], paint: [f64; 3]) -> [f64; 3] {
        let light = self.irradiance(wall, uv);
        [0, 1, 2].map(|i| light[i] * paint[i].clamp(0.0, WHITE) / PI)
    }

    /// Power on all walls.
    #[must_use]
    pub fn power(&self) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for map in &self.walls {
            for texel in &map.texels {
                for (sum, light) in sum.iter_mut().zip(texel) {
                    *sum += light * map.area;
                }
            }
        }
        sum
    }
}

/// Texels within 3 σ of a place along one side, and their weights.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped to the wall's texels"
)]
fn weights(place: f64, length: f64, texels: usize, sigma: f64) -> Vec<(usize, f64)> {
    let side = length / texels as f64;
    let last = (texels - 1) as f64;
    let index = |at: f64| (at / side).floor().clamp(0.0, last) as usize;
    let own = index(place);
    (index(place - 3.0 * sigma)..=index(place + 3.0 * sigma))
        .filter_map(|i| {
            let x = ((i as f64 + 0.5) * side - place) / sigma;
            let near = x.abs() <= 3.0;
            // A filter narrower than a texel falls into that texel alone.
            (near || i == own)
                .then(|| (i, libm::exp(-0.5 * x.clamp(-6.0, 6.0) * x.clamp(-6.0, 6.0))))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_power_arrives_wherever_a_photon_lands() {
        let mut map = LightMap::new(&[[4.0, 2.5], [1.0, 3.0]], 16.0);
        let mut sent = 0.0;
        for (i, uv) in
            [[0.5, 0.5], [0.0, 0.0], [1.0, 0.3], [0.999, 1.0], [0.25, 0.01]].into_iter().enumerate()
        {
            for sigma in [0.001, 0.05, 0.4] {
                map.splat(i % 2, uv, [1.0, 2.0, 0.5], sigma);
                sent += 1.0;
            }
        }
        // Every texel takes a few roundings of a share, all shares of a photon add up to 1: n·2^-53 with n below 4000.
        let power = map.power();
        for (got, factor) in power.into_iter().zip([1.0, 2.0, 0.5]) {
            assert!((got / (factor * sent) - 1.0).abs() < 4000.0 * f64::EPSILON, "{got}");
        }
    }

    /// The paper's shader passes `IN.pos.xy`, −1…1, where the filter's texture wants 0…1: its splat would show a
    /// quarter of the filter, its centre in a corner.
    #[test]
    fn errata_caustic_splat_is_centred_on_its_photon() {
        let mut map = LightMap::new(&[[4.0, 4.0]], 16.0);
        // In the middle of texel (24, 40), so that the filter is symmetric about it.
        let uv = [24.5 / 64.0, 40.5 / 64.0];
        map.splat(0, uv, [1.0; 3], 0.2);
        let wall = &map.walls[0];
        let (mut centre, mut total, mut lit) = ([0.0; 2], 0.0, 0);
        for (i, texel) in wall.texels.iter().enumerate() {
            centre[0] += texel[0] * ((i % wall.columns) as f64 + 0.5);
            centre[1] += texel[0] * ((i / wall.columns) as f64 + 0.5);
            total += texel[0];
            lit += usize::from(texel[0] > 0.0);
        }
        // 3σ are 9.6 texels either way: 19 × 19 of them.
        assert_eq!(lit, 19 * 19);
        assert!((centre[0] / total - 24.5).abs() < 1e-12);
        assert!((centre[1] / total - 40.5).abs() < 1e-12);
        let brightest = map.irradiance(0, uv)[0];
        assert!(wall.texels.iter().all(|t| t[0] <= brightest));
    }
}
