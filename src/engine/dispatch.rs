//! Runs the integer model's block under the widest vector instructions of the machine.
//!
//! The stages are always inlined, so that this one function is compiled once for each set of
//! instructions. All of it is integer arithmetic: the bits are the same.

use rtl_model::unit::{Ports, Results, Words};
use rtl_model::{NoTap, Texture, Unit};

/// Fragments in a block.
pub const LANES: usize = 32;

/// Which instructions blocks run under.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// What the target guarantees.
    Baseline,
    /// AVX2 with BMI2 and LZCNT.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// AVX-512 F, DQ, BW, VL.
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Level {
    /// The widest level that this machine runs.
    #[must_use]
    pub fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        {
            let avx2 = is_x86_feature_detected!("avx2")
                && is_x86_feature_detected!("bmi1")
                && is_x86_feature_detected!("bmi2")
                && is_x86_feature_detected!("lzcnt");
            let avx512 = is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512dq")
                && is_x86_feature_detected!("avx512bw")
                && is_x86_feature_detected!("avx512vl");
            if avx2 && avx512 {
                return Self::Avx512;
            }
            if avx2 {
                return Self::Avx2;
            }
        }
        Self::Baseline
    }

    /// Every level that this machine runs, the narrowest first.
    #[must_use]
    pub fn available() -> Vec<Self> {
        #[cfg(target_arch = "x86_64")]
        match Self::detect() {
            Self::Avx512 => return vec![Self::Baseline, Self::Avx2, Self::Avx512],
            Self::Avx2 => return vec![Self::Baseline, Self::Avx2],
            Self::Baseline => {}
        }
        vec![Self::Baseline]
    }
}

/// A block of at most [`LANES`] fragments through the whole unit.
pub fn block(
    level: Level,
    unit: &Unit,
    words: &[Words],
    texture: Option<&Texture>,
    out: &mut Results<LANES>,
) {
    #[cfg(target_arch = "x86_64")]
    match level {
        // SAFETY: these levels come from `detect` or `available`, which found the features named in the
        // functions' `target_feature` attributes on this machine.
        Level::Avx512 => return unsafe { block_avx512(unit, words, texture, out) },
        // SAFETY: as above.
        Level::Avx2 => return unsafe { block_avx2(unit, words, texture, out) },
        Level::Baseline => {}
    }
    let _ = level;
    block_here(unit, words, texture, out);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512bw,avx512vl,avx2,bmi1,bmi2,lzcnt")]
fn block_avx512(unit: &Unit, words: &[Words], texture: Option<&Texture>, out: &mut Results<LANES>) {
    block_here(unit, words, texture, out);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt")]
fn block_avx2(unit: &Unit, words: &[Words], texture: Option<&Texture>, out: &mut Results<LANES>) {
    block_here(unit, words, texture, out);
}

#[inline(always)]
fn block_here(unit: &Unit, words: &[Words], texture: Option<&Texture>, out: &mut Results<LANES>) {
    let mut ports = Ports::<LANES>::default();
    for words in words.iter().take(LANES) {
        unit.load(&mut ports, words, &mut NoTap);
    }
    unit.env(&ports, texture, out, &mut NoTap);
}
