//! Probes of many fragments at a time: a vector over probes, wherever on their lines and in whichever level they lie.

use lanes::{Mask as _, Vector};

use super::lanes::Lanes;
use super::{Cfg, P};
use crate::policy::Wrap;
use crate::regs::Register;
use crate::stages::Roms;
use crate::stages::cube_face::{components_of, direction_of, face_of};
use crate::tables::rom::mantissa;
use crate::texture::Level;

/// The form of [`Cfg`] for a texture whose levels its registers hold.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Block<'a> {
    cfg: &'a Cfg,
    lanes: &'a Lanes,
}

/// Bilinear footprints: the index of each one's first texel, and its texels' weights, row by row.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Footprints<V> {
    pub(crate) at: V,
    pub(crate) weight: [V; 4],
}

/// Probes brought back into the texture: faces, u + 1 and v + 1, and what the registers of u and v lost.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moved<V> {
    pub(crate) face: V,
    pub(crate) at: [V; 2],
    pub(crate) lost: [V; 2],
}

impl Cfg {
    /// `None` where a vector's operations do not do.
    pub(crate) fn block(&self, levels: &[Level]) -> Option<Block<'_>> {
        let lanes = self.lanes.as_ref()?;
        let mut sizes = levels.iter().flat_map(|level| level.size);
        sizes.all(|size| size <= lanes.max_size).then_some(Block { cfg: self, lanes })
    }
}

impl<'a> Block<'a> {
    /// u + 1 of the first probes of lines along an axis, and the distance from probe to probe.
    #[inline(always)]
    pub(crate) fn line<V: Vector>(
        &self,
        i: usize,
        line: [V; 2],
        step_frac: i64,
        count: V,
    ) -> [V; 2] {
        let [center, step] = line;
        let half = step.up(self.cfg.step_lift(i, step_frac));
        let first = center.up(self.cfg.center_lift[i]).plus(1 << self.lanes.frac);
        [first - half.mul_wide(count.plus(-1)), half.up(1)]
    }

    /// Negative where u + 1 or v + 1 is not in 0…2.
    #[inline(always)]
    pub(crate) fn beyond<V: Vector>(&self, [u, v]: [V; 2]) -> V {
        let two = u.like(2 << self.lanes.frac);
        u | v | (two - u) | (two - v)
    }

    /// The registers of u and v.
    pub(crate) fn registers(&self) -> [&'a Register; 2] {
        [&self.cfg.u, &self.cfg.v]
    }

    /// Whether a probe beyond its face lies on another one; a 2-D texture goes on.
    pub(crate) fn has_faces(&self) -> bool {
        self.cfg.wrap.is_none()
    }

    /// Brings probes back that left the texture, those that did not stay: `other_face` and `wrapped` of lanes.
    #[inline(always)]
    pub(crate) fn moved<V: Vector>(&self, roms: &Roms, face: V, at: [V; 2], beyond: V) -> Moved<V> {
        let left = beyond.negative();
        let one = 1i64 << self.lanes.frac;
        let zero = face.like(0);
        let mut out = Moved { face, at, lost: [zero; 2] };
        if let Some(wrap) = self.cfg.wrap {
            for (at, wrap) in out.at.iter_mut().zip(wrap) {
                *at = match wrap {
                    Wrap::Repeat => {
                        let inside = !at.negative() & !at.gt(at.like(2 * one));
                        inside.select(*at, at.and(2 * one - 1))
                    }
                    Wrap::Clamp => at.limit(0, 2 * one),
                    Wrap::Mirror => {
                        let turn = at.and(4 * one - 1);
                        turn.smaller(turn.like(4 * one) - turn)
                    }
                };
            }
            return out;
        }
        let mut uv = at;
        for ((uv, lost), q) in uv.iter_mut().zip(&mut out.lost).zip(self.registers()) {
            let exact = uv.plus(-one);
            *uv = exact.limit(q.format.min_raw(), q.format.max_raw());
            *lost = left.select(exact ^ *uv, zero);
        }
        let d = direction_of(face, [uv[0], uv[1], face.like(one)]);
        let other = face_of(d);
        let [sc, tc, ma] = components_of(other, d);
        let (m, e) = mantissa(ma.larger(ma.like(1)));
        let y = roms.recip.recip(m);
        let (up, down) = ((e.like(P) - e).larger(zero), e.plus(-P).larger(zero));
        let shift = 2 * P - i64::from(self.lanes.frac);
        for ((at, c), own) in out.at.iter_mut().zip([sc, tc]).zip(at) {
            // c/ma at 30 bits: c·2^(30 − e), then times y; to nearest, ties to even.
            let x = c.shl(up).sra(down).mul(y);
            let code = (x.plus((1 << (shift - 1)) - 1) + x.down(shift).and(1)).down(shift);
            *at = left.select(code.limit(-one, one).plus(one), own);
        }
        out.face = left.select(other, face);
        out
    }

