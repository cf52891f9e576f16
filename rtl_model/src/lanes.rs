//! Register writes of whole lane arrays.
//!
//! A stage computes one register component of all lanes at a time. Its loops have no branch and no
//! call, so that the compiler turns them into vector instructions: a product of two narrow operands is
//! one instruction, rounding and the range check are a handful. What is seldom needed (a register out of
//! range, another rounding) is settled after the loop, from what the loop has stored.

use crate::fx::{Flags, Quantizer, Rounding};
use crate::regs::{Event, Reg};
use crate::stages::Lanes;
use crate::tap::Tap;

/// a·b. Where `T::STANDARD` both must fit 32 bits.
#[inline(always)]
pub(crate) fn mul<T: Tap>(a: i64, b: i64) -> i64 {
    if T::STANDARD {
        narrow(a) * narrow(b)
    } else {
        a * b
    }
}

/// a·b of non-negative operands. Where `T::STANDARD` both must be below 2^32.
#[inline(always)]
pub(crate) fn mul_unsigned<T: Tap>(a: i64, b: i64) -> i64 {
    if T::STANDARD {
        debug_assert!((a | b) >> 32 == 0, "{a} or {b} needs more than 32 bits");
        (a & 0xffff_ffff) * (b & 0xffff_ffff)
    } else {
        a * b
    }
}

/// a·b of any a. Where `T::STANDARD` b must fit 32 bits.
#[inline(always)]
pub(crate) fn mul_wide<T: Tap>(a: i64, b: i64) -> i64 {
    if T::STANDARD {
        let (high, low) = (a >> 31, a & 0x7fff_ffff);
        ((narrow(high) * narrow(b)) << 31) + narrow(low) * narrow(b)
    } else {
        a * b
    }
}

/// x, which must fit 32 bits, in a form that tells the compiler so.
#[inline(always)]
fn narrow(x: i64) -> i64 {
    let low = (x << 32) >> 32;
    debug_assert!(low == x, "{x} needs more than 32 bits");
    low
}

/// ⟨a, b⟩ of narrow operands.
#[inline(always)]
pub(crate) fn dot<T: Tap>(a: [i64; 3], b: [i64; 3]) -> i64 {
    mul::<T>(a[0], b[0]) + mul::<T>(a[1], b[1]) + mul::<T>(a[2], b[2])
}

/// How many lanes the loops of a block run over when `used` are in use: a multiple of 8 where the block
/// has as many. Not a constant, or the loops would be unrolled into more code than a cache holds.
#[inline(always)]
pub(crate) fn span<const N: usize>(used: usize) -> usize {
    used.next_multiple_of(8).min(N)
}

/// `f` of the first `n` lanes.
#[inline(always)]
pub(crate) fn each<const N: usize>(n: usize, f: impl Fn(usize) -> i64) -> [i64; N] {
    let mut out = [0; N];
    for i in 0..n.min(N) {
        out[i] = f(i);
    }
    out
}

/// Right shifts that differ from lane to lane, prepared for the writes of one register.
#[derive(Clone, Debug)]
pub(crate) struct Shift<const N: usize> {
    raw: [i64; N],
    right: [i64; N],
    /// 2^right − 1.
    mask: [i64; N],
    left: [i64; N],
    bias: [i64; N],
    beyond: [i64; N],
}

impl<const N: usize> Shift<N> {
    /// Shifts for the register `q`; a negative one is a left shift.
    #[inline(always)]
    pub(crate) fn new(n: usize, q: &Quantizer, shift: impl Fn(usize) -> i64) -> Self {
        let mut out = Self {
            raw: [0; N],
            right: [0; N],
            mask: [0; N],
            left: [0; N],
            bias: [0; N],
            beyond: [0; N],
        };
        let (min, max) = (q.format.min_raw(), q.format.max_raw());
        let (bias, size) = (-min, max - min + 1);
        // A left shift by the register's width moves any bit out of it.
        let most = i64::from(q.format.width());
        // Another rounding: nothing is shifted, and everything is settled later.
        let keep = if Quantizer::is_standard(q.format) {
            -1
        } else {
            0
        };
        for i in 0..n.min(N) {
            let s = shift(i);
            // Beyond 62 less than half an LSB is left; 63 makes 0 of every |x| ≤ 2^62.
            let right = s.clamp(0, 63) & keep;
            let left = (-s).clamp(0, most) & keep;
            out.raw[i] = s;
            out.right[i] = right;
            out.mask[i] = i64::MAX >> (63 - right);
            out.left[i] = left;
            out.bias[i] = (bias & keep) >> left;
            out.beyond[i] = !(((size & keep) >> left) - 1) | !keep;
        }
        out
    }
}

/// Components that share one exponent in each lane: value = `m · 2^−frac`.
#[derive(Clone, Debug)]
pub(crate) struct LaneBlock<const N: usize, const C: usize> {
    /// Mantissas.
    pub(crate) m: Lanes<N, C>,
    /// Fraction bits of all of them.
    pub(crate) frac: [i64; N],
}

