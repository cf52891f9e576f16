//! A scene of the ENV operation.

use std::collections::BTreeMap;
use std::time::Instant;

use rayon::prelude::*;
use rtl_model::unit::Needs;

use super::Model;
use crate::base::num;
use crate::cube::CubeMap;
use crate::engine::float::{EwaEngine, F64Engine, TruthEngine};
use crate::engine::probe::{RtlProbe, rtl};
use crate::engine::registers::{RegisterErrors, Sides};
use crate::engine::reuse::lines::Line;
use crate::engine::rtl::RtlEngine;
use crate::engine::{Engine, Progress, Rendering, encode, texels_read};
use crate::fragment::{Fragment, PixelFragment};
use crate::gpu::GpuError;
use crate::picture::Picture;
use crate::reference::{Env, NoTap, Prepared, Texture, env, ewa_counted};
use crate::scene::Scene;
use crate::settings::Settings;
use crate::truth::{background, truth};

/// Fragments that one task takes at a time.
const CHUNK: usize = 256;

/// A scene with its environment.
#[derive(Clone, Debug)]
pub struct EnvJob {
    /// Geometry and fragments.
    pub scene: Scene,
    /// Environment with its mip chain.
    pub map: CubeMap,
    /// Colours of the pixels without a fragment, and black elsewhere.
    pub background: Vec<[f64; 3]>,
}

impl EnvJob {
    /// A job; the background is what the eye sees past the surface.
    #[must_use]
    pub fn new(scene: Scene, map: CubeMap, settings: &Settings) -> Self {
        let background = background(&scene, &map, settings);
        Self { scene, map, background }
    }

    /// The picture of `colors`, one a fragment, over the background.
    #[must_use]
    pub fn picture(&self, colors: &[[f64; 3]]) -> Picture {
        let mut picture = Picture::new(self.scene.width, self.scene.height);
        picture.rgb.copy_from_slice(&self.background);
        for (fragment, color) in self.scene.fragments.iter().zip(colors) {
            let index = picture.index(fragment.pixel);
            picture.rgb[index] = *color;
            picture.covered[index] = true;
        }
        picture
    }

    /// What the fragments need of the unit. All of a scene need the same, so the first one tells; a
    /// scene without fragments needs nothing.
    #[must_use]
    pub fn needs(&self) -> Needs {
        self.scene
            .fragments
            .first()
            .map_or(Needs { bump: false, rough: false }, |f| encode::needs(&f.fragment))
    }

    /// Renders fragment by fragment in doubles: `each` yields the footprint, the colour, probes and texels.
    fn each(
        &self,
        progress: Progress<'_>,
        each: impl Fn(&Fragment) -> (Env, [f64; 3], u64, u64) + Sync,
    ) -> (Rendering, Vec<Line>) {
        #[derive(Default)]
        struct Part {
            colors: Vec<[f64; 3]>,
            lines: Vec<Line>,
            probes: u64,
            texels: u64,
            flags: BTreeMap<String, u64>,
        }
        let start = Instant::now();
        let parts: Vec<Part> = self
            .scene
            .fragments
            .par_chunks(CHUNK)
            .map(|chunk| {
                let mut part = Part::default();
                for fragment in chunk {
                    let (env, color, probes, texels) = each(&fragment.fragment);
                    part.colors.push(color);
                    part.lines.push(Line::of_env(&env, self.map.size()));
                    part.probes += probes;
                    part.texels += texels;
                    for name in env.flags.names() {
                        *part.flags.entry(name.to_string()).or_default() += 1;
                    }
                }
                progress(num::u64(chunk.len()));
                part
            })
            .collect();
        let seconds = start.elapsed().as_secs_f64();
        let mut whole = Part::default();
        for part in parts {
            whole.colors.extend(part.colors);
            whole.lines.extend(part.lines);
            whole.probes += part.probes;
            whole.texels += part.texels;
            for (name, count) in part.flags {
                *whole.flags.entry(name).or_default() += count;
            }
        }
        let rendering = Rendering {
            picture: self.picture(&whole.colors),
            seconds,
            probes: whole.probes,
            texels: whole.texels,
            flags: whole.flags,
            ..Rendering::default()
        };
        (rendering, whole.lines)
    }

    /// By the float reference, with the probe line of every fragment.
    pub(super) fn f64(
        &self,
        settings: &Settings,
        progress: Progress<'_>,
    ) -> (Rendering, Vec<Line>) {
        let prepared = Prepared::new(settings);
        let texture = Texture::new(&self.map);
        self.each(progress, |fragment| {
            let env = env(&prepared, fragment, self.map.size(), Some(&texture), &mut NoTap);
            (env, env.color, u64::from(env.probes), texels_read(env.lod, env.probes))
        })
    }
}

impl Engine<EnvJob> for F64Engine {
    fn render(&self, job: &EnvJob, progress: Progress<'_>) -> Result<Rendering, GpuError> {
        Ok(job.f64(&self.settings, progress).0)
    }
}

impl Engine<EnvJob> for EwaEngine {
    fn render(&self, job: &EnvJob, progress: Progress<'_>) -> Result<Rendering, GpuError> {
        let prepared = Prepared::new(&self.settings);
        let texture = Texture::new(&job.map);
        let rendered = job.each(progress, |fragment| {
            let env = env(&prepared, fragment, job.map.size(), None, &mut NoTap);
            let ewa = ewa_counted(&env, &texture);
            (env, ewa.color, 1, ewa.points)
        });
        Ok(rendered.0)
    }
}

impl Engine<EnvJob> for TruthEngine {
    fn render(&self, job: &EnvJob, progress: Progress<'_>) -> Result<Rendering, GpuError> {
        let start = Instant::now();
        let result = truth(&job.scene, &job.map, &self.settings, &self.options, progress);
        let texels = 4 * result.samples;
        Ok(Rendering { texels, ..Rendering::by_rays(start, result, &job.background) })
    }
}

impl Model for (&EnvJob, RtlEngine) {
    fn render(&self, progress: Progress<'_>) -> Result<Rendering, GpuError> {
        self.1.render(self.0, progress)
    }

    fn registers(&self, settings: &Settings, progress: Progress<'_>) -> RegisterErrors {
        let (job, e) = self;
        let (prepared, texture) = (Prepared::new(settings), Texture::new(&job.map));
        let each = |f: &PixelFragment, sides: &mut Sides| {
            let memory = e.memory.texture.as_ref();
            let here = rtl(&e.unit, &e.config, &f.fragment, memory, &mut sides.mine);
            let size = job.map.size();
            let there = env(&prepared, &f.fragment, size, Some(&texture), &mut sides.theirs);
            let same_face = here.face == there.face;
            let same_count = here.probes == i64::from(there.probes);
            sides.add(f.pixel, same_face, same_count);
        };
        RegisterErrors::of(&job.scene.fragments, 2 * CHUNK, progress, each)
    }

    fn trace(&self, pixel: [u32; 2], probe: &mut RtlProbe) -> Option<Vec<String>> {
        let (job, e) = self;
        let found = job.scene.fragments.iter().find(|f| f.pixel == pixel)?;
        let texture = e.memory.texture.as_ref();
        Some(rtl(&e.unit, &e.config, &found.fragment, texture, probe).flags)
    }
}
