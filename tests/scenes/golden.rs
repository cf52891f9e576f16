//! The bits of scenes, environment and truth: the same on every machine, in debug and release.
#![expect(
    clippy::unwrap_used,
    reason = "a test stops at the first thing that is not as it should be"
)]

use std::fmt::Write as _;
use std::path::Path;

use tapline::cube::CubeMap;
use tapline::fragment::PixelFragment;
use tapline::policy::{Curvature, RoughnessInterpolation};
use tapline::scene::environment::procedural;
use tapline::scene::{SCENES, SceneOptions, build};
use tapline::settings::Settings;
use tapline::stage::Stage;
use tapline::truth::{TruthOptions, truth};

fn options(width: usize, height: usize) -> SceneOptions {
    SceneOptions { width, height, ..SceneOptions::default() }
}

/// FNV-1a over the bytes of 64-bit words, lowest first.
fn fnv(words: impl Iterator<Item = u64>) -> u64 {
    words.flat_map(u64::to_le_bytes).fold(0xCBF2_9CE4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01B3)
    })
}

/// The bits of every number of every fragment.
fn fingerprint(fragments: &[PixelFragment]) -> u64 {
    let mut words = Vec::new();
    for PixelFragment { pixel, fragment: f } in fragments {
        words.push((u64::from(pixel[0]) << 32) | u64::from(pixel[1]));
        let vectors = [f.v, f.n, f.dv_dx, f.dv_dy, f.dn_dx, f.dn_dy];
        words.extend(vectors.iter().flatten().map(|c| c.to_bits()));
        words.extend(f.h.iter().flatten().map(|c| c.to_bits()));
        words.extend(f.bump.iter().flatten().map(|c| c.to_bits()));
        words.extend(f.rough.iter().flatten().map(|c| c.to_bits()));
    }
    fnv(words.into_iter())
}

#[test]
fn fragments_have_the_golden_bits_for_any_number_of_threads() {
    let mut lines = String::new();
    for info in SCENES {
        let mut variants = vec![Settings::default()];
        if info.stages().contains(&Stage::Roughness) {
            variants.push(
                Settings::default()
                    .with(|p| p.roughness.interpolate = RoughnessInterpolation::Factors),
            );
            variants.push(Settings::default().with(|p| p.roughness.curvature = Curvature::Surface));
        }
        for settings in variants {
            let hashes = [1, 3].map(|threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                let scene = pool.install(|| build(info.name, &options(96, 64), &settings).unwrap());
                fingerprint(&scene.fragments)
            });
            assert_eq!(hashes[0], hashes[1], "{} depends on the threads", info.name);
            let interpolation = settings.policy.roughness.interpolate.name();
            let curvature = settings.policy.roughness.curvature.name();
            writeln!(lines, "{} {interpolation} {curvature} {:016x}", info.name, hashes[0])
                .unwrap();
        }
    }
    // The environment, and a small truth of it: all that other engines are compared with.
    let settings = Settings::default();
    let sphere = build("sphere", &options(24, 16), &settings).unwrap();
    let texture = CubeMap { levels: vec![procedural(32)] };
    let words = texture.levels[0].texels.iter().flatten().map(|c| u64::from(c.to_bits()));
    writeln!(lines, "environment 32 {:016x}", fnv(words)).unwrap();
    let picture = truth(&sphere, &texture, &settings, &TruthOptions::default(), &|_| {}).picture;
    let words = picture.rgb.iter().flatten().map(|c| c.to_bits());
    writeln!(lines, "truth sphere {:016x}", fnv(words)).unwrap();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/scene_fragments.txt");
    if std::env::var_os("TAPLINE_BLESS").is_some() {
        std::fs::write(&path, &lines).unwrap();
        panic!("wrote {}; run again without TAPLINE_BLESS", path.display());
    }
    let golden = std::fs::read_to_string(&path).unwrap_or_default();
    assert_eq!(
        lines, golden,
        "fragments changed; if that is meant, TAPLINE_BLESS=1 accepts them (and CHANGELOG names it)"
    );
}
