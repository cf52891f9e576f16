//! The plain version of the back end: scalar f32, the same probes, the same bordered texels as floats.

use rtl_model::stages::filter;
use tapline::cube::{CubeMap, across_edge, direction, face_uv};

/// A fragment's probe line in floats.
pub(crate) struct Request {
    face: usize,
    center: [f32; 2],
    step: [f32; 2],
    /// Probes.
    pub(crate) count: u32,
    lod: f32,
}

impl Request {
    /// From the integer model's request with the default unit's formats.
    pub(crate) fn new(r: &filter::In) -> Self {
        let value = |raw: i64, frac: i32| raw as f32 / 2f32.powi(frac);
        Self {
            face: r.line.face,
            center: r.line.center.map(|c| value(c, 24)),
            step: r.line.step.map(|s| value(s, 24)),
            count: r.line.count as u32,
            lod: value(r.lod, 8),
        }
    }
}

/// Bordered levels of RGBA floats.
pub(crate) struct Map {
    levels: Vec<(usize, Vec<[f32; 4]>)>,
}

impl Map {
    /// Pads every face by one texel.
    pub(crate) fn new(map: &CubeMap) -> Self {
        let levels = map
            .levels
            .iter()
            .map(|level| {
                let n = level.size as i64;
                let mut texels = Vec::new();
                for face in 0..6 {
                    for y in -1..=n {
                        for x in -1..=n {
                            let (f, x, y) = across_edge(level.size, face, x, y)
                                .or_else(|| {
                                    across_edge(
                                        level.size,
                                        face,
                                        x.clamp(0, n - 1),
                                        y.clamp(0, n - 1),
                                    )
                                })
                                .unwrap_or((face, 0, 0));
                            let [r, g, b] = level.texel(f, x, y);
                            texels.push([r, g, b, 0.0]);
                        }
                    }
                }
                (level.size, texels)
            })
            .collect();
        Self { levels }
    }

    /// Footprint assembly of one fragment.
    pub(crate) fn filter(&self, r: &Request) -> [f32; 4] {
        let first = r.lod.floor();
        let part = r.lod - first;
        let mut sum = [0.0; 4];
        for k in 0..r.count {
            let along = (2 * k + 1) as f32 - r.count as f32;
            let (mut u, mut v) = (r.center[0] + along * r.step[0], r.center[1] + along * r.step[1]);
            let mut face = r.face;
            if u.abs() > 1.0 || v.abs() > 1.0 {
                let (f, a, b) = face_uv(direction(face, f64::from(u), f64::from(v)));
                (face, u, v) = (f, a as f32, b as f32);
            }
            for (level, weight) in [(first as usize, 1.0 - part), (first as usize + 1, part)] {
                if weight > 0.0 {
                    self.bilinear(level.min(self.levels.len() - 1), face, u, v, weight, &mut sum);
                }
            }
        }
        sum.map(|s| s / r.count as f32)
    }

    fn bilinear(&self, level: usize, face: usize, u: f32, v: f32, weight: f32, sum: &mut [f32; 4]) {
        let (n, texels) = &self.levels[level];
        let size = *n as f32;
        let (s, t) = ((u + 1.0) * 0.5 * size + 0.5, (v + 1.0) * 0.5 * size + 0.5);
        let (x, y) = (s.floor(), t.floor());
        let (a, b) = (s - x, t - y);
        let stride = n + 2;
        let at = (face * stride + y as usize) * stride + x as usize;
        let (upper, lower) = (&texels[at..at + 2], &texels[at + stride..at + stride + 2]);
        for (c, out) in sum.iter_mut().enumerate() {
            let top = upper[0][c] + (upper[1][c] - upper[0][c]) * a;
            let bottom = lower[0][c] + (lower[1][c] - lower[0][c]) * a;
            *out += weight * (top + (bottom - top) * b);
        }
    }
}
