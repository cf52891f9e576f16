//! Ground truth: rays through the whole square of a pixel, reflected by the exact surface and the
//! unfiltered bump map, into the bilinear texels of level 0.
//!
//! Every pixel is cut into strata of equal area with two independent samples each; where they fall
//! comes from a hash of pixel, round and sample, so that a picture is the same on every machine and for
//! every thread count. The difference of the two samples in a stratum gives an unbiased estimate of the
//! picture's own variance. A pixel that is still noisier than the target gets further rounds.

pub mod sampling;
pub mod texels;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::cube::CubeMap;
use crate::picture::Picture;
use crate::scene::Scene;
use crate::settings::Settings;
use sampling::{Seen, Shade, Strata, Sums};
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
        Self { samples: 256, max_samples: 1024, target: 1.0 / 255.0, seed: 0 }
    }
}

/// A picture with the estimate of its own error.
#[derive(Clone, Debug, PartialEq)]
pub struct TruthPicture {
    /// Linear RGB of every fragment; elsewhere black and not covered.
    pub picture: Picture,
    /// Standard error of each pixel, root mean square over the three channels, linear; 0 where there is
    /// no fragment.
    pub standard_error: Vec<f64>,
    /// Root mean square of `standard_error` over the fragments.
    pub rms_standard_error: f64,
    /// The same for the picture as it is shown: every channel's error carried through the clamp to 0…1
    /// and the sRGB curve. A comparison with truth cannot mean more than −20·log10 of this, in dB.
    pub rms_display_error: f64,
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
    let rows = DMat3::from_cols_array_2d(&settings.rotation);
    let pixels: Vec<[u32; 2]> = scene.fragments.iter().map(|f| f.pixel).collect();
    let shade = |places: &[[f64; 2]], colours: &mut Vec<_>| {
        // Directions first, then what lies there: the loads of many samples are under way at the same time.
        let directions = places.iter().map(|&[x, y]| scene.surface.shade_point(x, y));
        colours.extend(directions.map(|d| d.map(|d| rows.transpose_mul_vec3(d).to_array())));
        for colour in colours.iter_mut().flatten() {
            *colour = environment.look_up(*colour);
        }
    };
    let size = [scene.width, scene.height];
    supersample(size, &pixels, &shade, options, progress)
}

/// Supersamples anything: `shade` gets image positions inside the `pixels` of a picture of that width and
/// height. Everything else as [`truth`].
#[must_use]
pub fn supersample(
    [width, height]: [usize; 2],
    pixels: &[[u32; 2]],
    shade: &Shade<'_>,
    options: &TruthOptions,
    progress: &(dyn Fn(u64) + Sync),
) -> TruthPicture {
    let strata = Strata::new(options.samples);
    let done: Vec<(Sums, [f64; 3], [f64; 3])> = pixels
        .par_chunks(256)
        .flat_map_iter(|chunk| {
            let colours: Vec<_> =
                chunk.iter().map(|at| pixel(&strata, options, *at, shade)).collect();
            progress(chunk.len() as u64);
            colours
        })
        .collect();
    let mut picture = Picture::new(width, height);
    let mut standard_error = vec![0.0; width * height];
    let (mut squares, mut display, mut samples) = (0.0, 0.0, 0);
    for ([column, row], (sums, colour, error)) in pixels.iter().zip(done) {
        let index = *row as usize * width + *column as usize;
        picture.rgb[index] = colour;
        picture.covered[index] = true;
        let square = mean_square(error);
        standard_error[index] = square.sqrt();
        squares += square;
        display += mean_square(
            [0, 1, 2]
                .map(|i| (encoded(colour[i] + error[i]) - encoded(colour[i] - error[i])) / 2.0),
        );
        samples += sums.taken();
    }
    let fragments = pixels.len().max(1) as f64;
    TruthPicture {
        picture,
        standard_error,
        rms_standard_error: (squares / fragments).sqrt(),
        rms_display_error: (display / fragments).sqrt(),
        samples,
    }
}

/// A function that shades positions one by one.
pub fn each(
    shade: impl Fn(f64, f64) -> Option<[f64; 3]> + Sync,
) -> impl Fn(&[[f64; 2]], &mut Seen) + Sync {
    move |places, colours| colours.extend(places.iter().map(|&[x, y]| shade(x, y)))
}

