//! `address`: where a probe lies and which texels it takes, level by level.
//!
//! A probe that leaves its face of a cube is looked up again from the direction (1, u, v); one that leaves a 2-D
//! texture, for which u = 2s − 1 and v = 2t − 1, is wrapped. Texels come with a border of one (edge texels from the
//! neighbours, corners the mean of the other three), so that a bilinear footprint is always two rows of two texels.

pub mod block;
pub mod lanes;

use super::cube_face::{components, direction, select};
use super::{Roms, Sink, bits, fits, frac, int};
use crate::config::{Config, ConfigError};
use crate::fx::Flags;
use crate::policy::Wrap;
use crate::regs::{Event, Reg, Register};
use crate::tables::rom::mantissa;
use crate::tap::Tap;

const P: i64 = 30;

/// Compiled configuration.
#[derive(Clone, Debug, Hash)]
pub struct Cfg {
    u: Register,
    v: Register,
    center_lift: [i64; 2],
    s: [Register; 2],
    s_shift: [i64; 2],
    weight_shift: i64,
    weight_bits: i64,
    /// How a 2-D texture goes on beyond its edges; `None` for a cube.
    wrap: Option<[Wrap; 2]>,
    lanes: Option<lanes::Lanes>,
}

/// The probe line of one fragment.
#[derive(Clone, Copy, Debug)]
pub struct In {
    /// Face of the fragment.
    pub face: usize,
    /// (u, v) with the registers' fraction bits.
    pub center: [i64; 2],
    /// Half the spacing of the probes.
    pub step: [i64; 2],
    /// Fraction bits of `step`.
    pub step_frac: i64,
    /// Probes.
    pub count: i64,
}

/// A probe on its final face.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Probe {
    /// Face that the probe lies on.
    pub face: usize,
    /// (u, v) there, with the registers' fraction bits.
    pub uv: [i64; 2],
}

/// Texels of a probe in one level: the first of two rows of two, and the weights of the second ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Taps {
    /// Column and row of the first texel, from −1 on, counted in the bordered face (+1).
    pub corner: [usize; 2],
    /// Weight of the right column and of the lower row, 0…2^weight_bits.
    pub weight: [i64; 2],
}

impl Cfg {
    /// Compiles and checks the stage for cube maps.
    pub fn new(config: &Config) -> Result<Self, ConfigError> {
        Self::compile(config, [Reg::FaceU, Reg::FaceV], None)
    }

    /// Compiles and checks the stage for 2-D textures.
    pub fn planar(config: &Config) -> Result<Self, ConfigError> {
        Self::compile(config, [Reg::SurfS, Reg::SurfT], Some(config.policy.address.wrap()))
    }

    /// `center` holds u and v, or s and t, whose 2s − 1 has the same fraction bits and one integer bit more.
    fn compile(
        config: &Config,
        center: [Reg; 2],
        wrap: Option<[Wrap; 2]>,
    ) -> Result<Self, ConfigError> {
        config.check()?;
        let weight_bits = i64::from(config.policy.filter.weight_bits);
        let f = |reg| frac(config, reg);
        let q = |reg, frac_in| config.register(reg, frac_in);
        let uv = center.map(f);
        let common = [uv[0].max(f(Reg::FootStep)), uv[1].max(f(Reg::FootStep))];
        for (i, reg) in [Reg::AddrU, Reg::AddrV].into_iter().enumerate() {
            let lift = u32::try_from(common[i] - f(Reg::FootStep)).unwrap_or(u32::MAX);
            fits(reg, bits(config, Reg::FootStep) + lift + 8)?;
            let lift = u32::try_from(common[i] - uv[i]).unwrap_or(u32::MAX);
            fits(reg, bits(config, center[i]) + 1 + lift)?;
            if bits(config, reg) > 44 {
                fits(reg, 63)?;
            }
            fits(Reg::AddrS, config.format(reg).frac + 18)?;
            // Another face is looked up at the common fraction of u and v.
            let fine = config.format(Reg::AddrU).frac;
            let fine = fine.max(config.format(Reg::AddrV).frac);
            fits(reg, int(config, reg).max(1) + fine)?;
        }
        Ok(Self {
            u: q(Reg::AddrU, common[0]),
            v: q(Reg::AddrV, common[1]),
            center_lift: [common[0] - uv[0], common[1] - uv[1]],
            s: [q(Reg::AddrS, f(Reg::AddrU) + 1), q(Reg::AddrS, f(Reg::AddrV) + 1)],
            s_shift: [f(Reg::AddrU) + 1 - f(Reg::AddrS), f(Reg::AddrV) + 1 - f(Reg::AddrS)],
            weight_shift: f(Reg::AddrS) - weight_bits,
            weight_bits,
            wrap,
            lanes: lanes::Lanes::new(config, common),
        })
    }

    #[inline(always)]
    fn step_lift(&self, i: usize, step_frac: i64) -> i64 {
        [&self.u, &self.v][i].frac_in - step_frac
    }