    /// The footprints of probes in levels of `size` columns and rows with their first texels at `base`.
    #[inline(always)]
    pub(crate) fn footprints<V: Vector>(&self, at: [V; 2], size: [V; 2], base: V) -> Footprints<V> {
        let lanes = self.lanes;
        let [shift, sub] = [lanes.shift, lanes.sub].map(i64::from);
        let [low, half, full] = [lanes.low, lanes.half, lanes.full].map(u64::cast_signed);
        let mut texel = at;
        let mut weight = at;
        for i in 0..2 {
            // (u + 1)·N/2 − ½ + 1: the texel coordinate of the bordered face.
            let t = at[i].mul_unsigned(size[i]).plus(1 << lanes.frac);
            let code = (t.plus(low) + t.down(shift).and(1)).down(shift);
            texel[i] = code.down(sub);
            let part = code.and((1 << sub) - 1).up(lanes.up.into());
            weight[i] = part.plus(half).down(lanes.down.into());
        }
        let [x, y] = weight;
        let [left, above] = [x.like(full) - x, y.like(full) - y];
        Footprints {
            at: base + texel[0] + texel[1].mul_unsigned(size[0].plus(2)),
            weight: [
                left.mul_unsigned(above),
                x.mul_unsigned(above),
                left.mul_unsigned(y),
                x.mul_unsigned(y),
            ],
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::config::Config;
    use crate::fx::Flags;
    use crate::policy::Wrap;
    use crate::regs::{Event, Reg};
    use crate::stages::address::{Cfg, In, address};
    use crate::stages::{Roms, Sink};
    use crate::tap::NoTapStandard;
    use crate::texture::Level;

    /// Probes on and far beyond a texture, and on its very edges.
    #[test]
    fn probes_lie_where_the_form_for_one_puts_them() {
        let mut config = Config::default();
        for reg in [Reg::AddrU, Reg::AddrV] {
            config.formats[reg.index()].int = 3;
        }
        let roms = Roms::new(&config).unwrap();
        let level = Level { size: [48, 32], offset: 7, stride: 50, face_stride: 1700 };
        let mut x = 1u64;
        let mut random = |bits: u32| {
            x = x.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            x.cast_signed() >> (64 - bits)
        };
        for wrap in [None, Some(Wrap::Repeat), Some(Wrap::Clamp), Some(Wrap::Mirror)] {
            if let Some(wrap) = wrap {
                (config.policy.address.wrap_s, config.policy.address.wrap_t) = (wrap, wrap);
            }
            let cfg =
                if wrap.is_some() { Cfg::planar(&config) } else { Cfg::new(&config) }.unwrap();
            let block = cfg.block(&[level]).unwrap();
            let [mut moved, mut lost] = [0; 2];
            for n in 0..20_000 {
                let bits = 20 + n % 8;
                let mut line = In {
                    face: usize::try_from(random(40).rem_euclid(6)).unwrap(),
                    center: [
                        random(26).clamp(-1 << 24, 1 << 24),
                        random(26) & !((1 << (n % 27)) - 1),
                    ],
                    step: [random(bits), random(bits)],
                    step_frac: 24,
                    count: 1 + random(40).rem_euclid(16),
                };
                if wrap.is_some() {
                    line.face = 0;
                }
                let k = random(40).rem_euclid(line.count);
                let (mut flags, mut found) = (Flags::default(), Flags::default());
                let mut sink = Sink { lane: 0, flags: &mut flags, tap: &mut NoTapStandard };
                let probe = address(&cfg, &roms, &line, k, &mut sink);
                let taps = cfg.taps(&probe, [48, 32], 0, &mut sink);

                let face = i64::try_from(line.face).unwrap();
                let mut at = [0; 2];
                for i in 0..2 {
                    let axis = [line.center[i], line.step[i]];
                    let [first, step] = block.line(i, axis, line.step_frac, line.count);
                    at[i] = first + k * step;
                }
                let mut to = face;
                if block.beyond(at) < 0 {
                    let out = block.moved(&roms, face, at, block.beyond(at));
                    (at, to) = (out.at, out.face);
                    found.event(Event::AddressOtherFace, block.has_faces());
                    for (lost, q) in out.lost.into_iter().zip(block.registers()) {
                        found.register(q.reg, lost != 0);
                    }
                    moved += 1;
                    lost += i32::from(out.lost != [0; 2]);
                }
                let base = 7 + 1700 * to;
                let out = block.footprints(at, [48, 32], base);
                let [s, t] = taps.corner;
                let index = i64::try_from(level.index(probe.face, s, t)).unwrap();
                let [x, y] = taps.weight;
                let weight = [(256 - x) * (256 - y), x * (256 - y), (256 - x) * y, x * y];
                let case = (wrap, line, k);
                assert_eq!((out.at, out.weight), (index, weight), "{case:?}");
                assert_eq!(found, flags, "{case:?}");
            }
            assert!(moved > 1000, "{wrap:?}: {moved} probes off the texture");
            assert_eq!(lost > 100, wrap.is_none(), "{wrap:?}: {lost} beyond the registers");
        }
    }
}
