//! A scene of the TEX operation as every engine renders it.

use std::collections::BTreeMap;
use std::time::Instant;

use rayon::prelude::*;
use rtl_model::unit::{HitWords, TexWords};

use super::Model;
use super::tex_requests::{AskedRtl, scene_row};
use super::tex_row::Row;
use crate::base::num;
use crate::cube::CubeMap;
use crate::distance::Distance;
use crate::engine::dispatch::Source;
use crate::engine::float::{EwaEngine, F64Engine, TruthEngine};
use crate::engine::hit::{self, HitF64, HitRtl};
use crate::engine::probe::RtlProbe;
use crate::engine::registers::{RegisterErrors, Sides};
use crate::engine::reuse::lines::Line;
use crate::engine::reuse::tex::{First, KeptBlocks, KeptRow};
use crate::engine::tex::TexRtl;
use crate::engine::tiles::Tiles;
use crate::engine::{Engine, Progress, Rendering, TextureUse, texels_read};
use crate::error::InputError;
use crate::fragment::HitFragment;
use crate::gpu::GpuError;
use crate::picture::Picture;
use crate::reference::tex::{point, tex};
use crate::reference::{NoTap, PlanarTexture, Prepared, Texture, ewa_counted, ewa_planar};
use crate::scene::tex::TexScene;
use crate::scene::tex::path::{Event, Path};
use crate::settings::Settings;
use crate::truth::texels::PaddedCube;
use crate::truth::{each, supersample, turned};
use crate::unit::UnitSpec;

/// A probe line that is kept, with the index of its texture.
type Kept = (usize, Line);

/// A scene with its environment.
#[derive(Clone, Debug)]
pub struct TexJob {
    /// Surfaces, camera, textures.
    pub scene: TexScene,
    /// The light that paths see when they leave the scene.
    pub sky: CubeMap,
    /// Requests to textures and to the environment.
    pub requests: u64,
}

/// The integer model, compiled for a scene.
#[derive(Clone, Debug)]
pub struct TexEngine {
    /// One unit a texture.
    pub textures: Vec<TexRtl>,
    /// The unit for the environment: a hit with no wall is a bare cone.
    pub sky: HitRtl,
}

impl TexEngine {
    /// Compiles the units and encodes textures and environment.
    pub fn new(spec: &UnitSpec, subject: &TexJob) -> Result<Self, InputError> {
        let textures = subject.scene.textures.iter();
        Ok(Self {
            textures: textures.map(|map| TexRtl::new(spec, map)).collect::<Result<_, _>>()?,
            sky: HitRtl::new(spec, &Distance::nothing(), Some(&subject.sky), subject.sky.size())?,
        })
    }
}

impl TexJob {
    /// A job; its paths are traced once to count their requests.
    #[must_use]
    pub fn new(scene: TexScene, sky: CubeMap) -> Self {
        let requests = (0..scene.height)
            .into_par_iter()
            .map(|row| {
                let mut count = 0;
                scene_row(&scene, row, &mut |_, _, path| {
                    let asks = |e: &&Event| !matches!(e, Event::Step(_));
                    count += num::u64(path.events.iter().filter(asks).count());
                });
                count
            })
            .sum();
        Self { scene, sky, requests }
    }

    /// Rows in parallel, put together in order; and what else each of them yields.
    fn rows<T: Send>(
        &self,
        progress: Progress<'_>,
        row: impl Fn(usize) -> (Row, T) + Sync,
    ) -> (Rendering, Vec<T>) {
        let start = Instant::now();
        let (rows, others): (Vec<Row>, Vec<T>) = (0..self.scene.height)
            .into_par_iter()
            .map(|y| {
                let out = row(y);
                progress(num::u64(self.scene.width));
                out
            })
            .unzip();
        (self.put_together(rows, start.elapsed().as_secs_f64()), others)
    }

    /// A picture of rows, in order, that took `wall` seconds.
    pub(in crate::engine) fn put_together(&self, rows: Vec<Row>, wall: f64) -> Rendering {
        let (width, height) = (self.scene.width, self.scene.height);
        let mut picture = Picture::new(width, height);
        let mut levels = Picture::new(width, height);
        picture.covered.fill(true);
        levels.covered.fill(true);
        let (mut probes, mut texels, mut flags) = (0, 0, BTreeMap::new());
        let mut tiles: Vec<Tiles> = Vec::new();
        let mut times = [0.0; 2];
        for (y, row) in rows.into_iter().enumerate() {
            picture.rgb[y * width..(y + 1) * width].copy_from_slice(&row.rgb);
            for (to, [red, green, blue, weight]) in
                levels.rgb[y * width..].iter_mut().zip(row.levels)
            {
                *to = if weight > 0.0 { [red, green, blue].map(|c| c / weight) } else { [0.02; 3] };
            }
            probes += row.probes;
            texels += row.texels;
            for (name, n) in row.flags {
                *flags.entry(name).or_default() += n;
            }
            if tiles.is_empty() {
                tiles = row.tiles;
            } else {
                for (a, b) in tiles.iter_mut().zip(&row.tiles) {
                    a.merge(b);
                }
            }
            times = [0, 1].map(|i| times[i] + row.seconds[i]);
        }
        // Paths are the scene's work, not the engine's.
        let share = times[1] / (times[0] + times[1]).max(f64::MIN_POSITIVE);
        Rendering {
            picture,
            seconds: wall * share,
            probes,
            texels,
            flags,
            texture_use: Some(TextureUse { levels, tiles }),
            ..Rendering::default()
        }
    }

