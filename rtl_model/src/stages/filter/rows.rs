//! Texel rows: the two rows of two texels of several footprints, times their weights.

use crate::stages::address::lanes::{Footprints, LOW};
use crate::texel::{PACKED_MANTISSA, PACKED_SHIFT, PACKED_STARTS};

/// Exact bilinear sums: channel by channel, lane by lane.
pub type Sums<const W: usize> = [[u64; W]; 3];

/// Memory that yields weighted sums of footprints.
pub trait Rows {
    /// The sum of each lane's four texels times their weights.
    fn sums<const W: usize>(&self, at: &Footprints<W>) -> Sums<W>;
}

/// Texels decoded beforehand.
#[derive(Clone, Copy, Debug)]
pub struct Wide<'a>(pub &'a [[i64; 4]]);

impl Rows for Wide<'_> {
    #[inline(always)]
    fn sums<const W: usize>(&self, at: &Footprints<W>) -> Sums<W> {
        let mut sums = [[0; W]; 3];
        for lane in 0..at.len.min(W) {
            let [t0, t1] = pair(self.0, at.upper[lane]);
            let [t2, t3] = pair(self.0, at.lower[lane]);
            for (c, sum) in sums.iter_mut().enumerate() {
                let four = [t0[c], t1[c], t2[c], t3[c]];
                for (texel, weight) in four.into_iter().zip(&at.weight) {
                    sum[lane] += texel.cast_unsigned() * weight[lane];
                }
            }
        }
        sums
    }
}

/// Packed halves ([`crate::texel::pack`]), decoded on the way.
#[derive(Clone, Copy, Debug)]
pub struct Half<'a>(pub &'a [u64]);

impl Half<'_> {
    /// The four texels of each lane, upper left to lower right.
    #[inline(always)]
    fn texels<const W: usize>(&self, at: &Footprints<W>) -> [[u64; W]; 4] {
        let mut texels = [[0; W]; 4];
        for lane in 0..W {
            [texels[0][lane], texels[1][lane]] = pair(self.0, at.upper[lane]);
            [texels[2][lane], texels[3][lane]] = pair(self.0, at.lower[lane]);
        }
        texels
    }
}

impl Rows for Half<'_> {
    #[inline(always)]
    fn sums<const W: usize>(&self, at: &Footprints<W>) -> Sums<W> {
        let texels = self.texels(at);
        let mut sums = [[0; W]; 3];
        for (texels, weights) in texels.iter().zip(&at.weight) {
            for (sum, start) in sums.iter_mut().zip(PACKED_STARTS) {
                for lane in 0..W {
                    // 11 bits of mantissa times 17 bits of weight; the exponent shifts afterwards.
                    let m = (texels[lane] >> start) & ((1 << PACKED_MANTISSA) - 1);
                    let shift =
                        (texels[lane] >> (start + PACKED_MANTISSA)) & ((1 << PACKED_SHIFT) - 1);
                    sum[lane] += (m * (weights[lane] & LOW)) << shift;
                }
            }
        }
        sums
    }
}

/// Two neighbouring texels; zeros beyond the memory, which no lane in use reaches.
#[inline(always)]
fn pair<X: Copy + Default>(texels: &[X], at: u64) -> [X; 2] {
    let at = usize::try_from(at).unwrap_or(usize::MAX);
    match texels.get(at..).and_then(|rest| rest.first_chunk()) {
        Some(two) => *two,
        None => [X::default(); 2],
    }
}
