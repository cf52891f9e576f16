//! A scene of the TEX operation as every engine renders it.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use rayon::prelude::*;
use rtl_model::unit::{HitWords, TexWords};

use super::dispatch::Source;
use super::gpu::Reports;
use super::gpu::tex::{AskedGpu, GpuTex};
use super::hit::{self, HitF64, HitRtl};
use super::probe::{FloatProbe, RtlProbe};
use super::registers::RegisterErrors;
use super::reuse::lines::{Line, TexLine};
use super::reuse::tex::{First, KeptBlocks, KeptRow};
use super::tex::TexRtl;
use super::tex_requests::{AskedRtl, scene_row};
use super::tex_row::Row;
use super::tiles::Tiles;
use super::{Progress, Rendering, TextureUse};
use crate::base::num;
use crate::cube::CubeMap;
use crate::distance::Distance;
use crate::error::InputError;
use crate::fragment::HitFragment;
use crate::gpu::GpuError;
use crate::picture::Picture;
use crate::reference::tex::{point, tex};
use crate::reference::{NoTap, PlanarTexture, Prepared, ewa_planar};
use crate::scene::tex::TexScene;
use crate::scene::tex::path::{Event, Path};
use crate::settings::Settings;
use crate::truth::texels::PaddedCube;
use crate::truth::{TruthOptions, supersample, turned};
use crate::unit::UnitSpec;

/// A scene with its environment.
#[derive(Clone, Debug)]
pub struct TexSubject {
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
    pub fn new(spec: &UnitSpec, subject: &TexSubject) -> Result<Self, InputError> {
        let textures = subject.scene.textures.iter();
        Ok(Self {
            textures: textures.map(|map| TexRtl::new(spec, map)).collect::<Result<_, _>>()?,
            sky: HitRtl::new(spec, &Distance::nothing(), Some(&subject.sky), subject.sky.size())?,
        })
    }
}

impl TexSubject {
    /// A subject; its paths are traced once to count their requests.
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

    /// Pixels, all of which show something.
    #[must_use]
    pub fn pixels(&self) -> Vec<[u32; 2]> {
        let whole = |n: usize| num::u32(n);
        (0..self.scene.height)
            .flat_map(|y| (0..self.scene.width).map(move |x| [whole(x), whole(y)]))
            .collect()
    }

    /// Rows in parallel, put together in order.
    fn rows(&self, progress: Progress<'_>, row: impl Fn(usize) -> Row + Sync) -> Rendering {
        let start = Instant::now();
        let rows: Vec<Row> = (0..self.scene.height)
            .into_par_iter()
            .map(|y| {
                let out = row(y);
                progress(num::u64(self.scene.width));
                out
            })
            .collect();
        self.put_together(rows, start.elapsed().as_secs_f64())
    }

