//! The work of a rendering command: a scene of any operation, by any engine.

use rtl_model::regs::Reg;

use super::args::SceneArgs;
use super::subject;
use crate::base::num;
use crate::caustic::Caustic;
use crate::cube::CubeMap;
use crate::distance::Distance;
use crate::engine::float::{EwaEngine, F64Engine, TruthEngine};
use crate::engine::gpu::GpuEnv;
use crate::engine::gpu::check::{StageChecks, check_env, check_hit, check_tex};
use crate::engine::gpu::hit::GpuHit;
use crate::engine::gpu::tex::GpuTex;
use crate::engine::hit::HitRtl;
use crate::engine::hit_subject::{HitSubject, lit};
use crate::engine::probe::{self, RtlProbe};
use crate::engine::registers::{self, RegisterErrors};
use crate::engine::rtl::RtlEngine;
use crate::engine::sampler::SamplerEngine;
use crate::engine::tex_subject::{TexEngine, TexSubject};
use crate::engine::{Engine as _, Progress, Rendering, Rung, Subject};
use crate::error::InputError;
use crate::gpu::{Gpu, GpuError};
use crate::operation::Operation;
use crate::picture::Picture;
use crate::report::error_map::{colour_of_steps, mosaic};
use crate::scene::registry::find;
use crate::scene::world::light::WallMap;
use crate::scene::{hit, tex};
use crate::settings::Settings;
use crate::srgb::srgb_decode;
use crate::truth::TruthOptions;
use crate::unit::UnitSpec;

/// A scene with its maps.
pub(super) enum Job {
    /// Fragments of reflections.
    Env(Box<Subject>),
    /// Rays against an impostor.
    Hit(Box<HitSubject>),
    /// Paths with ray cones.
    Tex(Box<TexSubject>),
}

/// Refuses the engine that has no TEX operation for scenes of it.
pub(super) fn refuse_sampler(scene: &str, rungs: &[Rung]) -> Result<(), InputError> {
    if rungs.contains(&Rung::Sampler) && find(scene)?.operation() == Operation::Tex {
        return Err(InputError::new(
            "sampler",
            "a scene of the operations that it has, ENV and HIT",
            format!("`{scene}`, a scene of TEX"),
            "leave sampler out, or choose another scene",
        ));
    }
    Ok(())
}

/// The integer model, compiled for a job.
pub(super) enum Rtl {
    Env(Box<RtlEngine>),
    Hit(Box<HitRtl>),
    Tex(Box<TexEngine>),
}

/// The pictures beside the engines' own that `--out` writes for scenes of the HIT operation, the last one where
/// there is a caustic.
pub(super) const HIT_PICTURES: [&str; 4] = ["classic", "views", "iterations", "lightmap"];

/// The pictures that `--out` writes for scenes of the TEX operation: the levels of detail in colours, and the tiles of
/// the first texture that the integer model touched.
pub(super) const TEX_PICTURES: [&str; 2] = ["levels", "tiles"];

/// The pictures beside the engines' own that a scene may have.
pub(super) const fn extra_pictures(operation: Operation) -> &'static [&'static str] {
    match operation {
        Operation::Env(_) => &[],
        Operation::Hit => &HIT_PICTURES,
        Operation::Tex => &TEX_PICTURES,
    }
}

/// The scene's caustic by those engines that search, and by real rays.
pub(super) struct Caustics {
    /// Photons that entered the object.
    pub(super) photons: usize,
    /// In the ladder's order; `truth` is real rays.
    pub(super) by: Vec<(Rung, Caustic)>,
}

