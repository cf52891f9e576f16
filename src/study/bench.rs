//! One picture under many units: everything that does not change from unit to unit is kept.
//!
//! Kept are the scene, the references by the policies that they honour, real rays, texels in memory, and the
//! registers in front of the first one that a unit changes (`engine::reuse`).

use crate::base::num;
use std::collections::BTreeMap;

use crate::engine::hit::HitResult;
use crate::engine::reuse::Saved;
use crate::engine::reuse::lines::{Apart, Line, RtlLine, quantile};
use crate::engine::reuse::tex::KeptTex;
use crate::engine::reuse::{KeptEnv, KeptHit};
use crate::engine::tiles::Tiles;
use crate::engine::{Rendering, Rung};
use crate::error::InputError;
use crate::picture::Picture;
use crate::report::metrics;
use crate::settings::Settings;
use crate::truth::TruthOptions;
use crate::unit::UnitSpec;

use super::cost::CostModel;
use super::cost::texels::{TexelUse, Walk};
use super::measures::Measures;
pub use super::scene::Scene;
use super::scene::render_reference;
use super::searches::RealRays;
use super::{cones, edges, footprints};

/// The results that a bench keeps from earlier units.
#[derive(Debug)]
enum Kept {
    Env(KeptEnv),
    Hit(KeptHit),
    Tex(KeptTex),
}

/// What units are compared with, and how costs are counted.
#[derive(Clone, Debug)]
pub struct Measuring {
    /// References, f64 first.
    pub against: Vec<Rung>,
    /// Options of `truth`.
    pub truth: TruthOptions,
    /// Exposure in stops.
    pub exposure: f64,
    /// The cost model's knobs.
    pub cost: CostModel,
    /// Whether results of the units before are used.
    pub reuse: bool,
    /// Figures that are kept: some take time of their own.
    pub figures: Vec<String>,
}

impl Measuring {
    /// Whether a figure is kept that has `part` in its name.
    #[must_use]
    pub fn wants(&self, part: &str) -> bool {
        self.figures.iter().any(|figure| figure.contains(part))
    }
}

/// A reference picture, with its lines where it is the float reference's.
#[derive(Clone, Debug)]
struct Reference {
    rung: Rung,
    settings: Settings,
    picture: Picture,
    lines: Vec<Line>,
    widths: Vec<f64>,
}

/// Most references that are kept.
const MOST_REFERENCES: usize = 24;

/// A scene with everything that is kept from unit to unit.
#[derive(Debug)]
pub struct Bench {
    scene: Scene,
    kept: Kept,
    references: Vec<Reference>,
    rays: Option<RealRays>,
    footprints: Option<Vec<(&'static str, Option<f64>)>>,
    texels: BTreeMap<u64, TexelUse>,
    /// Seconds in the integer model.
    pub rtl_seconds: f64,
    /// Steps kept and steps in all.
    pub saved: [u64; 2],
}

/// A bench's results for a unit.
#[derive(Debug)]
pub struct Found {
    /// Figures.
    pub measures: Measures,
    /// The unit's picture.
    pub picture: Picture,
    /// The parts that were not run again.
    pub saved: Saved,
}

impl Bench {
    /// A bench for a scene.
    #[must_use]
    pub fn new(scene: Scene) -> Self {
        let kept = Self::empty(&scene);
        Self {
            scene,
            kept,
            references: Vec::new(),
            rays: None,
            footprints: None,
            texels: BTreeMap::new(),
            rtl_seconds: 0.0,
            saved: [0; 2],
        }
    }

    fn empty(scene: &Scene) -> Kept {
        match scene {
            Scene::Env(_) => Kept::Env(KeptEnv::default()),
            Scene::Hit(_) => Kept::Hit(KeptHit::default()),
            Scene::Tex(_) => Kept::Tex(KeptTex::default()),
        }
    }

