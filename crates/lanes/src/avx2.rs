//! Four lanes under AVX2, which lacks some instructions on 64-bit lanes: they are put together here.

use core::arch::x86_64::{
    __m256i, _mm_cvtsi64_si128, _mm256_add_epi64, _mm256_and_si256, _mm256_blendv_epi8,
    _mm256_cmpeq_epi64, _mm256_cmpgt_epi64, _mm256_cvtepu16_epi64, _mm256_loadu_si256,
    _mm256_mask_i64gather_epi64, _mm256_mul_epi32, _mm256_mul_epu32, _mm256_or_si256,
    _mm256_set1_epi64x, _mm256_setzero_si256, _mm256_sllv_epi64, _mm256_srlv_epi64,
    _mm256_storeu_si256, _mm256_sub_epi64, _mm256_testz_si256, _mm256_xor_si256,
};
use core::ops::{Add, BitAnd, BitOr, BitXor, Neg, Not, Sub};

use crate::{Mask, Simd, Task, Vector, place};

const LEN: usize = 4;

/// Proof that the machine has AVX2, BMI1, BMI2 and LZCNT.
#[derive(Clone, Copy, Debug)]
pub struct Avx2(());

/// Four integers.
#[derive(Clone, Copy, Debug)]
pub struct I64x4(__m256i);

/// All ones or zeros in each lane.
#[derive(Clone, Copy, Debug)]
pub struct Mask4(I64x4);

impl Avx2 {
    /// The proof, where the machine has them.
    #[cfg(feature = "std")]
    #[must_use]
    pub fn detect() -> Option<Self> {
        let has = std::is_x86_feature_detected!("avx2")
            && std::is_x86_feature_detected!("bmi1")
            && std::is_x86_feature_detected!("bmi2")
            && std::is_x86_feature_detected!("lzcnt");
        has.then_some(Self(()))
    }

    /// Runs a task under these instructions.
    #[inline(always)]
    pub(crate) fn run<T: Task>(self, task: T) -> T::Output {
        // SAFETY: an `Avx2` exists only where its features were found.
        unsafe { run_avx2(self, task) }
    }
}

#[inline(never)]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt")]
fn run_avx2<T: Task>(simd: Avx2, task: T) -> T::Output {
    task.run(simd)
}

/// Calls of instructions: vectors and masks are made from an [`Avx2`] or from each other alone.
macro_rules! on {
    ($call:expr) => {
        // SAFETY: there is a value of this level, so the machine has its instructions.
        unsafe { $call }
    };
}

impl Simd for Avx2 {
    type I = I64x4;

    #[inline(always)]
    fn splat(self, x: i64) -> I64x4 {
        I64x4(on!(_mm256_set1_epi64x(x)))
    }

    #[inline(always)]
    fn load<const N: usize>(self, from: &[i64; N], at: usize) -> I64x4 {
        const { assert!(N >= LEN, "a block of fewer lanes") };
        let at = place::<N>(at, LEN);
        // SAFETY: as above, and `place` leaves `LEN` numbers behind `at`.
        I64x4(unsafe { _mm256_loadu_si256(from.as_ptr().add(at).cast()) })
    }

    #[inline(always)]
    fn add_rows<const M: u32>(self, rows: [[u64; 2]; 2], weights: [i64; 4], sums: &mut [i64; 8]) {
        let mut sum = self.load(sums, 0);
        for (word, weight) in rows.as_flattened().iter().zip(weights) {
            let float = I64x4(on!(_mm256_cvtepu16_epi64(_mm_cvtsi64_si128(word.cast_signed()))));
            let product = float.and((1 << M) - 1).mul_unsigned(float.like(weight));
            sum = sum + product.shl(float.shr(float.like(M.into())));
        }
        sum.store(sums, 0);
    }
}

impl BitAnd for Mask4 {
    type Output = Self;

    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

impl BitOr for Mask4 {
    type Output = Self;

    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl Not for Mask4 {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}

impl Mask<I64x4> for Mask4 {
    #[inline(always)]
    fn select(self, yes: I64x4, no: I64x4) -> I64x4 {
        I64x4(on!(_mm256_blendv_epi8(no.0, yes.0, self.0.0)))
    }
}

impl Neg for I64x4 {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.like(0) - self
    }
}

impl Not for I64x4 {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        self ^ self.like(-1)
    }
}

impl I64x4 {
    #[inline(always)]
    fn array(self) -> [i64; LEN] {
        let mut lanes = [0; LEN];
        self.store(&mut lanes, 0);
        lanes
    }
}

