//! Eight lanes under AVX-512.

use core::arch::x86_64::{
    __m512i, __mmask8, _mm_loadu_si128, _mm512_abs_epi64, _mm512_add_epi64, _mm512_and_si512,
    _mm512_cmpeq_epi64_mask, _mm512_cmpgt_epi64_mask, _mm512_cmplt_epu64_mask,
    _mm512_cvtepu16_epi64, _mm512_loadu_si512, _mm512_lzcnt_epi64, _mm512_mask_blend_epi64,
    _mm512_mask_i64gather_epi64, _mm512_max_epi64, _mm512_min_epi64, _mm512_mul_epi32,
    _mm512_mul_epu32, _mm512_mullo_epi64, _mm512_or_si512, _mm512_set1_epi64, _mm512_setzero_si512,
    _mm512_sllv_epi64, _mm512_srav_epi64, _mm512_srlv_epi64, _mm512_storeu_si512, _mm512_sub_epi64,
    _mm512_test_epi64_mask, _mm512_xor_si512,
};
use core::ops::{Add, BitAnd, BitOr, BitXor, Neg, Not, Sub};

use crate::{Mask, Simd, Task, Vector, place};

const LEN: usize = 8;

/// Proof that the machine has AVX2's companions and AVX-512 F, BW, CD, DQ and VL.
#[derive(Clone, Copy, Debug)]
pub struct Avx512(());

/// Eight integers.
#[derive(Clone, Copy, Debug)]
pub struct I64x8(__m512i);

/// Eight bits.
#[derive(Clone, Copy, Debug)]
pub struct Mask8(__mmask8);

impl Avx512 {
    /// The proof, where the machine has them.
    #[cfg(feature = "std")]
    #[must_use]
    pub fn detect() -> Option<Self> {
        let has = std::is_x86_feature_detected!("avx512f")
            && std::is_x86_feature_detected!("avx512bw")
            && std::is_x86_feature_detected!("avx512cd")
            && std::is_x86_feature_detected!("avx512dq")
            && std::is_x86_feature_detected!("avx512vl");
        (has && crate::Avx2::detect().is_some()).then_some(Self(()))
    }

    /// Runs a task under these instructions.
    #[inline(always)]
    pub(crate) fn run<T: Task>(self, task: T) -> T::Output {
        // SAFETY: an `Avx512` exists only where its features were found.
        unsafe { run_avx512(self, task) }
    }
}

#[inline(never)]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,avx512f,avx512bw,avx512cd,avx512dq,avx512vl")]
fn run_avx512<T: Task>(simd: Avx512, task: T) -> T::Output {
    task.run(simd)
}

/// Calls of instructions: vectors and masks are made from an [`Avx512`] or from each other alone.
macro_rules! on {
    ($call:expr) => {
        // SAFETY: there is a value of this level, so the machine has its instructions.
        unsafe { $call }
    };
}

impl Simd for Avx512 {
    type I = I64x8;

    #[inline(always)]
    fn splat(self, x: i64) -> I64x8 {
        I64x8(on!(_mm512_set1_epi64(x)))
    }

    #[inline(always)]
    fn load<const N: usize>(self, from: &[i64; N], at: usize) -> I64x8 {
        const { assert!(N >= LEN, "a block of fewer lanes") };
        let at = place::<N>(at, LEN);
        // SAFETY: as above, and `place` leaves `LEN` numbers behind `at`.
        I64x8(unsafe { _mm512_loadu_si512(from.as_ptr().add(at).cast()) })
    }

    #[inline(always)]
    fn add_rows<const M: u32>(self, rows: [[u64; 2]; 2], weights: [i64; 4], sums: &mut [i64; 8]) {
        let mut sum = self.load(sums, 0);
        for (row, weights) in rows.iter().zip(weights.as_chunks::<2>().0) {
            // SAFETY: as above, and a row has 16 bytes.
            let float =
                I64x8(unsafe { _mm512_cvtepu16_epi64(_mm_loadu_si128(row.as_ptr().cast())) });
            let second = Mask8(0xf0).select(float.like(weights[1]), float.like(weights[0]));
            let product = float.and((1 << M) - 1).mul_unsigned(second);
            sum = sum + product.shl(float.shr(float.like(M.into())));
        }
        sum.store(sums, 0);
    }
}

impl BitAnd for Mask8 {
    type Output = Self;

    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

impl BitOr for Mask8 {
    type Output = Self;

    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl Not for Mask8 {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}

impl Mask<I64x8> for Mask8 {
    #[inline(always)]
    fn select(self, yes: I64x8, no: I64x8) -> I64x8 {
        I64x8(on!(_mm512_mask_blend_epi64(self.0, no.0, yes.0)))
    }
}

impl Neg for I64x8 {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.like(0) - self
    }
}

impl Not for I64x8 {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        self ^ self.like(-1)
    }
}