impl Caustics {
    /// The wall that gets the most light from real rays, by every engine, side by side; its brightest texel is white.
    fn picture(&self) -> Option<Picture> {
        let (_, rays) = self.by.last()?;
        let power = |w: &WallMap| w.texels.iter().map(|t| t[0]).sum::<f64>() * w.area;
        let walls = &rays.map.walls;
        let most =
            (0..walls.len()).max_by(|a, b| power(&walls[*a]).total_cmp(&power(&walls[*b])))?;
        let brightest = walls[most].texels.iter().flatten().fold(1e-9, |a: f64, b| a.max(*b));
        let shown: Vec<(Picture, String)> = self
            .by
            .iter()
            .map(|(rung, caustic)| {
                let wall = &caustic.map.walls[most];
                let mut picture = Picture::new(wall.columns, wall.rows);
                for (rgb, light) in picture.rgb.iter_mut().zip(&wall.texels) {
                    *rgb = light.map(|e| e / brightest);
                }
                picture.covered.fill(true);
                let name = if *rung == Rung::Truth { "rays" } else { rung.name() };
                (picture, name.to_string())
            })
            .collect();
        let row: Vec<(&Picture, &str)> = shown.iter().map(|(p, n)| (p, n.as_str())).collect();
        Some(mosaic(&row, 8))
    }
}

impl Job {
    /// Loads and builds what the flags ask for; warnings go to stderr.
    pub(super) fn load(
        name: &str,
        args: &SceneArgs,
        settings: &Settings,
    ) -> Result<Self, InputError> {
        let info = find(name)?;
        let operation = info.operation();
        if operation != Operation::Tex {
            args.refuse_texture()?;
        }
        if operation != Operation::Hit {
            args.refuse_distance()?;
        }
        match operation {
            Operation::Env(_) => {
                let subject = subject::load(name, args, settings)?;
                Ok(Self::Env(Box::new(subject)))
            }
            Operation::Hit => {
                let mut scene = hit::build(name, &subject::options(args)?)?;
                scene.notes.iter().for_each(|note| super::note(note));
                let distance = args.distance()?;
                let other = subject::load_map(args)?;
                let own_colours = other.is_none();
                let (impostor, lit) = lit(&mut scene);
                let map = other.unwrap_or(impostor.colour);
                let distance = distance.unwrap_or(Distance::Cube(impostor.distance));
                let mut subject = HitSubject::new(scene, map, distance, own_colours);
                subject.lit = lit;
                Ok(Self::Hit(Box::new(subject)))
            }
            Operation::Tex => {
                let options = subject::options(args)?;
                let floor = subject::load_texture(args)?;
                let mut scene = tex::build(name, &options, floor)?;
                args.bounces.into_iter().for_each(|bounces| scene.show_only(bounces));
                scene.notes.iter().for_each(|note| super::note(note));
                let sky = subject::load_sky(args)?;
                Ok(Self::Tex(Box::new(TexSubject::new(scene, sky))))
            }
        }
    }

    /// Columns and rows.
    pub(super) fn size(&self) -> [usize; 2] {
        match self {
            Self::Env(s) => [s.scene.width, s.scene.height],
            Self::Hit(s) => [s.scene.width, s.scene.height],
            Self::Tex(s) => [s.scene.width, s.scene.height],
        }
    }

    /// Fragments, or rays.
    pub(super) fn fragments(&self) -> usize {
        match self {
            Self::Env(s) => s.scene.fragments.len(),
            Self::Hit(s) => s.scene.rays.len(),
            Self::Tex(s) => num::usize(s.requests),
        }
    }

    /// Fragments that an engine's progress counts: `truth` works on pixels.
    pub(super) fn total(&self, rung: Rung) -> u64 {
        match self {
            Self::Hit(s) if rung == Rung::Truth => num::u64(s.scene.pixels().len()),
            Self::Tex(s) => num::u64(s.scene.width * s.scene.height),
            Self::Env(_) | Self::Hit(_) => num::u64(self.fragments()),
        }
    }

    /// The environment that is filtered.
    pub(super) fn map(&self) -> &CubeMap {
        match self {
            Self::Env(s) => &s.map,
            Self::Hit(s) => &s.map,
            Self::Tex(s) => &s.sky,
        }
    }