/// All rounds of one pixel: what was summed, the mean colour and its standard error by channel.
fn pixel(
    strata: &Strata,
    options: &TruthOptions,
    pixel: [u32; 2],
    shade: &Shade<'_>,
) -> (Sums, [f64; 3], [f64; 3]) {
    let mut sums = Sums::default();
    let mut round = 0;
    loop {
        strata.round(options.seed, pixel, round, shade, &mut sums);
        round += 1;
        let Some((colour, error)) = sums.estimate() else {
            let centre = pixel.map(|c| f64::from(c) + 0.5);
            let mut seen = Vec::new();
            shade(&[centre], &mut seen);
            let colour = seen.into_iter().flatten().next().unwrap_or([0.0; 3]);
            return (sums, colour, colour.map(f64::abs));
        };
        let brightest = colour.iter().fold(1.0f64, |most, c| most.max(*c));
        let enough = mean_square(error).sqrt() <= options.target * brightest;
        if enough || sums.taken() + strata.samples() > u64::from(options.max_samples) {
            return (sums, colour, error);
        }
    }
}

fn mean_square(error: [f64; 3]) -> f64 {
    error.iter().map(|e| e * e).sum::<f64>() / 3.0
}

/// The sRGB curve of a linear value, clamped to 0…1.
fn encoded(linear: f64) -> f64 {
    let linear = linear.clamp(0.0, 1.0);
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055
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
            environment.look_up(turned(settings, d.into()))
        })
        .collect()
}

/// A·d: where the turned environment is looked up for a direction.
pub(crate) fn turned(settings: &Settings, d: DVec3) -> [f64; 3] {
    let rows = DMat3::from_cols_array_2d(&settings.rotation);
    rows.transpose_mul_vec3(d).to_array()
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "where bits must be equal, that is what is tested")]
mod tests {
    use super::*;
    use crate::cube::CubeLevel;
    use crate::scene::{SceneOptions, build};

    /// A cube whose texels are stripes of 0 and 1 with a different tint per face.
    fn stripes(size: usize) -> CubeMap {
        let texel = |index: usize| {
            let (face, y, x) = (index / (size * size), index / size % size, index % size);
            let on = (x / 2 + y / 3 + face) % 2 == 0;
            if on { [1.0, 0.5, 0.25] } else { [0.0, 0.125, 0.75] }
        };
        CubeMap {
            levels: vec![CubeLevel { size, texels: (0..6 * size * size).map(texel).collect() }],
        }
    }

    fn faces(colours: [[f32; 3]; 6]) -> CubeMap {
        let texels = colours.iter().flat_map(|c| [*c; 16]).collect();
        CubeMap { levels: vec![CubeLevel { size: 4, texels }] }
    }

    fn scene(name: &str) -> Scene {
        let options = SceneOptions { width: 48, height: 32, ..SceneOptions::default() };
        build(name, &options, &Settings::default()).unwrap()
    }

    fn run(scene: &Scene, texture: &CubeMap, samples: u32, seed: u64) -> TruthPicture {
        let options = TruthOptions { samples, max_samples: samples, target: 0.0, seed };
        truth(scene, texture, &Settings::default(), &options, &|_| {})
    }

    #[test]
    fn the_standard_error_covers_the_error_against_sixty_four_times_the_samples() {
        for name in ["sphere", "waves"] {
            let (scene, texture) = (scene(name), stripes(64));
            let (few, many) = (run(&scene, &texture, 64, 1), run(&scene, &texture, 4096, 2));
            let (mut errors, mut predicted, mut fourth) = (0.0, 0.0, 0.0);
            for fragment in &scene.fragments {
                let i = fragment.pixel[1] as usize * 48 + fragment.pixel[0] as usize;
                let (a, b) = (few.picture.rgb[i], many.picture.rgb[i]);
                errors += (0..3).map(|c| (a[c] - b[c]) * (a[c] - b[c]) / 3.0).sum::<f64>();
                let variance = few.standard_error[i].powi(2) + many.standard_error[i].powi(2);
                predicted += variance;
                fourth += variance * variance;
            }
            // The square of a normal error has twice the variance of its expectation's square; the
            // estimate from 32 strata adds at most as much again: 6 standard deviations of the ratio.
            let spread = 6.0 * (4.0 * fourth).sqrt() / predicted;
            let ratio = errors / predicted;
            assert!(spread < 0.6, "{name}: too few pixels to say anything: {spread}");
            assert!((ratio - 1.0).abs() <= spread, "{name}: {ratio} of 1 ± {spread}");
        }
    }

    #[test]
    fn the_standard_error_shrinks_with_the_samples() {
        let (scene, texture) = (scene("sphere"), stripes(64));
        let (few, many) = (run(&scene, &texture, 64, 0), run(&scene, &texture, 1024, 0));
        // 16 times the samples: a quarter without strata, and smaller strata only help. The root mean
        // square of some 700 estimates is good to a few per cent.
        assert!(few.rms_standard_error > 1e-3);
        assert!(many.rms_display_error < few.rms_display_error);
        assert!(many.rms_standard_error <= 0.27 * few.rms_standard_error);
        assert_eq!(many.samples, 1024 * scene.fragments.len() as u64);
    }

