//! The TEX operation on a device: requests of a scene's paths, cones included.

use std::time::Instant;

use rayon::prelude::*;

use super::{Filtered, GpuEngine, Operands, Reports, tables};
use crate::base::num;
use crate::engine::TexJob;
use crate::engine::job::tex_requests::{Request, scene_row};
use crate::engine::job::tex_row::Row;
use crate::engine::{Engine, Progress, Rendering};
use crate::fragment::{Tangents, TexFragment};
use crate::gpu::dispatch::{Program, Words};
use crate::gpu::kernels::{Fused, Kernel};
use crate::gpu::maps::Maps;
use crate::gpu::policy::to_f32;
use crate::gpu::{Gpu, GpuError};
use crate::policy::Wrap;
use crate::reference::Flag;
use crate::reference::ray_cone::Step;
use crate::scene::tex::path::Event;
use crate::settings::Settings;

/// Words of TEX's operands and results.
const TEX_WORDS: Words = Words { input: 24, output: Filtered::WORDS };
/// Words of a bare cone's operands and results.
const SKY_WORDS: Words = Words { input: 8, output: Filtered::WORDS };
/// Words of a step in the buffer of steps.
const STEP_WORDS: usize = 4;
/// Requests that a block of rows aims at.
const BLOCK: u64 = 1 << 17;

/// The TEX operation's kernels with the maps of a scene.
pub struct GpuTex<'a> {
    tex: Program,
    sky: Program,
    textures: Vec<Maps<'a>>,
    environment: Maps<'a>,
    /// Address modes beyond the textures' edges.
    wrap: [Wrap; 2],
}

/// One request: the path's first direction, its steps until then, and the texture asked.
struct Asked {
    /// Index of the texture; none asks for the environment.
    texture: Option<usize>,
    direction: [f64; 3],
    first: usize,
    count: usize,
    operands: Vec<u32>,
    flags: u32,
}

/// The requests of a row.
#[derive(Default)]
struct AskedGpu {
    steps: Vec<f32>,
    requests: Vec<Request<Asked>>,
}

/// A step's number and its operands.
#[must_use]
pub fn step_words(step: Step) -> [f32; STEP_WORDS] {
    match step {
        Step::Propagate(d) => [0.0, to_f32(d), 0.0, 0.0],
        Step::Reflect(k) => [1.0, to_f32(k), 0.0, 0.0],
        Step::Refract { curvature, outside, inside } => {
            [2.0, to_f32(curvature), to_f32(outside), to_f32(inside)]
        }
        Step::Scatter(f) => [3.0, to_f32(f), 0.0, 0.0],
    }
}

/// A texture coordinate brought into the first period in doubles: f32 keeps its place in a texel only there.
fn in_first_period(x: f64, wrap: Wrap) -> f64 {
    match wrap {
        Wrap::Repeat => x - x.floor(),
        Wrap::Mirror => x - 2.0 * (x / 2.0).floor(),
        Wrap::Clamp => x,
    }
}

/// The words of a request behind its path's.
pub fn encode(operands: &mut Operands, fragment: &TexFragment, wrap: [Wrap; 2]) {
    let (tangents, st, triangle) = match fragment.tangents {
        Tangents::Surface { dp_ds, dp_dt } => ([dp_ds, dp_dt], [[0.0; 2]; 2], 0),
        Tangents::Triangle { edges, st } => (edges, st, 1),
    };
    for v in [fragment.d, fragment.n, tangents[0], tangents[1]] {
        operands.numbers(&v);
    }
    operands.numbers(st.as_flattened());
    operands.word(triangle);
    operands.numbers(&[0, 1].map(|i| in_first_period(fragment.st[i], wrap[i])));
}

impl TexJob {
    /// A row's requests as the kernels take them.
    fn ask_gpu(&self, wrap: [Wrap; 2], y: usize) -> AskedGpu {
        let mut out = AskedGpu::default();
        let part = 1.0 / f64::from(self.scene.samples);
        scene_row(&self.scene, y, &mut |column, _, path| {
            let first = out.steps.len();
            for event in &path.events {
                let mut operands = Operands::new(Flag::SurfNotFinite);
                operands.begin();
                let (texture, weight) = match event {
                    Event::Step(step) => {
                        out.steps.extend(step_words(*step));
                        continue;
                    }
                    Event::Look(look) => {
                        encode(&mut operands, &look.fragment, wrap);
                        (Some(look.texture), look.weight)
                    }
                    Event::Sky { direction, weight } => {
                        operands.numbers(direction);
                        (None, *weight)
                    }
                };
                out.requests.push(Request {
                    column,
                    weight: weight * part,
                    asked: Asked {
                        texture,
                        direction: path.direction,
                        first,
                        count: (out.steps.len() - first) / STEP_WORDS,
                        flags: operands.flags[0],
                        operands: operands.words,
                    },
                });
            }
        });
        out
    }
}

