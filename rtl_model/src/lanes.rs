//! Register writes of whole lane arrays.
//!
//! A stage computes one register component of all lanes at a time. Its loops have no branch and no
//! call, so that the compiler turns them into vector instructions: a product of two narrow operands is
//! one instruction, rounding and the range check are a handful. The rare cases (a register out of
//! range, another rounding) are settled after the loop, from the values that the loop has stored.

use crate::fx::{Flags, Quantizer, Rounding};
use crate::regs::{Event, Register};
use crate::stages::Lanes;
use crate::tap::Tap;

/// a·b. Where `T::STANDARD` both must fit 32 bits.
#[inline(always)]
pub(crate) fn mul<T: Tap>(a: i64, b: i64) -> i64 {
    if T::STANDARD { narrow(a) * narrow(b) } else { a * b }
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

/// How many lanes the loops of a block run over when `used` are in use: a multiple of 16 where the
/// block has as many. Not a constant, or the loops would be unrolled into more code than a cache holds.
#[inline(always)]
pub(crate) fn span<const N: usize>(used: usize) -> usize {
    used.next_multiple_of(16).min(N)
}

/// `f` of the first `n` lanes.
#[inline(always)]
pub(crate) fn each<const N: usize>(n: usize, f: impl Fn(usize) -> i64) -> [i64; N] {
    let mut out = [0; N];
    fill(n, &mut out, f);
    out
}

/// `f` of the first `n` lanes, to an array that is there already.
#[inline(always)]
pub(crate) fn fill<const N: usize>(n: usize, out: &mut [i64; N], f: impl Fn(usize) -> i64) {
    for i in 0..n.min(N) {
        out[i] = f(i);
    }
}

/// Right shifts that differ from lane to lane, for the writes of one register; left where negative.
#[derive(Clone, Debug)]
pub(crate) struct Shift<const N: usize>([i64; N]);

impl<const N: usize> Shift<N> {
    /// Shifts for the register `q`. Beyond 62 less than half an LSB is left, and 63 makes 0 of every
    /// |x| ≤ 2^62; a left shift by the register's width moves any bit out of it.
    #[inline(always)]
    pub(crate) fn new(n: usize, q: &Quantizer, shift: impl Fn(usize) -> i64) -> Self {
        let most = i64::from(q.format.width());
        Self(each(n, |i| shift(i).clamp(-most, 63)))
    }
}

/// Zeros above the leading one of the largest component; 64 where all are zero.
#[inline(always)]
pub(crate) fn leading_zeros<const N: usize, const C: usize>(n: usize, x: &Lanes<N, C>) -> [i64; N] {
    let any: [i64; N] = each(n, |i| {
        let mut any = 0;
        for x in x {
            any |= x[i].unsigned_abs();
        }
        any.cast_signed()
    });
    each(n, |i| i64::from(any[i].leading_zeros()))
}

/// Components moved `up` (so far that the block's leading one is next to the sign; one place down, its
/// bit kept sticky, where −1), then rounded by one shift for all lanes: ones that round up to the next
/// power of two stay at the largest code.
#[inline(always)]
pub(crate) fn mantissas<const N: usize, const C: usize>(
    n: usize,
    q: &Quantizer,
    x: &Lanes<N, C>,
    up: impl Fn(usize) -> i64,
    out: &mut Lanes<N, C>,
) {
    let max = q.format.max_raw();
    let down = 63 - q.bits();
    let low = (1i64 << (down - 1)) - 1;
    for (out, x) in out.iter_mut().zip(x) {
        for i in 0..n.min(N) {
            let less = (up(i) >> 63) & 1;
            let y = ((x[i] >> less) | (x[i] & less)) << ((up(i) + less) & 63);
            let kept = y >> down;
            let rest = y & (2 * low + 1);
            out[i] = (kept + ((rest + low + (kept & 1)) >> down)).clamp(-max, max);
        }
    }
    if q.format.rounding != Rounding::HalfEven {
        for (out, x) in out.iter_mut().zip(x) {
            round_other(q, x, &each::<N>(n, &up), down, &mut out[..n]);
        }
    }
}

/// Positive integers as mantissas in [1, 2) with 30 fraction bits and their powers of two:
/// x = m · 2^e. Bits below 2^−30 of the mantissas are dropped.
#[inline(always)]
pub(crate) fn mantissa<const N: usize>(
    n: usize,
    x: impl Fn(usize) -> i64,
    m: &mut [i64; N],
    e: &mut [i64; N],
) {
    fill(n, e, |i| 63 - i64::from(x(i).leading_zeros()));
    fill(n, m, |i| ((x(i) << ((63 - e[i]) & 63)).cast_unsigned() >> 33).cast_signed());
}

/// Positive integers as m·4^q, m in [1, 4) with 30 fraction bits.
#[inline(always)]
pub(crate) fn mantissa4<const N: usize>(
    n: usize,
    x: impl Fn(usize) -> i64,
    m: &mut [i64; N],
    q: &mut [i64; N],
) {
    fill(n, q, |i| (63 - i64::from(x(i).leading_zeros())) >> 1);
    fill(n, m, |i| ((x(i) << ((62 - 2 * q[i]) & 62)).cast_unsigned() >> 32).cast_signed());
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
        Self { n: span::<N>(flags.len()), flags, tap }
    }

    /// Writes x(lane) (with the quantizer's own input fraction) to a fixed register whose nominal scale
    /// is 2^exponent(lane) in true units.
    #[inline(always)]
    pub(crate) fn write(
        &mut self,
        q: &Register,
        c: usize,
        x: impl Fn(usize) -> i64,
        exponent: impl Fn(usize) -> i64,
        out: &mut [i64; N],
    ) {
        self.code(q, x, out);
        self.put(q, c, out, |i| q.frac() - exponent(i));
    }

    /// [`LaneSink::write`] without a word to the tap.
    #[inline(always)]
    pub(crate) fn code(&mut self, q: &Register, x: impl Fn(usize) -> i64, out: &mut [i64; N]) {
        let r = q.lanes;
        let mut any = 0;
        for i in 0..self.n.min(N) {
            let y = r.round(x(i));
            any |= y + r.bias;
            out[i] = y;
        }
        if any & r.beyond != 0 {
            settle(q, &mut out[..self.n], self.flags);
        }
    }

    /// Writes x(lane) with right shifts that differ from lane to lane.
    #[inline(always)]
    pub(crate) fn shift(
        &mut self,
        q: &Register,
        c: usize,
        shift: &Shift<N>,
        x: impl Fn(usize) -> i64,
        exponent: impl Fn(usize) -> i64,
        out: &mut [i64; N],
    ) {
        self.shift_code(q, shift, i64::MAX, x, out);
        self.put(q, c, out, |i| q.frac() - exponent(i));
    }

    /// [`LaneSink::shift`] without a word to the tap; codes of `most` and more in magnitude count as in
    /// range.
    #[inline(always)]
    pub(crate) fn shift_code(
        &mut self,
        q: &Register,
        shift: &Shift<N>,
        most: i64,
        x: impl Fn(usize) -> i64,
        out: &mut [i64; N],
    ) {
        let mut exact = [0; N];
        let mut any = 0;
        let (bias, size) = (-q.format.min_raw(), q.format.max_raw() - q.format.min_raw() + 1);
        for i in 0..self.n.min(N) {
            let x = x(i);
            let right = shift.0[i].max(0);
            let left = right - shift.0[i];
            let mask = i64::MAX >> (63 - right);
            let y = (x + (mask >> 1) + ((x >> right) & mask & 1)) >> right;
            // In range where y's bits lie below the register's size after the left shift.
            any |= (y + (bias >> left)) & !((size >> left) - 1);
            out[i] = y << left;
            exact[i] = x;
        }
        if any != 0 || !Quantizer::is_standard(q.format) {
            settle_shift((q, most), &exact, &shift.0, &mut out[..self.n], self.flags);
        }
    }

    /// Normalises into a block register: the common shift of a lane depends on its largest component.
    #[inline(always)]
    pub(crate) fn block<const C: usize>(
        &mut self,
        q: &Register,
        x: &Lanes<N, C>,
        frac: impl Fn(usize) -> i64,
        exponent: impl Fn(usize) -> i64,
        (out, out_frac): (&mut Lanes<N, C>, &mut [i64; N]),
    ) {
        let n = self.n;
        let width = q.bits();
        let zeros: [i64; N] = leading_zeros(n, x);
        fill(n, out_frac, |i| {
            let shift = 64 - zeros[i] - width;
            frac(i) - if zeros[i] == 64 { 0 } else { shift }
        });
        mantissas(n, q, x, |i| zeros[i] - 1, out);
        for (c, m) in out.iter().enumerate() {
            self.put(q, c, m, |i| out_frac[i] - exponent(i));
        }
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
        q: &Register,
        c: usize,
        codes: &[i64; N],
        frac: impl Fn(usize) -> i64,
    ) {
        if T::ACTIVE {
            for (i, code) in codes.iter().enumerate().take(self.flags.len()) {
                self.tap.put(i, q.reg, c, *code, frac(i));
            }
        }
    }
}

/// Limits rounded codes, or writes exact ones, and sets the flags of the lanes in use.
#[cold]
#[inline(never)]
fn settle(q: &Register, codes: &mut [i64], flags: &mut [Flags]) {
    for (i, code) in codes.iter_mut().enumerate() {
        let (limited, over) =
            if q.lanes.passes_through() { q.write(*code) } else { q.limit(*code) };
        *code = limited;
        if let Some(flags) = flags.get_mut(i) {
            flags.register(q.reg, over);
        }
    }
}

/// Writes exact values with a shift for each lane, and sets the flags of the lanes in use.
#[cold]
#[inline(never)]
fn settle_shift(
    (q, most): (&Register, i64),
    exact: &[i64],
    shifts: &[i64],
    codes: &mut [i64],
    flags: &mut [Flags],
) {
    for (i, (code, (x, shift))) in codes.iter_mut().zip(exact.iter().zip(shifts)).enumerate() {
        let (limited, over) = q.write_shifted(*x, *shift);
        *code = limited;
        if let Some(flags) = flags.get_mut(i) {
            flags.register(q.reg, over && limited.abs() < most);
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
