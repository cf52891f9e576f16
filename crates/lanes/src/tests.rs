//! Every operation of every level against plain integers.

use std::vec::Vec;

use crate::{Level, Mask as _, Runs as _, Simd, Task, Vector};

/// Numbers of all sizes, and the ends.
fn numbers() -> Vec<i64> {
    let mut x = 0x9e37_79b9_7f4a_7c15_u64;
    let mut out = std::vec![0, 1, -1, i64::MAX, i64::MIN, 1 << 31, -(1 << 31), (1 << 32) - 1];
    while out.len() < 1024 {
        x = x.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        out.push(x.cast_signed() >> (x.rotate_left(13) % 64));
    }
    out
}

/// One operation on vectors of 8 numbers.
struct Each<F>([i64; 8], [i64; 8], F);

trait Operation {
    fn of<V: Vector>(&self, a: V, b: V) -> V;
}

impl<F: Operation> Task for Each<F> {
    type Output = [i64; 8];

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> [i64; 8] {
        let mut out = [0; 8];
        for at in (0..8).step_by(S::I::LEN) {
            self.2.of(simd.load(&self.0, at), simd.load(&self.1, at)).store(&mut out, at);
        }
        out
    }
}

macro_rules! agree {
    ($name:ident, |$a:ident, $b:ident| $of:expr, |$x:ident, $y:ident| $plain:expr) => {
        #[test]
        fn $name() {
            struct This;
            impl Operation for This {
                #[inline(always)]
                fn of<V: Vector>(&self, $a: V, $b: V) -> V {
                    $of
                }
            }
            let numbers = numbers();
            for level in Level::available() {
                for (k, a) in numbers.chunks(8).enumerate() {
                    for b in numbers.chunks(8).skip(k % 7) {
                        let (a, b) = (a.try_into().unwrap(), b.try_into().unwrap());
                        let found = level.run(Each(a, b, This));
                        for i in 0..8 {
                            let ($x, $y): (i64, i64) = (a[i], b[i]);
                            assert_eq!(found[i], $plain, "{}: {}, {}", level.name(), a[i], b[i]);
                        }
                    }
                }
            }
        }
    };
}

fn low(x: i64) -> i64 {
    x << 32 >> 32
}

fn half(x: i64) -> i64 {
    x >> 1
}

agree!(sums, |a, b| a.down(1) + b.down(1), |a, b| half(a) + half(b));
agree!(differences, |a, b| a.down(1) - b.down(1), |a, b| half(a) - half(b));
agree!(negatives, |a, b| -(a.down(1)) ^ !b, |a, b| -half(a) ^ !b);
agree!(bits, |a, b| (a & b) | (b ^ a.and(99)), |a, b| (a & b) | (b ^ (a & 99)));
agree!(products, |a, b| a.up(32).down(32).mul(b.up(32).down(32)), |a, b| low(a) * low(b));
agree!(unsigned_products, |a, b| a.and(0x7fff_ffff).mul_unsigned(b.and(0xffff_ffff)), |a, b| (a
    & 0x7fff_ffff)
    * (b & 0xffff_ffff));
agree!(wide_products, |a, b| a.down(31).mul_wide(b.down(33)), |a, b| (a >> 31) * (b >> 33));
agree!(left_shifts, |a, b| a.shl(b.and(63)), |a, b| a << (b & 63));
agree!(right_shifts, |a, b| a.sra(b.and(63)), |a, b| a >> (b & 63));
agree!(zero_shifts, |a, b| a.shr(b.and(63)), |a, b| (a.cast_unsigned() >> (b & 63)).cast_signed());
agree!(smaller, |a, b| a.smaller(b), |a, b| Ord::min(a, b));
agree!(larger, |a, b| a.larger(b), |a, b| Ord::max(a, b));
agree!(magnitudes, |a, b| a.abs() ^ b, |a, b| a.wrapping_abs() ^ b);
agree!(zeros, |a, b| a.leading_zeros() + b.and(1), |a, b| i64::from(a.leading_zeros()) + (b & 1));
agree!(choices, |a, b| (a.gt(b) | !a.same(a.and(-2)) & b.negative()).select(a, b), |a, b| if a > b
    || (a & 1 == 1 && b < 0)
{
    a
} else {
    b
});
agree!(
    look_ups,
    |a, b| (a.and(7) ^ b.negative().select(a, a.like(0))).look_up(&[5, -6, 7, 8]),
    |a, b| {
        let at = (a & 7) ^ if b < 0 { a } else { 0 };
        usize::try_from(at).ok().and_then(|at| [5, -6, 7, 8].get(at)).copied().unwrap_or(0)
    }
);
agree!(quotients, |a, b| a.div_rem(12).0 ^ b.div_rem(7).1, |a, b| (a / 12) ^ (b % 7));
agree!(anything, |a, b| a.like(i64::from((a ^ b).any() || !(a ^ b).any())), |_a, _b| 1);

/// Rows of 16-bit floats, and a store at a place that is no multiple of the lanes.
struct Rows([[u64; 2]; 2], [i64; 4]);

impl Task for Rows {
    type Output = ([i64; 4], [i64; 16]);

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let mut sums = [7, 6, 5, 4, 0, 0, 0, 0];
        simd.add_rows::<11>(self.0, self.1, &mut sums);
        let mut out = [0; 16];
        for at in (0..8).step_by(S::I::LEN) {
            simd.load(&[1, 2, 3, 4, 5, 6, 7, 8], at).put(&mut out, at + 5);
        }
        ([0, 1, 2, 3].map(|c| sums[c] + sums[c + 4]), out)
    }
}

#[test]
fn rows_of_floats() {
    let words = numbers();
    for (k, words) in words.chunks(4).enumerate() {
        let words: Vec<u64> = words.iter().map(|x| x.cast_unsigned()).collect();
        let rows = [[words[0], words[1]], [words[2], words[3]]];
        let weights = [0, 1, 0x1_0000, 99 * i64::try_from(k).unwrap()];
        let expected = [0, 1, 2, 3].map(|c| {
            let four = words.iter().zip(weights).map(|(word, weight)| {
                let float = (word >> (16 * c)) & 0xffff;
                ((float & 0x7ff).cast_signed() * weight) << (float >> 11)
            });
            [7, 6, 5, 4][c] + four.sum::<i64>()
        });
        for level in Level::available() {
            let (sums, out) = level.run(Rows(rows, weights));
            assert_eq!(sums, expected, "{}", level.name());
            assert_eq!(out[5..13], [1, 2, 3, 4, 5, 6, 7, 8], "{}", level.name());
        }
    }
}
