//! Distances between texels, in doubles.

use crate::cube::{across_edge, face_uv};
use crate::distance::DistanceCube;

/// A distance cube with a border of one texel, for bilinear look-ups across edges.
#[derive(Clone, Debug)]
pub struct Distances {
    size: usize,
    texels: Vec<f64>,
    /// Largest finite distance; 0 where there is none.
    pub farthest: f64,
}

impl Distances {
    /// Copies a cube. `frac` rounds every distance to that many fraction bits (half-even); 0 becomes the
    /// least step, so that no wall falls onto the reference point.
    #[must_use]
    pub fn new(cube: &DistanceCube, frac: Option<i32>) -> Self {
        let size = cube.size;
        let word = |texel: f32| {
            let value = f64::from(texel);
            match frac {
                Some(frac) if value.is_finite() => {
                    let steps = libm::rint(libm::ldexp(value, frac)).max(1.0);
                    libm::ldexp(steps, -frac)
                }
                Some(_) | None => value,
            }
        };
        let texel =
            |face: usize, x: usize, y: usize| word(cube.texels[(face * size + y) * size + x]);
        let along: Vec<i64> = (-1..).take(size + 2).collect();
        let mut texels = Vec::with_capacity(6 * (size + 2) * (size + 2));
        for face in 0..6 {
            let at = |x: i64, y: i64| across_edge(size, face, x, y).map(|(f, x, y)| texel(f, x, y));
            for &y in &along {
                for &x in &along {
                    texels.push(at(x, y).unwrap_or_else(|| {
                        // A corner's missing tap is the mean of the other three.
                        let inside = |t: i64| if t < 0 { 0 } else { t - 1 };
                        let three = [(inside(x), y), (x, inside(y)), (inside(x), inside(y))];
                        three.into_iter().filter_map(|(x, y)| at(x, y)).sum::<f64>() / 3.0
                    }));
                }
            }
        }
        let farthest = cube
            .texels
            .iter()
            .filter(|t| t.is_finite())
            .fold(0.0, |most: f64, t| most.max(f64::from(*t)));
        Self {
            size,
            texels,
            farthest,
        }
    }

    /// Bilinear distance in a direction of any length but zero; infinite where a tap with weight is.
    #[must_use]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "places are clamped to 0..=size + ½"
    )]
    pub fn look_up(&self, d: [f64; 3]) -> f64 {
        let (face, u, v) = face_uv(d);
        let size = self.size as f64;
        let place = |u: f64| ((u + 1.0) * 0.5 * size + 0.5).clamp(0.0, size + 0.5);
        let (x, y) = (place(u), place(v));
        let (x0, y0) = (x as usize, y as usize);
        let (fx, fy) = (x - x0 as f64, y - y0 as f64);
        let stride = self.size + 2;
        let start = (face * stride + y0) * stride + x0;
        let mix = |a: f64, b: f64, f: f64| {
            if f == 0.0 {
                a
            } else if a.is_infinite() || b.is_infinite() {
                f64::INFINITY
            } else {
                a + (b - a) * f
            }
        };
        let above = mix(self.texels[start], self.texels[start + 1], fx);
        if fy == 0.0 {
            return above;
        }
        let below = mix(
            self.texels[start + stride],
            self.texels[start + stride + 1],
            fx,
        );
        mix(above, below, fy)
    }
}