/// Zeros above the leading one of the largest component; 64 where all are zero.
#[inline(always)]
pub(crate) fn leading_zeros<const N: usize, const C: usize>(
    n: usize,
    x: &Lanes<N, C>,
) -> [i64; N] {
    let any: [i64; N] = each(n, |i| {
        let mut any = 0;
        for x in x {
            any |= x[i].unsigned_abs();
        }
        any.cast_signed()
    });
    each(n, |i| i64::from(any[i].leading_zeros()))
}

/// Components moved `up` (so far that the block's leading one is next to the sign), then rounded by one
/// shift for all lanes: ones that round up to the next power of two stay at the largest code.
#[inline(always)]
pub(crate) fn mantissas<const N: usize, const C: usize>(
    n: usize,
    q: &Quantizer,
    x: &Lanes<N, C>,
    up: &[i64; N],
) -> Lanes<N, C> {
    let max = q.format.max_raw();
    let down = 63 - i64::from(q.format.magnitude_bits());
    let low = (1i64 << (down - 1)) - 1;
    let mut out = [[0; N]; C];
    for (out, x) in out.iter_mut().zip(x) {
        for i in 0..n.min(N) {
            let y = x[i] << (up[i] & 63);
            let kept = y >> down;
            let rest = y & (2 * low + 1);
            out[i] = (kept + ((rest + low + (kept & 1)) >> down)).clamp(-max, max);
        }
    }
    if q.format.rounding != Rounding::HalfEven {
        for (out, x) in out.iter_mut().zip(x) {
            round_other(q, x, up, down, &mut out[..n]);
        }
    }
    out
}

/// Positive integers as mantissas in [1, 2) with 30 fraction bits and the powers of two beside them:
/// x = m · 2^e. Bits below 2^−30 of the mantissas are dropped.
#[inline(always)]
pub(crate) fn mantissa<const N: usize>(n: usize, x: &[i64; N]) -> ([i64; N], [i64; N]) {
    let zeros = leading_zeros(n, core::array::from_ref(x));
    let m = each(n, |i| ((x[i] << (zeros[i] & 63)).cast_unsigned() >> 33).cast_signed());
    (m, each(n, |i| 63 - zeros[i]))
}

/// Positive integers as m·4^q, m in [1, 4) with 30 fraction bits.
#[inline(always)]
pub(crate) fn mantissa4<const N: usize>(n: usize, x: &[i64; N]) -> ([i64; N], [i64; N]) {
    let zeros = leading_zeros(n, core::array::from_ref(x));
    let m = each(n, |i| ((x[i] << (zeros[i] & 62)).cast_unsigned() >> 32).cast_signed());
    (m, each(n, |i| (63 - zeros[i]) >> 1))
}

/// Where register writes of whole lane arrays go: the flags of the lanes in use, and the tap.
#[derive(Debug)]
pub(crate) struct LaneSink<'a, const N: usize, T> {
    /// How many lanes loops run over: [`span`] of those in use.
    pub(crate) n: usize,
    /// Flags of the lanes in use.
    pub(crate) flags: &'a mut [Flags],
    /// Who listens.
    pub(crate) tap: &'a mut T,
}

impl<'a, const N: usize, T: Tap> LaneSink<'a, N, T> {
    /// A sink for the lanes that have flags.
    #[inline(always)]
    pub(crate) fn new(flags: &'a mut [Flags], tap: &'a mut T) -> Self {
        Self {
            n: span::<N>(flags.len()),
            flags,
            tap,
        }
    }

    /// Writes x(lane) (with the quantizer's own input fraction) to a fixed register whose nominal scale
    /// is 2^exponent(lane) in true units.
    #[inline(always)]
    pub(crate) fn write(
        &mut self,
        q: &Quantizer,
        reg: Reg,
        c: usize,
        x: impl Fn(usize) -> i64,
        exponent: impl Fn(usize) -> i64,
    ) -> [i64; N] {
        let out = self.code(q, reg, x);
        self.put(reg, c, &out, |i| i64::from(q.format.frac) - exponent(i));
        out
    }

    /// [`LaneSink::write`] without a word to the tap.
    #[inline(always)]
    pub(crate) fn code(&mut self, q: &Quantizer, reg: Reg, x: impl Fn(usize) -> i64) -> [i64; N] {
        let r = q.lanes;
        let mut out = [0; N];
        let mut any = 0;
        for i in 0..self.n.min(N) {
            let y = r.round(x(i));
            any |= y + r.bias;
            out[i] = y;
        }
        if any & r.beyond != 0 {
            settle(q, reg, &mut out[..self.n], self.flags);
        }
        out
    }

