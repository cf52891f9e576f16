//! The filter of a block of fragments: one row of footprints, several addressed at a time, each one's texels and
//! channels summed at a time.
//!
//! For standard units to which nobody listens, with box weights, exact bilinear sums and packed texels.

use lanes::{Simd, Vector};

use super::Cfg;
use crate::fx::Flags;
use crate::lanes::Place as _;
use crate::regs::{Event, Reg};
use crate::stages::Roms;
use crate::stages::address::block::Block;
use crate::texel::PACKED_MANTISSA;
use crate::texture::Level;

/// The texture requests of a block.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Requests<'a, const N: usize> {
    /// Lanes in use.
    pub(crate) len: usize,
    /// Faces.
    pub(crate) face: &'a [i64; N],
    /// (u, v) with the registers' fraction bits.
    pub(crate) center: [&'a [i64; N]; 2],
    /// Half the spacing of the probes.
    pub(crate) step: &'a [[i64; N]; 2],
    /// Fraction bits of `step`.
    pub(crate) step_frac: i64,
    /// Probes.
    pub(crate) count: &'a [i64; N],
    /// Levels of detail.
    pub(crate) lod: &'a [i64; N],
}

/// Where the results of a block go.
#[derive(Debug)]
pub(crate) struct Filtered<'a, const N: usize> {
    /// RGB with the register's fraction bits.
    pub(crate) color: &'a mut [[i64; 3]; N],
    /// Texels read.
    pub(crate) texels: &'a mut [u64; N],
    /// Sticky flags.
    pub(crate) flags: &'a mut [Flags; N],
}

/// Footprints of fragments, one after the other.
struct List {
    len: usize,
    /// u + 1 and v + 1.
    at: [[i64; ROOM]; 2],
    /// Columns, and rows from bit 32 on.
    size: [i64; ROOM],
    /// Index of the first texel of the face.
    base: [i64; ROOM],
    /// Lane of the fragment and level, and the face from bit `FACE` on.
    from: [i64; ROOM],
}

const ROOM: usize = 256;
const FACE: i64 = 32;
const LOW: i64 = 0xffff_ffff;
/// Numbers from 0 on.
const RISING: [i64; 8] = [0, 1, 2, 3, 4, 5, 6, 7];

/// Sums of the levels of a fragment, twice four channels.
type Sums<const N: usize> = [[[i64; 8]; 2]; N];

impl List {
    fn new() -> Self {
        Self { len: 0, at: [[0; ROOM]; 2], size: [0; ROOM], base: [0; ROOM], from: [0; ROOM] }
    }

    /// Adds the probes of a fragment in a level: those of the line from `at` on by `step`.
    #[inline(always)]
    fn add<S: Simd>(
        &mut self,
        simd: S,
        count: i64,
        [at, step]: [[S::I; 2]; 2],
        (level, face, from): (&Level, i64, i64),
    ) {
        let [columns, rows, offset, stride] =
            [level.size[0], level.size[1], level.offset, level.face_stride]
                .map(|n| i64::try_from(n).unwrap_or(0));
        let size = simd.splat(columns | rows << 32);
        let base = simd.splat(offset + face * stride);
        let from = simd.splat(from | face << FACE);
        let mut at = at;
        let mut left = usize::try_from(count).unwrap_or(0);
        loop {
            at[0].put(&mut self.at[0], self.len);
            at[1].put(&mut self.at[1], self.len);
            size.put(&mut self.size, self.len);
            base.put(&mut self.base, self.len);
            from.put(&mut self.from, self.len);
            self.len += left.min(S::I::LEN);
            if left <= S::I::LEN {
                return;
            }
            left -= S::I::LEN;
            at = [at[0] + step[0], at[1] + step[1]];
        }
    }

