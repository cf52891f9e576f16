//! The pictures of `compare --out` besides the engines' own.

use std::cell::OnceCell;

use super::compare::Results;
use crate::engine::job::lit::Caustics;
use crate::engine::{EngineKind, HitJob, Job};
use crate::operation::Operation;
use crate::picture::Picture;
use crate::report::error_map::{mosaic, ramp};
use crate::scene::world::light::WallMap;
use crate::settings::Settings;

/// One of them. A scene has those of its operation that the engines of a run give.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Extra {
    /// The look-up by R alone.
    Classic,
    /// That, the hit and real rays side by side.
    Views,
    /// The look-ups of each pixel's first ray.
    Iterations,
    /// The caustic on the wall that gets most of it.
    Lightmap,
    /// Levels of detail in colours.
    Levels,
    /// The tiles of the first texture that the integer model touched.
    Tiles,
}

impl Extra {
    /// Those that a scene of an operation may have.
    pub(super) const fn of(operation: Operation) -> &'static [Self] {
        match operation {
            Operation::Env(_) => &[],
            Operation::Hit => &[Self::Classic, Self::Views, Self::Iterations, Self::Lightmap],
            Operation::Tex => &[Self::Levels, Self::Tiles],
        }
    }

    /// The name of its file.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Classic => "classic",
            Self::Views => "views",
            Self::Iterations => "iterations",
            Self::Lightmap => "lightmap",
            Self::Levels => "levels",
            Self::Tiles => "tiles",
        }
    }

    /// Whether it shows data, which no exposure changes.
    pub(super) const fn is_data(self) -> bool {
        matches!(self, Self::Iterations | Self::Levels | Self::Tiles)
    }
}

/// The sources of the pictures.
pub(super) struct Drawing<'a> {
    job: &'a Job,
    settings: &'a Settings,
    results: &'a Results,
    classic: OnceCell<Picture>,
}

impl<'a> Drawing<'a> {
    pub(super) fn new(job: &'a Job, settings: &'a Settings, results: &'a Results) -> Self {
        Self { job, settings, results, classic: OnceCell::new() }
    }

    fn classic(&self, job: &HitJob) -> &Picture {
        self.classic.get_or_init(|| job.classic(self.settings))
    }

    /// A picture; nothing where the engines that ran do not give it. Searches are the float reference's, else the
    /// integer model's, and levels the other way round.
    pub(super) fn picture(&self, extra: Extra) -> Option<Picture> {
        let [rtl, f64, truth] = [EngineKind::Rtl, EngineKind::F64, EngineKind::Truth]
            .map(|kind| self.results.get(kind));
        let used = |r: Option<&'a crate::engine::Rendering>| r?.texture_use.as_ref();
        match (extra, self.job) {
            (Extra::Classic, Job::Hit(job)) => Some(self.classic(job).clone()),
            (Extra::Views, Job::Hit(job)) => {
                let mut views = vec![(self.classic(job), "classic")];
                views.extend(f64.or(rtl).map(|r| (&r.picture, "hit")));
                views.extend(truth.map(|r| (&r.picture, "rays")));
                Some(mosaic(&views, 8))
            }
            (Extra::Iterations, _) => {
                let found = &f64.or(rtl)?.searches.as_ref()?.iterations;
                let most = found.iter().copied().max().unwrap_or(0);
                let numbers = found.iter().map(|n| f64::from(*n));
                let picture = ramp(self.job.size(), self.job.pixels().into_iter().zip(numbers));
                let label = format!("look-ups 0 = dark, {most} = white");
                Some(mosaic(&[(&picture, &label)], 8))
            }
            (Extra::Lightmap, _) => lightmap(self.results.caustics.as_ref()?),
            (Extra::Levels, _) => used(rtl).or(used(f64)).map(|u| u.levels.clone()),
            (Extra::Tiles, _) => used(rtl)?.tiles.first().map(|tiles| tiles.picture()),
            (Extra::Classic | Extra::Views, Job::Env(_) | Job::Tex(_)) => None,
        }
    }
}

/// The wall that gets the most light from real rays, by every engine, side by side; its brightest texel is white.
fn lightmap(caustics: &Caustics) -> Option<Picture> {
    let (_, rays) = caustics.by.last()?;
    let power = |w: &WallMap| w.texels.iter().map(|t| t[0]).sum::<f64>() * w.area;
    let walls = &rays.map.walls;
    let most = (0..walls.len()).max_by(|a, b| power(&walls[*a]).total_cmp(&power(&walls[*b])))?;
    let brightest = walls[most].texels.iter().flatten().fold(1e-9, |a: f64, b| a.max(*b));
    let shown: Vec<(Picture, &str)> = caustics
        .by
        .iter()
        .map(|(kind, caustic)| {
            let wall = &caustic.map.walls[most];
            let mut picture = Picture::new(wall.columns, wall.rows);
            for (rgb, light) in picture.rgb.iter_mut().zip(&wall.texels) {
                *rgb = light.map(|e| e / brightest);
            }
            picture.covered.fill(true);
            (picture, if *kind == EngineKind::Truth { "rays" } else { kind.name() })
        })
        .collect();
    let row: Vec<(&Picture, &str)> = shown.iter().map(|(picture, name)| (picture, *name)).collect();
    Some(mosaic(&row, 8))
}