impl I64x8 {
    fn array(self) -> [i64; LEN] {
        let mut lanes = [0; LEN];
        self.store(&mut lanes, 0);
        lanes
    }
}

impl Vector for I64x8 {
    type Mask = Mask8;
    const LEN: usize = LEN;

    #[inline(always)]
    fn like(self, x: i64) -> Self {
        Self(on!(_mm512_set1_epi64(x)))
    }

    #[inline(always)]
    fn mul(self, by: Self) -> Self {
        Self(on!(_mm512_mul_epi32(self.0, by.0)))
    }

    #[inline(always)]
    fn mul_unsigned(self, by: Self) -> Self {
        Self(on!(_mm512_mul_epu32(self.0, by.0)))
    }

    #[inline(always)]
    fn mul_wide(self, by: Self) -> Self {
        Self(on!(_mm512_mullo_epi64(self.0, by.0)))
    }

    #[inline(always)]
    fn shl(self, by: Self) -> Self {
        Self(on!(_mm512_sllv_epi64(self.0, by.0)))
    }

    #[inline(always)]
    fn sra(self, by: Self) -> Self {
        Self(on!(_mm512_srav_epi64(self.0, by.0)))
    }

    #[inline(always)]
    fn shr(self, by: Self) -> Self {
        Self(on!(_mm512_srlv_epi64(self.0, by.0)))
    }

    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        Self(on!(_mm512_min_epi64(self.0, other.0)))
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        Self(on!(_mm512_max_epi64(self.0, other.0)))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(on!(_mm512_abs_epi64(self.0)))
    }

    #[inline(always)]
    fn leading_zeros(self) -> Self {
        Self(on!(_mm512_lzcnt_epi64(self.0)))
    }

    #[inline(always)]
    fn gt(self, other: Self) -> Mask8 {
        Mask8(on!(_mm512_cmpgt_epi64_mask(self.0, other.0)))
    }

    #[inline(always)]
    fn same(self, other: Self) -> Mask8 {
        Mask8(on!(_mm512_cmpeq_epi64_mask(self.0, other.0)))
    }

    #[inline(always)]
    fn look_up(self, table: &[i64]) -> Self {
        let len = self.like(i64::try_from(table.len()).unwrap_or(0));
        // SAFETY: as above, and lanes beyond the table are masked out.
        Self(unsafe {
            let inside = _mm512_cmplt_epu64_mask(self.0, len.0);
            let none = _mm512_setzero_si512();
            _mm512_mask_i64gather_epi64::<8>(none, inside, self.0, table.as_ptr().cast())
        })
    }

    #[inline(always)]
    fn any(self) -> bool {
        on!(_mm512_test_epi64_mask(self.0, self.0)) != 0
    }

    fn div_rem(self, by: i64) -> (Self, Self) {
        let proof = Avx512(());
        let lanes = self.array();
        let [quotients, rests] = [lanes.map(|x| x / by), lanes.map(|x| x % by)];
        (proof.load(&quotients, 0), proof.load(&rests, 0))
    }

    #[inline(always)]
    fn store<const N: usize>(self, to: &mut [i64; N], at: usize) {
        const { assert!(N >= LEN, "a block of fewer lanes") };
        let at = place::<N>(at, LEN);
        // SAFETY: as above, and `place` leaves `LEN` numbers behind `at`.
        unsafe { _mm512_storeu_si512(to.as_mut_ptr().add(at).cast(), self.0) }
    }

    #[inline(always)]
    fn put<const N: usize>(self, to: &mut [i64; N], at: usize) {
        const { assert!(N >= LEN, "a block of fewer lanes") };
        let at = at.min(N - LEN);
        // SAFETY: as above, and there are `LEN` numbers behind `at`.
        unsafe { _mm512_storeu_si512(to.as_mut_ptr().add(at).cast(), self.0) }
    }
}

/// Operators of one instruction each.
macro_rules! operators {
    ($($operator:ident $name:ident $call:ident;)+) => {$(
        impl $operator for I64x8 {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self(on!($call(self.0, other.0)))
            }
        }
    )+};
}

operators! {
    Add add _mm512_add_epi64;
    Sub sub _mm512_sub_epi64;
    BitAnd bitand _mm512_and_si512;
    BitOr bitor _mm512_or_si512;
    BitXor bitxor _mm512_xor_si512;
}
