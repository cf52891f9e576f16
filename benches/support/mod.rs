//! Work for the benches: blocks of fragments with every stage's inputs at hand.

mod scalar;

use rayon::prelude::*;
use rtl_model::unit::{EnvBlock, Memory, Operation as _, Results, Words};
use rtl_model::{NoTap, NoTapStandard, Unit};
use tapline::engine::dispatch::{self, GROUP, LANES, Level, Task};
use tapline::engine::float::F64Engine;
use tapline::engine::rtl::RtlEngine;
use tapline::engine::{Engine as _, EnvJob, encode};
use tapline::image::mips::build_mips;
use tapline::scene::{self, SceneOptions};
use tapline::settings::Settings;
use tapline::unit::{ReferenceAxis, UnitSpec};

/// What can be timed.
pub(crate) const PARTS: &[&str] = &[
    "ports",
    "local_frame",
    "bump",
    "reflect",
    "cube_face",
    "normal",
    "jacobian",
    "roughness",
    "covariance",
    "eigen",
    "footprint",
    "front",
    "floor",
    "floor_1",
    "floor_4",
    "floor_16",
    "back",
    "back_1",
    "back_4",
    "back_16",
    "whole",
    "two_threads",
    "scalar_f32",
    "f64",
];

/// A scene's fragments, ready for each part.
pub(crate) struct Bench {
    engine: RtlEngine,
    subject: EnvJob,
    settings: Settings,
    words: Vec<Words>,
    blocks: Vec<EnvBlock<LANES>>,
    /// The same lines with another number of probes for all: `back_1`, `floor_16` and so on.
    recounted: Vec<(&'static str, Vec<EnvBlock<LANES>>)>,
    requests: Vec<scalar::Request>,
    scalar: scalar::Map,
}

impl Bench {
    /// Prepares a built-in scene at 256×256.
    pub(crate) fn new(name: &str) -> Self {
        let spec = UnitSpec::default();
        let settings = spec.settings(ReferenceAxis::Exact);
        let options = SceneOptions { width: 256, height: 256, ..SceneOptions::default() };
        let scene = scene::build(name, &options, &settings).expect("a built-in scene");
        let map = build_mips(scene.environment());
        let background = vec![[0.0; 3]; scene.width * scene.height];
        let needs = encode::needs(&scene.fragments[0].fragment);
        let engine = RtlEngine::new(&spec, needs, &map).expect("the default unit");
        let words: Vec<Words> =
            scene.fragments.iter().map(|f| encode::words(&f.fragment)).collect();
        let mut requests = Vec::new();
        let blocks: Vec<_> = words
            .chunks(LANES)
            .map(|chunk| {
                let (block, _) = engine.lanes(chunk, &mut NoTap);
                for lane in 0..chunk.len() {
                    requests.push(scalar::Request::new(&engine.unit.request(&block.env, lane)));
                }
                block
            })
            .collect();
        let scalar = scalar::Map::new(&map);
        let recounted = [("1", 1), ("4", 4), ("16", 16)]
            .map(|(name, count)| (name, recount(&blocks, count)))
            .into();
        Self {
            engine,
            subject: EnvJob { scene, map, background },
            settings,
            words,
            blocks,
            recounted,
            requests,
            scalar,
        }
    }

    /// Fragments of one run.
    pub(crate) fn fragments(&self) -> u64 {
        self.words.len() as u64
    }

    /// Probes of one run.
    pub(crate) fn probes(&self) -> u64 {
        self.requests.iter().map(|r| u64::from(r.count)).sum()
    }