    /// Where the colours come from if no file was named.
    pub(super) fn environment(&self) -> &'static str {
        match self {
            Self::Env(_) => "procedural environment",
            Self::Hit(_) => "the world's impostor",
            Self::Tex(_) => "procedural textures, procedural environment",
        }
    }

    /// Compiles the integer model.
    pub(super) fn rtl(&self, spec: &UnitSpec) -> Result<Rtl, InputError> {
        Ok(match self {
            Self::Env(s) => Rtl::Env(Box::new(RtlEngine::new(spec, s.needs(), &s.map)?)),
            Self::Hit(s) => {
                Rtl::Hit(Box::new(HitRtl::new(spec, &s.distance, Some(&s.map), s.map.size())?))
            }
            Self::Tex(s) => Rtl::Tex(Box::new(TexEngine::new(spec, s)?)),
        })
    }

    /// Renders by the integer model.
    pub(super) fn render_rtl(
        &self,
        rtl: &Rtl,
        settings: &Settings,
        progress: Progress<'_>,
    ) -> Option<Rendering> {
        match (self, rtl) {
            (Self::Env(s), Rtl::Env(engine)) => Some(engine.render(s, progress)),
            (Self::Hit(s), Rtl::Hit(engine)) => Some(s.rtl(engine, progress)),
            (Self::Tex(s), Rtl::Tex(engine)) => Some(s.rtl(engine, settings, progress)),
            (Self::Env(_) | Self::Hit(_) | Self::Tex(_), _) => None,
        }
    }

    /// Renders on a GPU: by its own sampler, else by kernels.
    pub(super) fn render_on(
        &self,
        gpu: &Gpu,
        rung: Rung,
        settings: &Settings,
        progress: Progress<'_>,
    ) -> Result<Rendering, GpuError> {
        if rung != Rung::Sampler {
            return self.render_gpu(gpu, settings, progress);
        }
        match self {
            Self::Env(s) => SamplerEngine::new(gpu, &s.map)?.env(settings, s, progress),
            Self::Hit(s) => SamplerEngine::new(gpu, &s.map)?.hit(settings, s, progress),
            Self::Tex(_) => Err(GpuError::Unsupported {
                adapter: gpu.adapter().title(),
                doing: "the engine sampler on 2-D textures".into(),
                lacks: "an engine for them".into(),
            }),
        }
    }

    /// Renders by a GPU's kernels.
    fn render_gpu(
        &self,
        gpu: &Gpu,
        settings: &Settings,
        progress: Progress<'_>,
    ) -> Result<Rendering, GpuError> {
        match self {
            Self::Env(s) => {
                let first = s.scene.fragments.first().map(|f| &f.fragment);
                GpuEnv::new(gpu, settings, &s.map, first)?.render(s, progress)
            }
            Self::Hit(s) => {
                let map = Some(&s.map);
                s.gpu(&GpuHit::new(gpu, settings, &s.distance, map, s.map.size())?, progress)
            }
            Self::Tex(s) => s.gpu(&GpuTex::new(gpu, settings, s)?, progress),
        }
    }

    /// Every register of every stage of a GPU's kernels against the float reference.
    pub(super) fn check_stages(
        &self,
        gpu: &Gpu,
        settings: &Settings,
        progress: Progress<'_>,
    ) -> Result<StageChecks, GpuError> {
        match self {
            Self::Env(s) => check_env(gpu, settings, &s.map, &s.scene.fragments, progress),
            Self::Hit(s) => {
                let rays: Vec<_> = s.scene.rays.iter().map(|r| (r.pixel, r.fragment)).collect();
                check_hit(gpu, settings, (&s.map, &s.distance), &rays, progress)
            }
            Self::Tex(s) => check_tex(gpu, settings, s, progress),
        }
    }

    /// Renders by one of the float engines; nothing for the others.
    pub(super) fn render_float(
        &self,
        rung: Rung,
        settings: &Settings,
        options: &TruthOptions,
        progress: Progress<'_>,
    ) -> Option<Rendering> {
        let settings = settings.clone();
        match (self, rung) {
            (_, Rung::Rtl | Rung::Gpu | Rung::Sampler) => None,
            (Self::Env(s), Rung::F64) => Some(F64Engine { settings }.render(s, progress)),
            (Self::Env(s), Rung::Ewa) => Some(EwaEngine { settings }.render(s, progress)),
            (Self::Env(s), Rung::Truth) => {
                let options = *options;
                Some(TruthEngine { settings, options }.render(s, progress))
            }
            (Self::Hit(s), Rung::F64) => Some(s.f64(&settings, progress)),
            (Self::Hit(s), Rung::Ewa) => Some(s.ewa(&settings, progress)),
            (Self::Hit(s), Rung::Truth) => Some(s.truth(options, progress)),
            (Self::Tex(s), Rung::F64) => Some(s.f64(&settings, progress)),
            (Self::Tex(s), Rung::Ewa) => Some(s.ewa(&settings, progress)),
            (Self::Tex(s), Rung::Truth) => Some(s.truth(&settings, options, progress)),
        }
    }

    /// Every register of the integer model against the float reference.
    pub(super) fn registers(
        &self,
        rtl: &Rtl,
        settings: &Settings,
        progress: Progress<'_>,
    ) -> Option<RegisterErrors> {
        match (self, rtl) {
            (Self::Env(s), Rtl::Env(e)) => Some(registers::compare(e, settings, s, progress)),
            (Self::Hit(s), Rtl::Hit(e)) => Some(s.registers(e, settings, progress)),
            (Self::Tex(s), Rtl::Tex(e)) => Some(s.registers(e, settings, progress)),
            (Self::Env(_) | Self::Hit(_) | Self::Tex(_), _) => None,
        }
    }

    /// A register of the integer model at the first fragment of a pixel; nothing where it has none of that name.
    pub(super) fn rtl_register(
        &self,
        rtl: &Rtl,
        settings: &Settings,
        pixel: [u32; 2],
        (stage, register): (&str, &str),
    ) -> Option<Vec<f64>> {
        let reg = Reg::find(stage, register)?;
        let mut probe = RtlProbe::default();
        match (self, rtl) {
            (Self::Env(s), Rtl::Env(e)) => {
                let f = s.scene.fragments.iter().find(|f| f.pixel == pixel)?;
                let texture = e.memory.texture.as_ref();
                probe::rtl(&e.unit, &e.config, &f.fragment, texture, &mut probe);
            }
            (Self::Hit(s), Rtl::Hit(e)) => {
                let ray = s.scene.rays.iter().find(|r| r.pixel == pixel)?;
                e.trace(&ray.fragment, &mut probe);
            }
            (Self::Tex(s), Rtl::Tex(e)) => {
                let [column, row] = pixel.map(num::usize);
                let mut done = false;
                s.each_look(e, settings, row, &mut |x, look, words, _| {
                    if x == column && !done {
                        let words = std::slice::from_ref(words);
                        let _ = e.textures[look.texture].lanes::<1, _>(words, &mut probe);
                        done = true;
                    }
                });
            }
            (Self::Env(_) | Self::Hit(_) | Self::Tex(_), _) => return None,
        }
        let values = probe.get(reg).iter().filter(|code| code.is_written());
        Some(values.map(|code| code.value()).collect())
    }

    /// The caustic by the engines of `rungs`; nothing where no lamp shines through an object.
    pub(super) fn caustics(
        &self,
        rungs: &[Rung],
        rtl: Option<&Rtl>,
        gpu: Option<&Gpu>,
        settings: &Settings,
    ) -> Result<Option<Caustics>, GpuError> {
        let Self::Hit(subject) = self else {
            return Ok(None);
        };
        let Some(lit) = subject.lit.as_ref() else {
            return Ok(None);
        };
        let world = &subject.scene.view.world;
        let mut by = Vec::new();
        if let Some(Rtl::Hit(engine)) = rtl {
            by.push((Rung::Rtl, lit.by_rtl(world, engine)));
        }
        if let Some(gpu) = gpu.filter(|_| rungs.contains(&Rung::Gpu)) {
            let engine = GpuHit::new(gpu, settings, &subject.distance, None, 1)?;
            by.push((Rung::Gpu, lit.by_gpu(world, &engine)?));
        }
        if rungs.contains(&Rung::F64) {
            by.push((Rung::F64, lit.by_f64(world, &subject.reference(settings))));
        }
        by.push((Rung::Truth, lit.by_rays(world)));
        Ok(Some(Caustics { photons: lit.photons.len(), by }))
    }

    /// The pictures of [`extra_pictures`]. `filtered` is by the float reference, else by the integer model.
    pub(super) fn extra(
        &self,
        settings: &Settings,
        [rtl, f64]: [Option<&Rendering>; 2],
        truth: Option<&Rendering>,
        caustics: Option<&Caustics>,
    ) -> Vec<(&'static str, Picture)> {
        match self {
            Self::Env(_) => Vec::new(),
            Self::Hit(_) => self.hit_pictures(settings, f64.or(rtl), truth, caustics),
            Self::Tex(_) => {
                let [rtl, f64] = [rtl, f64].map(|r| r.and_then(|r| r.texture_use.as_ref()));
                let levels = rtl.or(f64).map(|u| (TEX_PICTURES[0], u.levels.clone()));
                let tiles = rtl.and_then(|u| u.tiles.first());
                let tiles = tiles.map(|t| (TEX_PICTURES[1], t.picture()));
                levels.into_iter().chain(tiles).collect()
            }
        }
    }

    /// The pictures of [`HIT_PICTURES`]: the look-up by R alone; that, the hit and real rays side by side; the
    /// look-ups of each pixel's first ray. `hit` is by the float reference, else by the integer model.
    fn hit_pictures(
        &self,
        settings: &Settings,
        hit: Option<&Rendering>,
        truth: Option<&Rendering>,
        caustics: Option<&Caustics>,
    ) -> Vec<(&'static str, Picture)> {
        let Self::Hit(subject) = self else {
            return Vec::new();
        };
        let light = caustics.and_then(Caustics::picture);
        let classic = subject.classic(settings);
        let mut views = vec![(&classic, "classic")];
        views.extend(hit.map(|r| (&r.picture, "hit")));
        views.extend(truth.map(|r| (&r.picture, "rays")));
        let views = mosaic(&views, 8);
        let mut out = vec![(HIT_PICTURES[1], views)];
        if let Some(searches) = hit.and_then(|r| r.searches.as_ref()) {
            let most = searches.iterations.iter().copied().max().unwrap_or(0);
            let mut picture = Picture::new(subject.scene.width, subject.scene.height);
            picture.rgb.fill([0.1; 3]);
            let mut before = None;
            for (ray, n) in subject.scene.rays.iter().zip(&searches.iterations) {
                if before == Some(ray.pixel) {
                    continue;
                }
                before = Some(ray.pixel);
                let [x, y] = ray.pixel.map(num::usize);
                let index = y * subject.scene.width + x;
                let share = f64::from(*n) / f64::from(most.max(1));
                picture.rgb[index] = colour_of_steps(libm::exp2(16.0 * share - 8.0))
                    .map(|c| srgb_decode(f64::from(c) / 255.0));
                picture.covered[index] = true;
            }
            let label = format!("look-ups 0 = dark, {most} = white");
            out.push((HIT_PICTURES[2], mosaic(&[(&picture, &label)], 8)));
        }
        out.extend(light.map(|picture| (HIT_PICTURES[3], picture)));
        out.insert(0, (HIT_PICTURES[0], classic));
        out
    }
}
