//! The `sampler` engine: the unit's derivatives through a GPU's own sampler.
//!
//! Face coordinates and D come from the float reference; what is filtered, the device decides: `textureSampleGrad` on the scene's
//! cube map, trilinear, anisotropy_clamp 16. The third component of the derivatives is 0 on the face's plane, so that every way to
//! project them gives D back. With roughness, whose footprint no pair of derivatives of the geometry has, the axes of K stand
//! for the columns of D: λ1 and λ2 along the ellipse. Four equal invocations make each look-up, as in a fingerprint.

use crate::base::num;
use std::collections::BTreeMap;
use std::time::Instant;

use rayon::prelude::*;

use super::hit::HitF64;
use super::hit_subject::HitSubject;
use super::{Progress, Rendering, Subject};
use crate::cube::{CubeMap, FACE_AXES, direction};
use crate::gpu::sampling::DeviceSampler;
use crate::gpu::{Gpu, GpuError};
use crate::picture::Picture;
use crate::reference::{Env, NoTap, Prepared, env};
use crate::sampler::{Format, Image, Query, Shape, Source, State};
use crate::settings::Settings;

/// Look-ups between two signs of progress.
const BLOCK: usize = 1 << 16;

/// A map in the device's memory.
pub struct SamplerEngine<'a> {
    sampler: DeviceSampler<'a>,
    view: wgpu::TextureView,
    state: State,
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

impl<'a> SamplerEngine<'a> {
    /// Uploads a map, as floats where the device filters them, else as halves.
    ///
    /// # Errors
    ///
    /// A map beyond the device's limits, no anisotropic filter, or the driver's error.
    pub fn new(gpu: &'a Gpu, map: &CubeMap) -> Result<Self, GpuError> {
        let format = if gpu.filters_f32() { Format::Float } else { Format::Half };
        let levels = map.levels.len();
        let image = Image::new(Shape::Cube, format, map.size(), levels, |level, face, x, y| {
            let [r, g, b] = map.levels[level].texel(face, x, y);
            [r, g, b, 1.0]
        });
        let sampler = DeviceSampler::new(gpu);
        Ok(Self { view: sampler.upload(&image)?, sampler, state: State::trilinear(16) })
    }

    /// The colours of look-ups.
    ///
    /// # Errors
    ///
    /// The driver's error.
    pub fn filter(
        &mut self,
        queries: &[Query],
        progress: Progress<'_>,
    ) -> Result<Vec<[f64; 3]>, GpuError> {
        let mut colors = Vec::with_capacity(queries.len());
        for block in queries.chunks(BLOCK) {
            let four: Vec<Query> = block.iter().flat_map(|q| [*q; 4]).collect();
            let (view, state) = (&self.view, self.state);
            let (cube, by) = (Shape::Cube, Source::Gradient);
            let seen = self.sampler.sample_view(view, cube, state, by, &four)?;
            colors.extend(seen.iter().step_by(4).map(|[r, g, b, _]| [*r, *g, *b].map(f64::from)));
            progress(num::u64(block.len()));
        }
        Ok(colors)
    }

    /// Renders a scene of the ENV operation. The seconds hold uploads of look-ups and read-backs, not the footprints.
    ///
    /// # Errors
    ///
    /// The driver's error.
    pub fn env(
        &mut self,
        settings: &Settings,
        subject: &Subject,
        progress: Progress<'_>,
    ) -> Result<Rendering, GpuError> {
        let prepared = Prepared::new(settings);
        let size = subject.map.size();
        let fragments = &subject.scene.fragments;
        let queries: Vec<Query> = fragments
            .par_iter()
            .map(|f| {
                let env = env(&prepared, &f.fragment, size, None, &mut NoTap);
                query(&env, f.fragment.h.is_some() && f.fragment.rough.is_some())
            })
            .collect();
        let start = Instant::now();
        let colors = self.filter(&queries, progress)?;
        Ok(rendering(subject.picture(&colors), start, queries.len()))
    }

    /// Renders a scene of the HIT operation: the float reference searches the hit, the device filters there.
    ///
    /// # Errors
    ///
    /// The driver's error.
    pub fn hit(
        &mut self,
        settings: &Settings,
        subject: &HitSubject,
        progress: Progress<'_>,
    ) -> Result<Rendering, GpuError> {
        let engine = HitF64::new(settings, &subject.distance, None, subject.map.size());
        let queries: Vec<Option<Query>> = subject
            .scene
            .rays
            .par_iter()
            .map(|ray| {
                let env = engine.trace(&ray.fragment, &mut NoTap).env;
                env.map(|env| query(&env, false))
            })
            .collect();
        let asked: Vec<Query> = queries.iter().copied().flatten().collect();
        let start = Instant::now();
        let mut found = self.filter(&asked, progress)?.into_iter();
        let colors: Vec<[f64; 3]> =
            queries.iter().map(|q| q.and_then(|_| found.next()).unwrap_or_default()).collect();
        Ok(rendering(subject.picture(&colors), start, asked.len()))
    }
}

/// The data of a picture whose probes only the device knows.
fn rendering(picture: Picture, start: Instant, look_ups: usize) -> Rendering {
    Rendering {
        picture,
        seconds: start.elapsed().as_secs_f64(),
        probes: num::u64(look_ups),
        texels: 0,
        flags: BTreeMap::new(),
        standard_error: None,
        searches: None,
        texture_use: None,
        beyond_f32: None,
    }
}
