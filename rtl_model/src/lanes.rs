//! Register writes of stages that are written once for any number of lanes.
//!
//! A stage computes on values of [`Vector`]s and hands each to a register. [`Sink`] writes one lane exactly, whatever the
//! register's rounding and overflow, sets its flags and tells the tap: traces run with it. `Fast` writes several
//! lanes of a standard unit without a branch and notes whether anything left the plain case (a value out of range, a
//! left shift, an event). Where that is so, the stage is run again for these lanes, one by one, with a [`Sink`].

use lanes::{Mask as _, Simd, Vector};

use crate::fx::{Quantizer, block};
use crate::regs::{Event, Register};
use crate::stages::Sink;
use crate::tap::Tap;

/// Where a stage's values go.
pub trait Writes<V: Vector> {
    /// Writes x, with the quantizer's own input fraction, without a word to the tap.
    fn code(&mut self, q: &Register, x: V) -> V;

    /// Writes x with right shifts of its own, without a word to the tap; codes of `most` and more in magnitude count
    /// as in range.
    fn shift_code(&mut self, q: &Register, x: V, right: V, most: i64) -> V;

    /// `Writes::shifted` for shifts of either direction: a negative `right` shifts left.
    fn shift_either(&mut self, q: &Register, c: usize, x: V, right: V, exponent: V) -> V;

    /// Normalises into a block register, or with `right` shifts by as much: mantissas, and their fraction bits.
    fn normalize<const C: usize>(
        &mut self,
        q: &Register,
        x: &[V; C],
        frac: V,
        right: Option<V>,
    ) -> ([V; C], V);

    /// A port of a number, which is divided by 2^`exponent`; clears `finite` where it is not.
    fn number(&mut self, q: &Register, c: usize, word: V, exponent: V, finite: &mut V::Mask) -> V;

    /// A port of a vector: mantissas, and their fraction bits; clears `finite` where a component is not.
    fn vector(&mut self, q: &Register, words: [V; 3], finite: &mut V::Mask) -> ([V; 3], V);

    /// Tells the tap of a component with its fraction bits.
    fn tell(&mut self, q: &Register, c: usize, code: V, frac: V);

    /// Notes an event where it happened. Whether its consequences have to be computed here.
    fn event(&mut self, event: Event, happened: V::Mask) -> bool;

    /// Writes x, with the quantizer's own input fraction, to a fixed register whose nominal scale is 2^`exponent` in
    /// true units.
    #[inline(always)]
    fn put(&mut self, q: &Register, c: usize, x: V, exponent: V) -> V {
        let code = self.code(q, x);
        self.tell(q, c, code, exponent.like(q.frac()) - exponent);
        code
    }

    /// Writes x with right shifts of its own.
    #[inline(always)]
    fn shifted(&mut self, q: &Register, c: usize, x: V, right: V, exponent: V) -> V {
        let code = self.shift_code(q, x, right, i64::MAX);
        self.tell(q, c, code, exponent.like(q.frac()) - exponent);
        code
    }

    /// Normalises into a block register: mantissas, and their fraction bits.
    #[inline(always)]
    fn normal<const C: usize>(
        &mut self,
        q: &Register,
        x: &[V; C],
        frac: V,
        exponent: V,
    ) -> ([V; C], V) {
        let (m, frac) = self.normalize(q, x, frac, None);
        for (c, m) in m.iter().enumerate() {
            self.tell(q, c, *m, frac - exponent);
        }
        (m, frac)
    }
}

impl<T: Tap> Writes<i64> for Sink<'_, T> {
    #[inline(always)]
    fn code(&mut self, q: &Register, x: i64) -> i64 {
        let (code, over) = q.write_fixed_as(T::STANDARD, x);
        self.flags.register(q.reg, over);
        code
    }

    #[inline(always)]
    fn shift_code(&mut self, q: &Register, x: i64, right: i64, most: i64) -> i64 {
        let (code, over) = q.write_as(T::STANDARD, x, right);
        self.flags.register(q.reg, over && code.abs() < most);
        code
    }

    #[inline(always)]
    fn shift_either(&mut self, q: &Register, c: usize, x: i64, right: i64, exponent: i64) -> i64 {
        self.shifted(q, c, x, right, exponent)
    }

    #[inline(always)]
    fn normalize<const C: usize>(
        &mut self,
        q: &Register,
        x: &[i64; C],
        frac: i64,
        right: Option<i64>,
    ) -> ([i64; C], i64) {
        let out = match right {
            Some(right) => block::shifted(T::STANDARD, q, x, frac, right),
            None => block::normalize(T::STANDARD, q, x, frac),
        };
        (out.m, out.frac)
    }

    #[inline(always)]
    fn number(
        &mut self,
        q: &Register,
        c: usize,
        word: i64,
        exponent: i64,
        finite: &mut bool,
    ) -> i64 {
        self.scalar_port(q, c, word.cast_unsigned(), exponent, finite)
    }

    #[inline(always)]
    fn vector(&mut self, q: &Register, words: [i64; 3], finite: &mut bool) -> ([i64; 3], i64) {
        let block = self.vector_port(q, words.map(i64::cast_unsigned), finite);
        (block.m, block.frac)
    }

    #[inline(always)]
    fn tell(&mut self, q: &Register, c: usize, code: i64, frac: i64) {
        self.tap.put(self.lane, q.reg, c, code, frac);
    }

    #[inline(always)]
    fn event(&mut self, event: Event, happened: bool) -> bool {
        self.flags.event(event, happened);
        happened
    }
}

