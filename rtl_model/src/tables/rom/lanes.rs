//! The tables' functions for whole lane arrays: the same bits as [`Rom::recip`] and its like.
//!
//! Addresses and arithmetic are vector code, reading the entries is not. Arguments have 31 or 32 bits,
//! results at most 32, so that every product of a Newton step has operands that vector instructions take.

use super::{ONE, P, Rom, shift_round, to_index};
use crate::lanes::{fill, mul, mul_unsigned};
use crate::tap::Tap;

impl Rom {
    /// [`Rom::interpolate`]; base(lane) is where the binade's run starts.
    #[inline(always)]
    fn interpolate_lanes<const N: usize, T: Tap>(
        &self,
        n: usize,
        base: impl Fn(usize) -> i64,
        t: impl Fn(usize) -> i64,
        out: &mut [i64; N],
    ) {
        if self.spec.order == 2 {
            // Three entries and a square: seldom chosen, one lane at a time.
            fill(n, out, |i| base(i) << P | t(i));
            return self.interpolate_twice(&mut out[..n]);
        }
        let rest_bits = P - self.log_intervals;
        let mask = (1i64 << rest_bits) - 1;
        let lift = P - i64::from(self.spec.frac);
        let mut step = [0; N];
        fill(n, out, |i| base(i) + (t(i) >> rest_bits));
        for i in 0..n.min(N) {
            let k = to_index(out[i]);
            let entry = self.values.get(k).copied().unwrap_or(0);
            step[i] = self.values.get(k + 1).copied().unwrap_or(0) - entry;
            out[i] = entry;
        }
        let first_order = self.spec.order == 1;
        let (bits, mask) = if first_order { (rest_bits, mask) } else { (0, 0) };
        let (down, up) = ((bits - lift).max(0), (lift - bits).max(0));
        let half = (1i64 << down) >> 1;
        for i in 0..n.min(N) {
            let sum = (out[i] << bits) + mul::<T>(step[i], t(i) & mask);
            out[i] = ((sum + half) >> down) << up;
        }
    }

    /// Base and position of every lane to the interpolated value.
    #[cold]
    #[inline(never)]
    fn interpolate_twice(&self, lanes: &mut [i64]) {
        for lane in lanes {
            *lane = self.interpolate(usize::from(*lane >> P > 0), *lane & (ONE - 1));
        }
    }

    /// Over two binades.
    #[inline(always)]
    fn two_binades_lanes<const N: usize, T: Tap>(
        &self,
        n: usize,
        x: &[i64; N],
        out: &mut [i64; N],
    ) {
        let run = i64::try_from(self.run).unwrap_or(0);
        let upper = |i: usize| x[i] >> (P + 1);
        let t = |i: usize| (x[i] >> upper(i)) - ONE;
        self.interpolate_lanes::<N, T>(n, |i| -upper(i) & run, t, out);
    }

    /// [`Rom::recip`] of every lane.
    #[inline(always)]
    pub(crate) fn recip_lanes<const N: usize, T: Tap>(
        &self,
        n: usize,
        x: &[i64; N],
        y: &mut [i64; N],
    ) {
        self.interpolate_lanes::<N, T>(n, |_| 0, |i| x[i] - ONE, y);
        for _ in 0..self.spec.newton {
            for i in 0..n.min(N) {
                let e = 2 * ONE - shift_round(mul_unsigned::<T>(x[i], y[i]), P);
                y[i] = shift_round(mul_unsigned::<T>(y[i], e), P);
            }
        }
    }

    /// [`Rom::rsqrt`] of every lane.
    #[inline(always)]
    pub(crate) fn rsqrt_lanes<const N: usize, T: Tap>(
        &self,
        n: usize,
        x: &[i64; N],
        y: &mut [i64; N],
    ) {
        self.two_binades_lanes::<N, T>(n, x, y);
        for _ in 0..self.spec.newton {
            for i in 0..n.min(N) {
                let square = shift_round(mul_unsigned::<T>(y[i], y[i]), P);
                let e = 3 * ONE - shift_round(mul_unsigned::<T>(x[i], square), P);
                y[i] = shift_round(mul_unsigned::<T>(y[i], e), P + 1);
            }
        }
    }

    /// [`Rom::sqrt`] of every lane.
    #[inline(always)]
    pub(crate) fn sqrt_lanes<const N: usize, T: Tap>(
        &self,
        n: usize,
        x: &[i64; N],
        rsqrt: &Self,
        y: &mut [i64; N],
    ) {
        self.two_binades_lanes::<N, T>(n, x, y);
        if self.spec.newton > 0 {
            let mut r = [0; N];
            rsqrt.rsqrt_lanes::<N, T>(n, x, &mut r);
            for _ in 0..self.spec.newton {
                for i in 0..n.min(N) {
                    let rest = x[i] - shift_round(mul_unsigned::<T>(y[i], y[i]), P);
                    y[i] += shift_round(mul::<T>(rest, r[i]), P + 1);
                }
            }
        }
    }

    /// [`Rom::log2`] of every lane.
    #[inline(always)]
    pub(crate) fn log2_lanes<const N: usize, T: Tap>(
        &self,
        n: usize,
        x: &[i64; N],
        y: &mut [i64; N],
    ) {
        self.interpolate_lanes::<N, T>(n, |_| 0, |i| x[i] - ONE, y);
    }
}
