//! What a unit's memories cannot hold of a job's maps: texels beyond their format, distances beyond their
//! register or below its last bit.

use rtl_model::regs::Reg;
use rtl_model::texel;

use super::Job;
use super::hit::distances_of;
use crate::base::num;
use crate::distance::Distance;
use crate::error::InputError;
use crate::policy::TexelFormat;
use crate::unit::{UnitSpec, check};

/// A sticky flag of loading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoadEvent {
    /// Texels that are stored as the largest of their format.
    TexelSaturated,
    /// Distances beyond the register.
    DistanceBeyond,
    /// Distances above 0 and below the register's last bit.
    DistanceBelowLsb,
}

impl LoadEvent {
    /// Every event.
    pub const ALL: [Self; 3] = [Self::TexelSaturated, Self::DistanceBeyond, Self::DistanceBelowLsb];

    /// Its name among the flags.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::TexelSaturated => "texel.saturated",
            Self::DistanceBeyond => "distance.beyond",
            Self::DistanceBelowLsb => "distance.below_lsb",
        }
    }
}

/// How much of a map is lost, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct Loss {
    /// The flag.
    pub event: LoadEvent,
    /// Texels.
    pub count: u64,
    /// In words: count, largest value, limit, what would hold them.
    pub note: String,
}

/// The losses of a job's maps in a unit; texels of level 0 are counted.
///
/// # Errors
/// A unit whose distance register is refused.
pub fn losses(job: &Job, spec: &UnitSpec) -> Result<Vec<Loss>, InputError> {
    let mut out: Vec<Loss> = texels(job, spec).into_iter().collect();
    if let Job::Hit(job) = job {
        out.extend(distances(&job.distance, spec)?);
    }
    Ok(out)
}

/// The largest texel that a unit holds.
fn most(spec: &UnitSpec) -> f64 {
    let [code, ..] = texel::decode(&spec.config, [f32::MAX.to_bits(); 3]);
    code as f64 / libm::exp2(f64::from(spec.config.policy.texel.frac))
}

fn texels(job: &Job, spec: &UnitSpec) -> Option<Loss> {
    let level = job.map().levels.first().map(|level| level.texels.as_slice());
    let planar = job.textures().iter().filter_map(|map| map.levels.first());
    let all = level.into_iter().chain(planar.map(|level| level.texels.as_slice()));
    let (mut count, mut whole, mut largest) = (0u64, 0, 0.0f32);
    for texels in all {
        whole += texels.len();
        for texel in texels {
            let beyond = texel.iter().filter(|c| texel::saturates(&spec.config, c.to_bits()));
            let top = beyond.copied().fold(0.0, f32::max);
            count += u64::from(top > 0.0);
            largest = largest.max(top);
        }
    }
    (count > 0).then(|| Loss {
        event: LoadEvent::TexelSaturated,
        count,
        note: format!(
            "{count} of {whole} texels lie beyond {} and are stored as that, the largest is {largest}; {}",
            most(spec),
            holding(spec, largest)
        ),
    })
}

/// What would hold a texel, in words.
fn holding(spec: &UnitSpec, largest: f32) -> String {
    let fits = |format: TexelFormat, int: u32, frac: u32| {
        let mut other = spec.clone();
        let texel = &mut other.config.policy.texel;
        (texel.format, texel.int, texel.frac) = (format, int, frac);
        check(&other).is_ok() && !texel::saturates(&other.config, largest.to_bits())
    };
    let (int, frac) = (17, spec.config.policy.texel.frac);
    if fits(TexelFormat::Half, int, frac) {
        return format!("texel.format=half with texel.int={int} holds them");
    }
    let needed = (1..=int).find(|int| fits(TexelFormat::Q, *int, frac));
    match needed {
        Some(int) => format!("texel.format=q with texel.int={int} holds them"),
        None => {
            let bits = libm::floor(libm::log2(f64::from(largest))) + 1.0;
            format!("no texel format holds them (texel.int would be {bits}): scale the map down")
        }
    }
}

/// The losses of a distance map.
///
/// # Errors
/// A unit whose distance register is refused.
pub fn distances(distance: &Distance, spec: &UnitSpec) -> Result<Vec<Loss>, InputError> {
    let Distance::Cube(cube) = distance else { return Ok(Vec::new()) };
    let memory = distances_of(&spec.config, distance).map_err(|e| {
        InputError::new(e.path, e.expected, e.found, "change the register of distances")
    })?;
    let format = spec.config.format(Reg::HitDistance);
    let power = memory.scale - i64::from(format.frac);
    let lsb = libm::exp2(num::i32(power).into());
    let finite = || cube.texels.iter().map(|d| f64::from(*d)).filter(|d| d.is_finite());
    let largest = finite().fold(0.0, f64::max);
    let below = num::u64(finite().filter(|d| *d > 0.0 && *d < lsb).count());
    let whole = cube.texels.len();
    let mut out = Vec::new();
    if memory.beyond > 0 {
        let note = format!(
            "{} of {whole} distances lie beyond the register hit.distance, the largest is {largest}",
            memory.beyond
        );
        out.push(Loss { event: LoadEvent::DistanceBeyond, count: memory.beyond, note });
    }
    if below > 0 {
        let note = format!(
            "{below} of {whole} distances lie below one LSB of hit.distance, {lsb}, as the largest is {largest}; \
             --distance-far D makes those from D on infinite"
        );
        out.push(Loss { event: LoadEvent::DistanceBelowLsb, count: below, note });
    }
    Ok(out)
}
