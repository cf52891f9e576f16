//! What the tests on a GPU share: the device, maps, judgement.

use tapline::base::num;
use tapline::base::random::Random;
pub(crate) use tapline::conformance::extremes::PLAIN;
use tapline::cube::{CubeLevel, CubeMap};
use tapline::engine::gpu::check::StageChecks;
use tapline::fragment::{Fragment, PixelFragment};
use tapline::mips::build_mips;

/// Fragments with pixels by their index.
pub(crate) fn numbered(fragments: &[Fragment]) -> Vec<PixelFragment> {
    (0u32..)
        .zip(fragments)
        .map(|(i, fragment)| PixelFragment { pixel: [i, 0], fragment: *fragment })
        .collect()
}

/// A number between 0 and 1 that belongs to an index.
pub(crate) fn noise(index: usize) -> f32 {
    let word = Random::new(num::u64(index)).word();
    f32::from(u16::try_from(word >> 48).unwrap_or(0)) / 65536.0
}

/// A cube map of noise with its mips.
pub(crate) fn noisy_cube(size: usize) -> CubeMap {
    let texels = (0..6 * size * size).map(|i| [0, 1, 2].map(|c| noise(3 * i + c))).collect();
    build_mips(CubeLevel { size, texels })
}

/// Every register is explained, and at least `least` components had a tolerance and met it.
pub(crate) fn assert_explained(checks: &StageChecks, least: u64) {
    assert!(checks.first.is_none(), "unexplained: {:?}", checks.first);
    let sure = |r: &tapline::engine::stage_checks::Row| r.compared - r.undecided - r.unbounded;
    let compared: u64 = checks.rows.iter().map(sure).sum();
    assert!(compared >= least, "only {compared} components were compared");
}

/// Components of a register that were compared within a finite tolerance.
pub(crate) fn compared(checks: &StageChecks, stage: &str, register: &str) -> u64 {
    let mut rows = checks.rows.iter();
    let row = rows.find(|r| r.stage.name() == stage && r.register == register);
    row.map_or(0, |r| r.compared - r.undecided - r.unbounded)
}
