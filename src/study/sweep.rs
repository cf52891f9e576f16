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
use crate::engine::{EngineKind, Job, Rendering, Setup};
use crate::error::InputError;
use crate::operation::Operation;
use crate::picture::Picture;
use crate::policy::{FootprintPolicy, Policy};
use crate::report::metrics;
use crate::settings::Settings;
use crate::truth::TruthOptions;
use crate::unit::UnitSpec;

use super::cost::CostModel;
use super::cost::texels::{Maps, TexelUse, Walk};
use super::measures::Measures;
use super::searches::RealRays;
use super::{cones, edges, footprints};

/// The results that a sweep keeps from earlier units; those of operations other than the job's stay empty.
#[derive(Debug, Default)]
struct Kept {
    env: KeptEnv,
    hit: KeptHit,
    tex: KeptTex,
}

/// What units are compared with, and how costs are counted.
#[derive(Clone, Debug)]
pub struct Measuring {
    /// References, f64 first.
    pub against: Vec<EngineKind>,
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
    kind: EngineKind,
    settings: Settings,
    picture: Picture,
    lines: Vec<Line>,
}

/// Most references that are kept.
const MOST_REFERENCES: usize = 24;

/// A job with everything that is kept from unit to unit.
#[derive(Debug)]
pub struct Sweep {
    job: Job,
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

/// A sweep's results for a unit.
#[derive(Debug)]
pub struct Found {
    /// Figures.
    pub measures: Measures,
    /// The unit's picture.
    pub picture: Picture,
    /// The parts that were not run again.
    pub saved: Saved,
}

impl Sweep {
    /// A sweep over a job.
    #[must_use]
    pub fn new(job: Job) -> Self {
        Self {
            job,
            kept: Kept::default(),
            references: Vec::new(),
            rays: None,
            footprints: None,
            texels: BTreeMap::new(),
            rtl_seconds: 0.0,
            saved: [0; 2],
        }
    }

    /// The job.
    #[must_use]
    pub fn job(&self) -> &Job {
        &self.job
    }

