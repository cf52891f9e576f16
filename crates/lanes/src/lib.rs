//! Vectors of signed 64-bit integers, and the vector instructions of the machine, chosen at run time.
//!
//! A [`Task`] is compiled once for each [`Level`] and gets a [`Simd`]: the proof that the machine has the
//! level's instructions, from which all [`Vector`]s are made. What a task calls must be
//! `#[inline(always)]`: a function that is only called from wide code, closures included, is compiled
//! for the target's own instructions.
#![no_std]
#![warn(missing_docs, unreachable_pub)]

#[cfg(feature = "std")]
extern crate std;

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod scalar;

use core::fmt::Debug;
use core::ops::{Add, BitAnd, BitOr, BitXor, Neg, Not, Sub};

#[cfg(target_arch = "x86_64")]
pub use avx2::Avx2;
#[cfg(target_arch = "x86_64")]
pub use avx512::Avx512;
pub use scalar::Scalar;

/// One bit a lane: the result of a comparison.
pub trait Mask<V>:
    Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self>
{
    /// `yes` where the bit is set, `no` elsewhere.
    fn select(self, yes: V, no: V) -> V;
}

/// Signed 64-bit integers, one a lane. Sums and shifts of one lane are checked as plain integers are.
pub trait Vector:
    Copy
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Neg<Output = Self>
    + BitAnd<Output = Self>
    + BitOr<Output = Self>
    + BitXor<Output = Self>
    + Not<Output = Self>
{
    /// What comparisons give.
    type Mask: Mask<Self>;
    /// Lanes.
    const LEN: usize;

    /// The same number in every lane.
    #[must_use]
    fn like(self, x: i64) -> Self;
    /// Products. Of several lanes the factors must have 32 bits with their sign.
    #[must_use]
    fn mul(self, by: Self) -> Self;
    /// Products of numbers that are not negative. Of several lanes the factors must be below 2^32.
    #[must_use]
    fn mul_unsigned(self, by: Self) -> Self;
    /// Products. Of several lanes `by` must have 32 bits with its sign.
    #[must_use]
    fn mul_wide(self, by: Self) -> Self;
    /// Left shifts by 0 to 63; of several lanes by more, which leaves 0.
    #[must_use]
    fn shl(self, by: Self) -> Self;
    /// Right shifts by 0 to 63 that repeat the sign.
    #[must_use]
    fn sra(self, by: Self) -> Self;
    /// Right shifts by 0 to 63 that fill with zeros.
    #[must_use]
    fn shr(self, by: Self) -> Self;
    /// The smaller one of each lane.
    #[must_use]
    fn smaller(self, other: Self) -> Self;
    /// The larger one of each lane.
    #[must_use]
    fn larger(self, other: Self) -> Self;
    /// Magnitudes.
    #[must_use]
    fn abs(self) -> Self;
    /// Zeros above the leading one; 64 for 0.
    #[must_use]
    fn leading_zeros(self) -> Self;
    /// Where a lane is greater.
    fn gt(self, other: Self) -> Self::Mask;
    /// Where lanes are equal.
    fn same(self, other: Self) -> Self::Mask;
    /// The entries at these places of a table; 0 beyond it.
    #[must_use]
    fn look_up(self, table: &[i64]) -> Self;
    /// Whether a lane is not 0.
    fn any(self) -> bool;
    /// Quotients towards zero and their remainders, lane by lane.
    fn div_rem(self, by: i64) -> (Self, Self);
    /// Stores the lanes at `at` and after it; `at` is a multiple of their number.
    fn store<const N: usize>(self, to: &mut [i64; N], at: usize);
    /// Stores the lanes at any place that leaves room for them.
    fn put<const N: usize>(self, to: &mut [i64; N], at: usize);

    /// Left shifts by one number.
    #[inline(always)]
    #[must_use]
    fn up(self, by: i64) -> Self {
        self.shl(self.like(by))
    }
    /// Right shifts by one number that repeat the sign.
    #[inline(always)]
    #[must_use]
    fn down(self, by: i64) -> Self {
        self.sra(self.like(by))
    }
    /// The sum with one number.
    #[inline(always)]
    #[must_use]
    fn plus(self, x: i64) -> Self {
        self + self.like(x)
    }
    /// The bits that one number has, too.
    #[inline(always)]
    #[must_use]
    fn and(self, x: i64) -> Self {
        self & self.like(x)
    }
    /// Products with one number of 32 bits with its sign.
    #[inline(always)]
    #[must_use]
    fn times(self, x: i64) -> Self {
        self.mul(self.like(x))
    }
    /// The nearest numbers from `low` to `high`.
    #[inline(always)]
    #[must_use]
    fn limit(self, low: i64, high: i64) -> Self {
        self.larger(self.like(low)).smaller(self.like(high))
    }
    /// Where a lane is negative.
    #[inline(always)]
    fn negative(self) -> Self::Mask {
        self.like(0).gt(self)
    }
    /// Where a lane is 0.
    #[inline(always)]
    fn zero(self) -> Self::Mask {
        self.same(self.like(0))
    }
}