impl<'a> GpuTex<'a> {
    /// Compiles the kernels and uploads textures and environment.
    ///
    /// # Errors
    ///
    /// A map beyond the device's limits, or the driver's error.
    pub fn new(gpu: &'a Gpu, settings: &Settings, subject: &TexJob) -> Result<Self, GpuError> {
        let tables = tables(settings);
        let maps = || -> Result<Maps<'a>, GpuError> {
            let mut maps = Maps::new(gpu, settings, &tables)?;
            maps.policy = maps.policy.with_camera(&subject.scene.camera);
            Ok(maps)
        };
        let textures = subject.scene.textures.iter();
        let out = Self {
            tex: Program::new(gpu, Kernel::Fused(Fused::Tex))?,
            sky: Program::new(gpu, Kernel::Fused(Fused::Sky))?,
            textures: textures.map(|map| maps()?.with_planar(map)).collect::<Result<_, _>>()?,
            environment: maps()?.with_cube(&subject.sky)?,
            wrap: settings.policy.address.wrap(),
        };
        if let Some(texture) = out.textures.first() {
            out.tex.warm(texture, TEX_WORDS)?;
        }
        out.sky.warm(&out.environment, SKY_WORDS)?;
        Ok(out)
    }

    /// The requests of some rows; `found` gets the row, the request and its result, flags of its operands included.
    fn filter(
        &self,
        rows: &[AskedGpu],
        found: &mut dyn FnMut(usize, &Request<Asked>, Filtered),
    ) -> Result<(), GpuError> {
        let mut steps = Vec::new();
        let starts: Vec<usize> = rows
            .iter()
            .map(|row| {
                let start = steps.len();
                steps.extend_from_slice(&row.steps);
                start
            })
            .collect();
        let kinds = (0..self.textures.len()).map(Some).chain([None]);
        for texture in kinds {
            let (program, maps, words) = match texture {
                Some(index) => (&self.tex, &self.textures[index], TEX_WORDS),
                None => (&self.sky, &self.environment, SKY_WORDS),
            };
            let asked: Vec<(usize, &Request<Asked>)> = rows
                .iter()
                .enumerate()
                .flat_map(|(y, row)| row.requests.iter().map(move |request| (y, request)))
                .filter(|(_, request)| request.asked.texture == texture)
                .collect();
            let mut operands = Operands::new(Flag::SurfNotFinite);
            for (y, request) in &asked {
                let asked = &request.asked;
                operands.begin();
                operands.numbers(&asked.direction);
                operands.word(num::u32(starts[*y] + asked.first));
                operands.word(num::u32(asked.count));
                operands.words.extend_from_slice(&asked.operands);
            }
            let input = (operands.words.as_slice(), steps.as_slice());
            let results = program.run(maps, words, input, &|_| {})?;
            for (words, (y, request)) in results.chunks_exact(words.output).zip(asked) {
                let mut filtered = Filtered::of(words);
                filtered.flags |= request.asked.flags;
                found(y, request, filtered);
            }
        }
        Ok(())
    }
}

/// Blocks of rows, whose paths the host traces.
impl Engine<TexJob> for GpuEngine<'_> {
    fn render(&self, job: &TexJob, progress: Progress<'_>) -> Result<Rendering, GpuError> {
        let engine = GpuTex::new(self.gpu, &self.settings, job)?;
        let (width, height) = (job.scene.width, job.scene.height);
        let a_row = (job.requests / num::u64(height).max(1)).max(1);
        let block = num::usize((BLOCK / a_row).max(1));
        let mut rows: Vec<Row> = Vec::with_capacity(height);
        let mut reports = Reports::default();
        let mut seconds = 0.0;
        for first in (0..height).step_by(block) {
            let last = (first + block).min(height);
            let asked: Vec<AskedGpu> =
                (first..last).into_par_iter().map(|y| job.ask_gpu(engine.wrap, y)).collect();
            let begin = Instant::now();
            rows.extend((first..last).map(|_| Row::new(width)));
            engine.filter(&asked, &mut |y, request, found| {
                let row = &mut rows[first + y];
                row.add(request.column, request.weight, found.color);
                if request.asked.texture.is_some() {
                    row.level(request.column, request.weight, found.lod);
                }
                row.probes += u64::from(found.probes);
                row.texels += found.texels();
                let pixel = [request.column, first + y].map(num::u32);
                reports.add(found.flags, pixel);
            })?;
            seconds += begin.elapsed().as_secs_f64();
            progress(num::u64((last - first) * width));
        }
        Ok(Rendering {
            seconds,
            flags: reports.flags,
            beyond_f32: reports.beyond_f32,
            ..job.put_together(rows, 0.0)
        })
    }
}
