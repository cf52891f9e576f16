//! Distances from an EXR file: the choice of the channel, the cleaning, and the conversion into a cube.

use std::path::Path;

use super::layout::{EnvPicture, to_cube};
use super::limits::{LoadOptions, room};
use super::load::load_planar;
use super::planar::Planar;
use crate::distance::DistanceCube;
use crate::error::InputError;

/// Names that are looked for where none is given, in this order.
pub const DISTANCE_CHANNELS: [&str; 3] = ["distance", "Z", "A"];

/// Samples that are no distances and what became of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CleanedDistances {
    /// NaN, now +∞: nothing is known to be there.
    pub nan: u64,
    /// Below zero (−∞ too), now +∞: several programs write −1 where a ray escapes.
    pub negative: u64,
}

impl CleanedDistances {
    /// One line for stderr, or nothing where nothing was wrong.
    #[must_use]
    pub fn note(&self, subject: &str) -> Option<String> {
        (self.nan + self.negative > 0).then(|| {
            format!(
                "{subject}: cleaned {} distances: {} NaN and {} negative (now infinite)",
                self.nan + self.negative,
                self.nan,
                self.negative
            )
        })
    }

    fn clean(&mut self, samples: &mut [f32]) {
        for s in samples {
            if s.is_nan() {
                self.nan += 1;
                *s = f32::INFINITY;
            } else if *s < 0.0 {
                self.negative += 1;
                *s = f32::INFINITY;
            } else {
                // −0 becomes +0.
                *s += 0.0;
            }
        }
    }
}

/// Loads a distance cube from an image whose samples are linear: EXR, or Radiance HDR by name.
///
/// The samples are Euclidean distances from the reference point in world units; +∞ means that nothing is
/// there. `channel` names the plane (`distance`, `depth.Z`); without it the plane is `distance`, else
/// `Z`, else `A`, else the only plane that ends in `.distance`, `.Z` or `.A`. NaN and negative
/// samples become +∞ and are counted. Layouts as for colours, see [`super::layout`]: a file with an
/// `envmap` attribute follows OpenEXR's convention, a strip or cross without it Vulkan's. Where a layout
/// or `face_size` asks for resampling, a texel that any infinite sample reaches is infinite.
///
/// # Errors
/// As [`load_planar`]; a channel that is not there (the message lists those that are), code values (PNG,
/// JPEG), a shape that is no environment, a cube beyond four times the size limit.
pub fn load_distance(
    path: &Path,
    channel: Option<&str>,
    options: &LoadOptions,
) -> Result<(DistanceCube, CleanedDistances), InputError> {
    let subject = path.display().to_string();
    if let Some(size) = options.face_size {
        options.admit_cube(size)?;
    }
    let mut planar = load_planar(path, options)?;
    if !planar.linear {
        return Err(InputError::new(
            subject,
            "an EXR file with distances",
            "an image of 8- or 16-bit colours",
            "render the distances into a float channel of an EXR file",
        ));
    }
    let index = find(&planar, channel, &subject)?;
    let mut samples = std::mem::take(&mut planar.channels[index].1);
    let mut cleaned = CleanedDistances::default();
    cleaned.clean(&mut samples);
    // Second component: whether the sample is infinite, as ∞ − ∞ would be no number.
    let mut texels: Vec<[f32; 3]> = room(samples.len(), &subject)?;
    texels.extend(
        samples.iter().map(|s| if s.is_infinite() { [0.0, 1.0, 0.0] } else { [*s, 0.0, 0.0] }),
    );
    drop(samples);
    let picture =
        EnvPicture { width: planar.width, height: planar.height, texels, envmap: planar.envmap };
    let level = to_cube(picture, options, &subject)?;
    let distances = level
        .texels
        .iter()
        .map(|[distance, infinite, _]| if *infinite > 0.0 { f32::INFINITY } else { *distance });
    Ok((DistanceCube { size: level.size, texels: distances.collect() }, cleaned))
}

/// Index of the plane that holds distances.
fn find(planar: &Planar, channel: Option<&str>, subject: &str) -> Result<usize, InputError> {
    let position = |name: &str| planar.channels.iter().position(|(n, _)| n == name);
    let found = match channel {
        Some(name) => position(name),
        None => DISTANCE_CHANNELS.iter().find_map(|name| position(name)).or_else(|| {
            DISTANCE_CHANNELS.iter().find_map(|name| {
                let ending = format!(".{name}");
                let mut all =
                    (0..planar.channels.len()).filter(|i| planar.channels[*i].0.ends_with(&ending));
                // Only if no second one has the same ending.
                let first = all.next()?;
                all.next().is_none().then_some(first)
            })
        }),
    };
    found.ok_or_else(|| {
        let expected = match channel {
            Some(name) => format!("a channel `{name}`"),
            None => format!("a channel {}", DISTANCE_CHANNELS.join(", ")),
        };
        InputError::new(
            subject,
            expected,
            planar.channel_list(),
            "name the channel that holds distances, as in FILE.exr:NAME",
        )
        .at("channels")
    })
}