/// Writes of a standard unit, to which nobody listens.
#[derive(Debug)]
pub(crate) struct Fast<S: Simd> {
    simd: S,
    /// Not 0 where a lane left the plain case.
    beyond: S::I,
}

impl<S: Simd> Fast<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S) -> Self {
        Self { simd, beyond: simd.splat(0) }
    }

    /// Whether a lane left the plain case.
    #[inline(always)]
    pub(crate) fn beyond(&self) -> bool {
        self.beyond.any()
    }

    /// Notes codes that are not in the register's range.
    #[inline(always)]
    fn check(&mut self, q: &Quantizer, y: S::I) {
        let (bias, beyond) = (-q.format.min_raw(), !(q.format.max_raw() - q.format.min_raw()));
        self.beyond = self.beyond | y.plus(bias).and(beyond);
    }

    /// Notes negative numbers.
    #[inline(always)]
    fn not_negative(&mut self, x: S::I) {
        self.beyond = self.beyond | x.and(i64::MIN);
    }
}

/// x·2^−right to nearest, ties to even; right from 0 to 63.
#[inline(always)]
fn half_even<V: Vector>(x: V, right: V) -> V {
    let mask = !x.like(-1).shl(right);
    let odd = x.sra(right) & mask.and(1);
    (x + mask.shr(x.like(1)) + odd).sra(right)
}

impl<S: Simd> Writes<S::I> for Fast<S> {
    #[inline(always)]
    fn code(&mut self, q: &Register, x: S::I) -> S::I {
        let r = q.lanes;
        let y = (x.plus(r.low) + x.down(r.down).and(r.odd)).down(r.down);
        self.beyond = self.beyond | y.plus(r.bias).and(r.beyond);
        y
    }

    #[inline(always)]
    fn shift_code(&mut self, q: &Register, x: S::I, right: S::I, _: i64) -> S::I {
        self.not_negative(right);
        let y = half_even(x, right.smaller(right.like(63)));
        self.check(q, y);
        y
    }

    #[inline(always)]
    fn shift_either(&mut self, q: &Register, _: usize, x: S::I, right: S::I, _: S::I) -> S::I {
        let y = half_even(x, right.limit(0, 63));
        let left = (-right).larger(right.like(0));
        let code = y.shl(left);
        self.beyond = self.beyond | (code.sra(left.smaller(left.like(63))) ^ y);
        self.check(q, code);
        code
    }

    #[inline(always)]
    fn normalize<const C: usize>(
        &mut self,
        q: &Register,
        x: &[S::I; C],
        frac: S::I,
        right: Option<S::I>,
    ) -> ([S::I; C], S::I) {
        let (width, max) = (q.bits(), q.format.max_raw());
        let right = match right {
            Some(right) => right,
            None => {
                let mut any = x[0].abs();
                for x in &x[1..] {
                    any = any | x.abs();
                }
                let shift = any.like(64 - width) - any.leading_zeros();
                any.zero().select(any.like(0), shift)
            }
        };
        // So far that the block's leading one is two below the sign, then rounded by one shift for all lanes. Ones that
        // round up to the next power of two stay at the largest code.
        let down = 62 - width;
        let up = right.like(down) - right;
        self.not_negative(up);
        let low = (1i64 << (down - 1)) - 1;
        let mut m = *x;
        for m in &mut m {
            let y = m.shl(up);
            *m = (y.plus(low) + y.down(down).and(1)).down(down).limit(-max, max);
        }
        (m, frac - right)
    }

    #[inline(always)]
    fn number(
        &mut self,
        q: &Register,
        _: usize,
        word: S::I,
        exponent: S::I,
        _: &mut <S::I as Vector>::Mask,
    ) -> S::I {
        let parts = Parts::new(word, &mut self.beyond);
        // Less than 1 overflows any register of up to 50 bits; beyond 62 nothing is left.
        let right = (exponent.plus(UNIT - q.frac()) - parts.biased).limit(1, 62);
        let code = parts.round(right, i64::MAX);
        self.check(q, code);
        if q.format.magnitude_bits() > 50 {
            self.beyond = self.simd.splat(1);
        }
        code
    }

