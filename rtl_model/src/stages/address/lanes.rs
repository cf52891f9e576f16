//! Several footprints of a probe line at a time: lanes over probes and their one or two levels.
//!
//! Where nothing rounds but the texel coordinate, and as long as probes stay on their face, an address
//! is a handful of operations that every vector unit has. Everything else goes probe by probe through
//! [`address`](super::address()) and [`Cfg::taps`]; both ways write the same registers.

use super::{Cfg, In, address};
use crate::config::Config;
use crate::fx::Rounding;
use crate::regs::Reg;
use crate::stages::{Roms, Sink};
use crate::tap::Tap;
use crate::texture::Level;

/// Low words: tells the compiler that a product is 32 × 32 bits.
pub(crate) const LOW: u64 = 0xffff_ffff;

/// Constants of the lane form.
#[derive(Clone, Copy, Debug, Hash)]
pub(super) struct Lanes {
    /// Fraction bits of u and v.
    pub(super) frac: u32,
    /// Right shift of a texel coordinate with `frac + 1` fraction bits, and its half less one.
    pub(super) shift: u32,
    pub(super) low: u64,
    /// Fraction bits of the texel coordinate.
    pub(super) sub: u32,
    /// A weight from them: (part·2^up + half) >> down.
    pub(super) up: u32,
    pub(super) half: u64,
    pub(super) down: u32,
    /// A whole weight.
    pub(super) full: u64,
    /// Largest face whose coordinates the register holds.
    pub(super) max_size: usize,
}

impl Lanes {
    /// `None` where u or v rounds on the way, a register is too short for its face, or the texel
    /// coordinate does not round half-even.
    pub(super) fn new(config: &Config, common: [i64; 2]) -> Option<Self> {
        let [u, v, s] = [Reg::AddrU, Reg::AddrV, Reg::AddrS].map(|reg| config.format(reg));
        let exact = common == [u, v].map(|f| i64::from(f.frac)) && u.frac == v.frac;
        let holds = u.signed && v.signed && s.signed && u.int >= 1 && v.int >= 1 && u.frac <= 30;
        // A texel has an even number of LSBs: adding one before the rounding changes no tie.
        let rounds = s.rounding == Rounding::HalfEven && (1..=u.frac).contains(&s.frac);
        if !(exact && holds && rounds) {
            return None;
        }
        let down = s.frac.saturating_sub(config.policy.filter.weight_bits);
        Some(Self {
            frac: u.frac,
            shift: u.frac + 1 - s.frac,
            low: (1 << (u.frac - s.frac)) - 1,
            sub: s.frac,
            up: config.policy.filter.weight_bits.saturating_sub(s.frac),
            half: (1 << down) >> 1,
            down,
            full: 1 << config.policy.filter.weight_bits,
            max_size: 1 << s.int.min(20),
        })
    }
}

/// Where the bilinear footprints of `W` lanes lie and what their four texels weigh; lanes without a
/// probe weigh nothing.
#[derive(Clone, Copy, Debug)]
pub struct Footprints<const W: usize> {
    /// Index of the first texel of the upper row.
    pub upper: [u64; W],
    /// Index of the first texel of the lower row.
    pub lower: [u64; W],
    /// Weights: upper left, upper right, lower left, lower right; 2^(2·weight_bits) together.
    pub weight: [[u64; W]; 4],
    /// Lanes in use.
    pub len: usize,
}

/// The footprints of one fragment, `W` at a time: level by level of probe by probe.
#[derive(Clone, Debug)]
pub struct Walk<'a, const W: usize> {
    cfg: &'a Cfg,
    line: &'a In,
    levels: [&'a Level; 2],
    /// log2 of the levels in use.
    two: usize,
    /// The lane form, if the configuration and the faces allow it.
    lanes: Option<&'a Lanes>,
    /// Whether the whole line lies on its face.
    inside: bool,
    /// u + 1 and v + 1 of the lanes' probes.
    at: [[u64; W]; 2],
    step: [u64; 2],
}