    /// Writes x(lane) with right shifts that differ from lane to lane.
    #[inline(always)]
    pub(crate) fn shift(
        &mut self,
        q: &Quantizer,
        reg: Reg,
        c: usize,
        shift: &Shift<N>,
        x: impl Fn(usize) -> i64,
        exponent: impl Fn(usize) -> i64,
    ) -> [i64; N] {
        let out = self.shift_code(q, reg, shift, i64::MAX, x);
        self.put(reg, c, &out, |i| i64::from(q.format.frac) - exponent(i));
        out
    }

    /// [`LaneSink::shift`] without a word to the tap; codes of `most` and more in magnitude count as in
    /// range.
    #[inline(always)]
    pub(crate) fn shift_code(
        &mut self,
        q: &Quantizer,
        reg: Reg,
        shift: &Shift<N>,
        most: i64,
        x: impl Fn(usize) -> i64,
    ) -> [i64; N] {
        let mut out = [0; N];
        let mut exact = [0; N];
        let mut any = 0;
        for i in 0..self.n.min(N) {
            let x = x(i);
            let (right, mask) = (shift.right[i], shift.mask[i]);
            let y = (x + (mask >> 1) + ((x >> right) & mask & 1)) >> right;
            any |= (y + shift.bias[i]) & shift.beyond[i];
            out[i] = y << shift.left[i];
            exact[i] = x;
        }
        if any != 0 {
            settle_shift((q, reg, most), &exact, &shift.raw, &mut out[..self.n], self.flags);
        }
        out
    }

    /// Normalises into a block register: the common shift of a lane depends on its largest component.
    #[inline(always)]
    pub(crate) fn block<const C: usize>(
        &mut self,
        q: &Quantizer,
        reg: Reg,
        x: &Lanes<N, C>,
        frac: impl Fn(usize) -> i64,
        exponent: impl Fn(usize) -> i64,
    ) -> LaneBlock<N, C> {
        let n = self.n;
        let zeros = leading_zeros(n, x);
        let width = i64::from(q.format.magnitude_bits());
        let out_frac = each(n, |i| {
            let shift = 64 - zeros[i] - width;
            frac(i) - if zeros[i] == 64 { 0 } else { shift }
        });
        let m = mantissas(n, q, x, &each(n, |i| zeros[i] - 1));
        for (c, m) in m.iter().enumerate() {
            self.put(reg, c, m, |i| out_frac[i] - exponent(i));
        }
        LaneBlock { m, frac: out_frac }
    }

    /// Sets the bit of an event in the lanes where it happened.
    #[inline(always)]
    pub(crate) fn event(&mut self, event: Event, happened: &[bool; N]) {
        if happened.contains(&true) {
            for (flags, happened) in self.flags.iter_mut().zip(happened) {
                flags.event(event, *happened);
            }
        }
    }

    /// Tells the tap of one component in every lane in use.
    #[inline(always)]
    pub(crate) fn put(
        &mut self,
        reg: Reg,
        c: usize,
        codes: &[i64; N],
        frac: impl Fn(usize) -> i64,
    ) {
        if T::ACTIVE {
            for (i, code) in codes.iter().enumerate().take(self.flags.len()) {
                self.tap.put(i, reg, c, *code, frac(i));
            }
        }
    }
}

/// Limits rounded codes, or writes exact ones, and sets the flags of the lanes in use.
#[cold]
#[inline(never)]
fn settle(q: &Quantizer, reg: Reg, codes: &mut [i64], flags: &mut [Flags]) {
    for (i, code) in codes.iter_mut().enumerate() {
        let (limited, over) = if q.lanes.passes_through() {
            q.write(*code)
        } else {
            q.limit(*code)
        };
        *code = limited;
        if let Some(flags) = flags.get_mut(i) {
            flags.register(reg, over);
        }
    }
}

/// Writes exact values with a shift for each lane, and sets the flags of the lanes in use.
#[cold]
#[inline(never)]
fn settle_shift(
    (q, reg, most): (&Quantizer, Reg, i64),
    exact: &[i64],
    shifts: &[i64],
    codes: &mut [i64],
    flags: &mut [Flags],
) {
    for (i, (code, (x, shift))) in codes.iter_mut().zip(exact.iter().zip(shifts)).enumerate() {
        let (limited, over) = q.write_shifted(*x, *shift);
        *code = limited;
        if let Some(flags) = flags.get_mut(i) {
            flags.register(reg, over && limited.abs() < most);
        }
    }
}

/// Mantissas by another rounding than half-even: `up` and then `down` is the block's shift.
#[cold]
#[inline(never)]
fn round_other(q: &Quantizer, x: &[i64], up: &[i64], down: i64, codes: &mut [i64]) {
    let max = q.format.max_raw();
    for (code, (x, up)) in codes.iter_mut().zip(x.iter().zip(up)) {
        let shift = if *x == 0 { 0 } else { down - up };
        *code = q.round(*x, shift).clamp(-max, max);
    }
}