    /// Renders by the integer model.
    ///
    /// # Errors
    /// The unit is refused.
    pub fn render(
        &mut self,
        spec: &UnitSpec,
        reuse: bool,
    ) -> Result<(Rendering, Vec<HitResult>, Saved), InputError> {
        if !reuse {
            self.kept = Kept::default();
        }
        let none = |(rendering, saved)| (rendering, Vec::new(), saved);
        let out = match &self.job {
            Job::Env(job) => none(self.kept.env.render(spec, job)?),
            Job::Hit(job) => self.kept.hit.render(spec, job)?,
            Job::Tex(job) => none(self.kept.tex.render(spec, job)?),
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
        let (rendering, results, saved) = self.render(spec, how.reuse)?;
        let mut measures = Measures::default();
        if !how.reuse {
            self.references.clear();
        }
        for kind in &how.against {
            let index = self.reference(*kind, settings, &how.truth)?;
            let reference = &self.references[index];
            let pair = metrics::compare(&rendering.picture, &reference.picture, how.exposure)?;
            measures.put_pair(*kind, &pair);
        }
        self.compare_lines(settings, how, &mut measures)?;
        self.compare_hits(settings, &results, how, &mut measures)?;
        if let Job::Env(job) = &self.job {
            if how.wants("minor_error_") || how.wants("thin_line_end_") {
                edges::thin(spec, &mut measures)?;
            }
            if how.wants("jump_") {
                edges::jumps(spec, settings, &job.map, &mut measures)?;
            }
        }
        if let (Job::Tex(job), true) =
            (&self.job, how.wants("cone_lod") || how.wants("texture_requests"))
        {
            for (name, value) in cones::figures(job, spec, settings) {
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
        measures.put("requests", self.job.fragments() as f64);
        let fragments = self.job.fragments().max(1) as f64;
        measures.put("flagged_share", rendering.flags.values().sum::<u64>() as f64 / fragments);
        let probes = rendering.probes as f64 / fragments;
        measures.put("probes_per_fragment", probes);
        measures.put("texels_per_fragment", rendering.texels as f64 / fragments);
        if let Some(texels) = self.texel_use(spec, how) {
            measures.put("tiles", texels.tiles as f64);
            measures.put("cache_hit_share", texels.hit_share());
        }
        let look_ups = rendering.searches.as_ref().map_or(0.0, crate::engine::Searches::look_ups);
        how.cost.sheet(&spec.config, self.job.operation()).put(
            &how.cost,
            [probes, look_ups],
            &mut measures,
        );
        Ok(Found { measures, picture: rendering.picture, saved })
    }

    /// The picture of a reference.
    ///
    /// # Errors
    /// An engine that cannot be a reference here.
    pub fn reference_picture(
        &mut self,
        kind: EngineKind,
        settings: &Settings,
        truth: &TruthOptions,
    ) -> Result<&Picture, InputError> {
        let index = self.reference(kind, settings, truth)?;
        Ok(&self.references[index].picture)
    }

    /// The probe lines of the float reference.
    ///
    /// # Errors
    /// Those of [`Sweep::reference_picture`].
    pub fn reference_lines(
        &mut self,
        settings: &Settings,
        truth: &TruthOptions,
    ) -> Result<&[Line], InputError> {
        let index = self.reference(EngineKind::F64, settings, truth)?;
        Ok(&self.references[index].lines)
    }

    /// The probe lines of the unit that rendered last, one a fragment, ray or texture request.
    pub fn lines(&self, each: &mut dyn FnMut(RtlLine)) {
        self.kept.env.lines(each);
        self.kept.hit.lines(each);
        self.kept.tex.lines(each);
    }

    /// The place of a reference among those that are kept.
    fn reference(
        &mut self,
        kind: EngineKind,
        settings: &Settings,
        truth: &TruthOptions,
    ) -> Result<usize, InputError> {
        let counts = settings_that_count(self.job.operation(), kind, settings);
        let known = self.references.iter().position(|r| r.kind == kind && r.settings == counts);
        if let Some(index) = known {
            return Ok(index);
        }
        let (rendering, lines) = match kind {
            EngineKind::F64 => self.job.lines(settings),
            EngineKind::Rtl
            | EngineKind::Gpu
            | EngineKind::Sampler
            | EngineKind::Ewa
            | EngineKind::Truth => {
                let spec = &UnitSpec::default();
                let setup = Setup { spec, settings, truth: *truth, gpu: None };
                (self.job.render(kind, &setup, &|_| {})?, Vec::new())
            }
        };
        if self.references.len() >= MOST_REFERENCES {
            // Truth costs most and is never dropped.
            let oldest = self.references.iter().position(|r| r.kind != EngineKind::Truth);
            self.references.remove(oldest.unwrap_or(0));
        }
        self.references.push(Reference {
            kind,
            settings: counts,
            picture: rendering.picture,
            lines,
        });
        Ok(self.references.len() - 1)
    }

    /// The integer model's probe lines against the reference's.
    fn compare_lines(
        &mut self,
        settings: &Settings,
        how: &Measuring,
        measures: &mut Measures,
    ) -> Result<(), InputError> {
        let index = self.reference(EngineKind::F64, settings, &how.truth)?;
        let reference = &self.references[index];
        let mut apart = Apart::default();
        let mut widths = Vec::new();
        let mut theirs = reference.lines.iter();
        self.lines(&mut |line| {
            let Some(float) = theirs.next() else { return };
            apart.add(line, float);
            if let (Some(here), Some(there)) = (line.width, float.width) {
                let there = there.abs();
                widths.push((here.abs() - there).abs() / there.max(f64::MIN_POSITIVE));
            }
        });
        widths.sort_by(f64::total_cmp);
        if apart.is_empty() {
            // Of very large pictures no registers are kept.
            return Ok(());
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
        Ok(())
    }

    /// The searches and footprints against real rays.
    fn compare_hits(
        &mut self,
        settings: &Settings,
        results: &[HitResult],
        how: &Measuring,
        measures: &mut Measures,
    ) -> Result<(), InputError> {
        let Job::Hit(job) = &self.job else {
            return Ok(());
        };
        let rays = self.rays.get_or_insert_with(|| RealRays::new(job));
        rays.compare(job, settings, results, how, measures);
        if how.wants("footprint_") {
            let known = match self.footprints.take() {
                Some(known) => known,
                None => footprints::figures(&job.scene, &job.map, &how.truth, how.exposure)?,
            };
            known.iter().for_each(|(name, db)| measures.put_db(name, *db));
            self.footprints = Some(known);
        }
        Ok(())
    }

    /// Tiles and cache of the last rendering; nothing where its registers are not kept.
    fn texel_use(&mut self, spec: &UnitSpec, how: &Measuring) -> Option<TexelUse> {
        let Kept { env, hit, tex } = &self.kept;
        let probes = env.probes_key().or(hit.probes_key()).or(tex.probes_key())?;
        let key = super::cost::texels::key(probes, &spec.config);
        if let Some(known) = self.texels.get(&key).filter(|_| how.reuse) {
            return Some(*known);
        }
        let mut walk = Walk::new(maps(&self.job, spec), &how.cost.cache, &spec.config);
        env.touched_corners(&mut |corner| walk.touch(0, corner));
        hit.touched_corners(&mut |corner| walk.touch(0, corner));
        tex.touched_corners(&mut |map, corner| walk.touch(map, corner));
        let found = walk.finish();
        self.texels.insert(key, found);
        Some(found)
    }
}

/// The part of a float engine's settings that a picture of an operation depends on.
fn settings_that_count(operation: Operation, kind: EngineKind, settings: &Settings) -> Settings {
    let plain = Settings::default();
    let mut s = settings.clone();
    let Policy { cone, surface_footprint, address, hit, .. } = plain.policy;
    match operation {
        Operation::Env(_) => {
            s.policy = Policy { cone, surface_footprint, address, hit, ..s.policy };
        }
        Operation::Hit | Operation::Tex => {
            s.roughness_scale = plain.roughness_scale;
            s.policy.jacobian = plain.policy.jacobian;
        }
    }
    let (mine, none) = (&mut s.policy, &plain.policy);
    if kind != EngineKind::F64 {
        // Neither takes probes.
        mine.footprint =
            FootprintPolicy { max_probes: mine.footprint.max_probes, ..none.footprint };
        s.reference_table = None;
    }
    if kind == EngineKind::Ewa && matches!(operation, Operation::Env(_)) {
        // The Gaussian follows from K alone.
        (mine.footprint, mine.eigen) = (none.footprint, none.eigen);
    }
    if kind == EngineKind::Truth {
        // Rays see the environment's rotation and how textures repeat.
        let policy = Policy { address: s.policy.address, ..plain.policy };
        s = Settings { policy, rotation: s.rotation, ..plain };
    }
    s
}

/// The maps that a job's requests touch.
fn maps(job: &Job, spec: &UnitSpec) -> Maps {
    if job.textures().is_empty() {
        return Maps::cube(job.map());
    }
    Maps::planar(job.textures(), spec.config.policy.address.wrap(), job.map())
}
