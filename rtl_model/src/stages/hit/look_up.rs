//! One look-up of a distance: face, texel coordinates, bilinear or nearest texels of level 0.

use super::P;
use crate::config::{Config, ConfigError, ROTATION_FRAC};
use crate::distance::{BEYOND, DistanceMemory, INFINITE, Kind, box_eighths};
use crate::policy::LookUp;
use crate::regs::{Reg, Register};
use crate::stages::cube_face::{components, select};
use crate::stages::{Roms, Sink, bits, dot, fits, frac};
use crate::tables::rom::mantissa;
use crate::tap::Tap;

/// Compiled configuration.
#[derive(Clone, Debug, Hash)]
pub struct Cfg {
    pub(super) rotation: Option<[[i64; 3]; 3]>,
    mode: LookUp,
    look_up: Register,
    uv: Register,
    s: Register,
    distance: Register,
    radius: Register,
    radius_plain: Register,
}

/// The result of a look-up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reading {
    /// Code of dist(q).
    pub radius: i64,
    /// Whether the distance is infinite, or beyond its register.
    pub infinite: bool,
}

/// Face, first column and row of the bordered face, and weights of the second ones.
pub(super) struct Place {
    pub(super) face: usize,
    pub(super) corner: [usize; 2],
    weight: [i64; 2],
}

impl Cfg {
    pub(super) fn new(config: &Config) -> Result<Self, ConfigError> {
        let f = |reg| frac(config, reg);
        let q = |reg, frac_in| config.register(reg, frac_in);
        let widest =
            bits(config, Reg::HitL).max(bits(config, Reg::HitX)).max(bits(config, Reg::HitR));
        if config.rotation.is_some() {
            fits(Reg::HitLookUp, widest + ROTATION_FRAC + 3)?;
        }
        fits(Reg::HitUv, bits(config, Reg::HitLookUp) + 30)?;
        fits(Reg::HitS, config.format(Reg::HitUv).frac + 18)?;
        if config.format(Reg::HitS).frac > 14 {
            return Err(ConfigError {
                path: "registers.hit.s.frac".into(),
                expected: "at most 14 fraction bits".into(),
                found: alloc::format!("{}", config.format(Reg::HitS).frac),
            });
        }
        let sub = f(Reg::HitS);
        Ok(Self {
            rotation: config.rotation,
            mode: config.policy.hit.lookup,
            look_up: q(Reg::HitLookUp, 0),
            uv: q(Reg::HitUv, 0),
            s: q(Reg::HitS, f(Reg::HitUv) + 1),
            distance: q(Reg::HitDistance, f(Reg::HitDistance) + 3),
            radius: q(Reg::HitRadius, f(Reg::HitDistance) + 2 * sub),
            radius_plain: q(Reg::HitRadius, f(Reg::HitDistance)),
        })
    }

    /// Fraction bits of a reading.
    pub(super) fn radius_frac(&self) -> i64 {
        self.radius.frac()
    }

    /// Where a direction (at most 31 bits) meets a face of `size` texels.
    #[inline(always)]
    pub(super) fn place<T: Tap>(
        &self,
        roms: &Roms,
        q: [i64; 3],
        size: usize,
        index: usize,
        sink: &mut Sink<'_, T>,
    ) -> Place {
        let face = select(q);
        let [sc, tc, ma] = components(face, q);
        let (m, e) = mantissa(ma.max(1));
        let y = roms.recip.recip(m);
        let f = self.uv.frac();
        let one = 1i64 << f;
        let n = i64::try_from(size).unwrap_or(1);
        let sub = self.s.frac();
        let half = if self.mode == LookUp::Bilinear { one } else { 0 };
        let mut out = Place { face, corner: [0; 2], weight: [0; 2] };
        for (i, s) in [sc, tc].into_iter().enumerate() {
            let (code, over) = self.uv.write_as(T::STANDARD, s * y, P + e - f);
            let code = if ma == 0 { 0 } else { code.clamp(-one, one) };
            sink.flags.register(Reg::HitUv, over && code.abs() < one);
            sink.tap.put(sink.lane, Reg::HitUv, 2 * index + i, code, f);
            let sum = (code + one) * n - half;
            let s = sink.write(&self.s, 2 * index + i, sum, 0);
            let whole = s >> sub;
            let part = s - (whole << sub);
            let low = if self.mode == LookUp::Bilinear { -1 } else { 0 };
            let clamped = whole.clamp(low, n - 1);
            out.corner[i] = usize::try_from(clamped + 1).unwrap_or(0);
            // Only a register too short for the face brings a coordinate outside of it.
            out.weight[i] = match whole.cmp(&clamped) {
                core::cmp::Ordering::Less => 0,
                core::cmp::Ordering::Equal => part,
                core::cmp::Ordering::Greater => 1 << sub,
            };
            if self.mode == LookUp::Nearest {
                out.weight[i] = 0;
            }
        }
        out
    }

