//! The measurements of the search: |q|, the ratio |q|/dist(q) and its side of 1, the point l.

use super::{Cfg, P, Ray, look_up};
use crate::regs::Reg;
use crate::stages::{Roms, Sink, dot};
use crate::tables::rom::{mantissa, mantissa4};
use crate::tap::Tap;

impl Cfg {
    /// −1 below 1 − τ, 1 above 1 + τ, 0 between.
    #[inline(always)]
    pub(super) fn side(&self, ratio: i64) -> i64 {
        let ratio = ratio << (self.tolerance_frac - self.ratio_frac);
        i64::from(ratio > self.limits[1]) - i64::from(ratio < self.limits[0])
    }

    /// Writes |q| of codes with `q_frac` bits.
    #[inline(always)]
    pub(super) fn length<T: Tap>(
        &self,
        roms: &Roms,
        q: [i64; 3],
        q_frac: i64,
        index: usize,
        scale: i64,
        sink: &mut Sink<'_, T>,
    ) -> i64 {
        let square = dot(q, q);
        let (m, e) = mantissa4(square.max(1));
        let y = if square == 0 { 0 } else { roms.sqrt.sqrt(m, &roms.rsqrt) };
        let shift = P - e + q_frac - self.length.frac();
        sink.shift(&self.length, index, y, shift, scale)
    }

    /// Writes length/dist: 0 where the distance is infinite, the largest code where it is 0.
    #[inline(always)]
    pub(super) fn ratio<T: Tap>(
        &self,
        roms: &Roms,
        length: i64,
        reading: look_up::Reading,
        index: usize,
        scale: i64,
        sink: &mut Sink<'_, T>,
    ) -> i64 {
        let frac = self.ratio.frac();
        let code = if reading.infinite {
            sink.tap.put(sink.lane, Reg::HitRatio, index, 0, frac);
            0
        } else if reading.radius == 0 {
            let most = self.ratio.format.max_raw();
            sink.tap.put(sink.lane, Reg::HitRatio, index, most, frac);
            most
        } else {
            let (m, e) = mantissa(reading.radius);
            let radius_frac = self.look_up.radius_frac();
            let inv =
                sink.block(&self.inv_radius, &[roms.recip.recip(m)], P + e - radius_frac, -scale);
            let shift = self.length.frac() + inv.frac - frac;
            let product = length * inv.m[0];
            sink.shift(&self.ratio, index, product, shift, 0)
        };
        code << (self.ratio_frac - frac)
    }

    /// Writes l = x + R d.
    #[inline(always)]
    pub(super) fn point<T: Tap>(
        &self,
        ray: &Ray,
        index: usize,
        scale: i64,
        sink: &mut Sink<'_, T>,
    ) -> [i64; 3] {
        let product = self.r.frac() + self.d.frac();
        let lift_x = self.l.frac_in - self.x.frac();
        let lift = self.l.frac_in - product;
        let mut l = [0; 3];
        for (i, l) in l.iter_mut().enumerate() {
            let sum = (ray.x[i] << lift_x) + ((ray.r[i] * ray.d) << lift);
            *l = sink.write(&self.l, 3 * index + i, sum, scale);
        }
        l
    }
}
