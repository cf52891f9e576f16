//! Ground truth: rays through the whole square of a pixel, reflected by the exact surface and the
//! unfiltered bump map, into the bilinear texels of level 0.
//!
//! Every pixel is cut into strata of equal area with two independent samples each; where they fall
//! comes from a hash of pixel, round and sample, so that a picture is the same on every machine and for
//! every thread count. The difference of the two samples in a stratum gives an unbiased estimate of the
//! picture's own variance. A pixel that is still noisier than the target gets further rounds.

pub mod sampling;
pub mod texels;

use rayon::prelude::*;

use crate::cube::CubeMap;
use crate::picture::Picture;
use crate::scene::Scene;
use crate::settings::Settings;
use sampling::{Strata, Sums};
use texels::PaddedCube;

/// How hard truth tries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TruthOptions {
    /// Samples of one round; rounded up to 4·g² for a whole g.
    pub samples: u32,
    /// Most samples of a pixel; at least one round is always made.
    pub max_samples: u32,
    /// A pixel gets another round while its standard error is above target · max(1, brightest channel).
    pub target: f64,
    /// Chooses another set of samples.
    pub seed: u64,
}

impl Default for TruthOptions {
    fn default() -> Self {
        Self {
            samples: 256,
            max_samples: 1024,
            target: 1.0 / 255.0,
            seed: 0,
        }
    }
}

/// A picture with what it knows about its own error.
#[derive(Clone, Debug, PartialEq)]
pub struct TruthPicture {
    /// Linear RGB of every fragment; elsewhere black and not covered.
    pub picture: Picture,
    /// Standard error of each pixel, root mean square over the three channels, linear; 0 where there is
    /// no fragment.
    pub standard_error: Vec<f64>,
    /// Root mean square of `standard_error` over the fragments.
    pub rms_standard_error: f64,
    /// Samples that were taken.
    pub samples: u64,
}

/// Renders a scene by supersampling.
///
/// Only pixels with a fragment are rendered. A sample that misses the surface is left out of its pixel's
/// mean; a pixel of which no sample hits takes its centre's colour and as large an error. The
/// environment is turned by `settings.rotation`; every other setting concerns filters and is not used.
/// `progress` is told the number of fragments done since it was last called, from any thread.
///
/// Adding rounds where the first one was noisy favours pixels whose first round happened to be quiet; the
/// bias is of second order in the standard error.
#[must_use]
pub fn truth(
    scene: &Scene,
    texture: &CubeMap,
    settings: &Settings,
    options: &TruthOptions,
    progress: &(dyn Fn(u64) + Sync),
) -> TruthPicture {
    let environment = PaddedCube::new(&texture.levels[0]);
    let strata = Strata::new(options.samples);
    let done: Vec<(Sums, [f64; 3], f64)> = scene
        .fragments
        .par_chunks(256)
        .flat_map_iter(|chunk| {
            let colours: Vec<_> = chunk
                .iter()
                .map(|fragment| {
                    let shade = |x: f64, y: f64| {
                        let d = scene.surface.shade_point(x, y)?;
                        Some(environment.look_up(turned(&settings.rotation, d)))
                    };
                    pixel(&strata, options, fragment.pixel, &shade)
                })
                .collect();
            progress(chunk.len() as u64);
            colours
        })
        .collect();
    let mut picture = Picture::new(scene.width, scene.height);
    let mut standard_error = vec![0.0; scene.width * scene.height];
    let (mut squares, mut samples) = (0.0, 0);
    for (fragment, (sums, colour, error)) in scene.fragments.iter().zip(done) {
        let [column, row] = fragment.pixel;
        let index = row as usize * scene.width + column as usize;
        picture.rgb[index] = colour;
        picture.covered[index] = true;
        standard_error[index] = error;
        squares += error * error;
        samples += sums.taken();
    }
    let fragments = scene.fragments.len().max(1) as f64;
    TruthPicture {
        picture,
        standard_error,
        rms_standard_error: (squares / fragments).sqrt(),
        samples,
    }
}

/// All rounds of one pixel: what was summed, the mean colour and its standard error.
fn pixel(
    strata: &Strata,
    options: &TruthOptions,
    pixel: [u32; 2],
    shade: &dyn Fn(f64, f64) -> Option<[f64; 3]>,
) -> (Sums, [f64; 3], f64) {
    let mut sums = Sums::default();
    let mut round = 0;
    loop {
        strata.round(options.seed, pixel, round, shade, &mut sums);
        round += 1;
        let Some((colour, error)) = sums.estimate() else {
            let centre = pixel.map(|c| f64::from(c) + 0.5);
            let colour = shade(centre[0], centre[1]).unwrap_or([0.0; 3]);
            let error = colour.iter().fold(0.0f64, |most, c| most.max(c.abs()));
            return (sums, colour, error);
        };
        let brightest = colour.iter().fold(1.0f64, |most, c| most.max(*c));
        let enough = error <= options.target * brightest;
        if enough || sums.taken() + strata.samples() > u64::from(options.max_samples) {
            return (sums, colour, error);
        }
    }
}

/// The environment where the picture has no fragment: level 0, bilinear, at the pixel's centre.
///
/// Returns the colours of all pixels; those with a fragment are black.
#[must_use]
pub fn background(scene: &Scene, texture: &CubeMap, settings: &Settings) -> Vec<[f64; 3]> {
    let environment = PaddedCube::new(&texture.levels[0]);
    let mut covered = vec![false; scene.width * scene.height];
    for fragment in &scene.fragments {
        let [column, row] = fragment.pixel;
        covered[row as usize * scene.width + column as usize] = true;
    }
    covered
        .par_iter()
        .enumerate()
        .map(|(index, covered)| {
            if *covered {
                return [0.0; 3];
            }
            let d = scene.background(index % scene.width, index / scene.width);
            environment.look_up(turned(&settings.rotation, d))
        })
        .collect()
}

/// A·d.
fn turned(rotation: &[[f64; 3]; 3], d: [f64; 3]) -> [f64; 3] {
    rotation
        .each_ref()
        .map(|row| row[0] * d[0] + row[1] * d[1] + row[2] * d[2])
}