/// The instructions that vectors are made of: a value is the proof that the machine has them.
pub trait Simd: Copy + Debug {
    /// Its vectors.
    type I: Vector;

    /// The same number in every lane.
    fn splat(self, x: i64) -> Self::I;
    /// The numbers at `at` and after it; `at` is a multiple of the lanes.
    fn load<const N: usize>(self, from: &[i64; N], at: usize) -> Self::I;
    /// Adds to `sums` two rows of two words of four 16-bit floats, each with `M` bits of mantissa below its
    /// exponent, times the words' weights of 32 bits: channel by channel the first word of a row to the first four,
    /// the second one to any four of them.
    fn add_rows<const M: u32>(self, rows: [[u64; 2]; 2], weights: [i64; 4], sums: &mut [i64; 8]);
}

/// `at`, brought to a place from which `len` of `N` numbers can be read.
#[inline(always)]
fn place<const N: usize>(at: usize, len: usize) -> usize {
    const { assert!(N.is_power_of_two(), "a block has a power of two of lanes") };
    debug_assert!(at + len <= N && at.is_multiple_of(len), "lanes {at} of {N}, {len} at a time");
    at & (N - len)
}

/// Which instructions a task runs under.
#[derive(Clone, Copy, Debug)]
pub enum Level {
    /// What the target guarantees.
    Baseline,
    /// AVX2 with BMI1, BMI2 and LZCNT: 4 lanes.
    #[cfg(target_arch = "x86_64")]
    Avx2(Avx2),
    /// AVX-512 F, BW, CD, DQ and VL: 8 lanes.
    #[cfg(target_arch = "x86_64")]
    Avx512(Avx512),
}

/// Something to run; its `run` must be `#[inline(always)]`.
pub trait Task {
    /// Its results.
    type Output;

    /// Does it.
    fn run<S: Simd>(self, simd: S) -> Self::Output;
}

impl Level {
    /// Every level that this machine runs, the narrowest first.
    #[cfg(feature = "std")]
    #[must_use]
    pub fn available() -> std::vec::Vec<Self> {
        let mut levels = std::vec![Self::Baseline];
        #[cfg(target_arch = "x86_64")]
        {
            levels.extend(Avx2::detect().map(Self::Avx2));
            levels.extend(Avx512::detect().map(Self::Avx512));
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
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(_) => "AVX-512",
        }
    }
}

/// What runs tasks: the instructions of a [`Level`], or [`Scalar`] where no others are compiled.
pub trait Runs: Copy {
    /// Runs a task, as a function of its own.
    fn run<T: Task>(self, task: T) -> T::Output;
}

impl Runs for Level {
    fn run<T: Task>(self, task: T) -> T::Output {
        match self {
            Self::Baseline => Scalar.run(task),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(simd) => simd.run(task),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(simd) => simd.run(task),
        }
    }
}

impl Runs for Scalar {
    #[inline(never)]
    fn run<T: Task>(self, task: T) -> T::Output {
        task.run(self)
    }
}

#[cfg(all(test, feature = "std"))]
mod tests;
