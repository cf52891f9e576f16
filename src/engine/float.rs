//! The float engines: `f64`, `ewa` and `truth`.

use crate::base::num;
use std::collections::BTreeMap;
use std::time::Instant;

use rayon::prelude::*;

use super::reuse::lines::Line;
use super::{Engine, Progress, Rendering, Rung, Subject};
use crate::reference::{Env, NoTap, Prepared, Texture, env, ewa_counted};
use crate::settings::Settings;
use crate::truth::{TruthOptions, truth};

/// Fragments that one task takes at a time.
const CHUNK: usize = 256;

/// The float reference of the same algorithm.
#[derive(Clone, Debug)]
pub struct F64Engine {
    /// Policies.
    pub settings: Settings,
}

/// The elliptical Gaussian over level 0.
#[derive(Clone, Debug)]
pub struct EwaEngine {
    /// Policies; the footprint is the float reference's.
    pub settings: Settings,
}

/// Supersampled rays.
#[derive(Clone, Debug)]
pub struct TruthEngine {
    /// Policies: only the environment's rotation matters.
    pub settings: Settings,
    /// Samples and seed.
    pub options: TruthOptions,
}

/// Sums of one task.
#[derive(Default)]
struct Part {
    colors: Vec<[f64; 3]>,
    envs: Vec<Env>,
    probes: u64,
    texels: u64,
    flags: BTreeMap<String, u64>,
}

fn per_fragment(
    subject: &Subject,
    progress: Progress<'_>,
    keep: bool,
    each: impl Fn(&crate::fragment::Fragment) -> (Env, [f64; 3], u64, u64) + Sync,
) -> (Rendering, Vec<Env>) {
    let start = Instant::now();
    let parts: Vec<Part> = subject
        .scene
        .fragments
        .par_chunks(CHUNK)
        .map(|chunk| {
            let mut part = Part::default();
            for fragment in chunk {
                let (env, color, probes, texels) = each(&fragment.fragment);
                part.colors.push(color);
                if keep {
                    part.envs.push(env);
                }
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
        whole.envs.extend(part.envs);
        whole.probes += part.probes;
        whole.texels += part.texels;
        for (name, count) in part.flags {
            *whole.flags.entry(name).or_default() += count;
        }
    }
    let rendering = Rendering {
        picture: subject.picture(&whole.colors),
        seconds,
        probes: whole.probes,
        texels: whole.texels,
        flags: whole.flags,
        standard_error: None,
        searches: None,
        texture_use: None,
        beyond_f32: None,
    };
    (rendering, whole.envs)
}

impl Engine for F64Engine {
    fn rung(&self) -> Rung {
        Rung::F64
    }

    fn render(&self, subject: &Subject, progress: Progress<'_>) -> Rendering {
        env_by_f64(&self.settings, subject, progress, false).0
    }
}

fn env_by_f64(
    settings: &Settings,
    subject: &Subject,
    progress: Progress<'_>,
    keep: bool,
) -> (Rendering, Vec<Env>) {
    let prepared = Prepared::new(settings);
    let texture = Texture::new(&subject.map);
    let size = subject.map.size();
    per_fragment(subject, progress, keep, |fragment| {
        let env = env(&prepared, fragment, size, Some(&texture), &mut NoTap);
        let levels = if env.lod.fract() == 0.0 { 1 } else { 2 };
        let probes = u64::from(env.probes);
        (env, env.color, probes, 4 * levels * probes)
    })
}

/// By the float reference, with the probe line of every fragment.
#[must_use]
pub fn env_lines(settings: &Settings, subject: &Subject) -> (Rendering, Vec<Line>) {
    let size = subject.map.size();
    let (rendering, envs) = env_by_f64(settings, subject, &|_| {}, true);
    let lines = envs.iter().map(|env| Line::of_env(env, size)).collect();
    (rendering, lines)
}

impl Engine for EwaEngine {
    fn rung(&self) -> Rung {
        Rung::Ewa
    }

    fn render(&self, subject: &Subject, progress: Progress<'_>) -> Rendering {
        let prepared = Prepared::new(&self.settings);
        let texture = Texture::new(&subject.map);
        per_fragment(subject, progress, false, |fragment| {
            let env = env(&prepared, fragment, subject.map.size(), None, &mut NoTap);
            let ewa = ewa_counted(&env, &texture);
            (env, ewa.color, 1, ewa.points)
        })
        .0
    }
}

impl Engine for TruthEngine {
    fn rung(&self) -> Rung {
        Rung::Truth
    }

    fn render(&self, subject: &Subject, progress: Progress<'_>) -> Rendering {
        let start = Instant::now();
        let result = truth(&subject.scene, &subject.map, &self.settings, &self.options, progress);
        let seconds = start.elapsed().as_secs_f64();
        let mut picture = result.picture;
        for (color, (covered, background)) in
            picture.rgb.iter_mut().zip(picture.covered.iter().zip(&subject.background))
        {
            if !covered {
                *color = *background;
            }
        }
        Rendering {
            picture,
            seconds,
            probes: result.samples,
            texels: 4 * result.samples,
            flags: BTreeMap::new(),
            standard_error: Some(result.rms_standard_error),
            searches: None,
            texture_use: None,
            beyond_f32: None,
        }
    }
}