    /// The centre of a 2-D texture's probe line from the codes of s and t: 2s − 1 and 2t − 1, brought back into the
    /// texture where it repeats.
    #[inline(always)]
    #[must_use]
    pub fn center(&self, st: [i64; 2]) -> [i64; 2] {
        let mut out = [0; 2];
        for (i, (out, x)) in out.iter_mut().zip(st).enumerate() {
            let one = 1i64 << ([&self.u, &self.v][i].frac_in - self.center_lift[i]);
            *out = match self.wrap {
                Some(wrap) if wrap[i] == Wrap::Repeat => wrapped(2 * x - one, one, wrap[i]),
                Some(_) | None => 2 * x - one,
            };
        }
        out
    }

    /// Texel coordinates, corner and weights of a probe in a level of `size` columns and rows.
    #[inline(always)]
    #[must_use]
    pub fn taps<T: Tap>(
        &self,
        probe: &Probe,
        size: [i64; 2],
        component: usize,
        sink: &mut Sink<'_, T>,
    ) -> Taps {
        let mut out = Taps::default();
        for i in 0..2 {
            let q = &self.s[i];
            let f = q.frac_in - 1;
            let one = 1i64 << f;
            // (u + 1)/2·N − ½ with f + 1 fraction bits.
            let sum = (probe.uv[i] + one) * size[i] - one;
            let code = sink.shift(q, component + i, sum, self.s_shift[i], 0);
            let sub = q.frac();
            let whole = code >> sub;
            let part = code - (whole << sub);
            let weight = if self.weight_shift > 0 {
                (part + (1 << (self.weight_shift - 1))) >> self.weight_shift
            } else {
                part << -self.weight_shift
            };
            let clamped = whole.clamp(-1, size[i] - 1);
            out.corner[i] = usize::try_from(clamped + 1).unwrap_or(0);
            // Only a register too short for the face brings a coordinate outside of it.
            out.weight[i] = match whole.cmp(&clamped) {
                core::cmp::Ordering::Less => 0,
                core::cmp::Ordering::Equal => weight,
                core::cmp::Ordering::Greater => 1 << self.weight_bits,
            };
        }
        out
    }
}

/// The stage for probe `k` of a fragment.
#[inline(always)]
pub fn address<T: Tap>(
    cfg: &Cfg,
    roms: &Roms,
    input: &In,
    k: i64,
    sink: &mut Sink<'_, T>,
) -> Probe {
    let index = usize::try_from(k).unwrap_or(0);
    let along = 2 * k + 1 - input.count;
    let mut uv = [0; 2];
    let mut outside = false;
    for (i, q) in [&cfg.u, &cfg.v].into_iter().enumerate() {
        let sum = (input.center[i] << cfg.center_lift[i])
            + ((along * input.step[i]) << cfg.step_lift(i, input.step_frac));
        let sum = match cfg.wrap {
            Some(wrap) => wrapped(sum, 1 << q.frac_in, wrap[i]),
            None => sum,
        };
        uv[i] = sink.write(q, index, sum, 0);
        outside |= uv[i].abs() > 1 << q.format.frac;
    }
    if outside {
        other_face(cfg, roms, input.face, uv, sink.flags)
    } else {
        Probe { face: input.face, uv }
    }
}

/// A coordinate of a 2-D texture that is left as it is from −1 to 1 (`one`), brought back from beyond.
#[inline(always)]
fn wrapped(x: i64, one: i64, wrap: Wrap) -> i64 {
    if (-one..=one).contains(&x) {
        return x;
    }
    match wrap {
        Wrap::Repeat => ((x + one) & (2 * one - 1)) - one,
        Wrap::Clamp => x.clamp(-one, one),
        Wrap::Mirror => {
            let turn = (x + one) & (4 * one - 1);
            turn.min(4 * one - turn) - one
        }
    }
}

/// Face and coordinates of the direction (1, u, v) of a probe outside its face.
#[inline(never)]
fn other_face(cfg: &Cfg, roms: &Roms, face: usize, uv: [i64; 2], flags: &mut Flags) -> Probe {
    flags.event(Event::AddressOtherFace, true);
    let [fu, fv] = [&cfg.u, &cfg.v].map(|q| q.frac());
    let common = fu.max(fv);
    let d = direction(face, [uv[0] << (common - fu), uv[1] << (common - fv), 1 << common]);
    let face = select(d);
    let [sc, tc, ma] = components(face, d);
    let (m, e) = mantissa(ma.max(1));
    let y = roms.recip.recip(m);
    let mut out = [0; 2];
    for (i, (q, c)) in [(&cfg.u, sc), (&cfg.v, tc)].into_iter().enumerate() {
        let one = 1i64 << q.format.frac;
        // c/ma at 30 bits: c·2^(30 − e), then times y.
        let c = if e > P { c >> (e - P) } else { c << (P - e) };
        let (code, over) = q.write_shifted(c * y, 2 * P - q.frac());
        flags.register(q.reg, over && code.abs() < one);
        out[i] = code.clamp(-one, one);
    }
    Probe { face, uv: out }
}