impl<'a, const W: usize> Walk<'a, W> {
    /// Starts at the first probe; both levels, or the first one alone. `W` must be even.
    #[inline(always)]
    #[must_use]
    pub fn new(cfg: &'a Cfg, line: &'a In, levels: [&'a Level; 2], both: bool) -> Self {
        let fits = |lanes: &&Lanes| {
            let mut sizes = levels.iter().flat_map(|level| level.size);
            sizes.all(|size| size <= lanes.max_size)
        };
        let lanes = cfg.lanes.as_ref().filter(fits);
        let two = usize::from(both);
        let one = lanes.map_or(0, |lanes| 1u64 << lanes.frac);
        let mut at = [[0; W]; 2];
        let mut step = [0; 2];
        let mut ends = 0;
        for i in 0..2 {
            let half = (line.step[i] << cfg.step_lift(i, line.step_frac)).cast_unsigned();
            let whole = half.wrapping_mul(2);
            let steps = (line.count - 1).cast_unsigned();
            let first = (line.center[i] << cfg.center_lift[i])
                .cast_unsigned()
                .wrapping_add(one)
                .wrapping_sub(half.wrapping_mul(steps));
            ends |= beyond(first, one) | beyond(first.wrapping_add(whole.wrapping_mul(steps)), one);
            let mut along = first;
            let mut next = first.wrapping_add(whole);
            if both {
                next = first;
            }
            for pair in 0..W / 2 {
                at[i][2 * pair] = along;
                at[i][2 * pair + 1] = next;
                let by = whole << (1 - two);
                along = along.wrapping_add(by);
                next = next.wrapping_add(by);
            }
            step[i] = whole;
        }
        Self { cfg, line, levels, two, lanes, inside: ends >> 63 == 0, at, step }
    }

    /// Probes of a step.
    #[inline(always)]
    #[must_use]
    pub fn probes(&self) -> i64 {
        i64::try_from(W >> self.two).unwrap_or(1)
    }

    /// The footprints of probes `k` onwards; `k` must rise by [`Walk::probes`] from call to call.
    #[inline(always)]
    pub fn next<T: Tap>(&mut self, roms: &Roms, k: i64, sink: &mut Sink<'_, T>) -> Footprints<W> {
        let probes = (self.line.count - k).min(self.probes());
        let out = match self.lanes {
            Some(lanes) if self.inside || self.stays(lanes, probes) => {
                self.plain(lanes, k, probes, sink)
            }
            _ => one_by_one(self, roms, k, probes, sink),
        };
        let by = self.probes().cast_unsigned();
        for i in 0..2 {
            let by = self.step[i].wrapping_mul(by);
            for at in &mut self.at[i] {
                *at = at.wrapping_add(by);
            }
        }
        out
    }

    /// Whether the next probes lie on the face: the first and the last of them do.
    #[inline(always)]
    fn stays(&self, lanes: &Lanes, probes: i64) -> bool {
        let one = 1u64 << lanes.frac;
        let mut ends = 0;
        for i in 0..2 {
            let (first, steps) = (self.at[i][0], (probes - 1).cast_unsigned());
            let last = first.wrapping_add(self.step[i].wrapping_mul(steps));
            ends |= beyond(first, one) | beyond(last, one);
        }
        ends >> 63 == 0
    }

    #[inline(always)]
    fn plain<T: Tap>(
        &self,
        lanes: &Lanes,
        k: i64,
        probes: i64,
        sink: &mut Sink<'_, T>,
    ) -> Footprints<W> {
        let one = 1u64 << lanes.frac;
        let len = usize::try_from(probes).unwrap_or(0) << self.two;
        let word = |x: usize| u64::try_from(x).unwrap_or(0);
        let both = |f: fn(&Level) -> usize| self.levels.map(|level| word(f(level)));
        let size = [both(|level| level.size[0]), both(|level| level.size[1])];
        let stride = both(|level| level.stride);
        let face = self.levels.map(|level| word(level.offset + self.line.face * level.face_stride));
        // (u + 1)·N/2 − ½ + 1: the texel coordinate of the bordered face.
        let mut code = [[0u64; W]; 2];
        for i in 0..2 {
            for lane in 0..W {
                let t = ((self.at[i][lane] & LOW) * (size[i][lane & 1] & LOW)).wrapping_add(one);
                let odd = (t >> lanes.shift) & 1;
                code[i][lane] = t.wrapping_add(lanes.low + odd) >> lanes.shift;
            }
        }
        let mut out = Footprints { upper: [0; W], lower: [0; W], weight: [[0; W]; 4], len };
        let part = (1u64 << lanes.sub) - 1;
        for lane in 0..W {
            let [s, t] = [code[0][lane], code[1][lane]];
            let at = ((t >> lanes.sub) & LOW) * (stride[lane & 1] & LOW);
            out.upper[lane] = (face[lane & 1] + (s >> lanes.sub)).wrapping_add(at);
            out.lower[lane] = out.upper[lane].wrapping_add(stride[lane & 1]);
            let used = if lane < len { LOW } else { 0 };
            let weight = |code: u64| (((code & part) << lanes.up) + lanes.half) >> lanes.down;
            let [x, y] = [weight(s) & LOW, weight(t) & LOW];
            let [left, above] = [(lanes.full - x) & used, (lanes.full - y) & LOW];
            let x = x & used;
            out.weight[0][lane] = left * above;
            out.weight[1][lane] = x * above;
            out.weight[2][lane] = left * y;
            out.weight[3][lane] = x * y;
        }
        // Nothing is left of this where nobody listens.
        let frac = i64::from(lanes.frac);
        let texel = 1i64 << lanes.sub;
        for lane in 0..len {
            let index = usize::try_from(k).unwrap_or(0) + (lane >> self.two);
            let level = lane & self.two;
            for (i, reg) in [Reg::AddrU, Reg::AddrV].into_iter().enumerate() {
                let uv = self.at[i][lane].wrapping_sub(one).cast_signed();
                if level == 0 {
                    sink.tap.put(sink.lane, reg, index, uv, frac);
                }
                let s = code[i][lane].cast_signed() - texel;
                let component = 4 * index + 2 * level + i;
                sink.tap.put(sink.lane, Reg::AddrS, component, s, i64::from(lanes.sub));
            }
        }
        out
    }
}

/// Its top bit is set where u + 1 is not in 0…2.
#[inline(always)]
fn beyond(at: u64, one: u64) -> u64 {
    at | (2 * one).wrapping_sub(at)
}

/// The same footprints by the single forms: any configuration, any face.
#[inline(never)]
fn one_by_one<const W: usize, T: Tap>(
    walk: &Walk<'_, W>,
    roms: &Roms,
    k: i64,
    probes: i64,
    sink: &mut Sink<'_, T>,
) -> Footprints<W> {
    let mut out = Footprints {
        upper: [0; W],
        lower: [0; W],
        weight: [[0; W]; 4],
        len: usize::try_from(probes).unwrap_or(0) << walk.two,
    };
    let word = |x: usize| u64::try_from(x).unwrap_or(0);
    let one = 1i64 << walk.cfg.weight_bits;
    for probe in 0..probes {
        let index = usize::try_from(k + probe).unwrap_or(0);
        let found = address(walk.cfg, roms, walk.line, k + probe, sink);
        for l in 0..=walk.two {
            let lane = (usize::try_from(probe).unwrap_or(0) << walk.two) + l;
            let level = walk.levels[l];
            let size = level.size.map(|n| i64::try_from(n).unwrap_or(1));
            let taps = walk.cfg.taps(&found, size, 4 * index + 2 * l, sink);
            let at = level.index(found.face, taps.corner[0], taps.corner[1]);
            out.upper[lane] = word(at);
            out.lower[lane] = word(at + level.stride);
            let [x, y] = taps.weight;
            let four = [(one - x) * (one - y), x * (one - y), (one - x) * y, x * y];
            for (weight, w) in out.weight.iter_mut().zip(four) {
                weight[lane] = w.cast_unsigned();
            }
        }
    }
    out
}
