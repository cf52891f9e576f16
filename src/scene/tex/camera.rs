//! Cameras of the TEX scenes and the first cone of a ray.

use glam::DVec3;

use crate::base::random::Keyed;
use crate::base::vector::unit;

/// Where a camera's rays start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lens {
    /// All in the eye.
    Pinhole,
    /// On a disc about the eye, each towards its pixel on the plane that is in focus.
    Thin {
        /// Diameter of the disc.
        width: f64,
    },
    /// On the image plane, all parallel.
    Orthographic,
}

/// A camera as the ray-cone note describes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The eye.
    pub eye: DVec3,
    /// To the right, half of the view rectangle's width.
    pub u: DVec3,
    /// Upwards, half of its height.
    pub v: DVec3,
    /// From the eye to its middle; a thin lens is in focus there.
    pub w: DVec3,
    /// Columns and rows.
    pub size: [u32; 2],
    /// Where rays start.
    pub lens: Lens,
    /// Pixels by which the picture is moved to the right and down.
    pub shift: f64,
}

impl Camera {
    /// A camera at `eye` that looks at `aim`, in focus there, whose shorter side spans 2·`tangent` at distance 1.
    #[must_use]
    pub fn looking(eye: DVec3, aim: DVec3, tangent: f64, size: [u32; 2], lens: Lens) -> Self {
        let w = aim - eye;
        let distance = w.length();
        let right = unit(w.cross(DVec3::Y));
        let up = right.cross(w) / distance;
        let pixel = 2.0 * tangent * distance / f64::from(size[0].min(size[1]));
        let [columns, rows] = size.map(f64::from);
        Self {
            eye,
            u: right * pixel * columns / 2.0,
            v: up * pixel * rows / 2.0,
            w,
            size,
            lens,
            shift: 0.0,
        }
    }

    /// Origin and unit direction of the ray through an image position; a lens is sampled at the `sample`-th of
    /// `samples` places, which cover it evenly.
    #[must_use]
    pub fn ray(
        &self,
        at: [f64; 2],
        sample: u32,
        samples: u32,
        random: &mut Keyed,
    ) -> (DVec3, DVec3) {
        let at = at.map(|position| position - self.shift);
        let x = 2.0 * at[0] / f64::from(self.size[0]) - 1.0;
        let y = 1.0 - 2.0 * at[1] / f64::from(self.size[1]);
        let offset = x * self.u + y * self.v;
        let target = self.eye + self.w + offset;
        let origin = match self.lens {
            Lens::Pinhole => self.eye,
            Lens::Orthographic => self.eye + offset,
            Lens::Thin { width } => {
                // A sunflower's places, turned at random as a whole.
                let k = f64::from(sample) + random.number();
                let radius = width / 2.0 * (k / f64::from(samples.max(1))).sqrt();
                let turn = 2.399_963_229_728_653 * f64::from(sample)
                    + 2.0 * std::f64::consts::PI * random.number();
                let scale = |v: DVec3, by: f64| v * by / v.length();
                self.eye
                    + scale(self.u, radius * libm::cos(turn))
                    + scale(self.v, radius * libm::sin(turn))
            }
        };
        (origin, unit(target - origin))
    }
}