    /// By the integer model, from kept rows.
    pub(in crate::engine) fn rtl_again(
        &self,
        engine: &TexEngine,
        rows: &mut [KeptRow],
        first: &First,
        progress: Progress<'_>,
    ) -> Rendering {
        let start = Instant::now();
        let rows: Vec<Row> = rows
            .par_iter_mut()
            .map(|kept| {
                let row = self.row_by_rtl(engine, &kept.asked, Some((&mut kept.blocks, first)));
                progress(num::u64(self.scene.width));
                row
            })
            .collect();
        let wall = start.elapsed().as_secs_f64();
        let mut out = self.put_together(rows, wall);
        out.seconds = wall;
        out
    }

    /// A row's requests through the units, or from kept blocks.
    fn row_by_rtl(
        &self,
        engine: &TexEngine,
        asked: &AskedRtl,
        mut kept: Option<(&mut KeptBlocks, &First)>,
    ) -> Row {
        let mut row = Row::new(self.scene.width);
        row.flags.clone_from(&asked.flags);
        let maps = self.scene.textures.iter().zip(&engine.textures);
        row.tiles =
            maps.map(|(map, unit)| Tiles::new(map, unit.config.policy.address.wrap())).collect();
        for (index, (unit, looks)) in engine.textures.iter().zip(&asked.looks).enumerate() {
            let words: Vec<TexWords>;
            let source = match &mut kept {
                Some((kept, first)) => Source::Kept(&mut kept.looks[index], first.looks[index]),
                None => {
                    words = looks.iter().map(|r| r.asked).collect();
                    Source::Words(&words)
                }
            };
            let mut looks = looks.iter();
            unit.blocks(source, &mut |block, out| {
                for (lane, request) in (0..block.env.len).zip(&mut looks) {
                    row.look(unit, index, request, (block, out, lane));
                }
            });
        }
        let rays: Vec<HitWords>;
        let source = match kept {
            Some((kept, first)) => Source::Kept(&mut kept.sky, first.sky),
            None => {
                rays = asked.sky.iter().map(|r| hit::words(&r.asked)).collect();
                Source::Words(&rays)
            }
        };
        let mut found = Vec::new();
        engine.sky.blocks(source, &mut |block, out| engine.sky.add(&mut found, block, out));
        row.sky(&asked.sky, found);
        row
    }

    fn planar(&self, settings: &Settings) -> Vec<PlanarTexture<'_>> {
        let textures = self.scene.textures.iter();
        textures.map(|map| PlanarTexture::new(map, settings.policy.address.wrap())).collect()
    }

    /// By the float reference; `gaussian` takes the elliptical Gaussian of its covariances instead of probes. `each`
    /// may keep the texture and the probe line of a request among those of its row.
    fn float(
        &self,
        settings: &Settings,
        gaussian: bool,
        progress: Progress<'_>,
        each: &(dyn Fn(&mut Vec<Kept>, Kept) + Sync),
    ) -> (Rendering, Vec<Vec<Kept>>) {
        let prepared = Prepared::new(settings);
        let textures = self.planar(settings);
        let nowhere = Distance::nothing();
        let sky = HitF64::new(settings, &nowhere, Some(&self.sky), self.sky.size());
        let cube = Texture::new(&self.sky);
        self.rows(progress, |y| {
            let mut row = Row::new(self.scene.width);
            let begin = Instant::now();
            let asked = self.ask_f64(settings, y);
            row.seconds[0] = asked.paths;
            let mut lines = Vec::new();
            for request in &asked.looks {
                let (index, fragment, width) = &request.asked;
                let texture = &textures[*index];
                let size = texture.level_size(0);
                let read = (!gaussian).then_some(texture);
                let found = tex(&prepared, *width, fragment, size, read, &mut NoTap);
                each(&mut lines, (*index, Line::of_tex(&found, *width)));
                let colour = if gaussian {
                    let (colour, points) = ewa_planar(&found, texture);
                    row.texels += points;
                    row.probes += 1;
                    colour
                } else {
                    row.texels += texels_read(found.lod, found.probes);
                    row.probes += u64::from(found.probes);
                    found.color
                };
                row.add(request.column, request.weight, colour);
                row.level(request.column, request.weight, found.lod);
                for name in found.flags.names() {
                    *row.flags.entry(name.to_string()).or_default() += 1;
                }
            }
            let rays: Vec<HitFragment> = asked.sky.iter().map(|r| r.asked).collect();
            if gaussian {
                for (request, ray) in asked.sky.iter().zip(&rays) {
                    if let Some(env) = sky.trace(ray, &mut NoTap).env {
                        let found = ewa_counted(&env, &cube);
                        row.add(request.column, request.weight, found.color);
                        row.texels += found.points;
                        row.probes += 1;
                    }
                }
            } else {
                row.sky(&asked.sky, sky.filter(&rays, &|_| {}));
            }
            row.seconds[1] = begin.elapsed().as_secs_f64() - row.seconds[0];
            (row, lines)
        })
    }

    /// By the float reference, with the probe line of every request to a texture: row by row, and in a row texture by
    /// texture, as kept results have them.
    pub(super) fn lines(&self, settings: &Settings) -> (Rendering, Vec<Line>) {
        let (rendering, mut rows) = self.float(settings, false, &|_| {}, &Vec::push);
        rows.iter_mut().for_each(|lines| lines.sort_by_key(|(texture, _)| *texture));
        (rendering, rows.into_iter().flatten().map(|(_, line)| line).collect())
    }
}