    /// The scene.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Renders by the integer model.
    ///
    /// # Errors
    /// The unit is refused.
    pub fn render(
        &mut self,
        spec: &UnitSpec,
        settings: &Settings,
        reuse: bool,
    ) -> Result<(Rendering, Vec<HitResult>, Saved), InputError> {
        if !reuse {
            self.kept = Self::empty(&self.scene);
        }
        let out = match (&self.scene, &mut self.kept) {
            (Scene::Env(subject), Kept::Env(kept)) => {
                let (rendering, saved) = kept.render(spec, subject)?;
                (rendering, Vec::new(), saved)
            }
            (Scene::Hit(subject), Kept::Hit(kept)) => kept.render(spec, subject)?,
            (Scene::Tex(subject), Kept::Tex(kept)) => {
                let (rendering, saved) = kept.render(spec, settings, subject)?;
                (rendering, Vec::new(), saved)
            }
            (scene, kept) => {
                // Both are made together; a bench that lost its way starts again.
                *kept = Self::empty(scene);
                return self.render(spec, settings, true);
            }
        };
        self.rtl_seconds += out.0.seconds;
        for (sum, n) in self.saved.iter_mut().zip([out.2.kept, out.2.steps]) {
            *sum += num::u64(n);
        }
        Ok(out)
    }

    /// Everything about a unit.
    ///
    /// # Errors
    /// The unit is refused.
    pub fn measure(
        &mut self,
        spec: &UnitSpec,
        settings: &Settings,
        how: &Measuring,
    ) -> Result<Found, InputError> {
        let (rendering, results, saved) = self.render(spec, settings, how.reuse)?;
        let mut measures = Measures::default();
        if !how.reuse {
            self.references.clear();
        }
        for rung in &how.against {
            let index = self.reference(*rung, settings, &how.truth);
            let reference = &self.references[index];
            let pair = metrics::compare(&rendering.picture, &reference.picture, how.exposure)?;
            measures.put_pair(*rung, &pair);
        }
        self.compare_lines(settings, how, &mut measures);
        self.compare_hits(settings, &results, how, &mut measures)?;
        if let Scene::Env(subject) = &self.scene {
            if how.wants("minor_error_") || how.wants("thin_line_end_") {
                edges::thin(spec, &mut measures)?;
            }
            if how.wants("jump_") {
                edges::jumps(spec, settings, &subject.map, &mut measures)?;
            }
        }
        if let (Scene::Tex(subject), true) =
            (&self.scene, how.wants("cone_lod") || how.wants("texture_requests"))
        {
            for (name, value) in cones::figures(subject, spec, settings) {
                measures.put(name, value);
            }
        }
        if let Some(used) = &rendering.texture_use {
            let counts = used.tiles.iter().map(Tiles::counts);
            let finest = counts.map(|c| c.first().copied().unwrap_or(0)).sum::<usize>();
            measures
                .put("texture_tiles", used.tiles.iter().map(Tiles::total).sum::<usize>() as f64);
            measures.put("texture_tiles_level_0", finest as f64);
        }
        measures.put("requests", self.scene.fragments() as f64);
        let fragments = self.scene.fragments().max(1) as f64;
        measures.put("flagged_share", rendering.flags.values().sum::<u64>() as f64 / fragments);
        let probes = rendering.probes as f64 / fragments;
        measures.put("probes_per_fragment", probes);
        measures.put("texels_per_fragment", rendering.texels as f64 / fragments);
        if let Some(texels) = self.texel_use(spec, how) {
            measures.put("tiles", texels.tiles as f64);
            measures.put("cache_hit_share", texels.hit_share());
        }
        let look_ups = rendering.searches.as_ref().map_or(0.0, crate::engine::Searches::look_ups);
        how.cost.sheet(&spec.config, self.scene.operation()).put(
            &how.cost,
            [probes, look_ups],
            &mut measures,
        );
        Ok(Found { measures, picture: rendering.picture, saved })
    }

    /// The picture of a reference.
    #[must_use]
    pub fn reference_picture(
        &mut self,
        rung: Rung,
        settings: &Settings,
        truth: &TruthOptions,
    ) -> &Picture {
        let index = self.reference(rung, settings, truth);
        &self.references[index].picture
    }

    /// The probe lines of the float reference.
    #[must_use]
    pub fn reference_lines(&mut self, settings: &Settings, truth: &TruthOptions) -> &[Line] {
        let index = self.reference(Rung::F64, settings, truth);
        &self.references[index].lines
    }

    /// The probe lines of the unit that rendered last, one a fragment, ray or texture request.
    pub fn lines(&self, each: &mut dyn FnMut(RtlLine)) {
        match &self.kept {
            Kept::Env(kept) => kept.lines(each),
            Kept::Hit(kept) => kept.lines(each),
            Kept::Tex(kept) => kept.lines(&mut |line, _| each(line)),
        }
    }