    /// Runs a part over all fragments, on one thread but for `two_threads`.
    pub(crate) fn run(&mut self, part: &str) -> u64 {
        let level = Level::detect();
        match part {
            "whole" => threads(1, || self.engine.filter(&self.words, &|_| {}).probes),
            "two_threads" => threads(2, || self.engine.filter(&self.words, &|_| {}).probes),
            "scalar_f32" => {
                self.requests.iter().map(|r| u64::from(self.scalar.filter(r)[0].to_bits())).sum()
            }
            "f64" => threads(1, || {
                let engine = F64Engine { settings: self.settings.clone() };
                engine.render(&self.subject, &|_| {}).map_or(0, |r| r.probes)
            }),
            _ => {
                let (name, count) = match part.split_once('_') {
                    Some((name @ ("back" | "floor"), count)) => (name, Some(count)),
                    _ => (part, None),
                };
                let recounted = self.recounted.iter_mut();
                let blocks = match count {
                    None => &mut self.blocks,
                    Some(count) => {
                        let mut found = recounted.filter(|(name, _)| *name == count);
                        &mut found.next().expect("a count of PARTS").1
                    }
                };
                dispatch::run(
                    level,
                    Part {
                        name,
                        unit: &self.engine.unit,
                        memory: &self.engine.memory,
                        words: &self.words,
                        blocks,
                    },
                )
            }
        }
    }
}

/// The lines with `count` probes each, as long as before to a probe's rounding.
fn recount(blocks: &[EnvBlock<LANES>], count: i64) -> Vec<EnvBlock<LANES>> {
    let mut out = blocks.to_vec();
    for line in out.iter_mut().map(|block| &mut block.env.line) {
        for lane in 0..LANES {
            let before = std::mem::replace(&mut line.count[lane], count);
            for step in &mut line.step {
                step[lane] = step[lane] * before / count;
            }
        }
    }
    out
}

fn threads<R: Send>(n: usize, work: impl FnOnce() -> R + Send) -> R {
    // Pools are kept: making one costs more than a part.
    static POOLS: [std::sync::OnceLock<rayon::ThreadPool>; 2] =
        [const { std::sync::OnceLock::new() }; 2];
    POOLS[n - 1]
        .get_or_init(|| rayon::ThreadPoolBuilder::new().num_threads(n).build().expect("threads"))
        .install(work)
}

struct Part<'a> {
    name: &'a str,
    unit: &'a Unit,
    memory: &'a Memory,
    words: &'a [Words],
    blocks: &'a mut [EnvBlock<LANES>],
}

impl Task for Part<'_> {
    type Output = u64;

    #[inline(always)]
    fn run(self) -> u64 {
        let unit = self.unit;
        let mut tap = NoTapStandard;
        let mut sum = 0;
        if self.name == "ports" {
            for (words, block) in self.words.chunks(LANES).zip(self.blocks) {
                unit.load(words, block);
                unit.ports(&block.front, &mut block.env, &mut tap);
                sum += block.env.len as u64;
            }
            return sum;
        }
        if self.name == "front" {
            let groups = self.words.chunks(GROUP * LANES).zip(self.blocks.chunks_mut(GROUP));
            for (words, blocks) in groups {
                for (words, block) in words.chunks(LANES).zip(&mut *blocks) {
                    unit.load(words, block);
                }
                unit.steps(0, self.memory, blocks, &mut tap);
            }
            return sum;
        }
        let mut out = Results::<LANES>::default();
        let Some(texture) = &self.memory.texture else { return sum };
        for state in self.blocks.iter_mut().map(|block| &mut block.env) {
            match self.name {
                "local_frame" => unit.local_frame(state, &mut tap),
                "bump" => unit.bump(state, &mut tap),
                "reflect" => unit.reflect(state, &mut tap),
                "cube_face" => unit.cube_face(state, &mut tap),
                "normal" => unit.normal_derivative(state, &mut tap),
                "jacobian" => unit.jacobian(state, &mut tap),
                "roughness" => unit.roughness(state, &mut tap),
                "covariance" => unit.covariance(state, &mut tap),
                "eigen" => unit.eigen(state, &mut tap),
                "footprint" => unit.footprint(state, &mut tap),
                "floor" => sum = sum.wrapping_add(unit.touch(state, texture)),
                "back" => {
                    unit.back(state, Some(texture), &mut out, &mut tap);
                    sum = sum.wrapping_add(out.texels[0]);
                }
                other => panic!("no part `{other}`"),
            }
        }
        sum
    }
}

/// Whether a scene uses a part at all.
pub(crate) fn used(scene: &str, part: &str) -> bool {
    scene != "sphere" || !["local_frame", "bump", "roughness"].contains(&part)
}

/// Keeps rayon's traits in scope for the pools above.
pub(crate) fn cores() -> usize {
    (0..1).into_par_iter().count().max(rayon::current_num_threads())
}