impl Engine<TexJob> for TexEngine {
    fn render(&self, job: &TexJob, progress: Progress<'_>) -> Result<Rendering, GpuError> {
        let (rendering, _) = job.rows(progress, |y| {
            let begin = Instant::now();
            let asked = job.ask_rtl(self, y);
            let mut row = job.row_by_rtl(self, &asked, None);
            row.seconds = [asked.paths, begin.elapsed().as_secs_f64() - asked.paths];
            (row, ())
        });
        Ok(rendering)
    }
}

impl Engine<TexJob> for F64Engine {
    fn render(&self, job: &TexJob, progress: Progress<'_>) -> Result<Rendering, GpuError> {
        Ok(job.float(&self.settings, false, progress, &|_, _| {}).0)
    }
}

/// The Gaussian of the float reference's covariances.
impl Engine<TexJob> for EwaEngine {
    fn render(&self, job: &TexJob, progress: Progress<'_>) -> Result<Rendering, GpuError> {
        Ok(job.float(&self.settings, true, progress, &|_, _| {}).0)
    }
}

/// Real paths through the whole pixel (and lens), into level 0.
impl Engine<TexJob> for TruthEngine {
    fn render(&self, job: &TexJob, progress: Progress<'_>) -> Result<Rendering, GpuError> {
        let start = Instant::now();
        let textures = job.planar(&self.settings);
        let cube = PaddedCube::new(&job.sky.levels[0]);
        let wrap = self.settings.policy.address.wrap();
        let shade = |px: f64, py: f64| {
            let mut path = Path::default();
            job.scene.path([px, py], [0, 1], &mut path);
            let texture = |index: usize, st: [f64; 2]| point(&textures[index], st, wrap);
            let sky = |d: [f64; 3]| cube.look_up(turned(&self.settings, d.into()));
            Some(job.scene.radiance(&path, &texture, &sky))
        };
        let (width, height) = (job.scene.width, job.scene.height);
        let pixels: Vec<[u32; 2]> =
            (0..height).flat_map(|y| (0..width).map(move |x| [x, y].map(num::u32))).collect();
        let result = supersample([width, height], &pixels, &each(shade), &self.options, progress);
        Ok(Rendering::by_rays(start, result, &[]))
    }
}

impl Model for (&TexJob, TexEngine) {
    fn render(&self, progress: Progress<'_>) -> Result<Rendering, GpuError> {
        self.1.render(self.0, progress)
    }

    /// Of the first path of every pixel. The float reference starts from the width in the integer model's cone, so
    /// that what differs is the stages behind `ray_cone`.
    fn registers(&self, settings: &Settings, progress: Progress<'_>) -> RegisterErrors {
        let (job, engine) = self;
        let prepared = Prepared::new(settings);
        let textures = job.planar(settings);
        let each = |y: &usize, sides: &mut Sides| {
            job.each_look(engine, *y, &mut |column, look, words, width| {
                sides.clear();
                let unit = &engine.textures[look.texture];
                let (_, out) = unit.lanes::<1, _>(std::slice::from_ref(words), &mut sides.mine);
                let texture = &textures[look.texture];
                let size = texture.level_size(0);
                let (texture, theirs) = (Some(texture), &mut sides.theirs);
                let there = tex(&prepared, width, &look.fragment, size, texture, theirs);
                let same = out.probes[0] == i64::from(there.probes);
                sides.add([column, *y].map(num::u32), true, same);
            });
        };
        let rows: Vec<usize> = (0..job.scene.height).collect();
        let width = num::u64(job.scene.width);
        RegisterErrors::of(&rows, 1, &|rows| progress(rows * width), each)
    }

    fn trace(&self, pixel: [u32; 2], probe: &mut RtlProbe) -> Option<Vec<String>> {
        let (job, engine) = self;
        let [column, row] = pixel.map(num::usize);
        let mut flags = None;
        job.each_look(engine, row, &mut |x, look, words, _| {
            if x == column && flags.is_none() {
                let unit = &engine.textures[look.texture];
                let (_, out) = unit.lanes::<1, _>(std::slice::from_ref(words), probe);
                flags = Some(unit.flag_names(out.flags[0]));
            }
        });
        flags
    }
}
