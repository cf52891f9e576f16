//! One lane: plain integers.

use crate::{Mask, Simd, Vector, place};

/// One lane.
#[derive(Clone, Copy, Debug)]
pub struct Scalar;

impl Simd for Scalar {
    type I = i64;

    #[inline(always)]
    fn splat(self, x: i64) -> i64 {
        x
    }

    #[inline(always)]
    fn load<const N: usize>(self, from: &[i64; N], at: usize) -> i64 {
        from[place::<N>(at, 1)]
    }

    #[inline(always)]
    fn add_rows<const M: u32>(self, rows: [[u64; 2]; 2], weights: [i64; 4], sums: &mut [i64; 8]) {
        for (word, weight) in rows.as_flattened().iter().zip(weights) {
            for (c, sum) in sums.iter_mut().take(4).enumerate() {
                let float = ((word >> (16 * c)) & 0xffff).cast_signed();
                *sum += ((float & ((1 << M) - 1)) * weight) << (float >> M);
            }
        }
    }
}

impl Mask<i64> for bool {
    #[inline(always)]
    fn select(self, yes: i64, no: i64) -> i64 {
        if self { yes } else { no }
    }
}

impl Vector for i64 {
    type Mask = bool;
    const LEN: usize = 1;

    #[inline(always)]
    fn like(self, x: i64) -> Self {
        x
    }

    #[inline(always)]
    fn mul(self, by: Self) -> Self {
        self * by
    }

    #[inline(always)]
    fn mul_unsigned(self, by: Self) -> Self {
        self * by
    }

    #[inline(always)]
    fn mul_wide(self, by: Self) -> Self {
        self * by
    }

    #[inline(always)]
    fn shl(self, by: Self) -> Self {
        self << by
    }

    #[inline(always)]
    fn sra(self, by: Self) -> Self {
        self >> by
    }

    #[inline(always)]
    fn shr(self, by: Self) -> Self {
        (self.cast_unsigned() >> by).cast_signed()
    }

    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        Ord::min(self, other)
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        Ord::max(self, other)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.unsigned_abs().cast_signed()
    }

    #[inline(always)]
    fn leading_zeros(self) -> Self {
        self.leading_zeros().into()
    }

    #[inline(always)]
    fn gt(self, other: Self) -> bool {
        self > other
    }

    #[inline(always)]
    fn same(self, other: Self) -> bool {
        self == other
    }

    #[inline(always)]
    fn look_up(self, table: &[i64]) -> Self {
        usize::try_from(self).ok().and_then(|at| table.get(at)).copied().unwrap_or(0)
    }

    #[inline(always)]
    fn any(self) -> bool {
        self != 0
    }

    #[inline(always)]
    fn div_rem(self, by: i64) -> (Self, Self) {
        (self / by, self % by)
    }

    #[inline(always)]
    fn store<const N: usize>(self, to: &mut [i64; N], at: usize) {
        to[place::<N>(at, 1)] = self;
    }

    #[inline(always)]
    fn put<const N: usize>(self, to: &mut [i64; N], at: usize) {
        self.store(to, at);
    }
}
