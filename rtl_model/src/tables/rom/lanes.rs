//! The tables' functions for whole lane arrays: the same bits as [`Rom::recip`] and its like.
//!
//! Addresses and arithmetic are vector code, reading the entries is not. Arguments have 31 or 32 bits,
//! results at most 32, so that every product of a Newton step has operands that vector instructions take.

use super::{ONE, P, Rom, shift_round, to_index};
use crate::lanes::{each, mul, mul_unsigned};
use crate::tap::Tap;

impl Rom {
    /// Two neighbouring entries of every lane.
    #[inline(always)]
    fn entries<const N: usize>(&self, n: usize, at: &[i64; N]) -> [[i64; N]; 2] {
        let (mut a, mut b) = ([0; N], [0; N]);
        for i in 0..n.min(N) {
            let k = to_index(at[i]);
            a[i] = self.values.get(k).copied().unwrap_or(0);
            b[i] = self.values.get(k + 1).copied().unwrap_or(0);
        }
        [a, b]
    }

    /// [`Rom::interpolate`]; `base` is where the binade's run starts.
    #[inline(always)]
    fn interpolate_lanes<const N: usize, T: Tap>(
        &self,
        n: usize,
        base: &[i64; N],
        t: &[i64; N],
    ) -> [i64; N] {
        let rest_bits = P - self.log_intervals;
        let mask = (1i64 << rest_bits) - 1;
        let lift = P - i64::from(self.spec.frac);
        if self.spec.order == 2 {
            // Three entries and a square: seldom chosen, one lane at a time.
            let mut out = [0; N];
            for (i, out) in out.iter_mut().enumerate().take(n) {
                *out = self.interpolate(usize::from(base[i] > 0), t[i]);
            }
            return out;
        }
        let at: [i64; N] = each(n, |i| base[i] + (t[i] >> rest_bits));
        let [a, b] = self.entries(n, &at);
        if self.spec.order == 0 {
            return each(n, |i| a[i] << lift);
        }
        let (down, up) = ((rest_bits - lift).max(0), (lift - rest_bits).max(0));
        let half = (1i64 << down) >> 1;
        each(n, |i| {
            let sum = (a[i] << rest_bits) + mul::<T>(b[i] - a[i], t[i] & mask);
            ((sum + half) >> down) << up
        })
    }

    /// Over two binades.
    #[inline(always)]
    fn two_binades_lanes<const N: usize, T: Tap>(&self, n: usize, x: &[i64; N]) -> [i64; N] {
        let run = i64::try_from(self.run).unwrap_or(0);
        let upper = |i: usize| x[i] >> (P + 1);
        self.interpolate_lanes::<N, T>(
            n,
            &each(n, |i| -upper(i) & run),
            &each(n, |i| (x[i] >> upper(i)) - ONE),
        )
    }

    /// [`Rom::recip`] of every lane.
    #[inline(always)]
    pub(crate) fn recip_lanes<const N: usize, T: Tap>(&self, n: usize, x: &[i64; N]) -> [i64; N] {
        let mut y = self.interpolate_lanes::<N, T>(n, &[0; N], &each(n, |i| x[i] - ONE));
        for _ in 0..self.spec.newton {
            y = each(n, |i| {
                let e = 2 * ONE - shift_round(mul_unsigned::<T>(x[i], y[i]), P);
                shift_round(mul_unsigned::<T>(y[i], e), P)
            });
        }
        y
    }

    /// [`Rom::rsqrt`] of every lane.
    #[inline(always)]
    pub(crate) fn rsqrt_lanes<const N: usize, T: Tap>(&self, n: usize, x: &[i64; N]) -> [i64; N] {
        let mut y = self.two_binades_lanes::<N, T>(n, x);
        for _ in 0..self.spec.newton {
            y = each(n, |i| {
                let square = shift_round(mul_unsigned::<T>(y[i], y[i]), P);
                let e = 3 * ONE - shift_round(mul_unsigned::<T>(x[i], square), P);
                shift_round(mul_unsigned::<T>(y[i], e), P + 1)
            });
        }
        y
    }

    /// [`Rom::sqrt`] of every lane.
    #[inline(always)]
    pub(crate) fn sqrt_lanes<const N: usize, T: Tap>(&self, n: usize, x: &[i64; N], rsqrt: &Self) -> [i64; N] {
        let mut y = self.two_binades_lanes::<N, T>(n, x);
        if self.spec.newton > 0 {
            let r = rsqrt.rsqrt_lanes::<N, T>(n, x);
            for _ in 0..self.spec.newton {
                y = each(n, |i| {
                    let rest = x[i] - shift_round(mul_unsigned::<T>(y[i], y[i]), P);
                    y[i] + shift_round(mul::<T>(rest, r[i]), P + 1)
                });
            }
        }
        y
    }

    /// [`Rom::log2`] of every lane.
    #[inline(always)]
    pub(crate) fn log2_lanes<const N: usize, T: Tap>(&self, n: usize, x: &[i64; N]) -> [i64; N] {
        self.interpolate_lanes::<N, T>(n, &[0; N], &each(n, |i| x[i] - ONE))
    }
}
