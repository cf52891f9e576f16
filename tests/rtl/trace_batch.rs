//! A trace and a batch are one code path: the same registers bit for bit, however many lanes,
//! threads or vector instructions.

use std::collections::BTreeMap;

use rtl_model::fx::flags::FlagCounts;
use rtl_model::regs::Reg;
use rtl_model::unit::{EnvBlock, Memory, Operation as _, Results, Words};
use rtl_model::{NoTap, Tap, Unit};
use support::reference::Random;
use tapline::engine::dispatch::{LANES, Level, Source};
use tapline::engine::encode::words;
use tapline::engine::probe::{RtlProbe, rtl};
use tapline::fragment::Fragment;
use tapline::scene::SCENES;
use tapline::unit::UnitSpec;

/// A fragment's writes: (register, component) to (raw, frac).
type Writes = BTreeMap<(Reg, usize), (i64, i64)>;

/// Every write of every lane.
struct Lanes(Vec<Writes>);

impl Tap for Lanes {
    fn put(&mut self, lane: usize, reg: Reg, component: usize, raw: i64, frac: i64) {
        self.0[lane].insert((reg, component), (raw, frac));
    }
}

/// The registers and the results of up to N fragments in one block.
fn batch<const N: usize>(
    unit: &Unit,
    memory: &Memory,
    fragments: &[Fragment],
) -> (Lanes, Results<N>) {
    let mut lanes = Lanes(vec![BTreeMap::new(); N]);
    let (mut block, mut out) = (EnvBlock::<N>::default(), Results::default());
    let words: Vec<Words> = fragments.iter().map(words).collect();
    unit.load(&words, &mut block);
    unit.run(memory, &mut block, &mut out, &mut lanes);
    (lanes, out)
}

/// Indices of 100 fragments at random.
fn sample(fragments: usize, random: &mut Random) -> Vec<usize> {
    (0..100)
        .map(|_| {
            usize::try_from(random.word() % u64::try_from(fragments).unwrap_or(1)).unwrap_or(0)
        })
        .collect()
}

fn traced(unit: &Unit, memory: &Memory, fragment: &Fragment) -> (Writes, Results<1>) {
    let (mut lanes, out) = batch::<1>(unit, memory, std::slice::from_ref(fragment));
    (lanes.0.remove(0), out)
}

fn same_for_n<const N: usize>(unit: &Unit, memory: &Memory, fragments: &[Fragment], name: &str) {
    // Chunks of N, the last one shorter: unused lanes must not matter.
    for chunk in fragments.chunks(N) {
        let (lanes, out) = batch::<N>(unit, memory, chunk);
        for (lane, fragment) in chunk.iter().enumerate() {
            let (alone, result) = traced(unit, memory, fragment);
            assert!(alone.len() > 40, "a trace of {} registers", alone.len());
            assert_eq!(alone, lanes.0[lane], "{name}, {N} lanes, {fragment:?}");
            assert_eq!(result.color[0], out.color[lane]);
            assert_eq!(result.probes[0], out.probes[lane]);
            assert_eq!(result.texels[0], out.texels[lane]);
            assert_eq!(result.flags[0], out.flags[lane]);
        }
    }
}

#[test]
fn a_hundred_pixels_of_every_scene_have_the_same_registers_traced_and_batched() {
    let spec = UnitSpec::default();
    let mut random = Random::new(1);
    for info in SCENES {
        let subject = support::rtl::subject(info.name, 64, &spec);
        let engine = support::rtl::engine(&spec, &subject);
        let (unit, memory) = (&engine.unit, &engine.memory);
        let all = &subject.scene.fragments;
        let fragments: Vec<Fragment> =
            sample(all.len(), &mut random).into_iter().map(|i| all[i].fragment).collect();
        same_for_n::<8>(unit, memory, &fragments, info.name);
        same_for_n::<32>(unit, memory, &fragments, info.name);
        // What `trace` prints is the same code with the engine's own tap.
        let mut probe = RtlProbe::default();
        for fragment in &fragments {
            let shown = rtl(unit, &engine.config, fragment, memory.texture.as_ref(), &mut probe);
            let (registers, result) = traced(unit, memory, fragment);
            assert_eq!(shown.color, result.color[0]);
            for ((reg, component), (raw, frac)) in registers {
                let code = probe.get(reg)[component];
                assert_eq!((code.raw, code.frac), (raw, frac), "{reg:?}[{component}]");
            }
        }
    }
}

#[test]
fn every_vector_level_gives_the_traced_colours_counts_and_flags() {
    let spec = UnitSpec::default();
    let mut random = Random::new(2);
    let levels = Level::available();
    eprintln!("levels: {levels:?}");
    for info in SCENES {
        let subject = support::rtl::subject(info.name, 64, &spec);
        let mut engine = support::rtl::engine(&spec, &subject);
        let all = &subject.scene.fragments;
        let fragments: Vec<Fragment> =
            sample(all.len(), &mut random).into_iter().map(|i| all[i].fragment).collect();
        let words: Vec<Words> = fragments.iter().map(words).collect();
        for level in &levels {
            for (chunk, words) in fragments.chunks(LANES).zip(words.chunks(LANES)) {
                let mut out = Results::<LANES>::default();
                engine.level = *level;
                engine.blocks(Source::Words(words), &mut |_, results| out = results.clone());
                for (lane, fragment) in chunk.iter().enumerate() {
                    let (_, alone) = traced(&engine.unit, &engine.memory, fragment);
                    let here =
                        (out.color[lane], out.probes[lane], out.texels[lane], out.flags[lane]);
                    let there = (alone.color[0], alone.probes[0], alone.texels[0], alone.flags[0]);
                    assert_eq!(here, there, "{} at {level:?}: {fragment:?}", info.name);
                }
            }
        }
    }
}

#[test]
fn the_engine_gives_the_traced_colours_for_one_two_and_three_threads() {
    let spec = UnitSpec::default();
    for info in SCENES {
        // More fragments than one task of the pool takes, so that threads do share the work.
        let subject = support::rtl::subject(info.name, 64, &spec);
        let engine = support::rtl::engine(&spec, &subject);
        let all = &subject.scene.fragments;
        assert!(all.len() > 2 * 16 * LANES, "{}: {} fragments", info.name, all.len());
        let words: Vec<Words> = all.iter().map(|f| words(&f.fragment)).collect();
        let mut colors = Vec::new();
        let (mut probes, mut texels, mut flags) = (0, 0, FlagCounts::default());
        for words in &words {
            let (_, out) = engine.lanes::<1, _>(std::slice::from_ref(words), &mut NoTap);
            colors.push(out.color[0]);
            probes += out.probes[0].unsigned_abs();
            texels += out.texels[0];
            flags.add(out.flags[0]);
        }
        assert!(colors.iter().flatten().any(|c| *c > 0), "all black");
        for threads in 1..=3 {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .expect("a pool of threads");
            let filtered = pool.install(|| engine.filter(&words, &|_| {}));
            assert_eq!(filtered.colors, colors, "{} with {threads} threads", info.name);
            assert_eq!((filtered.probes, filtered.texels), (probes, texels));
            assert_eq!(filtered.flags, flags);
        }
    }
}