    /// A picture of rows, in order, that took `wall` seconds.
    fn put_together(&self, rows: Vec<Row>, wall: f64) -> Rendering {
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
            standard_error: None,
            searches: None,
            texture_use: Some(TextureUse { levels, tiles }),
            beyond_f32: None,
        }
    }

    /// By the integer model.
    #[must_use]
    pub fn rtl(
        &self,
        engine: &TexEngine,
        settings: &Settings,
        progress: Progress<'_>,
    ) -> Rendering {
        self.rows(progress, |y| {
            let begin = Instant::now();
            let asked = self.ask_rtl(engine, settings, y);
            let mut row = self.row_by_rtl(engine, &asked, None);
            row.seconds = [asked.paths, begin.elapsed().as_secs_f64() - asked.paths];
            row
        })
    }

    /// By the integer model, from kept rows.
    pub(super) fn rtl_again(
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

    /// By the float reference; `gaussian` takes the elliptical Gaussian of its covariances instead of probes.
    fn float(
        &self,
        settings: &Settings,
        gaussian: bool,
        progress: Progress<'_>,
        keep: &(dyn Fn(usize, Vec<TexLine>) + Sync),
    ) -> Rendering {
        let prepared = Prepared::new(settings);
        let textures = self.planar(settings);
        let nowhere = Distance::nothing();
        let sky = HitF64::new(settings, &nowhere, Some(&self.sky), self.sky.size());
        let cube = crate::reference::Texture::new(&self.sky);
        self.rows(progress, |y| {
            let mut row = Row::new(self.scene.width);
            let begin = Instant::now();
            let asked = self.ask_f64(settings, y);
            row.seconds[0] = asked.paths;
            let mut lines = Vec::with_capacity(asked.looks.len());
            for request in &asked.looks {
                let (index, fragment, width) = &request.asked;
                let texture = &textures[*index];
                let size = texture.level_size(0);
                let read = (!gaussian).then_some(texture);
                let found = tex(&prepared, *width, fragment, size, read, &mut NoTap);
                lines.push(TexLine { texture: *index, line: Line::of_tex(&found), width: *width });
                let colour = if gaussian {
                    let (colour, points) = ewa_planar(&found, texture);
                    row.texels += points;
                    row.probes += 1;
                    colour
                } else {
                    let levels = if found.lod.fract() == 0.0 { 1 } else { 2 };
                    row.texels += 4 * levels * u64::from(found.probes);
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
                        let found = crate::reference::ewa_counted(&env, &cube);
                        row.add(request.column, request.weight, found.color);
                        row.texels += found.points;
                        row.probes += 1;
                    }
                }
            } else {
                row.sky(&asked.sky, sky.filter(&rays, &|_| {}));
            }
            row.seconds[1] = begin.elapsed().as_secs_f64() - row.seconds[0];
            keep(y, lines);
            row
        })
    }

    /// By the kernels of a device: blocks of rows, whose paths the host traces.
    ///
    /// # Errors
    ///
    /// The driver's error.
    pub fn gpu(&self, engine: &GpuTex<'_>, progress: Progress<'_>) -> Result<Rendering, GpuError> {
        let (width, height) = (self.scene.width, self.scene.height);
        let block = engine.rows_of_a_block(self.requests, height);
        let mut rows: Vec<Row> = Vec::with_capacity(height);
        let mut reports = Reports::default();
        let mut seconds = 0.0;
        for first in (0..height).step_by(block) {
            let last = (first + block).min(height);
            let asked: Vec<AskedGpu> =
                (first..last).into_par_iter().map(|y| self.ask_gpu(engine.wrap, y)).collect();
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
        let mut out = self.put_together(rows, 0.0);
        out.seconds = seconds;
        out.flags = reports.flags;
        out.beyond_f32 = reports.beyond_f32;
        Ok(out)
    }

    /// By the float reference.
    #[must_use]
    pub fn f64(&self, settings: &Settings, progress: Progress<'_>) -> Rendering {
        self.float(settings, false, progress, &|_, _| {})
    }

    /// By the float reference, with the probe line of every texture request: row by row, and in a row texture by
    /// texture, as kept results have them.
    #[must_use]
    pub fn f64_lines(&self, settings: &Settings) -> (Rendering, Vec<TexLine>) {
        let rows = Mutex::new(vec![Vec::new(); self.scene.height]);
        let rendering = self.float(settings, false, &|_| {}, &|y, mut lines| {
            lines.sort_by_key(|line| line.texture);
            rows.lock().unwrap_or_else(PoisonError::into_inner)[y] = lines;
        });
        let rows = rows.into_inner().unwrap_or_else(PoisonError::into_inner);
        (rendering, rows.concat())
    }

    /// By the elliptical Gaussian of the float reference's covariances.
    #[must_use]
    pub fn ewa(&self, settings: &Settings, progress: Progress<'_>) -> Rendering {
        self.float(settings, true, progress, &|_, _| {})
    }

    /// By real paths through the whole pixel (and lens), into level 0.
    #[must_use]
    pub fn truth(
        &self,
        settings: &Settings,
        options: &TruthOptions,
        progress: Progress<'_>,
    ) -> Rendering {
        let start = Instant::now();
        let textures = self.planar(settings);
        let cube = PaddedCube::new(&self.sky.levels[0]);
        let wrap = settings.policy.address.wrap();
        let shade = |px: f64, py: f64| {
            let mut path = Path::default();
            self.scene.path([px, py], [0, 1], &mut path);
            let texture = |index: usize, st: [f64; 2]| point(&textures[index], st, wrap);
            let sky = |d: [f64; 3]| cube.look_up(turned(settings, d.into()));
            Some(self.scene.radiance(&path, &texture, &sky))
        };
        let size = [self.scene.width, self.scene.height];
        let result = supersample(size, &self.pixels(), &shade, options, progress);
        Rendering::by_rays(
            result.picture,
            start.elapsed().as_secs_f64(),
            result.samples,
            result.rms_standard_error,
        )
    }

    /// Compares every register of the first path of every pixel. The float reference starts from the width in the
    /// integer model's cone, so that what differs is the stages behind `ray_cone`.
    #[must_use]
    pub fn registers(
        &self,
        engine: &TexEngine,
        settings: &Settings,
        progress: Progress<'_>,
    ) -> RegisterErrors {
        let prepared = Prepared::new(settings);
        let textures = self.planar(settings);
        let parts: Vec<RegisterErrors> = (0..self.scene.height)
            .into_par_iter()
            .map(|y| {
                let mut errors = RegisterErrors::default();
                let (mut mine, mut theirs) = (RtlProbe::default(), FloatProbe::default());
                self.each_look(engine, settings, y, &mut |column, look, words, width| {
                    mine.clear();
                    theirs.clear();
                    let unit = &engine.textures[look.texture];
                    let (_, out) = unit.lanes::<1, _>(std::slice::from_ref(words), &mut mine);
                    let texture = &textures[look.texture];
                    let size = texture.level_size(0);
                    let there =
                        tex(&prepared, width, &look.fragment, size, Some(texture), &mut theirs);
                    let same = out.probes[0] == i64::from(there.probes);
                    let pixel = [column, y].map(num::u32);
                    errors.add(&mine, &theirs, pixel, true, same);
                });
                progress(num::u64(self.scene.width));
                errors
            })
            .collect();
        parts.iter().fold(RegisterErrors::default(), RegisterErrors::merge)
    }
}
