//! The ranges of values that occur in a scene's registers.

use rayon::prelude::*;
use rtl_model::regs::{Kind, Reg};

use crate::base::num;
use crate::engine::Job;
use crate::engine::hit::HitRtl;
use crate::engine::job::Compile as _;
use crate::engine::probe::{RtlProbe, rtl};
use crate::error::InputError;
use crate::policy::HitStatus;
use crate::unit::UnitSpec;

/// The codes of a register.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Range {
    /// Smallest code.
    pub least: i64,
    /// Largest code.
    pub most: i64,
    /// Whether it was written at all.
    pub used: bool,
}

impl Range {
    fn add(&mut self, raw: i64) {
        self.least = self.least.min(raw);
        self.most = self.most.max(raw);
        self.used = true;
    }

    /// Integer bits that hold every code, without the sign.
    #[must_use]
    pub fn int_bits(&self, frac: u32) -> u32 {
        // −2^n needs n bits, as 2^n − 1 does.
        let magnitude = (self.most.max(0)).max(!self.least.min(0));
        (64 - magnitude.leading_zeros()).saturating_sub(frac)
    }
}

/// The ranges of all registers, and the limits that the scene reaches.
#[derive(Clone, Debug)]
pub struct Ranges {
    /// By `Reg::index`.
    pub registers: Vec<Range>,
    /// Most probes of a request.
    pub probes: u32,
    /// Integer bits of the brightest texel.
    pub texel_int: u32,
    /// Most look-ups of a search.
    pub look_ups: u32,
    /// Whether every search ended before its limit.
    pub searches: bool,
}

impl Ranges {
    fn new() -> Self {
        Self {
            registers: vec![Range::default(); Reg::COUNT],
            probes: 0,
            texel_int: 1,
            look_ups: 0,
            searches: true,
        }
    }

    fn add(&mut self, probe: &RtlProbe, probes: u32) {
        for (range, codes) in self.registers.iter_mut().zip(&probe.registers) {
            codes.iter().filter(|c| c.is_written()).for_each(|c| range.add(c.raw));
        }
        self.probes = self.probes.max(probes);
    }

    fn merge(mut self, other: Self) -> Self {
        for (a, b) in self.registers.iter_mut().zip(&other.registers).filter(|(_, b)| b.used) {
            a.add(b.least);
            a.add(b.most);
        }
        self.probes = self.probes.max(other.probes);
        self.look_ups = self.look_ups.max(other.look_ups);
        self.searches &= other.searches;
        self
    }

    fn ray(&mut self, engine: &HitRtl, ray: &crate::fragment::HitFragment, probe: &mut RtlProbe) {
        let (result, _) = engine.trace(ray, probe);
        self.add(probe, result.probes);
        self.look_ups = self.look_ups.max(result.iterations);
        self.searches &= result.status != HitStatus::MaxIterations;
    }

    /// Traces every request of a job.
    ///
    /// # Errors
    /// The unit is refused.
    pub fn of(job: &Job, spec: &UnitSpec) -> Result<Self, InputError> {
        let mut ranges = Self::traced(job, spec)?;
        let brightest = |texels: &[[f32; 3]]| {
            let most = texels.iter().flatten().fold(0.0f32, |most, c| most.max(*c));
            // 2^n itself needs a bit more than what is below it.
            (0..17).find(|n| f64::from(most) < libm::exp2(f64::from(*n)))
        };
        let flat = job.textures().iter().map(|t| brightest(&t.levels[0].texels));
        let bits = flat.chain([brightest(&job.map().levels[0].texels)]);
        let most = bits.map(|b| b.unwrap_or(17)).max();
        ranges.texel_int = most.unwrap_or(17).max(1);
        Ok(ranges)
    }

    fn traced(job: &Job, spec: &UnitSpec) -> Result<Self, InputError> {
        Ok(match job {
            Job::Env(s) => {
                let engine = s.rtl(spec)?;
                over(&s.scene.fragments, |ranges, fragment, probe| {
                    let (unit, config) = (&engine.unit, &engine.config);
                    let texture = engine.memory.texture.as_ref();
                    let found = rtl(unit, config, &fragment.fragment, texture, probe);
                    ranges.add(probe, num::u32(found.probes));
                })
            }
            Job::Hit(s) => {
                let engine = s.rtl(spec)?;
                over(&s.scene.rays, |ranges, ray, probe| ranges.ray(&engine, &ray.fragment, probe))
            }
            Job::Tex(s) => {
                let engine = s.rtl(spec)?;
                let rows: Vec<usize> = (0..s.scene.height).collect();
                let mut ranges = over(&rows, |ranges, row, probe| {
                    s.trace_row(&engine, *row, probe, &mut |traced, probes| {
                        ranges.add(traced, probes)
                    });
                });
                // The sky's bare cones do not search.
                ranges.searches = false;
                ranges
            }
        })
    }

    /// The fixed registers that were written.
    pub fn fixed(&self) -> impl Iterator<Item = (Reg, &Range)> {
        self.used().filter(|(reg, _)| reg.info().kind == Kind::Fixed)
    }

    /// The registers that were written.
    pub fn used(&self) -> impl Iterator<Item = (Reg, &Range)> {
        Reg::ALL.iter().copied().zip(&self.registers).filter(|(_, range)| range.used)
    }
}

/// Requests in parallel, each part with its own probe.
fn over<I: Sync>(items: &[I], each: impl Fn(&mut Ranges, &I, &mut RtlProbe) + Sync) -> Ranges {
    let parts: Vec<Ranges> = items
        .par_chunks(items.len().div_ceil(64).max(1))
        .map(|chunk| {
            let (mut ranges, mut probe) = (Ranges::new(), RtlProbe::default());
            chunk.iter().for_each(|item| each(&mut ranges, item, &mut probe));
            ranges
        })
        .collect();
    parts.into_iter().fold(Ranges::new(), Ranges::merge)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integer_bits_hold_both_ends() {
        let range = |least, most| Range { least, most, used: true };
        assert_eq!(range(0, 255).int_bits(8), 0);
        assert_eq!(range(0, 256).int_bits(8), 1);
        assert_eq!(range(-256, 0).int_bits(8), 0, "−1 is the least code of no integer bits");
        assert_eq!(range(-257, 255).int_bits(8), 1);
        assert_eq!(range(-1024, 700).int_bits(8), 2);
    }
}
