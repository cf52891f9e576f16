//! The vector instructions that code runs under, chosen at run time.
//!
//! A [`Task`] is compiled once for each [`Level`]. What it calls must be `#[inline(always)]`, closures
//! included: a function that is only called from wide code is compiled for the target's own instructions.
#![no_std]
#![warn(missing_docs, unreachable_pub)]

#[cfg(feature = "std")]
extern crate std;

/// Proof that the machine has AVX2, BMI1, BMI2 and LZCNT.
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Avx2(());

/// Which instructions a task runs under.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// What the target guarantees.
    Baseline,
    /// AVX2 with BMI1, BMI2 and LZCNT.
    #[cfg(target_arch = "x86_64")]
    Avx2(Avx2),
}

/// Something to run; its `run` must be `#[inline(always)]`.
pub trait Task {
    /// Its results.
    type Output;

    /// Does it.
    fn run(self) -> Self::Output;
}

impl Level {
    /// Every level that this machine runs, the narrowest first.
    #[cfg(feature = "std")]
    #[must_use]
    pub fn available() -> std::vec::Vec<Self> {
        let mut levels = std::vec![Self::Baseline];
        #[cfg(target_arch = "x86_64")]
        if std::is_x86_feature_detected!("avx2")
            && std::is_x86_feature_detected!("bmi1")
            && std::is_x86_feature_detected!("bmi2")
            && std::is_x86_feature_detected!("lzcnt")
        {
            levels.push(Self::Avx2(Avx2(())));
        }
        levels
    }

    /// The widest level that this machine runs.
    #[cfg(feature = "std")]
    #[must_use]
    pub fn detect() -> Self {
        Self::available().pop().unwrap_or(Self::Baseline)
    }

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Baseline => "baseline",
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(_) => "AVX2",
        }
    }

    /// Runs a task under these instructions.
    pub fn run<T: Task>(self, task: T) -> T::Output {
        match self {
            Self::Baseline => run_baseline(task),
            #[cfg(target_arch = "x86_64")]
            // SAFETY: an `Avx2` exists only where its features were found.
            Self::Avx2(_) => unsafe { run_avx2(task) },
        }
    }
}

#[inline(never)]
fn run_baseline<T: Task>(task: T) -> T::Output {
    task.run()
}

#[cfg(target_arch = "x86_64")]
#[inline(never)]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt")]
fn run_avx2<T: Task>(task: T) -> T::Output {
    task.run()
}