    /// The place of a reference among those that are kept.
    fn reference(&mut self, rung: Rung, settings: &Settings, truth: &TruthOptions) -> usize {
        let counts = self.scene.settings_that_count(rung, settings);
        let known = self.references.iter().position(|r| r.rung == rung && r.settings == counts);
        if let Some(index) = known {
            return index;
        }
        let (rendering, lines, widths) = render_reference(&self.scene, rung, settings, truth);
        if self.references.len() >= MOST_REFERENCES {
            // Truth costs most and is never dropped.
            let oldest = self.references.iter().position(|r| r.rung != Rung::Truth);
            self.references.remove(oldest.unwrap_or(0));
        }
        self.references.push(Reference {
            rung,
            settings: counts,
            picture: rendering.picture,
            lines,
            widths,
        });
        self.references.len() - 1
    }

    /// The integer model's probe lines against the reference's.
    fn compare_lines(&mut self, settings: &Settings, how: &Measuring, measures: &mut Measures) {
        let index = self.reference(Rung::F64, settings, &how.truth);
        let reference = &self.references[index];
        let mut apart = Apart::default();
        let mut widths = Vec::new();
        let mut theirs = reference.lines.iter();
        match &self.kept {
            Kept::Env(kept) => kept.lines(&mut |line| {
                theirs.next().into_iter().for_each(|float| apart.add(line, float));
            }),
            Kept::Hit(kept) => kept.lines(&mut |line| {
                theirs.next().into_iter().for_each(|float| apart.add(line, float));
            }),
            Kept::Tex(kept) => {
                let mut exact = reference.widths.iter();
                kept.lines(&mut |line, width| {
                    theirs.next().into_iter().for_each(|float| apart.add(line, float));
                    let there = exact.next().copied().unwrap_or(0.0).abs();
                    widths.push((width.abs() - there).abs() / there.max(f64::MIN_POSITIVE));
                });
                widths.sort_by(f64::total_cmp);
            }
        }
        if apart.is_empty() {
            // Of very large pictures no registers are kept.
            return;
        }
        if !widths.is_empty() {
            measures.put("cone_width_median", quantile(&widths, 50));
            measures.put("cone_width_p95", quantile(&widths, 95));
            measures.put("cone_width_max", quantile(&widths, 100));
        }
        let [axis, end, lod] = apart.quantiles();
        measures.put("axis_p95_deg", axis[0]);
        measures.put("axis_max_deg", axis[1]);
        measures.put("line_end_p95", end[0]);
        measures.put("line_end_max", end[1]);
        measures.put("lod_p95", lod[0]);
        measures.put("lod_max", lod[1]);
        measures.put("count_differs", apart.count_differs());
    }

    /// The searches and footprints against real rays.
    fn compare_hits(
        &mut self,
        settings: &Settings,
        results: &[HitResult],
        how: &Measuring,
        measures: &mut Measures,
    ) -> Result<(), InputError> {
        let Scene::Hit(subject) = &self.scene else {
            return Ok(());
        };
        let rays = self.rays.get_or_insert_with(|| RealRays::new(subject));
        rays.compare(subject, settings, results, how, measures);
        if how.wants("footprint_") {
            let known = match self.footprints.take() {
                Some(known) => known,
                None => {
                    footprints::figures(&subject.scene, &subject.map, &how.truth, how.exposure)?
                }
            };
            known.iter().for_each(|(name, db)| measures.put_db(name, *db));
            self.footprints = Some(known);
        }
        Ok(())
    }

    /// Tiles and cache of the last rendering; nothing where its registers are not kept.
    fn texel_use(&mut self, spec: &UnitSpec, how: &Measuring) -> Option<TexelUse> {
        let probes = match &self.kept {
            Kept::Env(kept) => kept.probes_key(),
            Kept::Hit(kept) => kept.probes_key(),
            Kept::Tex(kept) => kept.probes_key(),
        };
        let key = super::cost::texels::key(probes?, &spec.config);
        if let Some(known) = self.texels.get(&key).filter(|_| how.reuse) {
            return Some(*known);
        }
        let mut walk = Walk::new(self.scene.maps(spec), &how.cost.cache, &spec.config);
        match &self.kept {
            Kept::Env(kept) => kept.touched_corners(&mut |corner| walk.touch(0, corner)),
            Kept::Hit(kept) => kept.touched_corners(&mut |corner| walk.touch(0, corner)),
            Kept::Tex(kept) => kept.touched_corners(&mut |map, corner| walk.touch(map, corner)),
        }
        let found = walk.finish();
        self.texels.insert(key, found);
        Some(found)
    }
}
