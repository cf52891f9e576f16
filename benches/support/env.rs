//! ENV: every step, the filter, the whole engine, the floor and the float reference over a scene's fragments.

use std::hint::black_box;
use std::time::Instant;

use rtl_model::NoTapStandard;
use rtl_model::unit::{Block, EnvBlock, Finish, Operation as _, Results, Words};
use tapline::engine::dispatch::{GROUP, LANES, Level, Runs as _};
use tapline::engine::float::F64Engine;
use tapline::engine::rtl::RtlEngine;
use tapline::engine::{Engine as _, EnvJob, encode};
use tapline::mips::build_mips;
use tapline::scene::{self, SceneOptions};
use tapline::unit::{ReferenceAxis, UnitSpec};

use super::floor::{Floor, Request};
use super::{Lowest, Table, threads, time, two_cores};

/// The steps of ENV in their order.
const STEPS: [&str; 11] = [
    "ports",
    "local_frame",
    "bump",
    "reflect",
    "cube_face",
    "jacobian: ∂n_mod",
    "jacobian",
    "roughness",
    "covariance",
    "eigen",
    "footprint",
];
/// Probes of the rows that tell the cost of a probe from that of a fragment.
const COUNTS: [i64; 2] = [1, 16];

/// Fragments of the whole engines' pieces: as many as one task takes.
const PIECE: usize = 32 * LANES;

/// A scene and its engines.
pub(crate) struct Env {
    title: String,
    engine: RtlEngine,
    job: EnvJob,
    float: F64Engine,
    words: Vec<Words>,
    /// Requests as they are, and with each of `COUNTS` on a line of the same length.
    requests: [Vec<Request>; 3],
}

/// Lowest seconds of a level's parts, piece by piece: of pieces of some microseconds, a busy machine leaves some alone.
#[derive(Clone, Default)]
struct Times {
    load: Lowest,
    steps: [Lowest; 11],
    front: Lowest,
    back: [Lowest; 3],
    floor: [Lowest; 3],
    whole: Lowest,
}

impl Env {
    /// Prepares a built-in scene.
    pub(crate) fn new(name: &str, size: usize) -> Self {
        let spec = UnitSpec::default();
        let settings = spec.settings(ReferenceAxis::Exact);
        let options = SceneOptions { width: size, height: size, ..SceneOptions::default() };
        let scene = scene::build(name, &options, &settings).expect("a built-in scene");
        let map = build_mips(scene.environment());
        let job = EnvJob::new(scene, map, &settings);
        let engine = RtlEngine::new(&spec, job.needs(), &job.map).expect("the default unit");
        let words: Vec<Words> =
            job.scene.fragments.iter().map(|f| encode::words(&f.fragment)).collect();
        let mut out = Self {
            title: format!("{name} {size}×{size}"),
            engine,
            job,
            float: F64Engine { settings },
            words,
            requests: [const { Vec::new() }; 3],
        };
        let mut requests = [const { Vec::new() }; 3];
        out.each_group(Level::detect(), |env, blocks, _| {
            for (requests, count) in requests.iter_mut().zip([None, Some(1), Some(16)]) {
                for block in &mut *blocks {
                    recount(block, count);
                    let all = (0..block.env.len).map(|i| env.engine.unit.request(&block.env, i));
                    requests.extend(all.map(|r| Request::new(&r)));
                }
            }
        });
        out.requests = requests;
        out
    }

    /// Fragments of one run.
    pub(crate) fn fragments(&self) -> usize {
        self.words.len()
    }

    /// The whole engine on one thread; its probes.
    pub(crate) fn whole(&self) -> u64 {
        self.engine.filter(&self.words, &|_| {}).probes
    }

    /// Groups of blocks behind all steps, each with its number.
    fn each_group(&self, level: Level, mut each: impl FnMut(&Self, &mut [EnvBlock<LANES>], f64)) {
        let mut group = vec![Block::default(); GROUP];
        for words in self.words.chunks(GROUP * LANES) {
            let start = Instant::now();
            let used = self.load(words, &mut group);
            let (unit, memory) = (&self.engine.unit, &self.engine.memory);
            unit.steps(level, 0..STEPS.len(), memory, &mut group[..used], &mut NoTapStandard);
            let seconds = start.elapsed().as_secs_f64();
            each(self, &mut group[..used], seconds);
        }
    }

    fn load(&self, words: &[Words], group: &mut [EnvBlock<LANES>]) -> usize {
        for (words, block) in words.chunks(LANES).zip(group) {
            self.engine.unit.load(words, block);
        }
        words.len().div_ceil(LANES)
    }

    /// One pass with a clock around every step; a second one around the front end alone.
    fn pass(&self, level: Level, lowest: &mut Times) {
        let (unit, memory) = (&self.engine.unit, &self.engine.memory);
        let mut group = vec![Block::default(); GROUP];
        let mut out = Results::default();
        let tap = &mut NoTapStandard;
        // What the clock itself takes.
        let mut clock = f64::INFINITY;
        for _ in 0..1000 {
            time(&mut clock, || ());
        }
        let since = |start: Instant| start.elapsed().as_secs_f64() - clock;
        for (piece, words) in self.words.chunks(GROUP * LANES).enumerate() {
            let start = Instant::now();
            let used = self.load(words, &mut group);
            lowest.load.note(piece, since(start));
            let group = &mut group[..used];
            for (k, lowest) in lowest.steps.iter_mut().enumerate() {
                let start = Instant::now();
                unit.steps(level, k..k + 1, memory, group, tap);
                lowest.note(piece, since(start));
            }
            let counts = [None, Some(COUNTS[0]), Some(COUNTS[1])];
            for (lowest, count) in lowest.back.iter_mut().zip(counts) {
                group.iter_mut().for_each(|block| recount(block, count));
                let start = Instant::now();
                for block in &*group {
                    level.run(Finish { unit, block, memory, out: &mut out, tap: &mut *tap });
                }
                lowest.note(piece, since(start));
                black_box(&out);
            }
        }
        let mut piece = 0;
        self.each_group(level, |_, blocks, seconds| {
            black_box(blocks);
            lowest.front.note(piece, seconds - clock);
            piece += 1;
        });
        let texture = memory.texture.as_ref().expect("an environment");
        for (lowest, requests) in lowest.floor.iter_mut().zip(&self.requests) {
            for (piece, requests) in requests.chunks(GROUP * LANES).enumerate() {
                let start = Instant::now();
                black_box(level.run(Floor { texture, requests }));
                lowest.note(piece, since(start));
            }
        }
    }