    /// A·q, normalised.
    #[inline(always)]
    fn turned<T: Tap>(
        &self,
        q: [i64; 3],
        index: usize,
        scale: i64,
        sink: &mut Sink<'_, T>,
    ) -> [i64; 3] {
        let q = match &self.rotation {
            None => q,
            Some(a) => a.map(|row| dot(row, q)),
        };
        let out = crate::fx::block::normalize(T::STANDARD, &self.look_up, &q, 0);
        // Only the direction counts: its frac is that of a unit in the first place.
        sink.put(&self.look_up, 3 * index, &out, scale);
        out.m
    }

    /// dist(q); `index` counts the look-ups of the ray.
    #[inline(always)]
    pub(super) fn read<T: Tap>(
        &self,
        roms: &Roms,
        memory: &DistanceMemory,
        q: [i64; 3],
        index: usize,
        scale: i64,
        sink: &mut Sink<'_, T>,
    ) -> Reading {
        let q = self.turned(q, index, scale, sink);
        let memory_scale = memory.scale;
        match &memory.kind {
            Kind::Sphere(code) => self.single(*code, index, memory_scale, sink),
            Kind::Box(half_edges) => {
                let q = if q == [0; 3] { [0, 0, 1] } else { q };
                let frac = self.distance.format.frac;
                let eighths = box_eighths(*half_edges, q, frac);
                let (code, over) = self.distance.write_fixed_as(T::STANDARD, eighths);
                let saturates = matches!(
                    self.distance.format.overflow,
                    crate::fx::Overflow::Saturate | crate::fx::Overflow::SaturateSymmetric
                );
                sink.flags.register(Reg::HitDistance, over);
                let code =
                    if over && saturates { BEYOND } else { u32::try_from(code).unwrap_or(0) };
                self.single(code, index, memory_scale, sink)
            }
            Kind::Cube { size, codes } => {
                let place = self.place(roms, q, *size, index, sink);
                self.filtered(codes, *size, &place, index, memory_scale, sink)
            }
        }
    }

    /// One code as a reading.
    #[inline(always)]
    fn single<T: Tap>(
        &self,
        code: u32,
        index: usize,
        scale: i64,
        sink: &mut Sink<'_, T>,
    ) -> Reading {
        if code >= BEYOND {
            sink.flags.register(Reg::HitDistance, code == BEYOND);
            return Reading { radius: 0, infinite: true };
        }
        let code = i64::from(code);
        let frac = self.distance.frac();
        sink.tap.put(sink.lane, Reg::HitDistance, index, code, frac - scale);
        Reading { radius: sink.write(&self.radius_plain, index, code, scale), infinite: false }
    }

    #[inline(always)]
    fn filtered<T: Tap>(
        &self,
        codes: &[u32],
        size: usize,
        place: &Place,
        index: usize,
        scale: i64,
        sink: &mut Sink<'_, T>,
    ) -> Reading {
        let stride = size + 2;
        let at = (place.face * stride + place.corner[1]) * stride + place.corner[0];
        let code = |k: usize| codes.get(at + k).copied().unwrap_or(INFINITE);
        if self.mode == LookUp::Nearest {
            return self.single(code(0), index, scale, sink);
        }
        let one = 1i64 << self.s.format.frac;
        let [x, y] = place.weight;
        let taps = [
            (code(0), (one - x) * (one - y)),
            (code(1), x * (one - y)),
            (code(stride), (one - x) * y),
            (code(stride + 1), x * y),
        ];
        let mut sum = 0;
        let mut most = 0;
        let mut heaviest = (0, 0);
        for (code, weight) in taps {
            if weight > 0 {
                most = most.max(code);
                sum += i64::from(code) * weight;
                if weight > heaviest.1 {
                    heaviest = (code, weight);
                }
            }
        }
        if most >= BEYOND {
            return self.single(most, index, scale, sink);
        }
        let frac = self.distance.frac();
        let shown = i64::from(heaviest.0);
        sink.tap.put(sink.lane, Reg::HitDistance, index, shown, frac - scale);
        Reading { radius: sink.write(&self.radius, index, sum, scale), infinite: false }
    }
}