    /// Adds the sums of all footprints up, and forgets them.
    #[inline(always)]
    fn sum<S: Simd, const N: usize>(
        &mut self,
        simd: S,
        (address, roms, texels): (&Block<'_>, &Roms, &[u64]),
        sums: &mut Sums<N>,
        flags: &mut [Flags; N],
    ) {
        let len = core::mem::take(&mut self.len).min(ROOM);
        for first in (0..len).step_by(S::I::LEN) {
            let used = (len - first).min(S::I::LEN);
            let mut at = self.at.load(simd, first);
            let size = simd.load(&self.size, first);
            let mut base = simd.load(&self.base, first);
            let size = [size.and(LOW), size.shr(size.like(32))];
            let beyond = address.beyond(at);
            if beyond.and(i64::MIN).any() {
                let face = simd.load(&self.from, first).down(FACE);
                let moved = address.moved(roms, face, at, beyond);
                at = moved.at;
                let texels = size[0].plus(2).mul_unsigned(size[1].plus(2));
                base = base + (moved.face - face).mul_wide(texels);
                if address.has_faces() {
                    let mut left = [0; 8];
                    beyond.put(&mut left, 0);
                    for (left, from) in left.iter().zip(&self.from[first..]).take(used) {
                        flags[lane_of::<N>(*from)].event(Event::AddressOtherFace, *left < 0);
                    }
                    for (lost, q) in moved.lost.into_iter().zip(address.registers()) {
                        let mut over = [0; 8];
                        lost.put(&mut over, 0);
                        for (over, from) in over.iter().zip(&self.from[first..]).take(used) {
                            flags[lane_of::<N>(*from)].register(q.reg, *over != 0);
                        }
                    }
                }
            }
            let found = address.footprints(at, size, base);
            let lower = found.at + size[0].plus(2);
            let (mut rows, mut weights) = ([[0; 8]; 2], [[0; 8]; 4]);
            found.at.put(&mut rows[0], 0);
            lower.put(&mut rows[1], 0);
            for (weights, weight) in weights.iter_mut().zip(found.weight) {
                weight.put(weights, 0);
            }
            for i in 0..used.min(8) {
                let from = self.from[(first + i) & (ROOM - 1)];
                let rows = [pair(texels, rows[0][i]), pair(texels, rows[1][i])];
                let weights = [weights[0][i], weights[1][i], weights[2][i], weights[3][i]];
                let level = usize::from(from & 1 != 0);
                let sums = &mut sums[lane_of::<N>(from)][level];
                simd.add_rows::<PACKED_MANTISSA>(rows, weights, sums);
            }
        }
    }
}

/// The lane of a footprint.
#[inline(always)]
fn lane_of<const N: usize>(from: i64) -> usize {
    usize::try_from((from & LOW) >> 1).unwrap_or(0) & (N - 1)
}

/// Two neighbouring texels; zeros beyond the memory, which no footprint reaches.
#[inline(always)]
fn pair(texels: &[u64], at: i64) -> [u64; 2] {
    let at = usize::try_from(at).unwrap_or(usize::MAX);
    texels.get(at..).and_then(|rest| rest.first_chunk()).copied().unwrap_or_default()
}

impl Cfg {
    /// Whether [`filter`] does: box weights, exact sums, and a colour that is no finer than they are.
    pub(crate) fn plain(&self) -> bool {
        let down = self.color_shift - 1;
        self.bilinear.is_none() && self.weights.is_empty() && (0..=62).contains(&down)
    }

    /// [`Cfg::level`] of lanes.
    #[inline(always)]
    fn levels<V: Vector>(&self, lod: V, last: usize) -> [V; 2] {
        let whole = lod.down(self.lod_frac);
        let part = lod - whole.up(self.lod_frac);
        let weight = if self.lod_shift > 0 {
            part.plus(1 << (self.lod_shift - 1)).down(self.lod_shift)
        } else {
            part.up(-self.lod_shift)
        };
        let (last, none) = (lod.like(i64::try_from(last).unwrap_or(0)), lod.like(0));
        let level = whole.larger(none);
        let inside = last.gt(level);
        [level.smaller(last), lanes::Mask::select(inside, weight, none)]
    }

    /// ⌊2·sum/2^color_shift⌋ and whether a remainder is left, of two levels' sums that are not negative.
    #[inline(always)]
    fn both<V: Vector>(&self, [a, b]: [V; 2], weight: V) -> [V; 2] {
        let (other, word) = (weight.like(1 << self.lod_bits) - weight, a.like(32));
        let low = a.and(LOW).mul_unsigned(other) + b.and(LOW).mul_unsigned(weight);
        let high = a.shr(word).mul_unsigned(other) + b.shr(word).mul_unsigned(weight);
        let (high, low) = (high + low.shr(word), low.and(LOW));
        let down = self.color_shift - 1;
        if down < 32 {
            [high.up(32 - down) | low.down(down), low.and((1 << down) - 1)]
        } else {
            [high.down(down - 32), low | high.and((1 << (down - 32)) - 1)]
        }
    }

