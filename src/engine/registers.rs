//! How far the integer model's registers are from the float reference's, in LSB.

use rayon::prelude::*;
use rtl_model::Stage;
use rtl_model::regs::Reg;

use super::Progress;
use super::probe::{Code, FloatProbe, RtlProbe};
use crate::base::num;

/// Errors of one register over all fragments.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RegisterError {
    /// Largest |rtl − f64| in LSB.
    pub worst_lsb: f64,
    /// Sum of all, for the mean.
    sum: f64,
    /// Components compared.
    pub count: u64,
    /// Pixel of the worst.
    pub pixel: [u32; 2],
}

impl RegisterError {
    /// Mean |rtl − f64| in LSB.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "a count as a divisor")]
    pub fn mean_lsb(&self) -> f64 {
        if self.count == 0 { 0.0 } else { self.sum / self.count as f64 }
    }

    fn add(&mut self, error: f64, pixel: [u32; 2]) {
        if error > self.worst_lsb || self.count == 0 {
            self.worst_lsb = error;
            self.pixel = pixel;
        }
        self.sum += error;
        self.count += 1;
    }

    fn merge(&mut self, other: &Self) {
        if other.count == 0 {
            return;
        }
        if other.worst_lsb > self.worst_lsb || self.count == 0 {
            self.worst_lsb = other.worst_lsb;
            self.pixel = other.pixel;
        }
        self.sum += other.sum;
        self.count += other.count;
    }
}

/// Errors of all registers.
#[derive(Clone, Debug, PartialEq)]
pub struct RegisterErrors {
    /// By `Reg::index`; `count` is 0 where nothing could be compared.
    pub registers: Vec<RegisterError>,
    /// Fragments whose face differs: nothing behind it was compared.
    pub other_face: u64,
    /// Fragments whose probe count differs: nothing per probe was compared.
    pub other_count: u64,
    /// Fragments with a probe that is a texel or more away, as on another face: no texel coordinates
    /// and bilinear sums were compared.
    pub other_texel: u64,
    /// Rays whose search ended otherwise or after another number of look-ups: nothing was compared.
    pub other_search: u64,
    /// Fragments compared.
    pub fragments: u64,
}

/// Both engines' registers of one request, and the errors so far.
#[derive(Debug, Default)]
pub(super) struct Sides {
    /// The integer model's.
    pub(super) mine: RtlProbe,
    /// The float reference's.
    pub(super) theirs: FloatProbe,
    /// Of the requests before.
    pub(super) errors: RegisterErrors,
}

impl Sides {
    /// Forgets the registers.
    pub(super) fn clear(&mut self) {
        self.mine.clear();
        self.theirs.clear();
    }

    /// Adds the registers' errors.
    pub(super) fn add(&mut self, pixel: [u32; 2], same_face: bool, same_count: bool) {
        let Self { mine, theirs, errors } = self;
        errors.fragments += 1;
        errors.other_face += u64::from(!same_face);
        errors.other_count += u64::from(!same_count);
        one(errors, mine, theirs, pixel, same_face, same_count);
    }
}

impl Default for RegisterErrors {
    fn default() -> Self {
        Self {
            registers: vec![RegisterError::default(); Reg::COUNT],
            other_face: 0,
            other_count: 0,
            other_texel: 0,
            other_search: 0,
            fragments: 0,
        }
    }
}

impl RegisterErrors {
    /// The errors of many requests, `chunk` of them a task: `each` adds those of one by probes that are empty.
    pub(super) fn of<I: Sync>(
        requests: &[I],
        chunk: usize,
        progress: Progress<'_>,
        each: impl Fn(&I, &mut Sides) + Sync,
    ) -> Self {
        let parts: Vec<Self> = requests
            .par_chunks(chunk)
            .map(|chunk| {
                let mut sides = Sides::default();
                for request in chunk {
                    sides.clear();
                    each(request, &mut sides);
                }
                progress(num::u64(chunk.len()));
                sides.errors
            })
            .collect();
        parts.iter().fold(Self::default(), Self::merge)
    }

    fn merge(mut self, other: &Self) -> Self {
        for (a, b) in self.registers.iter_mut().zip(&other.registers) {
            a.merge(b);
        }
        self.other_face += other.other_face;
        self.other_count += other.other_count;
        self.other_texel += other.other_texel;
        self.other_search += other.other_search;
        self.fragments += other.fragments;
        self
    }
}

/// |rtl − f64| of one component in LSB of the integer register.
#[must_use]
#[expect(
    clippy::cast_precision_loss,
    reason = "codes of up to 58 bits; the error is printed to three digits"
)]
pub fn error_lsb(code: Code, value: f64) -> f64 {
    let frac = num::i32(code.frac.clamp(-3000, 3000));
    (code.raw as f64 - libm::ldexp(value, frac)).abs()
}

/// Whether a register lies behind the choice of the face.
fn behind_face(reg: Reg) -> bool {
    reg.index() >= Reg::FaceU.index()
        && reg.info().stage != Stage::Hit
        && !matches!(reg.info().stage, Stage::Jacobian if reg.index() < Reg::JacNumerator.index())
}

/// Whether a register's sign follows the axis', which is free where the axis points along (0, ±1).
fn along_axis(reg: Reg) -> bool {
    [Reg::EigenAxis, Reg::FootLine, Reg::FootStep].contains(&reg)
}

/// Whether a texel coordinate differs by a texel or more.
fn texel_apart(mine: &RtlProbe, theirs: &FloatProbe) -> bool {
    mine.get(Reg::AddrS)
        .iter()
        .zip(theirs.get(Reg::AddrS))
        .any(|(code, value)| code.is_written() && (code.value() - value).abs() >= 1.0)
}

fn one(
    errors: &mut RegisterErrors,
    mine: &RtlProbe,
    theirs: &FloatProbe,
    pixel: [u32; 2],
    same_face: bool,
    same_count: bool,
) {
    let dot: f64 = mine
        .get(Reg::EigenAxis)
        .iter()
        .zip(theirs.get(Reg::EigenAxis))
        .map(|(a, b)| a.value() * b)
        .sum();
    let flipped = dot < 0.0;
    let level = |lod: f64| lod.floor();
    let lods = (mine.get(Reg::FootLod).first(), theirs.get(Reg::FootLod).first());
    let same_level = match lods {
        (Some(a), Some(b)) => (level(a.value()) - level(*b)).abs() < 0.5,
        _ => false,
    };
    let probes_match = same_face && same_count && same_level && !flipped;
    let other_texel = probes_match && texel_apart(mine, theirs);
    errors.other_texel += u64::from(other_texel);
    for reg in Reg::ALL {
        let (a, b) = (mine.get(*reg), theirs.get(*reg));
        if other_texel && [Reg::AddrS, Reg::FilterBilinear].contains(reg) {
            continue;
        }
        if a.is_empty() || b.is_empty() || (behind_face(*reg) && !same_face) {
            continue;
        }
        let per_probe =
            matches!(reg.info().stage, Stage::Address | Stage::Filter) && *reg != Reg::FilterColor;
        if per_probe
            && (!same_count || flipped || (!same_level && reg.index() >= Reg::AddrS.index()))
        {
            continue;
        }
        if [Reg::FootStep].contains(reg) && !same_count {
            continue;
        }
        let sign = if flipped && along_axis(*reg) { -1.0 } else { 1.0 };
        for (code, value) in a.iter().zip(b).filter(|(code, _)| code.is_written()) {
            errors.registers[reg.index()].add(error_lsb(*code, sign * value), pixel);
        }
    }
}
