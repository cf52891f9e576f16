//! The `sampler` engine: the unit's derivatives through a GPU's own sampler.
//!
//! Face coordinates and D come from the float reference; what is filtered, the device decides: `textureSampleGrad` on the scene's
//! cube map, trilinear, anisotropy_clamp 16. The third component of the derivatives is 0 on the face's plane, so that every way to
//! project them gives D back. With roughness, whose footprint no pair of derivatives of the geometry has, the axes of K stand
//! for the columns of D: λ1 and λ2 along the ellipse. Four equal invocations make each look-up, as in a fingerprint.

use crate::base::num;
use std::time::Instant;

use rayon::prelude::*;

use crate::cube::{CubeMap, FACE_AXES, direction};
use crate::engine::hit::HitF64;
use crate::engine::{Engine, EnvJob, HitJob, Progress, Rendering, TexJob};
use crate::fragment::PixelFragment;
use crate::gpu::sampling::DeviceSampler;
use crate::gpu::{Gpu, GpuError};
use crate::picture::Picture;
use crate::reference::{Env, NoTap, Prepared, env};
use crate::sampler::{Format, Image, Query, Shape, Source, State};
use crate::scene::hit::PixelRay;
use crate::settings::Settings;

/// Look-ups between two signs of progress.
const BLOCK: usize = 1 << 16;

/// A device's sampler. The seconds of a rendering hold uploads of look-ups and read-backs, not the footprints.
pub struct SamplerEngine<'a> {
    /// The device.
    pub gpu: &'a Gpu,
    /// Policies of the footprints.
    pub settings: Settings,
}

/// The look-up of a footprint.
#[must_use]
pub fn query(env: &Env, rough: bool) -> Query {
    let pair = if rough {
        let ([major, minor], [x, y]) = (env.lambda, env.axis);
        [[major * x, major * y], [-minor * y, minor * x]]
    } else {
        [0, 1].map(|column| [env.d[0][column], env.d[1][column]])
    };
    let on_face = |[du, dv]: [f64; 2]| {
        let mut d = [0.0f32; 3];
        for ((axis, sign), value) in FACE_AXES[env.face].into_iter().zip([du, dv]) {
            d[axis] = num::f32(sign * value);
        }
        d
    };
    Query {
        at: direction(env.face, env.u, env.v).map(num::f32),
        dx: on_face(pair[0]),
        dy: on_face(pair[1]),
        lod: 0.0,
    }
}

impl SamplerEngine<'_> {
    /// The colours of look-ups into a map, which is uploaded as floats where the device filters them, else as halves;
    /// and the moment at which it was there.
    fn filter(
        &self,
        map: &CubeMap,
        queries: &[Query],
        progress: Progress<'_>,
    ) -> Result<(Vec<[f64; 3]>, Instant), GpuError> {
        let format = if self.gpu.filters_f32() { Format::Float } else { Format::Half };
        let levels = map.levels.len();
        let image = Image::new(Shape::Cube, format, map.size(), levels, |level, face, x, y| {
            let [r, g, b] = map.levels[level].texel(face, x, y);
            [r, g, b, 1.0]
        });
        let mut sampler = DeviceSampler::new(self.gpu);
        let view = sampler.upload(&image)?;
        let (start, state) = (Instant::now(), State::trilinear(16));
        let mut colors = Vec::with_capacity(queries.len());
        for block in queries.chunks(BLOCK) {
            let four: Vec<Query> = block.iter().flat_map(|q| [*q; 4]).collect();
            let (cube, by) = (Shape::Cube, Source::Gradient);
            let seen = sampler.sample_view(&view, cube, state, by, &four)?;
            colors.extend(seen.iter().step_by(4).map(|[r, g, b, _]| [*r, *g, *b].map(f64::from)));
            progress(num::u64(block.len()));
        }
        Ok((colors, start))
    }
}

impl Engine<EnvJob> for SamplerEngine<'_> {
    fn render(&self, job: &EnvJob, progress: Progress<'_>) -> Result<Rendering, GpuError> {
        let prepared = Prepared::new(&self.settings);
        let each = |f: &PixelFragment| {
            let env = env(&prepared, &f.fragment, job.map.size(), None, &mut NoTap);
            query(&env, f.fragment.h.is_some() && f.fragment.rough.is_some())
        };
        let queries: Vec<Query> = job.scene.fragments.par_iter().map(each).collect();
        let (colors, start) = self.filter(&job.map, &queries, progress)?;
        Ok(rendering(job.picture(&colors), start, queries.len()))
    }
}

/// The float reference searches the hit, the device filters there.
impl Engine<HitJob> for SamplerEngine<'_> {
    fn render(&self, job: &HitJob, progress: Progress<'_>) -> Result<Rendering, GpuError> {
        let engine = HitF64::new(&self.settings, &job.distance, None, job.map.size());
        let each = |ray: &PixelRay| {
            let env = engine.trace(&ray.fragment, &mut NoTap).env;
            env.map(|env| query(&env, false))
        };
        let queries: Vec<Option<Query>> = job.scene.rays.par_iter().map(each).collect();
        let asked: Vec<Query> = queries.iter().copied().flatten().collect();
        let (found, start) = self.filter(&job.map, &asked, progress)?;
        let mut found = found.into_iter();
        let colors: Vec<[f64; 3]> =
            queries.iter().map(|q| q.and_then(|_| found.next()).unwrap_or_default()).collect();
        Ok(rendering(job.picture(&colors), start, asked.len()))
    }
}

impl Engine<TexJob> for SamplerEngine<'_> {
    fn render(&self, _: &TexJob, _: Progress<'_>) -> Result<Rendering, GpuError> {
        Err(GpuError::Unsupported {
            adapter: self.gpu.adapter().title(),
            doing: "the engine sampler on 2-D textures".into(),
            lacks: "an engine for them".into(),
        })
    }
}

/// The rendering of a picture whose probes only the device knows.
fn rendering(picture: Picture, start: Instant, look_ups: usize) -> Rendering {
    Rendering {
        picture,
        seconds: start.elapsed().as_secs_f64(),
        probes: num::u64(look_ups),
        ..Rendering::default()
    }
}