    /// The colours of a block from its sums.
    #[inline(always)]
    fn colors<S: Simd, const N: usize>(
        &self,
        simd: S,
        sums: &Sums<N>,
        (weights, requests): (&[i64; N], &Requests<'_, N>),
        out: &mut Filtered<'_, N>,
    ) {
        let len = requests.len.min(N);
        let mut totals = [[[0; N]; 3]; 2];
        for (lane, sums) in sums.iter().enumerate().take(len) {
            for (totals, sums) in totals.iter_mut().zip(sums) {
                for (c, totals) in totals.iter_mut().enumerate() {
                    totals[lane] = sums[c] + sums[c + 4];
                }
            }
        }
        let (mut heads, mut tails) = ([[0; N]; 3], [[0; N]; 3]);
        for at in (0..len).step_by(S::I::LEN) {
            let weight = simd.load(weights, at);
            for c in 0..3 {
                let both = [simd.load(&totals[0][c], at), simd.load(&totals[1][c], at)];
                let [head, tail] = self.both(both, weight);
                head.store(&mut heads[c], at);
                tail.store(&mut tails[c], at);
            }
        }
        for lane in 0..len {
            let count = requests.count[lane];
            let place = usize::try_from(count).unwrap_or(0);
            let inv = self.inv_count.get(place).copied().unwrap_or(u64::MAX);
            let mut over_any = false;
            for c in 0..3 {
                let head = heads[c][lane];
                let high = (u128::from(head.cast_unsigned()) * u128::from(inv)) >> 64;
                let quotient = if count == 1 { head } else { super::narrow(high.cast_signed()) };
                let sticky = tails[c][lane] | (head - quotient * count);
                let code = (quotient << 1) | i64::from(sticky != 0);
                let (code, over) = self.color.write_as(true, code, 2);
                over_any |= over;
                out.color[lane][c] = code;
            }
            out.flags[lane].register(Reg::FilterColor, over_any);
        }
    }
}

/// The stage for a block, its addresses included.
#[inline(always)]
pub(crate) fn filter<S: Simd, const N: usize>(
    simd: S,
    (cfg, address, roms): (&Cfg, &Block<'_>, &Roms),
    (levels, texels): (&[Level], &[u64]),
    requests: &Requests<'_, N>,
    out: &mut Filtered<'_, N>,
) {
    let len = requests.len.min(N);
    let last = levels.len().saturating_sub(1);
    let (mut first, mut step) = ([[0; N]; 2], [[0; N]; 2]);
    let (mut level, mut weight) = ([0; N], [0; N]);
    for at in (0..len).step_by(S::I::LEN) {
        let count = simd.load(requests.count, at);
        for i in 0..2 {
            let line = [simd.load(requests.center[i], at), simd.load(&requests.step[i], at)];
            let [from, by] = address.line(i, line, requests.step_frac, count);
            from.store(&mut first[i], at);
            by.store(&mut step[i], at);
        }
        let [whole, part] = cfg.levels(simd.load(requests.lod, at), last);
        whole.store(&mut level, at);
        part.store(&mut weight, at);
    }
    let mut list = List::new();
    let mut sums = [[[0; 8]; 2]; N];
    let rising = simd.load(&RISING, 0);
    let mut lane = 0;
    loop {
        while lane < len {
            let count = requests.count[lane];
            let most = 2 * (usize::try_from(count).unwrap_or(0) + S::I::LEN);
            if list.len > 0 && list.len + most > ROOM {
                break;
            }
            let (mut at, mut by) = ([rising; 2], [rising; 2]);
            for i in 0..2 {
                let step = simd.splat(step[i][lane]);
                at[i] = step.mul_wide(rising).plus(first[i][lane]);
                by[i] = step.up(S::I::LEN.ilog2().into());
            }
            let two = usize::from(weight[lane] != 0);
            let from = i64::try_from(lane).unwrap_or(0) << 1;
            let face = requests.face[lane];
            let start = usize::try_from(level[lane]).unwrap_or(0);
            for (l, level) in (0..=1).zip(levels.iter().skip(start).take(1 + two)) {
                list.add(simd, count, [at, by], (level, face, from | l));
            }
            out.texels[lane] = count.unsigned_abs() << (2 + two);
            lane += 1;
        }
        if list.len == 0 {
            break;
        }
        list.sum(simd, (address, roms, texels), &mut sums, out.flags);
    }
    cfg.colors(simd, &sums, (&weight, requests), out);
}