impl Vector for I64x4 {
    type Mask = Mask4;
    const LEN: usize = LEN;

    #[inline(always)]
    fn like(self, x: i64) -> Self {
        Self(on!(_mm256_set1_epi64x(x)))
    }

    #[inline(always)]
    fn mul(self, by: Self) -> Self {
        Self(on!(_mm256_mul_epi32(self.0, by.0)))
    }

    #[inline(always)]
    fn mul_unsigned(self, by: Self) -> Self {
        Self(on!(_mm256_mul_epu32(self.0, by.0)))
    }

    #[inline(always)]
    fn mul_wide(self, by: Self) -> Self {
        // self = high·2^32 + low, low not negative: the signed product of its 32 bits lacks by·2^32 where bit 31 is set.
        let high = self.shr(self.like(32)) + self.shr(self.like(31)).and(1);
        (high.mul(by)).up(32) + self.mul(by)
    }

    #[inline(always)]
    fn shl(self, by: Self) -> Self {
        Self(on!(_mm256_sllv_epi64(self.0, by.0)))
    }

    #[inline(always)]
    fn sra(self, by: Self) -> Self {
        let sign = self.like(i64::MIN);
        (self ^ sign).shr(by) - sign.shr(by)
    }

    #[inline(always)]
    fn shr(self, by: Self) -> Self {
        Self(on!(_mm256_srlv_epi64(self.0, by.0)))
    }

    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        self.gt(other).select(other, self)
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        self.gt(other).select(self, other)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        let sign = self.negative().0;
        (self ^ sign) - sign
    }

    #[inline(always)]
    fn leading_zeros(self) -> Self {
        let [a, b, c, d] = self.array();
        let zeros = [a.leading_zeros(), b.leading_zeros(), c.leading_zeros(), d.leading_zeros()];
        Avx2(()).load(&[zeros[0].into(), zeros[1].into(), zeros[2].into(), zeros[3].into()], 0)
    }

    #[inline(always)]
    fn gt(self, other: Self) -> Mask4 {
        Mask4(Self(on!(_mm256_cmpgt_epi64(self.0, other.0))))
    }

    #[inline(always)]
    fn same(self, other: Self) -> Mask4 {
        Mask4(Self(on!(_mm256_cmpeq_epi64(self.0, other.0))))
    }

    #[inline(always)]
    fn look_up(self, table: &[i64]) -> Self {
        let len = self.like(i64::try_from(table.len()).unwrap_or(0));
        let inside = len.gt(self) & !self.negative();
        // SAFETY: as above, and lanes beyond the table are masked out.
        Self(unsafe {
            let none = _mm256_setzero_si256();
            _mm256_mask_i64gather_epi64::<8>(none, table.as_ptr(), self.0, inside.0.0)
        })
    }

    #[inline(always)]
    fn any(self) -> bool {
        on!(_mm256_testz_si256(self.0, self.0)) == 0
    }

    fn div_rem(self, by: i64) -> (Self, Self) {
        let lanes = self.array();
        let [quotients, rests] = [lanes.map(|x| x / by), lanes.map(|x| x % by)];
        (Avx2(()).load(&quotients, 0), Avx2(()).load(&rests, 0))
    }

    #[inline(always)]
    fn store<const N: usize>(self, to: &mut [i64; N], at: usize) {
        const { assert!(N >= LEN, "a block of fewer lanes") };
        let at = place::<N>(at, LEN);
        // SAFETY: as above, and `place` leaves `LEN` numbers behind `at`.
        unsafe { _mm256_storeu_si256(to.as_mut_ptr().add(at).cast(), self.0) }
    }

    #[inline(always)]
    fn put<const N: usize>(self, to: &mut [i64; N], at: usize) {
        const { assert!(N >= LEN, "a block of fewer lanes") };
        let at = at.min(N - LEN);
        // SAFETY: as above, and there are `LEN` numbers behind `at`.
        unsafe { _mm256_storeu_si256(to.as_mut_ptr().add(at).cast(), self.0) }
    }
}

/// Operators of one instruction each.
macro_rules! operators {
    ($($operator:ident $name:ident $call:ident;)+) => {$(
        impl $operator for I64x4 {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self(on!($call(self.0, other.0)))
            }
        }
    )+};
}

operators! {
    Add add _mm256_add_epi64;
    Sub sub _mm256_sub_epi64;
    BitAnd bitand _mm256_and_si256;
    BitOr bitor _mm256_or_si256;
    BitXor bitxor _mm256_xor_si256;
}