    #[inline(always)]
    fn vector(
        &mut self,
        q: &Register,
        words: [S::I; 3],
        _: &mut <S::I as Vector>::Mask,
    ) -> ([S::I; 3], S::I) {
        let (width, max) = (q.bits(), q.format.max_raw());
        let [x, y, z] = words;
        let [x, y, z] = [
            Parts::new(x, &mut self.beyond),
            Parts::new(y, &mut self.beyond),
            Parts::new(z, &mut self.beyond),
        ];
        let top = x.biased.larger(y.biased).larger(z.biased);
        let frac = top.like(UNIT - 53 + width) - top;
        let frac = top.zero().select(top.like(width - 1), frac);
        let mut m = [top; 3];
        for (m, parts) in m.iter_mut().zip([x, y, z]) {
            let right = (top.plus(53 - width) - parts.biased).smaller(top.like(62));
            *m = parts.round(right, max);
        }
        (m, frac)
    }

    #[inline(always)]
    fn tell(&mut self, _: &Register, _: usize, _: S::I, _: S::I) {}

    #[inline(always)]
    fn event(&mut self, _: Event, happened: <S::I as Vector>::Mask) -> bool {
        let zero = self.simd.splat(0);
        self.beyond = self.beyond | happened.select(zero.like(1), zero);
        false
    }
}

/// Biased exponent of a binary64 number whose last fraction bit is 1.
const UNIT: i64 = 1075;

/// The parts of binary64 words; none of them subnormal or not finite, or it is noted.
#[derive(Clone, Copy)]
struct Parts<V> {
    magnitude: V,
    biased: V,
    /// All ones where negative.
    sign: V,
}

impl<V: Vector> Parts<V> {
    #[inline(always)]
    fn new(word: V, beyond: &mut V) -> Self {
        const FRACTION: i64 = (1 << 52) - 1;
        const EXPONENT: i64 = 0x7ff;
        let (biased, fraction) = (word.down(52).and(EXPONENT), word.and(FRACTION));
        let (zero, one) = (word.like(0), word.like(1));
        let none = biased.zero();
        let infinite = biased.same(word.like(EXPONENT)).select(one, zero);
        *beyond = *beyond | none.select(fraction, zero) | infinite;
        let magnitude = none.select(zero, fraction | word.like(1 << 52));
        Self { magnitude, biased, sign: word.down(63) }
    }

    /// The numbers shifted right by 1 to 62 bits, to nearest, ties to even, of magnitudes up to `max`.
    #[inline(always)]
    fn round(&self, right: V, max: i64) -> V {
        let m = half_even(self.magnitude, right).smaller(right.like(max));
        (m ^ self.sign) - self.sign
    }
}

/// Numbers of lanes in an array: of some lanes as a vector, of a block's.
pub(crate) trait Place<S: Simd> {
    /// The numbers of the lanes that a vector has.
    type Values;
    /// Those from `at` on.
    fn load(&self, simd: S, at: usize) -> Self::Values;
    /// Puts them there.
    fn store(&mut self, at: usize, values: Self::Values);
}

impl<S: Simd, const N: usize> Place<S> for [i64; N] {
    type Values = S::I;

    #[inline(always)]
    fn load(&self, simd: S, at: usize) -> S::I {
        simd.load(self, at)
    }

    #[inline(always)]
    fn store(&mut self, at: usize, values: S::I) {
        values.store(self, at);
    }
}

impl<S: Simd, const N: usize, const C: usize> Place<S> for [[i64; N]; C] {
    type Values = [S::I; C];

    #[inline(always)]
    fn load(&self, simd: S, at: usize) -> [S::I; C] {
        let mut out = [simd.splat(0); C];
        for (out, from) in out.iter_mut().zip(self) {
            *out = simd.load(from, at);
        }
        out
    }

    #[inline(always)]
    fn store(&mut self, at: usize, values: [S::I; C]) {
        for (to, values) in self.iter_mut().zip(values) {
            values.store(to, at);
        }
    }
}

/// What an array holds before anything was written.
pub(crate) trait Zero {
    /// Zeros.
    const ZERO: Self;
}

impl<const N: usize> Zero for [i64; N] {
    const ZERO: Self = [0; N];
}

impl<const N: usize, const C: usize> Zero for [[i64; N]; C] {
    const ZERO: Self = [[0; N]; C];
}

/// A struct of numbers with a type for one of them, `V`: a vector, or an array with a block's lanes.
macro_rules! in_lanes {
    ($(#[$doc:meta])* pub struct $name:ident<V> { $($(#[$about:meta])* pub $field:ident: $kind:ty,)+ }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug)]
        pub struct $name<V> { $($(#[$about])* pub $field: $kind),+ }

        impl<const N: usize> Default for $name<[i64; N]> {
            fn default() -> Self {
                Self { $($field: $crate::lanes::Zero::ZERO),+ }
            }
        }

        impl<S: lanes::Simd, const N: usize> $crate::lanes::Place<S> for $name<[i64; N]> {
            type Values = $name<S::I>;

            #[inline(always)]
            fn load(&self, simd: S, at: usize) -> $name<S::I> {
                $name { $($field: $crate::lanes::Place::load(&self.$field, simd, at)),+ }
            }

            #[inline(always)]
            fn store(&mut self, at: usize, values: $name<S::I>) {
                $($crate::lanes::Place::<S>::store(&mut self.$field, at, values.$field);)+
            }
        }
    };
}
pub(crate) use in_lanes;
