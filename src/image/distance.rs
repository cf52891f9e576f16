//! Distances from an EXR file: the choice of the channel, the cleaning, and the conversion into a cube.

use std::path::Path;

use super::layout::{EnvPicture, to_cube};
use super::limits::{LoadOptions, room};
use super::load::{Loaded, load_planar_for};
use super::planar::{Colour, Planar};
use super::window;
use crate::distance::DistanceCube;
use crate::error::InputError;
use crate::taken::Taken;

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
/// there. `FILE.exr:NAME` names the plane (`distance`, `depth.Z`), its layer or its part; without it the plane is `distance`, else
/// `Z`, else `A`, else the only plane that ends in `.distance`, `.Z` or `.A`. NaN and negative
/// samples become +∞ and are counted. Layouts as for colours, see [`super::layout`]: a file with an
/// `envmap` attribute follows OpenEXR's convention, a strip or cross without it Vulkan's. Where a layout
/// or `face_size` asks for resampling, a texel that any infinite sample reaches is infinite.
///
/// # Errors
/// As [`load_planar`](super::load_planar); a channel that is not there (the message lists those that are), code values (PNG,
/// JPEG), a shape that is no environment, a cube beyond four times the size limit.
pub fn load_distance(
    path: &Path,
    options: &LoadOptions,
) -> Result<Loaded<DistanceCube, CleanedDistances>, InputError> {
    let subject = path.display().to_string();
    if let Some(size) = options.face_size {
        options.admit_cube(size)?;
    }
    // Coverage is the last that is looked for, so it comes behind every other part's channel.
    let suits = |names: &[&str], _: Option<&str>| {
        find(names, None).map_or(0, |i| 1 + u8::from(!names[i].ends_with('A')))
    };
    let mut planar = load_planar_for(path, options, &suits)?;
    if !planar.is_linear() {
        return Err(InputError::new(
            subject,
            "an EXR file with distances",
            "an image of 8- or 16-bit colours",
            "render the distances into a float channel of an EXR file",
        ));
    }
    let index = index(&planar, &subject)?;
    // Nothing can stand in for a distance.
    let options = &LoadOptions { fill: None, ..options.clone() };
    let fitted = window::fitted(&planar, options, &subject)?;
    let from = planar.source(Colour::Grey(index)).replace(" as grey", "");
    let samples = std::mem::take(&mut planar.channels[index].1);
    let mut samples = fitted.plane(samples, 0.0, &subject)?;
    let mut cleaned = CleanedDistances::default();
    cleaned.clean(&mut samples);
    let mut remarks = std::mem::take(&mut planar.remarks);
    let zeros = samples.iter().filter(|s| **s == 0.0).count();
    if zeros > 0 {
        remarks.push(format!(
            "{zeros} distances are 0, at the reference point; if they mean that nothing is there, store infinity"
        ));
    }
    if let Some(far) = options.far {
        let beyond = samples.iter_mut().filter(|s| f64::from(**s) >= far && s.is_finite());
        let count = beyond.map(|s| *s = f32::INFINITY).count();
        remarks
            .push(format!("{count} distances of {far} or more count as infinite (--distance-far)"));
    }
    // Second component: whether the sample is infinite, as ∞ − ∞ would be no number.
    let mut texels: Vec<[f32; 3]> = room(samples.len(), &subject)?;
    texels.extend(
        samples.iter().map(|s| if s.is_infinite() { [0.0, 1.0, 0.0] } else { [*s, 0.0, 0.0] }),
    );
    drop(samples);
    let [width, height] = fitted.size;
    let picture = EnvPicture { width, height, texels, envmap: planar.envmap };
    let (level, kind) = to_cube(picture, options, &subject)?;
    let distances = level
        .texels
        .iter()
        .map(|[distance, infinite, _]| if *infinite > 0.0 { f32::INFINITY } else { *distance });
    let map = DistanceCube { size: level.size, texels: distances.collect() };
    let taken = Taken {
        option: "--distance",
        file: subject,
        kind: format!("distances along rays from the reference point, {kind}"),
        from,
        window: fitted.words,
        remarks,
        flags: &["--distance-far", "FILE.exr:CHANNEL"],
        ..Taken::default()
    };
    Ok(Loaded { map, cleaned, taken })
}

/// Index of the plane that holds distances: that which is named, else the first of the usual names, else
/// the only one that ends in one of them.
fn find(names: &[&str], layer: Option<&str>) -> Option<usize> {
    let position = |name: &str| names.iter().position(|n| *n == name);
    let usual =
        |layer: &str| DISTANCE_CHANNELS.iter().find_map(|n| position(&format!("{layer}{n}")));
    if let Some(layer) = layer.filter(|layer| !layer.is_empty()) {
        return position(layer).or_else(|| usual(&format!("{layer}.")));
    }
    usual("").or_else(|| {
        DISTANCE_CHANNELS.iter().find_map(|name| {
            let ending = format!(".{name}");
            let mut all = (0..names.len()).filter(|i| names[*i].ends_with(&ending));
            // Only if no second one has the same ending.
            let first = all.next()?;
            all.next().is_none().then_some(first)
        })
    })
}

fn index(planar: &Planar, subject: &str) -> Result<usize, InputError> {
    let names: Vec<&str> = planar.channels.iter().map(|(n, _)| n.as_str()).collect();
    let layer = planar.layer.as_deref();
    find(&names, layer).ok_or_else(|| {
        let expected = match layer {
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