    /// Measures everything and prints it.
    pub(crate) fn measure(mut self, rounds: usize, table: &mut Table) {
        let levels: Vec<Level> = Level::available().into_iter().rev().collect();
        let mut times = vec![Times::default(); levels.len()];
        let (mut float, mut two) = (Lowest::default(), f64::INFINITY);
        let fragments = std::mem::take(&mut self.job.scene.fragments);
        for _ in 0..rounds {
            for (level, times) in levels.iter().zip(&mut times) {
                self.pass(*level, times);
                self.engine.level = *level;
                for (piece, words) in self.words.chunks(PIECE).enumerate() {
                    let start = Instant::now();
                    threads(1, || black_box(self.engine.filter(words, &|_| {})));
                    times.whole.note(piece, start.elapsed().as_secs_f64());
                }
            }
            self.engine.level = levels[0];
            if two_cores() {
                time(&mut two, || threads(2, || black_box(self.whole())));
            }
            for (piece, fragments) in fragments.chunks(PIECE).enumerate() {
                self.job.scene.fragments = fragments.to_vec();
                let seconds = threads(1, || self.float.render(&self.job, &|_| {}));
                float.note(piece, seconds.map_or(f64::INFINITY, |r| r.seconds));
            }
        }
        self.print(&levels, &times, float.seconds(), two, table);
    }

    fn print(&self, levels: &[Level], times: &[Times], float: f64, two: f64, table: &mut Table) {
        let each = 1e9 / self.fragments() as f64;
        let probes: f64 = self.requests[0].iter().map(|r| r.count as f64).sum();
        let title = format!(
            "{}, ns a fragment: {} fragments with {:.2} probes",
            self.title,
            self.fragments(),
            probes / self.fragments() as f64
        );
        let names: Vec<&str> = levels.iter().map(|level| level.name()).collect();
        table.head(&title, &names);
        let mut row = |name: &str, of: &dyn Fn(&Times) -> f64| {
            let numbers: Vec<f64> = times.iter().map(|t| each * of(t)).collect();
            if numbers.iter().any(|x| *x > 0.5) {
                table.row(name, &numbers, 1);
            }
        };
        row("load", &|t| t.load.seconds());
        for (k, name) in STEPS.iter().enumerate() {
            row(name, &|t| t.steps[k].seconds());
        }
        let stages =
            |t: &Times| t.load.seconds() + t.steps.iter().map(Lowest::seconds).sum::<f64>();
        // Seconds with one probe and with sixteen give the costs of a fragment and of a probe.
        let slope = |t: &[Lowest; 3]| (t[2].seconds() - t[1].seconds()) / 15.0;
        row("sum of stages", &stages);
        row("front", &|t| t.front.seconds());
        row("back", &|t| t.back[0].seconds());
        row("back, a fragment (F)", &|t| t.back[1].seconds() - slope(&t.back));
        row("back, a probe (P)", &|t| slope(&t.back));
        row("floor", &|t| t.floor[0].seconds());
        row("floor, a fragment", &|t| t.floor[1].seconds() - slope(&t.floor));
        row("floor, a probe", &|t| slope(&t.floor));
        row("whole", &|t| t.whole.seconds());
        row("f64", &|_| float);
        let mut ratio = |name: &str, of: &dyn Fn(&Times) -> f64| {
            table.row(name, &times.iter().map(of).collect::<Vec<_>>(), 2);
        };
        ratio("**f64 / whole**", &|t| float / t.whole.seconds());
        ratio("**front / floor**", &|t| t.front.seconds() / t.floor[0].seconds());
        ratio("**back / floor**", &|t| t.back[0].seconds() / t.floor[0].seconds());
        let best = &times[0];
        ratio("**front / widest front**", &|t| t.front.seconds() / best.front.seconds());
        ratio("**back / widest back**", &|t| t.back[0].seconds() / best.back[0].seconds());
        if two.is_finite() {
            println!(
                "| **one / two threads** | {:.2} |{}",
                best.whole.seconds() / two,
                " |".repeat(times.len() - 1)
            );
        }
        for (name, t) in names.iter().zip(times) {
            let (what, front) = (format!("{}, {name}", self.title), t.front.seconds());
            let (back, whole) = (t.back[0].seconds(), t.whole.seconds());
            table.at_most(&format!("{what}: front / sum of stages"), front, 1.15, stages(t));
            table.at_most(&format!("{what}: whole / (front + back)"), whole, 1.1, front + back);
        }
    }
}

/// Gives the lines of a block `count` probes each, as long as before to a probe's rounding.
fn recount(block: &mut EnvBlock<LANES>, count: Option<i64>) {
    let Some(count) = count else { return };
    let line = &mut block.env.line;
    for lane in 0..LANES {
        let before = std::mem::replace(&mut line.count[lane], count);
        for step in &mut line.step {
            step[lane] = step[lane] * before / count;
        }
    }
}