    #[test]
    fn noisy_pixels_get_more_samples_until_target_or_cap() {
        let (scene, texture) = (scene("sphere"), stripes(8));
        // The target is the median error of the first round, so that half the pixels are quiet.
        let first = run(&scene, &texture, 64, 0);
        let mut errors: Vec<f64> = scene
            .fragments
            .iter()
            .map(|f| first.standard_error[f.pixel[1] as usize * 48 + f.pixel[0] as usize])
            .collect();
        errors.sort_by(f64::total_cmp);
        let target = errors[errors.len() / 2];
        let options = TruthOptions { samples: 64, max_samples: 640, target, seed: 0 };
        let settings = Settings::default();
        let got = truth(&scene, &texture, &settings, &options, &|_| {});
        let fragments = scene.fragments.len() as u64;
        assert!(got.samples > 64 * fragments && got.samples < 640 * fragments);
        let (mut quiet, mut helped) = (0, 0);
        for fragment in &scene.fragments {
            let i = fragment.pixel[1] as usize * 48 + fragment.pixel[0] as usize;
            if first.standard_error[i] <= target {
                assert_eq!(got.picture.rgb[i], first.picture.rgb[i]);
                quiet += 1;
            } else {
                helped += usize::from(got.standard_error[i] < first.standard_error[i]);
            }
        }
        assert!(quiet > 300 && helped > 150, "{quiet} quiet, {helped} helped");
    }

    #[test]
    fn a_constant_environment_gives_a_constant_picture_without_error() {
        let texture = faces([[0.3, 0.6, 7.0]; 6]);
        for name in ["sphere", "scratches"] {
            let got = run(&scene(name), &texture, 64, 0);
            for (rgb, covered) in got.picture.rgb.iter().zip(&got.picture.covered) {
                for (c, want) in rgb.iter().zip([0.3f32, 0.6, 7.0].map(f64::from)) {
                    // A sum of 64 equal numbers, divided by 64.
                    let want = if *covered { want } else { 0.0 };
                    assert!((c - want).abs() <= 64.0 * f64::EPSILON * want);
                }
            }
            // A difference of sums of squares: the root of their rounding, below 1e-6. On display the
            // curve's slope, at most 12.92, and half of it on either side.
            assert!(got.rms_display_error < 12.92e-6);
            assert!(got.rms_standard_error <= 7.0 * (64.0 * f64::EPSILON).sqrt());
        }
    }

    #[test]
    fn the_rotation_turns_the_environment() {
        let mut colours = [[0.0f32; 3]; 6];
        colours[0] = [1.0, 0.0, 0.0];
        colours[4] = [0.0, 1.0, 0.0];
        let (scene, texture) = (scene("parabola"), faces(colours));
        // All rays leave along (3, 4, 12)/13. Turned so that z becomes x they meet +x at (−3, 4)/12,
        // inside the texels that do not touch another face.
        let settings = Settings {
            rotation: [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]],
            ..Settings::default()
        };
        let options = TruthOptions::default();
        let middle = 16 * 48 + 24;
        let straight = truth(&scene, &texture, &Settings::default(), &options, &|_| {});
        let turned = truth(&scene, &texture, &settings, &options, &|_| {});
        assert!((straight.picture.rgb[middle][1] - 1.0).abs() <= 256.0 * f64::EPSILON);
        assert!((turned.picture.rgb[middle][0] - 1.0).abs() <= 256.0 * f64::EPSILON);
    }

    #[test]
    fn the_picture_does_not_depend_on_the_threads_and_progress_counts_every_fragment() {
        let (scene, texture) = (scene("scratches"), stripes(16));
        let pictures = [1, 3].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let count = std::sync::atomic::AtomicU64::new(0);
            let options = TruthOptions { samples: 16, ..TruthOptions::default() };
            let picture = pool.install(|| {
                truth(&scene, &texture, &Settings::default(), &options, &|done| {
                    count.fetch_add(done, std::sync::atomic::Ordering::Relaxed);
                })
            });
            assert_eq!(count.into_inner(), scene.fragments.len() as u64);
            picture
        });
        assert_eq!(pictures[0], pictures[1]);
    }

    #[test]
    fn the_background_shows_the_environment_where_there_is_no_fragment() {
        let mut colours = [[0.0f32; 3]; 6];
        colours[5] = [0.25, 0.5, 1.0];
        let (scene, texture) = (scene("sphere"), faces(colours));
        let got = background(&scene, &texture, &Settings::default());
        // The corner looks along −z, well inside the face.
        assert_eq!(got[0], [0.25, 0.5, 1.0]);
        assert_eq!(got[16 * 48 + 24], [0.0; 3]);
    }
}
